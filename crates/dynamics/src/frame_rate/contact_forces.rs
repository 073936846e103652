//! Forces that contacts carried at the end of a frame.

use frangible_bodies::{Bodies, Pair};
use frangible_collision::{Manifold, WarmStart};
use glam::DVec3;

/// A force at a point of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// Whose.
    pub pair: Pair,
    /// On the surfaces of the first and of the second body, each in its body frame [m].
    pub points: [DVec3; 2],
    /// On the first body, in the world frame [N]; its opposite acts on the second.
    pub force: DVec3,
}

/// The mean forces of the frame in which each pair was solved, this one or one before it, at the
/// points that some manifolds had at its start, in order. Blows are in them.
pub fn contact_forces<'a>(
    bodies: &Bodies,
    manifolds: impl Iterator<Item = Manifold<'a>>,
    carried: &WarmStart,
) -> Vec<ContactForce> {
    let of = |manifold: Manifold| {
        let pair = manifold.pair;
        let forces = manifold.points.iter().filter_map(|point| {
            let force = carried.get(bodies, pair, point.sample)?.force.mean.as_dvec3();
            let towards = |i: usize, rounding: f64| {
                bodies.poses[i].orientation.conjugate() * (rounding * point.normal)
            };
            let points = [
                point.anchor_first - towards(pair.first, point.rounding[0]),
                point.anchor_second + towards(pair.second, point.rounding[1]),
            ];
            Some(ContactForce { pair, points, force })
        });
        forces.collect::<Vec<_>>()
    };
    manifolds.flat_map(of).collect()
}
