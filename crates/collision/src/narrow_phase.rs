//! Narrow phase: contact points of pairs, one file per pair of shapes.

pub(crate) mod compound;
pub(crate) mod convex_pairs;
pub(crate) mod convex_shape;
pub(crate) mod core;
pub(crate) mod finder;
pub(crate) mod fixed_neighbours;
pub(crate) mod flat_contacts;
pub(crate) mod hull_hull;
pub(crate) mod hull_plane;
pub(crate) mod mesh;
pub(crate) mod pair_motion;
pub(crate) mod pair_separation;
pub(crate) mod pierced;
pub(crate) mod revolved;
pub(crate) mod samples;
pub(crate) mod seam_contacts;
pub(crate) mod seams;
pub(crate) mod sphere;
pub(crate) mod way_out;
