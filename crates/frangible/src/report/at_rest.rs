//! The pieces of a break as they lay in their parent: with it they can be put together again.

use frangible_bodies::{Bodies, NewBody};
use frangible_fracture::{Interface, interfaces_between};
use frangible_geometry::Shape;
use frangible_math::RigidTransform;
use serde::{Deserialize, Serialize};

/// The place of a piece in its parent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RestPose {
    /// Of its centre of mass, in the parent's body frame [m].
    pub position: [f64; 3],
    /// `parent_from_piece`, a unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

/// The common surface of two pieces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PieceContact {
    /// Both by their number among the fragments, the smaller first.
    pub pieces: [usize; 2],
    /// [m^2]
    pub area: f64,
    /// Mean of its points, in the parent's body frame [m].
    pub point: [f64; 3],
    /// Unit, from the first piece to the second, in the parent's body frame; the mean where the
    /// surface is not flat.
    pub normal: [f64; 3],
}

/// Where the pieces of a body lay in it, and who touched whom, from the pieces that are about to
/// take its place.
pub(crate) fn at_rest<'a>(
    bodies: &Bodies,
    parent: usize,
    pieces: impl Iterator<Item = &'a NewBody>,
) -> (Vec<RestPose>, Vec<PieceContact>) {
    let parent_from_world = bodies.poses[parent].world_from_body().inverse();
    let placed: Vec<(&Shape, RigidTransform)> = pieces
        .map(|piece| (&*piece.shape, parent_from_world.after(&piece.pose.world_from_body())))
        .collect();
    let rest = |(_, parent_from_piece): &(&Shape, RigidTransform)| RestPose {
        position: parent_from_piece.translation.to_array(),
        orientation: parent_from_piece.rotation.to_array(),
    };
    let contact = |Interface { a, b, area, centroid, normal, .. }: Interface| PieceContact {
        pieces: [a, b],
        area,
        point: centroid.to_array(),
        normal: normal.to_array(),
    };
    let contacts = interfaces_between(&placed).into_iter().map(contact).collect();
    (placed.iter().map(rest).collect(), contacts)
}
