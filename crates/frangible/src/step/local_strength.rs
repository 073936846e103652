//! What bodies bear where they are struck.

use crate::world::Label;
use frangible_bodies::Bodies;
use glam::DVec3;

/// The largest impulse that a breakable body, by dense index, bears at a point of its frame [m]: by
/// its thickness there, and by its strength points [N s]. At least what it bears where it is
/// weakest, `bodies.surfaces[i].strength`, which is asked first.
pub(crate) fn bears_at(bodies: &Bodies, labels: &[Label], i: usize, point_body: DVec3) -> f64 {
    let bears = bodies.surfaces[i].strength;
    let (shape, density) = (&bodies.shapes[i], bodies.densities[i]);
    // What stays whole in this frame bears all.
    match &labels[i].breaking {
        Some(breaking) if bears.is_finite() => breaking.bears_at(shape, density, point_body, bears),
        _ => bears,
    }
}
