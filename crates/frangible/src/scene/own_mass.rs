//! Mass properties of a body's own: checks, and the shape that has them.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::mass_properties::MassDesc;
use crate::scene::desc::{BodyDesc, MotionDesc};
use frangible_geometry::{BodyFrame, MassProperties, Shape, parallel_axis};
use frangible_math::RigidTransform;
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// Moments may break the triangle inequality by this [1]: a disc has equality, and a stage holds
/// singles.
const ROUNDING: f64 = 1e-6;
/// Off-diagonal moments below this part of the largest are rounding [1]; with them a body of
/// revolution would lose its axis.
const DIAGONAL: f64 = 1e-7;
/// Lengths of a shape that its centre of mass may be outside of its bounds [1].
const MOST_OFFSET: f64 = 10.0;

/// The shape and the density [kg/m^3] with the mass properties that a body has of its own, if it
/// has any.
pub(crate) fn with_own_mass(
    desc: &BodyDesc,
    shape: Arc<Shape>,
    density: f64,
    at: &Checker,
) -> Result<(Arc<Shape>, f64), BuildError> {
    let Some(own) = &desc.mass_properties else { return Ok((shape, density)) };
    let at = at.field("mass_properties");
    if desc.motion != MotionDesc::Dynamic {
        return Err(at.broken(
            &format!("on a {} body", desc.motion.name()),
            "left out: its mass is infinite",
        ));
    }
    if desc.breaking.is_some() || desc.bonds.is_some() {
        let rule = "left out: pieces have the mass of their shapes";
        return Err(at.broken("on a body that breaks or is glued", rule));
    }
    let density = match own.mass {
        Some(mass) => at.field("mass").positive(mass, "kg")? / shape.volume,
        None => density,
    };
    if own.center.is_none() && own.moments.is_none() {
        return Ok((shape, density));
    }
    let grid_from_body = shape.body_from_grid.inverse();
    let center = match own.center {
        Some(center) => at.field("center").vector(center, "m")?,
        None => grid_from_body.translation,
    };
    check_center(&shape, center, &at)?;
    let unit_inertia = match own.moments {
        Some(moments) => own_inertia(own, moments, &at)? * density.recip(),
        None => inertia_about(&shape, center),
    };
    let mass = MassProperties { volume: shape.volume, center, inertia: diagonal(unit_inertia) };
    let (unit_moments, axes) = mass.principal_axes();
    let body_from_grid = RigidTransform::new(axes, center).inverse();
    let frame = BodyFrame { body_from_grid, volume: shape.volume, unit_moments };
    match shape.with_body_frame(frame) {
        Some(shape) => Ok((Arc::new(shape), density)),
        None => Err(at.broken(
            "of a round shape off its axis or its middle",
            "about its middle, with one of its axes along y",
        )),
    }
}

/// Near the shape: a load on a stick may be outside, but a
/// radius far above the size would make all turns look fast.
fn check_center(shape: &Shape, center: DVec3, at: &Checker) -> Result<(), BuildError> {
    let center_body = shape.body_from_grid.point(center);
    let (low, high) = shape.bounds;
    let most = DVec3::splat(MOST_OFFSET * (high - low).max_element());
    if center_body.cmpge(low - most).all() && center_body.cmple(high + most).all() {
        return Ok(());
    }
    let rule = "no farther from the shape than ten times its length";
    Err(at.field("center").broken(&format!("{:?}", center.to_array()), rule))
}

/// Inertia tensor about the centre of mass, in the shape's frame [kg m^2].
fn own_inertia(own: &MassDesc, moments: [f64; 3], at: &Checker) -> Result<DMat3, BuildError> {
    let axes = DMat3::from_quat(at.field("axes").rotation(own.axes)?);
    let at = at.field("moments");
    for moment in moments {
        at.positive(moment, "kg m^2")?;
    }
    let largest = moments.into_iter().fold(0.0, f64::max);
    if 2.0 * largest > moments.iter().sum::<f64>() * (1.0 + ROUNDING) {
        let rule = "at most the sum of the other two, each";
        return Err(at.broken(&format!("{moments:?}"), rule));
    }
    Ok(axes * DMat3::from_diagonal(DVec3::from_array(moments)) * axes.transpose())
}

/// Inertia tensor of an evenly filled shape about a point, in the shape's frame, at unit density
/// [m^5].
fn inertia_about(shape: &Shape, center: DVec3) -> DMat3 {
    let grid_from_body = shape.body_from_grid.inverse();
    let axes = DMat3::from_quat(grid_from_body.rotation);
    let about_own = axes * DMat3::from_diagonal(shape.unit_moments) * axes.transpose();
    about_own + parallel_axis(shape.volume, center - grid_from_body.translation)
}

/// Symmetric, and without rounding off its diagonal.
fn diagonal(tensor: DMat3) -> DMat3 {
    let tensor = 0.5 * (tensor + tensor.transpose());
    let of_diagonal = DVec3::new(tensor.x_axis.x, tensor.y_axis.y, tensor.z_axis.z);
    let off = [tensor.x_axis.y, tensor.x_axis.z, tensor.y_axis.z];
    let largest = off.into_iter().fold(0.0, |largest: f64, moment| largest.max(moment.abs()));
    if largest < DIAGONAL * of_diagonal.max_element() {
        return DMat3::from_diagonal(of_diagonal);
    }
    tensor
}
