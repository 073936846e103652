//! Bodies that are stronger at one place than at another.

use crate::world::{Label, World};
use frangible_fracture::StrengthPoints;
use frangible_math::RigidTransform;
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Those with strength points, by dense index, and the frames of their points; few have any.
pub(crate) struct LocalStrengths(BTreeMap<usize, (Arc<StrengthPoints>, RigidTransform)>);

impl LocalStrengths {
    pub(crate) fn of(World { bodies, labels, .. }: &World) -> Self {
        let varied = |(i, label): (usize, &Label)| {
            let points = label.breaking.as_ref()?.strength_points.clone()?;
            Some((i, (points, bodies.shapes[i].body_from_grid.inverse())))
        };
        Self(labels.iter().enumerate().filter_map(varied).collect())
    }

    /// How much stronger a body is at a point of its frame [m] than where it is weakest.
    pub(crate) fn at(&self, i: usize, point_body: DVec3) -> f64 {
        self.0.get(&i).map_or(1.0, |(points, grid_from_body)| {
            points.factor(grid_from_body.point(point_body)) / points.least()
        })
    }
}
