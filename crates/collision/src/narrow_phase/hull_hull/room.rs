//! Room for what is found on the way to a pair's points.

use crate::narrow_phase::hull_hull::hull_point::{Feature, HullPoint};
use crate::narrow_phase::hull_hull::placement::Ridge;
use frangible_math::Singles;
use glam::DVec3;

/// Room for what is found on the way to a pair's points, used again from pair to pair; nothing in
/// it lasts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Room {
    /// The points where two hulls meet.
    pub(crate) points: Vec<HullPoint>,
    pub(crate) spare: Vec<HullPoint>,
    pub(crate) polygon: Vec<Corner>,
    pub(crate) clipped: Vec<Corner>,
    /// The vertices of a hull that are within two layers, as `mark_within` finds them.
    pub(crate) marks: Vec<u8>,
    pub(crate) ridges: [Vec<Ridge>; 2],
    pub(crate) ridge_columns: Vec<RidgeColumns>,
}

/// What a polygon's side lies on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Side {
    /// An edge of the incident hull.
    Incident(u32),
    /// A side of the reference face, by its place around it.
    Reference(usize),
}

/// A corner of the polygon that is clipped.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    pub(crate) point: DVec3,
    /// What it is, the reference hull being the first.
    pub(crate) feature: Feature,
    /// The polygon's side that begins here.
    pub(crate) side: Side,
    /// Beyond the side of the reference face that clips, at first in any unit, then [m].
    pub(crate) beyond: f64,
}

/// Eight ridges: where they begin, along them, and the two normals beside them.
pub(crate) type RidgeColumns = [[Singles; 3]; 4];
