//! How finely a shape is sampled that has no resolution of its own.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::shape::Resolution;
use frangible_geometry::{CleanMesh, Grid, TriMesh};
use glam::DVec3;

/// Layers of voxels around a solid, so that its surface and the band around it lie inside of the
/// grid.
pub(crate) const MARGIN: usize = 2;

/// Voxels along the longest side, if no part is thin.
const ALONG: f64 = 64.0;

/// Voxels in the thickness of the thinnest part: of what is thinner, samples miss a share of the
/// volume. A plank of 2 x 0.2 x 0.04 m held 15 % too much at 31 mm, and broke into 12 of 30 pieces.
const ACROSS: f64 = 3.0;

/// Most voxels for the sake of a thin part: as many as a cube has.
const MOST: f64 = ALONG * ALONG * ALONG;

/// A part with less of the volume does not decide.
const LEAST_PART: f64 = 0.01;

/// Voxels along each side of the bounding box of a shape whose thinnest part is so thick [m].
pub(crate) fn voxels_for(
    extent: DVec3,
    thickness: f64,
    resolution: &Resolution,
    at: &Checker,
) -> Result<[usize; 3], BuildError> {
    let voxels = resolution.voxels.unwrap_or_else(|| by_thickness(extent, thickness));
    let at = at.field("resolution.voxels");
    let total = voxels
        .iter()
        .try_fold(1_usize, |product, &n| product.checked_mul(n.checked_add(2 * MARGIN)?));
    if total.is_none_or(|total| total > Grid::MOST_NODES) {
        return Err(at.broken(
            &format!("{voxels:?}"),
            &format!("at most {} with their margin, to fit in memory", Grid::MOST_NODES),
        ));
    }
    Ok(voxels)
}

/// Voxels along each side of the bounding box of a mesh's solids without a resolution of their own.
pub fn default_voxels(clean: &CleanMesh) -> [usize; 3] {
    let (low, high) = clean.mesh.bounds();
    by_thickness(high - low, thinnest_of(clean))
}

fn by_thickness(extent: DVec3, thickness: f64) -> [usize; 3] {
    let longest = extent.max_element() / ALONG;
    let along = |spacing: f64| (extent / spacing).ceil().max(DVec3::ONE);
    let mut spacing = (thickness / ACROSS).min(longest).max(1e-3 * longest);
    // Coarser until there are few enough.
    while spacing < longest && along(spacing).element_product() > MOST {
        spacing = (1.05 * spacing).min(longest);
    }
    along(spacing).to_array().map(|count| count as usize)
}

/// Volume [m^3] and area [m^2] of what a surface encloses.
#[derive(Clone, Copy, Default)]
struct Extents {
    volume: f64,
    area: f64,
}

impl Extents {
    fn add(&mut self, [a, b, c]: [DVec3; 3]) {
        self.volume += a.dot(b.cross(c)) / 6.0;
        self.area += 0.5 * (b - a).cross(c - a).length();
    }

    /// Of a plate it is twice its volume by its area [m].
    fn thickness(&self) -> f64 {
        2.0 * self.volume.abs() / self.area
    }
}

/// How thick a solid is in the mean, if it is a plate [m].
pub(crate) fn thickness_of(surface: &TriMesh) -> f64 {
    let mut extents = Extents::default();
    (0..surface.triangles.len()).for_each(|triangle| extents.add(surface.corners(triangle)));
    extents.thickness()
}

/// The same of the thinnest of a mesh's solids.
pub(crate) fn thinnest_of(clean: &CleanMesh) -> f64 {
    let mut solids: Vec<Extents> = Vec::new();
    for (triangle, &solid) in clean.solid.iter().enumerate() {
        if solids.len() <= solid as usize {
            solids.resize(solid as usize + 1, Extents::default());
        }
        solids[solid as usize].add(clean.mesh.corners(triangle));
    }
    let least = LEAST_PART * solids.iter().map(|solid| solid.volume.abs()).sum::<f64>();
    let large = solids.iter().filter(|solid| solid.volume.abs() >= least);
    large.map(Extents::thickness).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thin parts are three voxels thick, as far as a cube's number of voxels goes; what is thick
    /// has 64 along its longest side.
    #[test]
    fn thin_parts_are_resolved_within_a_bound() {
        let plank = by_thickness(DVec3::new(2.0, 0.2, 0.04), 0.0328);
        assert!(plank[2] >= 3 && plank[0] > 150, "{plank:?}");
        assert_eq!(by_thickness(DVec3::ONE, 1.0 / 3.0), [64; 3]);
        for (extent, thickness) in
            [(DVec3::new(3.0, 0.006, 2.0), 0.006), (DVec3::ONE, 0.01), (DVec3::ONE, 1e-9)]
        {
            let voxels = by_thickness(extent, thickness);
            assert!(voxels.iter().product::<usize>() <= 64 * 64 * 64, "{voxels:?}");
            assert!(*voxels.iter().max().unwrap() >= 64, "{voxels:?}");
        }
    }
}
