//! Contacts of solids of any form: along the cracks between them.

use super::hulls::SAME_PLANE;
use super::meshes::{CrackTriangle, interfaces_of_triangles};
use crate::interfaces::cross_section::FlatPart;
use crate::interfaces::interface::{Contacts, Interface};
use frangible_geometry::{Geometry, Shape, Solid};
use frangible_math::RigidTransform;
use glam::DVec3;

/// Areas of the two sides of a crack differ by less, relatively.
const SAME_AREA: f64 = 1e-6;

/// A crack's face of one piece.
struct CrackFace<'a> {
    piece: usize,
    solid: &'a Solid,
    sides: Vec<[u32; 2]>,
    /// In the common frame, its vector outward.
    part: FlatPart,
    placed: RigidTransform,
    normal_grid: DVec3,
}

/// The contacts of shapes that are solids; `None` if a piece is none.
pub(super) fn between_solids<'a>(pieces: &[(&'a Shape, RigidTransform)]) -> Option<Vec<Interface>> {
    let placed = |(shape, parent_from_piece): &(&'a Shape, RigidTransform)| match &shape.geometry {
        Geometry::Solid(solid) => Some((&**solid, parent_from_piece.after(&shape.body_from_grid))),
        _ => None,
    };
    let solids: Vec<(&Solid, RigidTransform)> = pieces.iter().map(placed).collect::<Option<_>>()?;
    Some(contacts(&solids))
}

/// The contacts of solids in one frame. The two sides of a crack are the same polygon as a rule.
/// Where they are not, as between bricks, their triangles tell what they have in common.
pub(crate) fn contacts(solids: &[(&Solid, RigidTransform)]) -> Vec<Interface> {
    let mut faces: Vec<CrackFace<'_>> = Vec::new();
    for (piece, &(solid, placed)) in solids.iter().enumerate() {
        for (face, sides) in solid.cracks() {
            let normal_grid = face.plane.normal;
            let place = |at: u32| placed.point(solid.vertices()[at as usize]);
            let corners = sides.iter().map(|side| side.map(place));
            if let Some(part) = FlatPart::of_sides(corners, placed.direction(normal_grid)) {
                faces.push(CrackFace { piece, solid, sides, part, placed, normal_grid });
            }
        }
    }
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = faces.iter().fold(none, |(low, high), face| {
        (low.min(face.part.centroid), high.max(face.part.centroid))
    });
    let near = SAME_PLANE * (high - low).max_element();

    // The two sides of a crack have their middles in one place.
    faces.sort_by(|a, b| a.part.centroid.x.total_cmp(&b.part.centroid.x));
    let mut contacts = Contacts::default();
    let mut is_matched = vec![false; faces.len()];
    for at in 0..faces.len() {
        if is_matched[at] {
            continue;
        }
        let CrackFace { piece, part, .. } = &faces[at];
        let is_other_side = |face: &CrackFace<'_>| {
            let apart = face.part.centroid.distance(part.centroid);
            let sum = (face.part.vector + part.vector).length();
            face.piece != *piece && apart <= near && sum <= SAME_AREA * part.vector.length()
        };
        let found = (at + 1..faces.len())
            .take_while(|&other| faces[other].part.centroid.x - part.centroid.x <= near)
            .find(|&other| !is_matched[other] && is_other_side(&faces[other]));
        if let Some(other) = found {
            is_matched[other] = true;
            is_matched[at] = true;
            let first = if faces[other].piece < *piece { other } else { at };
            let pair = (faces[first].piece, faces[at + other - first].piece);
            contacts.add(pair, faces[first].part.clone());
        }
    }
    let unmatched = faces.iter().zip(is_matched).filter(|(_, matched)| !matched);
    let triangles: Vec<CrackTriangle> = unmatched.flat_map(|(face, _)| face.triangles()).collect();
    for contact in interfaces_of_triangles(&triangles, SAME_PLANE) {
        contacts.add((contact.a, contact.b), contact.flat_part());
    }
    contacts.into_interfaces()
}

impl CrackFace<'_> {
    fn triangles(&self) -> impl Iterator<Item = CrackTriangle> {
        let normal = self.placed.direction(self.normal_grid);
        let triangles = self.solid.filled(self.sides.clone(), self.normal_grid);
        triangles.into_iter().map(move |corners| {
            let corners = corners.map(|corner| self.placed.point(corner));
            CrackTriangle::new(self.piece, corners, normal)
        })
    }
}
