//! A solid on a grid: what can break.

use crate::{ClosedForm, HalfSpace, LevelSet, MassProperties};
use std::sync::Arc;

/// A level set, how much of each voxel is material, and what its surface is made of.
#[derive(Clone, Debug)]
pub struct GridSolid {
    /// Signed distance in the grid frame; outside it may be underestimated after a break [Su09 sec. 4.2].
    pub level_set: LevelSet,
    /// Fraction of each node's voxel that is this solid's material, in [0, 1]. The fragments of a solid share out its
    /// coverage exactly.
    pub coverage: Vec<f32>,
    /// The exact surfaces behind the samples, so that edges stay sharp.
    pub outline: Outline,
}

/// The smooth pieces that a grid solid's surface consists of, all in its grid frame.
#[derive(Clone, Debug)]
pub struct Outline {
    /// The surface of the body before any break.
    pub root: Root,
    /// The cracks: each fragment lies inside of all of these, up to merged slivers.
    pub cuts: Vec<HalfSpace>,
}

/// The surface of a body before any break.
#[derive(Clone, Debug)]
pub enum Root {
    /// A formula.
    ClosedForm(ClosedForm),
    /// Samples of a mesh's distance.
    Sampled(Arc<LevelSet>),
}

impl GridSolid {
    /// Volume, centre and inertia at unit density, in the grid frame.
    pub fn mass_properties(&self) -> MassProperties {
        crate::coverage::mass_properties(self.level_set.grid(), &self.coverage)
    }
}
