//! Shapes from their descriptions; equal descriptions share one shape.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::shape::{PartDesc, Resolution, ShapeDesc, SidesDesc};
use crate::scene::piece_file::load_mesh;
use crate::scene::voxel_count::{MARGIN, thickness_of, thinnest_of, voxels_for};
use frangible_geometry::{
    CleanMesh, ClosedForm, Compound, ContactHulls, Grid, GridSolid, HalfSpace, Hull, LevelSet,
    Part, PlaneSearch, Shape, Sides, Solid, StaticMesh, TriMesh, heightfield_mesh, mesh_samples,
    solids_and_boundary, surface_samples,
};
use frangible_math::RigidTransform;
use glam::{DVec3, Vec3};
use std::path::Path;
use std::sync::Arc;

/// Voxels between surface samples, unless told otherwise.
const SAMPLE_VOXELS: f64 = 2.0;

/// Surface samples along the longest side.
const MOST_SAMPLES_ALONG: f64 = 1000.0;

/// The hulls as which a mesh meets others until it breaks; one that they exceed by more is sampled.
/// Heaps of ten are cheaper and truer with samples where more than a dozen parts are needed: a torus
/// of 32 hulls took 79 ms a frame, its samples 5 ms.
const OF_WHOLE: ContactHulls = ContactHulls {
    vertices: 256,
    within: 5e-4,
    convex: 0.05,
    parts: 12,
    excess: 0.1,
    search: PlaneSearch::Thorough,
};

/// Parts of a compound: contact points know them by a 16-bit number.
const MOST_PARTS: usize = 1 << 16;

/// Target representation of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Make {
    /// Unbroken: exact, or on a grid for a given number of voxels.
    Whole,
    /// For breaking into convex polyhedra.
    Polyhedron,
    /// For breaking into pieces of a mesh's own surface.
    Solid,
    /// For breaking by voxels: on a grid.
    Voxels,
    /// An environment of triangles, closed or open.
    Triangles,
}

/// Every shape of a scene, once.
#[derive(Default)]
pub(crate) struct ShapeLibrary {
    shapes: Vec<(ShapeDesc, Make, Arc<Shape>)>,
}

impl ShapeLibrary {
    /// The shape of a description.
    pub(crate) fn shape(
        &mut self,
        desc: &ShapeDesc,
        make: Make,
        at: &Checker,
    ) -> Result<Arc<Shape>, BuildError> {
        if let Some((_, _, shape)) =
            self.shapes.iter().find(|(other, m, _)| other == desc && *m == make)
        {
            return Ok(shape.clone());
        }
        let shape = Arc::new(build_shape(desc, make, at)?);
        self.shapes.push((desc.clone(), make, shape.clone()));
        Ok(shape)
    }
}

fn build_shape(desc: &ShapeDesc, make: Make, at: &Checker) -> Result<Shape, BuildError> {
    // A rule holds also where the shape needs no voxels.
    for count in desc.resolution().voxels.into_iter().flatten() {
        at.field("resolution.voxels").count(count, 1, Grid::MOST_NODES)?;
    }
    match desc {
        ShapeDesc::HalfSpace => {
            let ground = HalfSpace { normal: DVec3::Y, offset: 0.0 };
            Ok(Shape::closed_form(ClosedForm::HalfSpace(ground), 1.0))
        }
        ShapeDesc::Sphere { radius, resolution } => {
            let radius = at.field("radius").length(*radius)?;
            from_form(ClosedForm::Sphere { radius }, resolution, make, at)
        }
        ShapeDesc::Box { size, resolution } => {
            let size = DVec3::from_array(*size);
            for edge in size.to_array() {
                at.field("size").length(edge)?;
            }
            from_form(ClosedForm::Box { half: 0.5 * size }, resolution, make, at)
        }
        ShapeDesc::Cylinder { radius, height, resolution } => {
            let radius = at.field("radius").length(*radius)?;
            let half_height = 0.5 * at.field("height").length(*height)?;
            from_form(ClosedForm::Cylinder { radius, half_height }, resolution, make, at)
        }
        ShapeDesc::Capsule { radius, height, resolution } => {
            let radius = at.field("radius").length(*radius)?;
            let half_height = 0.5 * at.field("height").length(*height)?;
            from_form(ClosedForm::Capsule { radius, half_height }, resolution, make, at)
        }
        ShapeDesc::Cone { radius, height, resolution } => {
            let radius = at.field("radius").length(*radius)?;
            let height = at.field("height").length(*height)?;
            from_form(ClosedForm::Cone { radius, height }, resolution, make, at)
        }
        ShapeDesc::Hull { points, resolution } => from_points(points, resolution, make, at),
        ShapeDesc::Compound { parts, resolution } => from_parts(parts, resolution, make, at),
        ShapeDesc::Mesh { path, scale, thickness, sides, resolution } => {
            let scale = at.field("scale").positive(*scale, "m")?;
            let at_path = at.field("path");
            let mut mesh = load_mesh(Path::new(path)).map_err(|error| at_path.file(&error))?;
            mesh.positions.iter_mut().for_each(|position| *position *= scale);
            let mesh = thickened(mesh, path, *thickness, at)?;
            if make == Make::Triangles {
                return from_triangles(&mesh, *sides, at);
            }
            check_unsided(*sides, at)?;
            from_mesh(&mesh, path, (resolution, make), at).map_err(|error| match error {
                BuildError::Rule { .. } => error,
                other => at_path.file(&other.to_string()),
            })
        }
        ShapeDesc::Triangles { positions, triangles, thickness, sides, resolution } => {
            let positions = positions.iter().copied().map(DVec3::from_array).collect();
            let mesh = TriMesh { positions, triangles: triangles.clone() };
            mesh.check(at.path())?;
            let mesh = thickened(mesh, at.path(), *thickness, at)?;
            if make == Make::Triangles {
                return from_triangles(&mesh, *sides, at);
            }
            check_unsided(*sides, at)?;
            from_mesh(&mesh, at.path(), (resolution, make), at)
        }
        ShapeDesc::Heightfield { heights, spacing, sides } => {
            if make != Make::Triangles {
                return Err(at.field("kind").broken("heightfield", HAS_SIDES));
            }
            let mesh = from_heights(heights, *spacing, at)?;
            from_triangles(&mesh, Some(sides.unwrap_or(SidesDesc::One)), at)
        }
    }
}

/// A formula, a formula that breaks into polyhedra, or its samples.
fn from_form(
    form: ClosedForm,
    resolution: &Resolution,
    make: Make,
    at: &Checker,
) -> Result<Shape, BuildError> {
    let (low, high) = form.bounds();
    if make == Make::Polyhedron {
        let spacing = spacing_of_exact(resolution, high - low, at)?;
        let no_volume = |_| at.broken("a half-space", "a shape with a volume to be broken");
        return Shape::breakable(form, spacing).map_err(no_volume);
    }
    if make == Make::Whole && resolution.voxels.is_none() {
        return Ok(Shape::closed_form(form, spacing_of_exact(resolution, high - low, at)?));
    }
    let thickness = (high - low).min_element();
    let voxels = voxels_for(high - low, thickness, resolution, at)?;
    let solid = GridSolid::from_closed_form(form, voxels, MARGIN)
        .map_err(|_| at.broken("a half-space", "a shape with a volume to be sampled"))?;
    sampled(solid, surface_samples, resolution, at)
}

/// The convex hull of points, or its samples.
fn from_points(
    points: &[[f64; 3]],
    resolution: &Resolution,
    make: Make,
    at: &Checker,
) -> Result<Shape, BuildError> {
    let hull = hull_of(points, at)?;
    let (low, high) = hull.bounds();
    if make == Make::Polyhedron || make == Make::Whole && resolution.voxels.is_none() {
        return convex(hull, resolution, &at.field("points"));
    }
    let voxels = voxels_for(high - low, thickness_of(&hull.surface()), resolution, at)?;
    sampled(GridSolid::from_hull(hull, voxels, MARGIN), surface_samples, resolution, at)
}

fn hull_of(points: &[[f64; 3]], at: &Checker) -> Result<Hull, BuildError> {
    let at_points = at.field("points");
    let mut checked = Vec::with_capacity(points.len());
    for (index, &point) in points.iter().enumerate() {
        checked.push(at.field(&format!("points[{index}]")).vector(point, "m")?);
    }
    let given = format!("{} points", points.len());
    let hull =
        Hull::of_points(&checked).map_err(|error| at_points.broken(&given, &error.to_string()))?;
    let (low, high) = hull.bounds();
    at_points.length((high - low).max_element())?;
    Ok(hull)
}

/// A compound of convex parts, or samples for breaking or a given number of voxels.
fn from_parts(
    parts: &[PartDesc],
    resolution: &Resolution,
    make: Make,
    at: &Checker,
) -> Result<Shape, BuildError> {
    let at_parts = at.field("parts");
    at_parts.count(parts.len(), 1, MOST_PARTS)?;
    let mut hulls = Vec::with_capacity(parts.len());
    for (index, part) in parts.iter().enumerate() {
        let at = at.field(&format!("parts[{index}]"));
        let (hull, position, orientation) = match part {
            PartDesc::Box { size, position, orientation } => {
                for &edge in size {
                    at.field("size").length(edge)?;
                }
                (Hull::cuboid(0.5 * DVec3::from_array(*size)), position, orientation)
            }
            PartDesc::Hull { points, position, orientation } => {
                (hull_of(points, &at)?, position, orientation)
            }
        };
        let rotation = at.field("orientation").rotation(*orientation)?;
        let translation = at.field("position").vector(*position, "m")?;
        hulls.push(hull.transformed(&RigidTransform::new(rotation, translation)));
    }
    let compound = Compound::new(hulls);
    let (low, high) = compound.bounds();
    if make != Make::Voxels && resolution.voxels.is_none() {
        let spacing = spacing_of_exact(resolution, high - low, at)?;
        let given = format!("{} parts", parts.len());
        return Shape::compound(compound, spacing)
            .map_err(|error| at_parts.broken(&given, &error.to_string()));
    }
    let thickness = |part: &Part| thickness_of(&part.hull.surface());
    let thinnest = compound.parts().iter().map(thickness).fold(f64::INFINITY, f64::min);
    let voxels = voxels_for(high - low, thinnest, resolution, at)?;
    let grid = Grid::around_box(low, high, voxels, MARGIN);
    let level_set = LevelSet::sample(grid, |point| compound.distance_and_gradient(point).0);
    let solid = GridSolid::from_level_set(level_set);
    let solid = match compound.outer_boundary() {
        Some(boundary) => solid.with_boundary(boundary),
        None => solid,
    };
    sampled(solid, |_, spacing| compound.samples(spacing), resolution, at)
}

/// A convex polyhedron as it is.
fn convex(hull: Hull, resolution: &Resolution, at: &Checker) -> Result<Shape, BuildError> {
    let (low, high) = hull.bounds();
    let spacing = spacing_of_exact(resolution, high - low, at)?;
    let given = format!("{} vertices", hull.vertices().len());
    Shape::convex(hull, spacing).map_err(|error| at.broken(&given, &error.to_string()))
}

/// Plates in place of a mesh's open parts, if they have a thickness [m].
fn thickened(
    mesh: TriMesh,
    name: &str,
    thickness: Option<f64>,
    at: &Checker,
) -> Result<TriMesh, BuildError> {
    let Some(thickness) = thickness else { return Ok(mesh) };
    let thickness = at.field("thickness").positive(thickness, "m")?;
    Ok(mesh.thickened(thickness, name)?.mesh)
}

/// What may have sides.
const HAS_SIDES: &str = "left out, but on a static or kinematic body without breaking, bonds and \
                         resolution, in the frame-rate method";

/// Solids have an inside.
fn check_unsided(sides: Option<SidesDesc>, at: &Checker) -> Result<(), BuildError> {
    match sides {
        Some(SidesDesc::One) => Err(at.field("sides").broken("one", HAS_SIDES)),
        Some(SidesDesc::Two) => Err(at.field("sides").broken("two", HAS_SIDES)),
        None => Ok(()),
    }
}

/// Triangles as they are.
fn from_triangles(
    mesh: &TriMesh,
    sides: Option<SidesDesc>,
    at: &Checker,
) -> Result<Shape, BuildError> {
    let encloses = || mesh.is_watertight() && mesh.mass_properties().volume > 0.0;
    let sides = match sides {
        Some(SidesDesc::One) => Sides::One,
        Some(SidesDesc::Two) => Sides::Two,
        None if encloses() => Sides::One,
        None => Sides::Two,
    };
    let given = format!("{} triangles without an area", mesh.triangles.len());
    let built = StaticMesh::new(mesh, sides);
    let built =
        built.ok_or_else(|| at.broken(&given, "triangles with at least one that has an area"))?;
    Ok(Shape::static_mesh(built))
}

/// The triangles of rows of heights.
fn from_heights(
    heights: &[Vec<f64>],
    spacing: [f64; 2],
    at: &Checker,
) -> Result<TriMesh, BuildError> {
    for &distance in &spacing {
        at.field("spacing").length(distance)?;
    }
    let at_heights = at.field("heights");
    let columns = heights.first().map_or(0, Vec::len);
    if heights.len() < 2 || columns < 2 {
        let given = format!("{} rows, the first of {columns}", heights.len());
        return Err(at_heights.broken(&given, "at least two rows of at least two heights"));
    }
    for (k, row) in heights.iter().enumerate() {
        let at = at.field(&format!("heights[{k}]"));
        if row.len() != columns {
            let rule = format!("as many as the first row, {columns}");
            return Err(at.broken(&format!("{} heights", row.len()), &rule));
        }
        for &height in row {
            at.within(height, -1e6, 1e6)?;
        }
    }
    Ok(heightfield_mesh(heights, spacing))
}

/// The solid of a mesh that came from the file, or the field, `name`, or its samples.
fn from_mesh(
    mesh: &TriMesh,
    name: &str,
    (resolution, make): (&Resolution, Make),
    at: &Checker,
) -> Result<Shape, BuildError> {
    let clean = mesh.cleaned(name)?;
    let (low, high) = clean.mesh.bounds();
    if make == Make::Solid
        && let Some(shape) = exact_solid(&clean, spacing_of_exact(resolution, high - low, at)?)
    {
        return Ok(shape);
    }
    let voxels = voxels_for(high - low, thinnest_of(&clean), resolution, at)?;
    let grid = Grid::around_box(low, high, voxels, MARGIN);
    let (level_set, boundary) = solids_and_boundary(&clean, grid)
        .map_err(|error| BuildError::Sampling { path: name.into(), error })?;
    let solid = GridSolid::from_level_set(level_set).with_boundary(boundary.clone());
    sampled(solid, |solid, spacing| mesh_samples(solid, &boundary, spacing), resolution, at)
}

/// A solid of a mesh's own surface; `None` if it cannot be closed.
fn exact_solid(clean: &CleanMesh, spacing: f64) -> Option<Shape> {
    let solid = Solid::of_clean(clean)?;
    let mass = solid.mass_properties();
    let (hulls, excess) = OF_WHOLE.of(&solid);
    let hulls = if excess <= OF_WHOLE.excess { hulls } else { Vec::new() };
    Shape::solid_with_mass(solid, hulls, &mass, spacing).ok()
}

/// Distance between surface samples of what is not on a grid [m].
fn spacing_of_exact(
    resolution: &Resolution,
    extent: DVec3,
    at: &Checker,
) -> Result<f64, BuildError> {
    check_spacing(resolution.sample_spacing.unwrap_or(0.1 * extent.max_element()), extent, at)
}

/// Distance between surface samples [m]: what is sampled a thousand times along a side has millions
/// of samples.
fn check_spacing(spacing: f64, extent: DVec3, at: &Checker) -> Result<f64, BuildError> {
    let least = extent.max_element() / MOST_SAMPLES_ALONG;
    at.field("resolution.sample_spacing").at_least(
        spacing,
        least,
        "m, a thousandth of the longest side",
    )
}

/// Mass and principal axes of a solid on a grid, with the surface samples that `samples_of` finds
/// at a spacing [m].
fn sampled(
    solid: GridSolid,
    samples_of: impl Fn(&GridSolid, f64) -> Vec<Vec3>,
    resolution: &Resolution,
    at: &Checker,
) -> Result<Shape, BuildError> {
    let voxels = at.field("resolution.voxels");
    let [x, y, z] = solid.grid().dims.map(|nodes| nodes - 2 * MARGIN);
    let given = format!("[{x}, {y}, {z}]");
    if !solid.level_set().phi().iter().any(|&phi| phi < 0.0) {
        return Err(voxels.broken(&given, "so many that a node lies inside of the shape"));
    }
    let spacing = resolution.sample_spacing.unwrap_or(SAMPLE_VOXELS * solid.grid().spacing);
    let (low, high) = solid.grid().bounds();
    let spacing = check_spacing(spacing, high - low, at)?;
    let samples = samples_of(&solid, spacing);
    Shape::from_grid_solid(solid, samples)
        .map_err(|error| voxels.broken(&given, &format!("finer: {error}")))
}
