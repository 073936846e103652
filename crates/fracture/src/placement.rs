//! Where a pattern lies on a body.

use crate::pattern::region::{Cut, Region};
use frangible_geometry::HalfSpace;
use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// A similarity transform from the pattern frame to the struck body's grid frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// A rotation.
    pub grid_from_pattern: DMat3,
    /// Metres per unit of the pattern.
    pub scale: f64,
    /// Point of the pattern to place at the impact point, pattern frame.
    pub center_pattern: DVec3,
    /// The impact point, grid frame [m].
    pub point_grid: DVec3,
}

impl Check for Placement {
    fn check(&self) -> Checked {
        let turn = self.grid_from_pattern;
        let off = turn.transpose() * turn - DMat3::IDENTITY;
        let is_turn = off.to_cols_array().iter().all(|part| part.abs() < 1e-6);
        require(is_turn, "a rotation of the pattern")?;
        require(self.scale > 0.0 && self.scale < 1e30, "a scale of the pattern")?;
        finite_vector(self.center_pattern)?;
        finite_vector(self.point_grid)
    }
}

impl Placement {
    /// Image of a point [m].
    pub fn point(&self, point_pattern: DVec3) -> DVec3 {
        self.point_grid
            + self.scale * (self.grid_from_pattern * (point_pattern - self.center_pattern))
    }

    /// The point of the pattern frame whose image is a point of the grid frame [m].
    pub(crate) fn pattern_from_grid(&self, point_grid: DVec3) -> DVec3 {
        let turned = self.grid_from_pattern.transpose() * (point_grid - self.point_grid);
        self.center_pattern + turned / self.scale
    }

    /// Image of a half-space. The unit normal stays one.
    pub fn half_space(&self, half_space: &HalfSpace) -> HalfSpace {
        let normal = (self.grid_from_pattern * half_space.normal).normalize();
        let beyond_center = half_space.offset - half_space.normal.dot(self.center_pattern);
        HalfSpace { normal, offset: normal.dot(self.point_grid) + self.scale * beyond_center }
    }

    /// Image of a region.
    pub fn region(&self, region: &Region) -> Region {
        let place = |cut: &Cut| Cut {
            half_space: self.half_space(&cut.half_space),
            face: cut.face.iter().map(|&corner| self.point(corner)).collect(),
        };
        Region { cuts: region.cuts.iter().map(place).collect() }
    }

    /// Images of the regions' planes, without faces: most of these lie beyond the body.
    pub(crate) fn planes(&self, regions: &[Region]) -> Vec<Region> {
        let place =
            |cut: &Cut| Cut { half_space: self.half_space(&cut.half_space), face: Vec::new() };
        regions
            .iter()
            .map(|region| Region { cuts: region.cuts.iter().map(place).collect() })
            .collect()
    }
}
