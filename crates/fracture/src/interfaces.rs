//! Contacts between pieces of a break, with areas: sites of glue, and newly exposed crack faces.

pub(crate) mod hulls;
pub(crate) mod interface;
pub(crate) mod meshes;
pub(crate) mod voxels;

use crate::fragment::Fragment;
use crate::interfaces::interface::{Contacts, Interface};
use frangible_geometry::{Geometry, Hull};

/// The contacts between the pieces of one break, in the order of `a`, then of `b`.
///
/// Convex polyhedra, and compounds of them, touch where faces of two of them lie in one plane and look at each other: the
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
    let parts: Option<Vec<Vec<Hull>>> = fragments.iter().map(convex_parts).collect();
    if let Some(parts) = parts {
        return of_convex(parts);
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

/// The polyhedra of a fragment, in its parent's body frame; `None` for other shapes.
fn convex_parts(fragment: &Fragment) -> Option<Vec<Hull>> {
    let place = |hull: &Hull| hull.transformed(&fragment.parent_from_fragment);
    match (&fragment.shape.hull, &fragment.shape.compound) {
        (Some(hull), _) => Some(vec![place(hull)]),
        (_, Some(compound)) => {
            Some(compound.parts().iter().map(|part| place(&part.hull)).collect())
        }
        _ => None,
    }
}

/// The contacts of pieces of one polyhedron or several.
fn of_convex(parts: Vec<Vec<Hull>>) -> Vec<Interface> {
    let owners: Vec<usize> =
        parts.iter().enumerate().flat_map(|(owner, own)| vec![owner; own.len()]).collect();
    let hulls: Vec<Hull> = parts.into_iter().flatten().collect();
    let of_hulls = hulls::contacts(&hulls);
    let is_one_each = owners.iter().enumerate().all(|(hull, &owner)| hull == owner);
    if is_one_each {
        return of_hulls;
    }
    let mut contacts = Contacts::default();
    for Interface { a, b, area, centroid, normal } in of_hulls {
        let (a, b) = (owners[a], owners[b]);
        if a != b {
            let normal = if a < b { normal } else { -normal };
            contacts.add((a.min(b), a.max(b)), area * normal, centroid);
        }
    }
    contacts.into_interfaces()
}
