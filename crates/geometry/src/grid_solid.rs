//! A solid on a grid: what can break.

use crate::{ClosedForm, Grid, HalfSpace, Hull, LevelSet, MassProperties, coverage};
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
    /// A convex polyhedron.
    Hull(Arc<Hull>),
    /// Samples of a mesh's distance.
    Sampled(Arc<LevelSet>),
}

/// Asked of a shape that has no volume, or whose mass lies on a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the shape has no volume or no moment of inertia: all three principal moments must be > 0")]
pub struct NoMass;

impl GridSolid {
    /// A formula sampled with `voxels` cells over its bounding box and `margin` further layers around it, see
    /// [`Grid::around_box`]; 2 layers keep all gradients at the surface central.
    ///
    /// # Errors
    /// For a half-space, which no grid can hold.
    pub fn from_closed_form(form: ClosedForm, voxels: [usize; 3], margin: usize) -> Result<Self, NoMass> {
        if form.mass_properties().is_none() {
            return Err(NoMass);
        }
        let (low, high) = form.bounds();
        let grid = Grid::around_box(low, high, voxels, margin);
        let level_set = LevelSet::sample(grid, |point| form.distance(point));
        let coverage = coverage::exact_coverage(&grid, |point| form.distance_and_gradient(point));
        Ok(Self { level_set, coverage, outline: Outline { root: Root::ClosedForm(form), cuts: Vec::new() } })
    }

    /// A convex polyhedron, sampled likewise.
    pub fn from_hull(hull: Hull, voxels: [usize; 3], margin: usize) -> Self {
        let (low, high) = hull.bounds();
        let grid = Grid::around_box(low, high, voxels, margin);
        let level_set = LevelSet::sample(grid, |point| hull.distance_and_gradient(point).0);
        let coverage = coverage::exact_coverage(&grid, |point| hull.distance_and_gradient(point));
        Self { level_set, coverage, outline: Outline { root: Root::Hull(Arc::new(hull)), cuts: Vec::new() } }
    }

    /// What the samples enclose; `level_set` is also the exact surface behind them.
    pub fn from_level_set(level_set: LevelSet) -> Self {
        let coverage = coverage::voxel_coverage(&level_set);
        let outline = Outline { root: Root::Sampled(Arc::new(level_set.clone())), cuts: Vec::new() };
        Self { level_set, coverage, outline }
    }

    /// Volume, centre and inertia at unit density, in the grid frame.
    pub fn mass_properties(&self) -> MassProperties {
        coverage::mass_properties(self.level_set.grid(), &self.coverage)
    }
}
