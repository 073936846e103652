//! What contacts carried at the end of a frame.

use crate::manifold::Manifold;
use crate::pair::Pair;
use crate::substeps::SUBSTEPS;
use crate::warm_start::WarmStart;
use crate::{Bodies, Frame};
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

/// The forces of the frame's last substep at the points that were found at its start, in order. What bounced has left none.
pub fn contact_forces(
    bodies: &Bodies,
    manifolds: &[Manifold],
    carried: &WarmStart,
    frame: &Frame,
) -> Vec<ContactForce> {
    let rate = f64::from(SUBSTEPS) / frame.dt;
    let of = |manifold: &Manifold| {
        let pair = manifold.pair;
        let forces = manifold.points.iter().filter_map(|point| {
            let impulses = &carried.get(bodies, pair, point.sample)?.impulses;
            let impulse =
                |at: usize| f64::from(impulses[at].normal) * point.normal + impulses[at].tangent.as_dvec3();
            let towards =
                |i: usize, rounding: f64| bodies.poses[i].orientation.conjugate() * (rounding * point.normal);
            let points = [
                point.anchor_first - towards(pair.first, point.rounding[0]),
                point.anchor_second + towards(pair.second, point.rounding[1]),
            ];
            Some(ContactForce { pair, points, force: rate * (impulse(0) + impulse(1)) })
        });
        forces.collect::<Vec<_>>()
    };
    manifolds.iter().flat_map(of).collect()
}
