//! Contact points on bodies of revolution: how each moves with its body.
//!
//! The normal line through a point of a surface of revolution meets its axis. An anchor there does
//! not move as the body spins, so what rolls is exact at any spin.

use crate::narrow_phase::revolved::placed::PlacedRevolved;
use glam::DVec3;

/// Rims steeper to the normal than this sine have their anchor on the rim: on the axis it would be
/// far away [1].
const STEEPEST_RIM: f64 = 0.05;

/// An anchor, and the distance of the surface from it along the normal [m].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor {
    pub(crate) point: DVec3,
    pub(crate) rounding: f64,
}

/// The point of a rim that a contact point was made for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RimPoint {
    /// True for the body of revolution, false for its partner.
    pub(crate) of_round: bool,
    pub(crate) end: usize,
    pub(crate) point: DVec3,
}

/// A contact point, in the partner's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundPoint {
    /// Of the body of revolution and of the partner.
    pub(crate) anchors: [Anchor; 2],
    /// Unit, from the partner.
    pub(crate) normal: DVec3,
    /// The same for the same features.
    pub(crate) id: u64,
    pub(crate) rim: Option<RimPoint>,
}

impl RoundPoint {
    pub(crate) fn new(anchors: [Anchor; 2], normal: DVec3, id: u64) -> Self {
        Self { anchors, normal, id, rim: None }
    }

    /// Separation of the surfaces along the normal [m].
    pub(crate) fn gap(&self) -> f64 {
        let [round, partner] = self.anchors;
        (round.point - partner.point).dot(self.normal) - round.rounding - partner.rounding
    }

    /// Points on both surfaces [m].
    pub(crate) fn on_surfaces(&self) -> [DVec3; 2] {
        let [round, partner] = self.anchors;
        [round.point - round.rounding * self.normal, partner.point + partner.rounding * self.normal]
    }
}

/// A point of a flat face or a vertex, fixed in its body [m].
pub(crate) fn fixed(point: DVec3) -> Anchor {
    Anchor { point, rounding: 0.0 }
}

impl PlacedRevolved {
    /// A point of the core, fixed in the body.
    pub(crate) fn hold_fixed(&self, point: DVec3) -> Anchor {
        Anchor { point, rounding: self.rounding }
    }

    /// A point of the core's side, `radius` [m] from the axis, held by the axis.
    pub(crate) fn hold_by_axis(&self, point: DVec3, radius: f64, towards: DVec3) -> Anchor {
        self.hold(point, radius, towards, 1.0)
    }

    /// A point of a rim that touches alone. Where the body rolls on, the rim is round; where it
    /// tips over, it is sharp. `angular` [rad/s] tells how much of each.
    pub(crate) fn hold_rim(
        &self,
        point: DVec3,
        end: usize,
        towards: DVec3,
        angular: DVec3,
    ) -> Anchor {
        let tangent = self.axis.cross(self.radial(towards));
        let tips = angular.dot(tangent);
        let rolls = angular.dot(tangent.cross(towards));
        let (tips, rolls) = (tips * tips, rolls * rolls);
        let share = if rolls > 0.0 { rolls / (rolls + tips) } else { 0.0 };
        self.hold(point, self.ends[end].radius, towards, share)
    }

    fn hold(&self, point: DVec3, radius: f64, towards: DVec3, share: f64) -> Anchor {
        let (_, _, across) = self.split(towards);
        if across < STEEPEST_RIM {
            return self.hold_fixed(point);
        }
        let inward = share * radius / across;
        Anchor { point: point - inward * towards, rounding: inward + self.rounding }
    }
}
