//! Scenes: described, checked and built.

pub(crate) mod bonds;
pub(crate) mod breaking;
pub(crate) mod build;
pub(crate) mod check;
pub(crate) mod desc;
pub(crate) mod fineness;
pub(crate) mod groups;
pub(crate) mod own_mass;
pub(crate) mod pattern_choice;
pub(crate) mod patterns;
pub(crate) mod piece_file;
pub(crate) mod shapes;
pub(crate) mod starts;
pub(crate) mod strength;
pub(crate) mod strength_points;
pub(crate) mod voxel_count;
