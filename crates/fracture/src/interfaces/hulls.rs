//! Contacts of convex polyhedra: overlaps of coplanar faces.

use crate::interfaces::cross_section::FlatPart;
use crate::interfaces::interface::{Contacts, Interface};
use crate::polygon;
use crate::slivers::Contact;
use frangible_geometry::{HalfSpace, Hull, HullFace};
use frangible_math::cancel;
use glam::DVec3;

/// Faces this close together, relative to the longest side of all the pieces' bounding boxes, lie
/// in one plane: far above what clipping and turning round off, far below any gap that is meant.
pub(super) const SAME_PLANE: f64 = 1e-7;
/// An overlap smaller than this part of the smaller face is where two faces touch along an edge.
const SMALLEST_OVERLAP: f64 = 1e-9;

/// The contacts of polyhedra in one frame.
pub(crate) fn contacts(hulls: &[Hull]) -> Vec<Interface> {
    let bounds: Vec<(DVec3, DVec3)> = hulls.iter().map(Hull::bounds).collect();
    let longest = bounds.iter().map(|(low, high)| (high - low).max_element()).fold(0.0, f64::max);
    let near = SAME_PLANE * longest;

    // Sweep along x: a box touches only boxes that begin before its end.
    let mut order: Vec<usize> = (0..hulls.len()).collect();
    order.sort_by(|&a, &b| bounds[a].0.x.total_cmp(&bounds[b].0.x).then(a.cmp(&b)));
    let mut contacts = Contacts::default();
    for (at, &first) in order.iter().enumerate() {
        cancel::check();
        let (low, high) = (bounds[first].0 - near, bounds[first].1 + near);
        for &second in order[at + 1..].iter().take_while(|&&other| bounds[other].0.x <= high.x) {
            let (other_low, other_high) = bounds[second];
            if other_low.cmple(high).all() && other_high.cmpge(low).all() {
                let (a, b) = (first.min(second), first.max(second));
                add_contact(&mut contacts, (a, b), (&hulls[a], &hulls[b]), near);
            }
        }
    }
    contacts.into_interfaces()
}

/// Those of some of the polyhedra with any, each pair once, with their areas [m^2].
pub(crate) fn contacts_of_some(hulls: &[&Hull], some: &[bool]) -> Vec<Contact> {
    let bounds: Vec<(DVec3, DVec3)> = hulls.iter().map(|hull| hull.bounds()).collect();
    let longest = bounds.iter().map(|(low, high)| (high - low).max_element()).fold(0.0, f64::max);
    let near = SAME_PLANE * longest;
    let mut contacts = Contacts::default();
    for first in (0..hulls.len()).filter(|&hull| some[hull]) {
        cancel::check();
        let (low, high) = (bounds[first].0 - near, bounds[first].1 + near);
        for (second, (other_low, other_high)) in bounds.iter().enumerate() {
            // A pair of them is looked at from its first.
            let is_known = second == first || (second < first && some[second]);
            if !is_known && other_low.cmple(high).all() && other_high.cmpge(low).all() {
                let (a, b) = (first.min(second), first.max(second));
                add_contact(&mut contacts, (a, b), (hulls[a], hulls[b]), near);
            }
        }
    }
    contacts
        .into_interfaces()
        .into_iter()
        .map(|contact| ([contact.a, contact.b], contact.area))
        .collect()
}

/// Adds the overlaps of all coplanar faces of two polyhedra.
fn add_contact(contacts: &mut Contacts, pair: (usize, usize), (a, b): (&Hull, &Hull), near: f64) {
    let corners = |hull: &Hull, face: &HullFace<'_>| -> Vec<DVec3> {
        face.vertices.iter().map(|&vertex| hull.vertices()[vertex as usize]).collect()
    };
    for face in a.faces().filter(|face| separates(&face.plane, b, near)) {
        let polygon_a = corners(a, &face);
        for other in b.faces() {
            let polygon_b = corners(b, &other);
            let in_plane =
                polygon_b.iter().all(|&corner| face.plane.distance(corner).abs() <= near);
            if !in_plane || face.plane.normal.dot(other.plane.normal) > 0.0 {
                continue;
            }
            if let Some(part) = overlap_of_faces(&polygon_a, &polygon_b, face.plane.normal) {
                contacts.add(pair, part);
            }
        }
    }
}

/// True if a polyhedron lies completely in front of a plane or on it.
fn separates(plane: &HalfSpace, hull: &Hull, near: f64) -> bool {
    hull.vertices().iter().all(|&vertex| plane.distance(vertex) >= -near)
}

/// The common part of two convex polygons in the plane with this normal, which is that of the first
/// and the other way round that of the second; `None` if they touch along an edge at most.
pub(super) fn overlap_of_faces(
    polygon_a: &[DVec3],
    polygon_b: &[DVec3],
    normal: DVec3,
) -> Option<FlatPart> {
    let smaller = polygon::area(polygon_a).min(polygon::area(polygon_b));
    let part = FlatPart::of_polygon(&overlap(polygon_a, polygon_b, normal), normal)?;
    (part.vector.length() > SMALLEST_OVERLAP * smaller).then_some(part)
}

/// The common part of the two.
fn overlap(polygon_a: &[DVec3], polygon_b: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    // Polygon b runs clockwise about the normal, so that its inside is on the right of each side.
    let mut kept = polygon_a.to_vec();
    for (at, &start) in polygon_b.iter().enumerate() {
        let end = polygon_b[(at + 1) % polygon_b.len()];
        if let Some(outward) = normal.cross(end - start).try_normalize() {
            kept = polygon::clip(&kept, &HalfSpace { normal: outward, offset: outward.dot(start) });
        }
    }
    kept
}
