//! Pieces of a body on a grid, and what some of them are together.

use crate::fragment::Fragment;
use crate::interfaces;
use crate::interfaces::interface::Interface;
use crate::pattern::Pattern;
use crate::placement::Placement;
use crate::shatter::laid::Laid;
use crate::shatter::settings::ShatterSettings;
use crate::shatter::{CutUp, cut_sampled};
use crate::stress::RigidPiece;
use frangible_geometry::{BodyFrame, ClusteredSamples, Geometry, GridSolid, Portion, Run, Shape};
use frangible_math::check::{Check, Checked, require};
use glam::{DMat3, DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Samples of cracks lie so deep in the union of both sides [voxels]: they are none of its surface.
const BURIED: f32 = -0.6;

/// A body on a grid and its pieces.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Cut", into = "Cut")]
pub(crate) struct GridPieces {
    cut: Cut,
    fragments: Vec<Fragment>,
    /// Material of each piece on the body's grid, and its cells.
    parts: Vec<(Portion, Vec<u32>)>,
}

/// Arguments of [`GridPieces::cut`]: a snapshot holds them, and cuts anew.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Cut {
    #[serde(with = "frangible_math::shared")]
    body: Arc<Shape>,
    #[serde(with = "as_json")]
    pattern: Arc<Pattern>,
    placement: Placement,
    settings: ShatterSettings,
}

/// A pattern as its files have it: fields that are left out need a format that names the others.
mod as_json {
    use crate::pattern::Pattern;
    use serde::de::Error as _;
    use serde::ser::Error as _;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::sync::Arc;

    pub(super) fn serialize<S: Serializer>(
        pattern: &Arc<Pattern>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serde_json::to_string(pattern.as_ref()).map_err(S::Error::custom)?.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Arc<Pattern>, D::Error> {
        let text = String::deserialize(deserializer)?;
        Pattern::of_json(&text).map(Arc::new).map_err(D::Error::custom)
    }
}

impl From<GridPieces> for Cut {
    fn from(pieces: GridPieces) -> Self {
        pieces.cut
    }
}

impl TryFrom<Cut> for GridPieces {
    type Error = &'static str;

    fn try_from(cut: Cut) -> Result<Self, Self::Error> {
        let Cut { body, pattern, placement, settings } = cut;
        placement.check()?;
        settings.check()?;
        if let Geometry::Grid(solid) = &body.geometry {
            let along = solid.grid().dims.into_iter().fold(0, usize::max);
            let is_spacing = 1e4 * settings.sample_spacing_voxels >= along as f64;
            require(is_spacing, "samples on cracks that can be counted")?;
        }
        Self::cut(body, pattern, placement, &settings).ok_or("pieces of a body on no grid")
    }
}

impl Check for GridPieces {
    fn check(&self) -> Checked {
        // What is cut is checked before it is cut.
        Ok(())
    }
}

impl GridPieces {
    /// Cuts a body along a pattern that is laid on it; `None` if it is on no grid.
    pub(crate) fn cut(
        body: Arc<Shape>,
        pattern: Arc<Pattern>,
        placement: Placement,
        settings: &ShatterSettings,
    ) -> Option<Self> {
        let Geometry::Grid(solid) = &body.geometry else { return None };
        pattern.prepare();
        let laid = Laid::new(&pattern, placement, solid);
        let CutUp { fragments, parts } = cut_sampled((&body, solid), &laid, settings);
        let is_whole = fragments.len() == parts.len();
        let cut = Cut { body, pattern, placement, settings: *settings };
        is_whole.then_some(Self { cut, fragments, parts })
    }

    /// Number of pieces.
    pub(crate) fn len(&self) -> usize {
        self.fragments.len()
    }

    /// The first cell of each piece.
    pub(crate) fn cells(&self) -> impl Iterator<Item = u32> {
        self.fragments.iter().map(|fragment| fragment.cell)
    }

    /// Mass of a piece at unit density, in the grid frame.
    pub(crate) fn rigid(&self, piece: usize) -> RigidPiece {
        let shape = &self.fragments[piece].shape;
        let grid_from_body = shape.body_from_grid.inverse();
        let axes = DMat3::from_quat(grid_from_body.rotation);
        RigidPiece {
            center: grid_from_body.translation,
            volume: shape.volume,
            inertia: axes * DMat3::from_diagonal(shape.unit_moments) * axes.transpose(),
            anchored: false,
        }
    }

    /// The contacts between the pieces, in the grid frame.
    pub(crate) fn contacts(&self) -> Vec<Interface> {
        let grid_from_body = self.cut.body.body_from_grid.inverse();
        let contacts = interfaces(&self.fragments);
        contacts.iter().map(|contact| contact.placed(&grid_from_body)).collect()
    }

    /// Signed distance from a point of the grid frame to a piece [m].
    pub(crate) fn distance(&self, piece: usize, point: DVec3) -> f64 {
        let shape = &self.fragments[piece].shape;
        shape.distance_and_gradient(shape.body_from_grid.point(point)).0
    }

    /// Points on the surface of a piece, in the grid frame.
    pub(crate) fn samples(&self, piece: usize) -> impl Iterator<Item = DVec3> {
        let shape = &self.fragments[piece].shape;
        let grid_from_body = shape.body_from_grid.inverse();
        shape.samples().iter().map(move |sample| grid_from_body.point(sample.as_dvec3()))
    }

    /// Half a voxel: the body's surface is known that well [m].
    pub(crate) fn half_voxel(&self) -> f64 {
        match &self.cut.body.geometry {
            Geometry::Grid(solid) => 0.5 * solid.grid().spacing,
            _ => 0.0,
        }
    }

    /// Some of the pieces as one body, in the grid frame.
    pub(crate) fn union(&self, members: &[u32]) -> Option<Shape> {
        if members.len() == self.len() {
            return Some(Shape::clone(&self.cut.body));
        }
        if let [member] = members {
            return Some(self.fragments[*member as usize].shape.clone());
        }
        let Geometry::Grid(solid) = &self.cut.body.geometry else { return None };

        // Material, and distance to the cells that are not theirs.
        let mut portion = Portion::with_capacity(solid.grid(), 0);
        let mut is_own = vec![false; self.cut.pattern.len()];
        for &member in members {
            let (own, cells) = &self.parts[member as usize];
            portion.sums.merge(&own.sums);
            portion.runs.extend(&own.runs);
            cells.iter().for_each(|&cell| is_own[cell as usize] = true);
        }
        portion.runs.sort_by_key(Run::place);
        let laid = Laid::new(&self.cut.pattern, self.cut.placement, solid);
        let union = solid.intersected(portion, |grid| laid.distances_to_union(&is_own, grid));
        let frame = BodyFrame::of(&union).ok()?;

        // The pieces' samples, but those of the cracks between them.
        let samples = members.iter().flat_map(|&member| self.samples(member as usize));
        let outer = samples.filter(|&sample| is_at_surface(&union, sample));
        let samples: Vec<Vec3> =
            outer.map(|sample| frame.body_from_grid.point(sample).as_vec3()).collect();
        Some(Shape::from_clusters(union, frame, ClusteredSamples::new(samples)))
    }
}

fn is_at_surface(solid: &GridSolid, point: DVec3) -> bool {
    solid.value(point) > BURIED * solid.grid().spacing as f32
}
