//! What contacts carried at the end of a frame.

use crate::Bodies;
use crate::manifold::Manifold;
use crate::pair::Pair;
use crate::warm_start::WarmStart;
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

/// The forces of the last substep in which each pair was solved, of this frame or of one before it, at the points that some manifolds had at its start, in order. What bounced has left none.
pub fn contact_forces<'a>(
    bodies: &Bodies,
    manifolds: impl Iterator<Item = Manifold<'a>>,
    carried: &WarmStart,
) -> Vec<ContactForce> {
    let of = |manifold: Manifold| {
        let pair = manifold.pair;
        let forces = manifold.points.iter().filter_map(|point| {
            let forces = &carried.get(bodies, pair, point.sample)?.forces;
            let force = |at: usize| forces[at].force.as_dvec3();
            let towards =
                |i: usize, rounding: f64| bodies.poses[i].orientation.conjugate() * (rounding * point.normal);
            let points = [
                point.anchor_first - towards(pair.first, point.rounding[0]),
                point.anchor_second + towards(pair.second, point.rounding[1]),
            ];
            Some(ContactForce { pair, points, force: force(0) + force(1) })
        });
        forces.collect::<Vec<_>>()
    };
    manifolds.flat_map(of).collect()
}
