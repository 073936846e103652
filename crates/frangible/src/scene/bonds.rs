//! Bodies that are cut into pieces and glued together.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::breaking::BondsDesc;
use crate::scene::desc::{BodyDesc, MotionDesc};
use crate::scene::patterns::build_pattern;
use crate::scene::piece_file::{PieceFile, parts_of_mesh};
use crate::scene::strength_points::build_strength_points;
use crate::step::bonds::state::Bonds;
use frangible_fracture::{BondStrength, Glued, Impact, Prescored, prescore, prescore_parts};
use frangible_geometry::Shape;
use frangible_math::RigidTransform;
use glam::DVec3;
use std::sync::Arc;

/// Cuts a body into pieces and glues them together.
pub(crate) fn build_bonds(
    desc: &BondsDesc,
    body: &BodyDesc,
    shape: &Arc<Shape>,
    world_from_shape: &RigidTransform,
    at: &Checker,
) -> Result<Bonds, BuildError> {
    let strength = BondStrength {
        tension: at.field("tensile_strength").positive(desc.tensile_strength, "Pa")?,
        shear: at.field("shear_strength").positive(desc.shear_strength, "Pa")?,
    };
    check_body(body, at)?;
    let anchors = build_anchors(desc, at)?;
    let impact = place_pattern(desc, shape, at)?;
    let pieces = cut_pieces(desc, body, shape, &impact, at)?;
    let is_anchored = |center: DVec3| {
        let world = world_from_shape.point(center);
        anchors.iter().any(|(low, high)| low.cmple(world).all() && world.cmple(*high).all())
    };
    let glued = Glued::new(pieces, is_anchored, strength).with_strength_points(
        build_strength_points((&desc.strength_points, &desc.strength_triangles), at)?,
    );
    if !anchors.is_empty() && !glued.is_anchored() {
        return Err(at.field("anchors").broken(
            "boxes without the centre of a piece",
            "boxes that hold the centres of the pieces to be fixed",
        ));
    }
    let (low, high) = shape.bounds;
    let spacing =
        body.shape.resolution().sample_spacing.unwrap_or(0.1 * (high - low).max_element());
    Ok(Bonds { glued, carried: Vec::new(), sample_spacing: spacing })
}

/// Only dynamic bodies without other breaking have bonds.
fn check_body(body: &BodyDesc, at: &Checker) -> Result<(), BuildError> {
    if body.motion != MotionDesc::Dynamic {
        return Err(at.broken(
            "on a body that is not dynamic",
            "left out, or the body dynamic: anchors hold it",
        ));
    }
    if body.breaking.is_some() {
        return Err(at.broken("on a body with 'breaking'", "left out, or 'breaking' left out"));
    }
    Ok(())
}

/// Low and high corners of the boxes whose pieces are fixed, world frame [m].
fn build_anchors(desc: &BondsDesc, at: &Checker) -> Result<Vec<(DVec3, DVec3)>, BuildError> {
    let numbered = desc.anchors.iter().enumerate();
    let anchors = numbered.map(|(index, anchor)| {
        let at = at.field(&format!("anchors[{index}]"));
        let low = at.field("low").vector(anchor.low, "m")?;
        Ok((low, at.field("high").vector(anchor.high, "m")?))
    });
    anchors.collect()
}

/// Point and direction that the pattern is laid on: by default the middle of the body.
fn place_pattern(desc: &BondsDesc, shape: &Shape, at: &Checker) -> Result<Impact, BuildError> {
    let middle = shape.body_from_grid.inverse().point(0.5 * (shape.bounds.0 + shape.bounds.1));
    let point = desc.point.map_or(Ok(middle), |point| at.field("point").vector(point, "m"))?;
    let at_normal = at.field("normal");
    let normal = at_normal
        .vector(desc.normal, "")?
        .try_normalize()
        .ok_or_else(|| at_normal.broken("0, 0, 0", "a direction"))?;
    Ok(Impact {
        point_body: shape.body_from_grid.point(point),
        normal_body: shape.body_from_grid.direction(normal),
    })
}

/// The pieces: cells of the pattern, or without one the parts of the shape.
fn cut_pieces(
    desc: &BondsDesc,
    body: &BodyDesc,
    shape: &Arc<Shape>,
    impact: &Impact,
    at: &Checker,
) -> Result<Prescored, BuildError> {
    let of_pattern = |pattern| build_pattern(pattern, &at.field("pattern")).map(Arc::new);
    let pattern = desc.pattern.as_ref().map(of_pattern).transpose()?;
    let parts = if pattern.is_some() { None } else { parts_of_mesh(&body.shape, at)? };
    if let Some(PieceFile { meshes, contacts }) = parts {
        return prescore_parts(shape, meshes, contacts).map_err(|error| at.file(&error));
    }
    prescore(shape, pattern.as_ref(), impact).ok_or_else(|| {
        at.broken(
            "on a shape without parts, and without a pattern",
            "with a pattern, or on a compound or a mesh of several closed parts",
        )
    })
}
