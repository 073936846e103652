//! User settings of a break.

use crate::reach::Reach;
use crate::slivers::Smallest;
use frangible_math::check::{Check, Checked, finite, require};
use serde::{Deserialize, Serialize};

/// User settings of a break.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShatterSettings {
    /// A connected part with less material joins its neighbour [voxels]. Default 27: in a block of
    /// three voxels a side the middle one is the first whose distance and gradient the samples
    /// resolve.
    pub smallest_fragment_voxels: f64,
    /// Distance between samples on cracks, in units of the grid's spacing. Default 2: a contact on
    /// a crack is found within one voxel of its place.
    pub sample_spacing_voxels: f64,
    /// The bounds below which a part is no piece, on a grid or without one.
    pub smallest: Smallest,
    /// How far the break reaches; by default through all of the body.
    pub reach: Option<Reach>,
    /// Turn of the pattern about the collision normal [rad]; 0 by default.
    pub twist: f64,
}

impl Check for ShatterSettings {
    fn check(&self) -> Checked {
        let Smallest { part, volume, slenderness } = self.smallest;
        let bounds = [self.smallest_fragment_voxels, part, volume, slenderness];
        let are_sizes = bounds.iter().all(|&bound| (0.0..1e30).contains(&bound));
        require(are_sizes, "least sizes of fragments")?;
        let is_spacing = (1e-3..1e30).contains(&self.sample_spacing_voxels);
        require(is_spacing, "a spacing of samples on cracks")?;
        finite(self.twist)?;
        let reach = self.reach.map_or(1.0, |reach| reach.distance);
        require(reach > 0.0 && reach < 1e30, "a reach")
    }
}

impl Default for ShatterSettings {
    fn default() -> Self {
        Self {
            smallest_fragment_voxels: 27.0,
            sample_spacing_voxels: 2.0,
            smallest: Smallest::default(),
            reach: None,
            twist: 0.0,
        }
    }
}
