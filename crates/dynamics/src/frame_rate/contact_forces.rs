//! Contact forces at the end of a frame.

use frangible_bodies::{Bodies, Pair};
use frangible_collision::{ImpulseCache, Manifold};
use glam::DVec3;

/// Force at a contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// Both bodies in contact.
    pub pair: Pair,
    /// Contact point on the surfaces of the first and of the second body, in body frames [m].
    pub points: [DVec3; 2],
    /// Force on the first body, world frame [N]; the second body feels its opposite.
    pub force: DVec3,
}

/// Mean contact forces of each pair's last solved frame (this frame or an earlier one), in the
/// order of `manifolds` and at their points. Impacts are included.
pub fn contact_forces<'a>(
    bodies: &Bodies,
    manifolds: impl Iterator<Item = Manifold<'a>>,
    carried: &ImpulseCache,
) -> Vec<ContactForce> {
    let of = |manifold: Manifold| {
        let pair = manifold.pair;
        let forces = manifold.points.iter().filter_map(|point| {
            let force = carried.get(bodies, pair, point.feature)?.force.mean.as_dvec3();
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
