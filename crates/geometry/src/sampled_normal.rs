//! Normals of sampled surfaces.

use crate::level_set::LevelSet;
use glam::DVec3;

/// Direction of the samples' gradient over a cell around a point.
pub(crate) fn sampled_normal(level_set: &LevelSet, point: DVec3) -> Option<DVec3> {
    // Differences over a cell around the point favour none of the cells that meet there.
    let half = 0.5 * level_set.grid().spacing;
    let along = |axis: DVec3| {
        f64::from(level_set.value(point + half * axis))
            - f64::from(level_set.value(point - half * axis))
    };
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z)).try_normalize()
}
