//! Contacts of convex polyhedra within a frame: separating axes, then face clipping, or edge
//! against edge [Gregorius13].

pub(crate) mod approach;
pub(crate) mod closest_points;
pub(crate) mod contact;
pub(crate) mod face_clipping;
pub(crate) mod feature_scan;
pub(crate) mod furthest_face;
pub(crate) mod hull_pair;
pub(crate) mod hull_point;
pub(crate) mod placement;
pub(crate) mod reduction;
pub(crate) mod reference_sides;
pub(crate) mod scratch;
pub(crate) mod separating_axis;
pub(crate) mod separation;
pub(crate) mod turning_clip;

#[cfg(test)]
mod many_vertices;
