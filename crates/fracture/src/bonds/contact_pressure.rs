//! The pressure of a flat contact on glued pieces, from the forces at its few points.

use crate::bonds::{Glued, PointLoad};
use crate::grid_pieces::GridPieces;
use crate::polygon;
use frangible_geometry::outer;
use glam::{DMat3, DVec3};

/// Maximum distance from a plane, relative to a contact's extent, for points and faces in the
/// contact.
const FLAT: f64 = 1e-3;

impl Glued {
    /// Spreads the point forces of a flat contact over the faces of pieces in it: a flat contact
    /// has few points but a distributed pressure. A linear pressure keeps the centre of pressure.
    /// Contacts that are not flat, or have fewer than three points, stay unchanged.
    pub fn spread(&self, contact: Vec<PointLoad>) -> Vec<PointLoad> {
        let force: DVec3 = contact.iter().map(|load| load.force).sum();
        let Some(normal) = force.try_normalize().filter(|_| contact.len() >= 3) else {
            return contact;
        };
        let weights = || contact.iter().map(|load| load.force.dot(normal));
        let total: f64 = weights().sum();
        let middle = contact
            .iter()
            .zip(weights())
            .map(|(load, weight)| weight / total * load.point)
            .sum::<DVec3>();

        // Faces in the plane of the points and in their box. Friction leans the force, and faces
        // lie across their own normals.
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for load in &contact {
            (low, high) = (low.min(load.point), high.max(load.point));
        }
        let faces = match &self.grid {
            Some(grid) => self.samples_in(grid, &contact, (low, high)),
            None => self.faces_in(&contact, normal, (low, high)),
        };

        // The share of each face is its area's, and a gradient's that moves the middle to where it
        // was.
        let area: f64 = faces.iter().map(|face| face.1).sum();
        if faces.is_empty() || area <= 0.0 {
            return contact;
        }
        let center = faces.iter().map(|(at, part)| *part / area * *at).sum::<DVec3>();
        let mut second = DMat3::ZERO;
        for (at, part) in &faces {
            second += outer(*at - center, *at - center) * (*part / area);
        }
        // Across the plane, and along a row of faces, there is no gradient to be had.
        second += DMat3::IDENTITY * (FLAT * (high - low).length_squared());
        let gradient = second.inverse() * (middle - center);
        let share = |(at, part): (DVec3, f64)| PointLoad {
            point: at,
            force: force * (part / area * (1.0 + gradient.dot(at - center))),
        };
        faces.into_iter().map(share).collect()
    }

    /// Faces of polyhedra in the plane of a contact and in the box of its points: centroid and
    /// area.
    fn faces_in(
        &self,
        contact: &[PointLoad],
        normal: DVec3,
        (low, high): (DVec3, DVec3),
    ) -> Vec<(DVec3, f64)> {
        let close = FLAT * (high - low).max_element();
        let mut faces: Vec<(DVec3, f64)> = Vec::new();
        for face in
            self.hulls.iter().flat_map(|hull| (0..hull.faces().len()).map(move |at| (hull, at)))
        {
            let (hull, plane) = (face.0, face.0.face(face.1).plane);
            let holds_all = contact.iter().all(|load| plane.distance(load.point).abs() <= close);
            if holds_all && plane.normal.dot(normal) < 0.0 {
                let corners: Vec<DVec3> = hull
                    .face(face.1)
                    .vertices
                    .iter()
                    .map(|&vertex| hull.vertices()[vertex as usize])
                    .collect();
                let (area, centroid) = polygon::area_and_centroid(&corners);
                if centroid.cmpge(low - close).all() && centroid.cmple(high + close).all() {
                    faces.push((centroid, area));
                }
            }
        }
        faces
    }

    /// The same of pieces on a grid: each of their surface samples there stands for as much area.
    fn samples_in(
        &self,
        grid: &GridPieces,
        contact: &[PointLoad],
        (low, high): (DVec3, DVec3),
    ) -> Vec<(DVec3, f64)> {
        let close = grid.half_voxel();
        let Some(first) = contact.first() else { return Vec::new() };
        let mut across = DVec3::ZERO;
        for pair in contact.windows(2) {
            let normal = (pair[0].point - first.point).cross(pair[1].point - first.point);
            across += if normal.dot(across) < 0.0 { -normal } else { normal };
        }
        let Some(across) = across.try_normalize() else { return Vec::new() };
        let height = |point: DVec3| across.dot(point - first.point).abs();
        if contact.iter().any(|load| height(load.point) > close) {
            return Vec::new();
        }
        let (low, high) = (low - close, high + close);
        let is_in = |point: &DVec3| {
            height(*point) <= close && point.cmpge(low).all() && point.cmple(high).all()
        };
        let samples = self.numbers.iter().flat_map(|&piece| grid.samples(piece as usize));
        samples.filter(is_in).map(|point| (point, 1.0)).collect()
    }
}
