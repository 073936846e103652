//! A solid on a grid: what can break.

mod nodes;

use crate::closed_form::ClosedForm;
use crate::coverage;
use crate::grid::Grid;
use crate::half_space::HalfSpace;
use crate::hull::Hull;
use crate::level_set::LevelSet;
use crate::mass_properties::MassProperties;
use crate::mass_properties::NoMass;
use crate::mesh_boundary::MeshBoundary;
use crate::moments::Portion;
use crate::outline_clip::{Clip, distances_over, larger};
use crate::run_core::RunCore;
use crate::runs::Run;
use crate::voxel_runs::{Held, VoxelRuns};
use frangible_math::check::{Check, Checked, require};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// A level set, how much of each voxel is material, and what its surface is made of.
///
/// A fragment of planar cells is its parent, clipped: it shares the parent's samples, and its
/// distance is the larger one of theirs and its planes' [Su09 sec. 4.2], taken where it is asked
/// for. Only what walks over nodes has them sampled.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct GridSolid {
    /// The part of the lattice around the material.
    grid: Grid,
    /// Signed distances that this solid is clipped from; outside they may be underestimated after a
    /// break [Su09 sec. 4.2].
    #[serde(with = "frangible_math::shared")]
    field: Arc<LevelSet>,
    /// The first node of `grid` on the field's lattice.
    shift: [i64; 3],
    /// The solid lies in any of these; if there are none, it is all of the field.
    parts: Vec<Clip>,
    /// True for a known convex body, independent of the grid's resolution.
    convex: bool,
    /// Exact content, divided among fragments.
    held: Held,
    /// The exact surfaces behind the samples, so that edges stay sharp.
    pub outline: Outline,
    /// The triangles behind the samples, if the body was one of triangles before any break.
    #[serde(with = "frangible_math::shared")]
    boundary: Option<Arc<MeshBoundary>>,
    /// Distances at the nodes of `grid`, made when they are asked for.
    #[serde(skip)]
    nodes: OnceLock<Arc<LevelSet>>,
}

/// The smooth pieces that a grid solid's surface consists of, all in its grid frame.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Outline {
    /// The surface of the body before any break.
    pub root: Root,
    /// The cracks: each fragment lies inside of all of these, up to merged slivers.
    pub cuts: Vec<HalfSpace>,
    /// The same for cracks that are no planes: samples of the distance to the cell, negative
    /// inside.
    #[serde(with = "frangible_math::shared")]
    pub rough: Vec<Arc<LevelSet>>,
}

/// The surface of a body before any break.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Root {
    /// A formula.
    ClosedForm(ClosedForm),
    /// A convex polyhedron.
    Hull(#[serde(with = "frangible_math::shared")] Arc<Hull>),
    /// Samples of a mesh's distance.
    Sampled(#[serde(with = "frangible_math::shared")] Arc<LevelSet>),
}

impl Check for Outline {
    fn check(&self) -> Checked {
        if let Root::ClosedForm(form) = &self.root {
            form.check()?;
        }
        self.cuts.iter().try_for_each(Check::check)
    }
}

impl Check for GridSolid {
    fn check(&self) -> Checked {
        self.grid.check()?;
        let field = self.field.grid();
        // The nodes of a part are the field's, and its margins.
        let fits = (0..3).all(|axis| {
            let most = field.dims[axis] + 2 * Self::MARGIN;
            let nodes = -(Self::MARGIN as i64)..field.dims[axis] as i64;
            self.grid.dims[axis] <= most && nodes.contains(&self.shift[axis])
        });
        require(fits, "a grid that is a part of the field's")?;
        let is_field = self.shift == [0; 3] && self.grid.dims == field.dims;
        require(is_field || !self.parts.is_empty(), "all of the field, or parts of it")?;
        self.parts.iter().try_for_each(Check::check)?;
        self.held.check(&self.grid)?;
        self.outline.check()
    }
}

impl GridSolid {
    /// Layers of nodes around a fragment's voxels, so that gradients at its surface are central.
    pub const MARGIN: usize = 2;

    /// A formula sampled with `voxels` cells over its bounding box and `margin` further layers
    /// around it, see [`Grid::around_box`]; 2 layers keep all gradients at the surface central.
    ///
    /// # Errors
    /// For a half-space, which no grid can hold.
    pub fn from_closed_form(
        form: ClosedForm,
        voxels: [usize; 3],
        margin: usize,
    ) -> Result<Self, NoMass> {
        if form.mass_properties().is_none() {
            return Err(NoMass);
        }
        let (low, high) = form.bounds();
        let grid = Grid::around_box(low, high, voxels, margin);
        let level_set = LevelSet::sample(grid, |point| form.distance(point));
        let coverage = coverage::exact_coverage(&grid, |point| form.distance_and_gradient(point));
        let convex = Self::whole(Arc::new(level_set), &coverage, Root::ClosedForm(form));
        Ok(Self { convex: true, ..convex })
    }

    /// A convex polyhedron, sampled likewise.
    pub fn from_hull(hull: Hull, voxels: [usize; 3], margin: usize) -> Self {
        let (low, high) = hull.bounds();
        let grid = Grid::around_box(low, high, voxels, margin);
        let level_set = LevelSet::sample(grid, |point| hull.distance_and_gradient(point).0);
        let coverage = coverage::exact_coverage(&grid, |point| hull.distance_and_gradient(point));
        let convex = Self::whole(Arc::new(level_set), &coverage, Root::Hull(Arc::new(hull)));
        Self { convex: true, ..convex }
    }

    /// A solid from samples; `level_set` is also the exact surface behind them.
    pub fn from_level_set(level_set: LevelSet) -> Self {
        let coverage = coverage::voxel_coverage(&level_set);
        Self::with_coverage(level_set, &coverage)
    }

    /// The same with the fraction of each voxel that is material.
    pub fn with_coverage(level_set: LevelSet, coverage: &[f32]) -> Self {
        let field = Arc::new(level_set);
        Self::whole(field.clone(), coverage, Root::Sampled(field))
    }

    fn whole(field: Arc<LevelSet>, coverage: &[f32], root: Root) -> Self {
        Self {
            grid: *field.grid(),
            held: Held::all(field.grid(), VoxelRuns::from_nodes(&field, coverage)),
            field,
            shift: [0; 3],
            parts: Vec::new(),
            convex: false,
            outline: Outline { root, cuts: Vec::new(), rough: Vec::new() },
            boundary: None,
            nodes: OnceLock::new(),
        }
    }

    /// The same with the triangles that it was sampled from: samples do not tell how thick a wall of
    /// few voxels is.
    pub fn with_boundary(self, boundary: MeshBoundary) -> Self {
        Self { boundary: Some(Arc::new(boundary)), ..self }
    }

    /// The triangles behind the samples, of the body before any break.
    pub fn boundary(&self) -> Option<&MeshBoundary> {
        self.boundary.as_deref()
    }

    /// The part of this solid that lies in any of some intersections of half-spaces, on its part of
    /// the lattice. `portion` is the material that is the part's.
    ///
    /// Its outline knows the first of the intersections: the others are slivers that joined it.
    pub fn clipped(&self, portion: Portion, regions: &[&[HalfSpace]]) -> Self {
        let mut part = self.part(portion);
        let extent = part.extent();
        let old: Vec<&[HalfSpace]> = if self.parts.is_empty() {
            vec![&[]]
        } else {
            self.parts.iter().map(Clip::half_spaces).collect()
        };
        for region in regions {
            for own in &old {
                part.parts.extend(Clip::new(&part.grid, own.iter().chain(*region), extent));
            }
        }
        if part.parts.is_empty() {
            // Drop regions with surface voxels only that end within them.
            let first = old.iter().zip(regions).map(|(own, region)| own.iter().chain(*region));
            let everywhere = part.grid.bounds();
            part.parts.extend(first.flat_map(|planes| Clip::new(&part.grid, planes, everywhere)));
        }
        part.convex = self.convex && regions.len() == 1 && part.parts.len() == 1;
        part.add_cuts(regions.first().copied().unwrap_or(&[]), extent);
        part
    }

    /// The part of this solid in a cell, too, whose signed distances at the nodes of the part's
    /// grid are `sampled`.
    pub fn intersected(&self, portion: Portion, sampled: impl FnOnce(Grid) -> LevelSet) -> Self {
        let mut part = self.part(portion);
        part.parts.clone_from(&self.parts);
        part.add_cuts(&[], part.extent());
        let cell = Arc::new(sampled(part.grid));
        let nodes = part.sample_nodes(Some(&cell));
        part.outline.rough.push(cell);
        part.sampled_as(nodes)
    }

    /// The same solid with its distance sampled at its own nodes. Where this solid's material ends,
    /// its inside does: what else the planes would hold belongs to others.
    pub fn sampled(self) -> Self {
        let nodes = self.sample_nodes(None);
        self.sampled_as(nodes)
    }

    fn sampled_as(self, nodes: LevelSet) -> Self {
        Self {
            field: Arc::new(nodes),
            shift: [0; 3],
            parts: Vec::new(),
            convex: false,
            nodes: OnceLock::new(),
            ..self
        }
    }

    /// Grid, field and material of a part, without its planes.
    fn part(&self, portion: Portion) -> Self {
        let [low, high] = portion.sums.nodes();
        // The part's own lattice; it may reach beyond this one's.
        let dims: [usize; 3] =
            std::array::from_fn(|axis| high[axis] + 1 + 2 * Self::MARGIN - low[axis]);
        let from = low.map(|n| n as i64 - Self::MARGIN as i64);
        let h = self.grid.spacing;
        let origin =
            self.grid.origin + h * DVec3::new(from[0] as f64, from[1] as f64, from[2] as f64);
        let grid = Grid { origin, spacing: h, dims };
        Self {
            held: self.held.part(portion, from, (&self.grid, &grid)),
            grid,
            field: self.field.clone(),
            shift: std::array::from_fn(|axis| self.shift[axis] + from[axis]),
            parts: Vec::new(),
            convex: false,
            outline: self.outline.clone(),
            boundary: self.boundary.clone(),
            nodes: OnceLock::new(),
        }
    }

    /// Adds cracks to the outline, and leaves out those that do not come within a voxel of the
    /// nodes in `extent`: they are the nearest surface to none of them.
    fn add_cuts(&mut self, new: &[HalfSpace], extent: (DVec3, DVec3)) {
        let h = self.grid.spacing;
        self.outline.cuts.extend(new);
        self.outline.cuts.retain(|half_space| {
            distances_over(half_space, extent).1 >= -h * half_space.normal.abs().element_sum()
        });
    }

    /// Lowest and highest corner of the box around the nodes of a part [m].
    fn extent(&self) -> (DVec3, DVec3) {
        let margin = Self::MARGIN as f64 * self.grid.spacing;
        let (low, high) = self.grid.bounds();
        (low + margin, high - margin)
    }

    /// The part of the lattice around the material.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Material of each voxel of [`GridSolid::grid`] in this solid.
    pub fn material(&self) -> &VoxelRuns {
        self.held.material()
    }

    /// The same by stretches of rows, in order: between their ends is no gap.
    pub fn runs(&self) -> &[Run] {
        self.held.runs()
    }

    /// The same on the grid that they were taken from, and the first node of [`GridSolid::grid`]
    /// there: nothing is made.
    pub(crate) fn taken_runs(&self) -> (&[Run], [i64; 3]) {
        self.held.taken()
    }

    /// The same, to be cut: for each of the runs.
    pub fn cores(&self) -> &[RunCore] {
        self.held.cores(&self.grid)
    }

    /// The fraction of each node's voxel that is this solid's material, x fastest.
    pub fn coverage(&self) -> Vec<f32> {
        self.material().coverage(&self.grid)
    }

    /// True for a known convex body, independent of the grid's resolution; `false` if unknown.
    pub fn is_convex(&self) -> bool {
        self.convex
    }

    /// The half-spaces that a fragment is clipped by: it lies in any of these intersections; all of
    /// the field if there are none.
    pub fn parts(&self) -> &[Clip] {
        &self.parts
    }

    /// True for a point of the grid frame in the surface before any break and in one of
    /// [`GridSolid::parts`], or beyond both by at most `slack` [m]: exact where that surface is a
    /// formula or a polyhedron. Other pieces of the same cell hold it too.
    pub fn holds(&self, point: DVec3, slack: f64) -> bool {
        let in_root = match &self.outline.root {
            Root::ClosedForm(form) => form.distance(point) <= slack,
            Root::Hull(hull) => hull.distance_up_to(point, slack) <= slack,
            Root::Sampled(level_set) => f64::from(level_set.value(point)) <= slack,
        };
        let in_part = |part: &Clip| {
            part.half_spaces().iter().all(|half_space| half_space.distance(point) <= slack)
        };
        in_root && self.parts.iter().any(in_part)
    }

    /// Volume, centre and inertia at unit density, in the grid frame.
    pub fn mass_properties(&self) -> MassProperties {
        self.held.mass
    }

    /// Signed distance [m] at the nodes of [`GridSolid::grid`]: made when it is first asked for,
    /// then kept.
    pub fn level_set(&self) -> &LevelSet {
        if self.parts.is_empty() {
            return &self.field;
        }
        self.nodes.get_or_init(|| Arc::new(self.sample_nodes(None)))
    }

    /// Signed distance [m] at a point of [`GridSolid::grid`] in lattice units. Values above `most`
    /// [m] are only lower bounds.
    #[inline]
    pub fn value_at_lattice(&self, lattice: Vec3, most: f32) -> f32 {
        if self.parts.is_empty() {
            return self.field.value_at_lattice(lattice);
        }
        let clip = self.clip_value(lattice);
        if clip > most {
            return clip;
        }
        larger(self.field.value_at_lattice(self.on_field(lattice)), clip)
    }

    /// Signed distance [m] to the parts at a point in lattice units, and beyond the grid at least
    /// the way to it.
    #[inline]
    fn clip_value(&self, lattice: Vec3) -> f32 {
        let nearer = |nearest: f32, part: &Clip| nearest.min(part.value(lattice, nearest));
        let nearest = self.parts.iter().fold(f32::INFINITY, nearer);
        larger(nearest, self.beyond(lattice))
    }

    /// Distance from a lattice point to the box of the nodes [m]; minus infinity inside.
    #[inline]
    fn beyond(&self, lattice: Vec3) -> f32 {
        let top = Vec3::from_array(self.grid.dims.map(|n| (n - 1) as f32));
        let within = lattice.cmpge(Vec3::ZERO).all() && lattice.cmple(top).all();
        if within {
            return f32::NEG_INFINITY;
        }
        (lattice - lattice.clamp(Vec3::ZERO, top)).length() * self.grid.spacing as f32
    }

    /// The same point on the field's lattice.
    #[inline]
    fn on_field(&self, lattice: Vec3) -> Vec3 {
        lattice + Vec3::from_array(self.shift.map(|n| n as f32))
    }

    /// Signed distance [m] and its gradient, not normalised, at a point of [`GridSolid::grid`] in
    /// lattice units.
    pub(crate) fn value_and_gradient_at_lattice(&self, lattice: Vec3) -> (f32, Vec3) {
        // Beyond its grid a part has lost planes that no node of it sees: there the way to the grid
        // counts at least.
        let beyond = self.beyond(lattice);
        let mut nearest = (f32::INFINITY, Vec3::Y);
        for part in &self.parts {
            let here = part.value_and_gradient(lattice);
            if here.0 < nearest.0 {
                nearest = here;
            }
        }
        let of_field = self.field.value_and_gradient_at_lattice(self.on_field(lattice));
        if self.parts.is_empty() || (of_field.0 >= nearest.0 && of_field.0 >= beyond) {
            of_field
        } else if nearest.0 >= beyond {
            nearest
        } else {
            let top = Vec3::from_array(self.grid.dims.map(|n| (n - 1) as f32));
            (beyond, (lattice - lattice.clamp(Vec3::ZERO, top)).normalize_or(Vec3::Y))
        }
    }

    /// [`GridSolid::value_at_lattice`] at a grid-frame point [m].
    pub fn value(&self, point: DVec3) -> f32 {
        self.value_at_lattice(self.grid.lattice_from_point(point).as_vec3(), f32::INFINITY)
    }

    /// [`GridSolid::value_and_gradient_at_lattice`] at a grid-frame point [m].
    pub fn value_and_gradient(&self, point: DVec3) -> (f32, Vec3) {
        self.value_and_gradient_at_lattice(self.grid.lattice_from_point(point).as_vec3())
    }
}
