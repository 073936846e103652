//! How much of each voxel is material, and the sums over it.

use crate::{LevelSet, MassProperties};

/// The fraction of each node's voxel that lies inside, from the value and the gradient at the node: the part of a cube
/// on one side of a plane. One value in [0, 1] for each node.
pub fn voxel_coverage(_level_set: &LevelSet) -> Vec<f32> {
    todo!()
}

/// Sums over voxels, each with the self-inertia of a cube (h^2/6 on the diagonal per unit mass).
///
/// Additive: the sums over the parts of a partition of the voxels give the sums over the whole, so that mass, momentum,
/// angular momentum and kinetic energy are equal before and after a break.
pub fn mass_properties(_grid: &crate::Grid, _coverage: &[f32]) -> MassProperties {
    todo!()
}
