//! How a body breaks: checked, and fitted to its shape.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::breaking::{BreakingDesc, StrengthDesc};
use crate::scene::desc::shape::{Resolution, ShapeDesc};
use crate::scene::desc::{BodyDesc, Method, MotionDesc};
use crate::scene::pattern_choice::{LEAST_PIECE, PatternChoice};
use crate::scene::shapes::{Make, ShapeLibrary};
use crate::scene::strength::Strength;
use crate::scene::strength_points::build_strength_points;
use crate::world::Breaking;
use frangible_fracture::{MOST_CELLS, Reach, Rim, ShatterSettings, Smallest};
use frangible_geometry::{BodyFrame, Geometry, Shape};
use std::sync::Arc;

/// Convex bodies under planar cracks break exactly into convex pieces, and meshes into pieces of
/// their own surface. The paper's method uses level sets instead.
pub(crate) fn make_to_break(desc: &BodyDesc, breaking: &Breaking, method: Method) -> Make {
    let is_exact = desc.shape.is_convex()
        || breaking.shatter.reach.is_some() && matches!(desc.shape, ShapeDesc::Compound { .. });
    let may_be_exact = method == Method::FrameRate && breaking.choice.is_planar();
    let is_solid = desc.shape.is_mesh() && breaking.shatter.reach.is_none();
    let asks_for_voxels = *desc.shape.resolution() != Resolution::default();
    if may_be_exact && is_exact {
        Make::Polyhedron
    } else if may_be_exact && is_solid && !asks_for_voxels {
        Make::Solid
    } else {
        Make::Voxels
    }
}

/// The shape of a body for as long as it is whole, if it is another than the one that it breaks as:
/// exact for one that breaks on a grid, but not for meshes, bodies that ask for voxels and those with
/// a mass of their own; and on a grid for a solid that no few hulls stand for.
pub(crate) fn shape_until_broken(
    desc: &BodyDesc,
    solid: &Arc<Shape>,
    (at, library): (&Checker, &mut ShapeLibrary),
) -> Result<Option<Shape>, BuildError> {
    let is_exact = desc.shape.is_convex() || matches!(desc.shape, ShapeDesc::Compound { .. });
    let is_free = desc.shape.resolution().voxels.is_none() && desc.mass_properties.is_none();
    if matches!(solid.geometry, Geometry::Solid(_)) {
        if solid.hull.is_some() || solid.compound.is_some() {
            return Ok(None);
        }
        let sampled = library.shape(&desc.shape, Make::Voxels, &at.field("shape"))?;
        let Shape { body_from_grid, volume, unit_moments, .. } = **solid;
        return Ok(sampled.with_body_frame(BodyFrame { body_from_grid, volume, unit_moments }));
    }
    let has_grid = matches!(solid.geometry, Geometry::Grid(_));
    if !(is_exact && is_free && has_grid) {
        return Ok(None);
    }
    let whole = library.shape(&desc.shape, Make::Whole, &at.field("shape"))?;
    Ok(whole.with_mass_of(solid))
}

/// A breakable body moves by itself, and is of one strength in the paper's method.
pub(crate) fn check_breaking(
    desc: &BodyDesc,
    breaking: Option<&Breaking>,
    method: Method,
    at: &Checker,
) -> Result<(), BuildError> {
    let Some(breaking) = breaking else { return Ok(()) };
    if method.is_papers() && breaking.strength_points.is_some() {
        let at = at.field("breaking.strength_points");
        return Err(at.broken("set", "left out, with the paper's method"));
    }
    if desc.motion != MotionDesc::Dynamic {
        return Err(at
            .field("breaking")
            .broken("on a body that is not dynamic", "left out, or the body dynamic"));
    }
    Ok(())
}

/// Cracks are sampled as densely as the surface was, and pieces are not too small for it.
pub(crate) fn fit_to_shape(mut breaking: Breaking, desc: &ShapeDesc, shape: &Shape) -> Breaking {
    breaking.shatter.smallest = Smallest::of_first(shape);
    if breaking.choice.wanted().is_some() {
        breaking.shatter.smallest.part = LEAST_PIECE;
    }
    if let (Geometry::Grid(solid), Some(spacing)) =
        (&shape.geometry, desc.resolution().sample_spacing)
    {
        breaking.shatter.sample_spacing_voxels = spacing / solid.grid().spacing;
    }
    breaking
}

pub(crate) fn build_breaking(desc: &BreakingDesc, at: &Checker) -> Result<Breaking, BuildError> {
    let strength = build_strength(&desc.strength, &at.field("strength"))?;
    at.field("generations").count(desc.generations as usize, 1, 64)?;
    let smallest = at.field("smallest").not_negative(desc.smallest)?;

    // Patterns of energy-limited blows need coarser alternatives.
    let pieces = match desc.pieces {
        Some(pieces) => Some(at.field("pieces").count(pieces, 2, MOST_CELLS)?),
        None => None,
    };
    let has_coarser = strength.fracture_energy() > 0.0 && pieces.is_none();
    let at_pattern = at.field("pattern");
    let choice = Arc::new(PatternChoice::new(&desc.pattern, pieces, has_coarser, &at_pattern)?);
    let reach = match desc.reach {
        Some(reach) => {
            let distance = at.field("reach").positive(reach, "m")?;
            let rim = if desc.pattern.has_cells_of_its_own() { Rim::Cells } else { Rim::Bowl };
            Some(Reach { distance, rim })
        }
        None => None,
    };
    let twist = at.field("twist").within(desc.twist, -1e3, 1e3)?;
    let shatter = ShatterSettings { reach, twist, ..ShatterSettings::default() };
    let center = desc.point.map(|point| at.field("point").vector(point, "m")).transpose()?;
    Ok(Breaking {
        choice,
        strength,
        shatter,
        generations: desc.generations,
        smallest,
        center,
        strength_points: build_strength_points(
            (&desc.strength_points, &desc.strength_triangles),
            at,
        )?,
        solid: None,
    })
}

fn build_strength(desc: &StrengthDesc, at: &Checker) -> Result<Strength, BuildError> {
    let material = match desc {
        StrengthDesc::Impulse(impulse) => return Ok(Strength::Impulse(at.impulse(*impulse)?)),
        StrengthDesc::Named(name) => name.properties(),
        StrengthDesc::Material(material) => *material,
    };
    at.field("tensile_strength").positive(material.tensile_strength, "Pa")?;
    at.field("youngs_modulus").positive(material.youngs_modulus, "Pa")?;
    at.field("fracture_energy").not_negative(material.fracture_energy)?;
    at.field("weibull_modulus").within(material.weibull_modulus, 1.0, 1e3)?;
    Ok(Strength::Material(material))
}
