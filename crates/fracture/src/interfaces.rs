//! Contacts between pieces of a break, with areas: sites of glue, and newly exposed crack faces.

pub(crate) mod hulls;
pub(crate) mod interface;
pub(crate) mod meshes;
pub(crate) mod voxels;

use crate::fragment::Fragment;
use crate::interfaces::interface::Interface;
use frangible_geometry::{Geometry, Hull};

/// The contacts between the pieces of one break, in the order of `a`, then of `b`.
///
/// Convex polyhedra touch where faces of two of them lie in one plane and look at each other: the
/// area is exact.
///
/// Pieces on a lattice touch where a voxel of one has a voxel of the other beside it. The faces
/// between the two make a staircase, whose area is too large by up to the root of 3; the sum of
/// their vectors is right. It is taken for each crack plane that the two pieces share, and along a
/// rough crack for each face with the crack's own normal. Where they share neither, as where
/// merging a sliver has bent a crack, it is taken in each cube of four voxels a side: ripples below
/// that are left out. A voxel that the parent fills in part counts in part. Areas of contacts ten
/// voxels across and more are within a few percent on planes; without planes all areas together
/// are, but flat wedges at the body's surface lose much of theirs.
///
/// All pieces must be of one kind, and those on a lattice of one parent, as
/// [`shatter`](crate::shatter) returns them; convex polyhedra may be any that do not overlap, each
/// placed in the common frame.
pub fn interfaces(fragments: &[Fragment]) -> Vec<Interface> {
    let hulls: Option<Vec<Hull>> = fragments
        .iter()
        .map(|fragment| {
            Some(fragment.shape.hull.as_deref()?.transformed(&fragment.parent_from_fragment))
        })
        .collect();
    if let Some(hulls) = hulls {
        return hulls::contacts(&hulls);
    }

    // All pieces of one break have the same grid frame.
    let Some(first) = fragments.first() else { return Vec::new() };
    let parent_from_grid = first.parent_from_fragment.after(&first.shape.body_from_grid);
    let solids: Option<Vec<_>> = fragments
        .iter()
        .map(|fragment| match &fragment.shape.geometry {
            Geometry::Grid(solid) => Some(&**solid),
            Geometry::ClosedForm(_)
            | Geometry::Hull(_)
            | Geometry::Compound(_)
            | Geometry::Mesh(_) => None,
        })
        .collect();
    let place = |contact: Interface| Interface {
        centroid: parent_from_grid.point(contact.centroid),
        normal: parent_from_grid.direction(contact.normal),
        ..contact
    };
    voxels::contacts(&solids.unwrap_or_default()).into_iter().map(place).collect()
}
