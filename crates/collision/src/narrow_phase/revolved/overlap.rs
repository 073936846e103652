//! The normal of least overlap of two cores: the best of all normals at which one feature of either
//! may be deepest in the other.
//!
//! Overlap along a normal is the sum of both supports. A least one lies at a flat face of either
//! body, or at a normal of two edges, one of them possibly round.

use crate::narrow_phase::revolved::partner::Partner;
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use crate::narrow_phase::revolved::polytope::least_reach;
use crate::narrow_phase::revolved::round_overlap::{across_both, rims};
use crate::narrow_phase::revolved::search::{Search, least_along};
use frangible_geometry::Hull;
use glam::DVec3;

/// The least reach of the difference is searched for to this part of the smaller body's size.
const POINTED: f64 = 1e-9;

/// Faces that a closer search begins at.
const BEGINNINGS: usize = 6;

/// Normals tried along the arc of an edge's normals, to find the deepest of several.
const ON_ARC: usize = 8;

impl Search<'_> {
    /// Normals at which a flat face or the round side of either body meets the other: almost all
    /// contacts at rest.
    pub(crate) fn flat(&mut self) {
        let (round, partner) = (self.round, self.partner);
        if let Partner::Hull(hull) = partner {
            for plane in hull.planes() {
                self.take(round.reach(-plane.normal) + plane.offset, plane.normal);
            }
        }
        self.offer(round.axis);
        self.offer(-round.axis);
        match partner {
            Partner::Hull(hull) => self.side_of_round(hull),
            Partner::Revolved(other) => {
                self.offer(other.axis);
                self.offer(-other.axis);
                for normal in across_both(round, other) {
                    self.offer(normal);
                }
            }
            Partner::Plane(plane) => self.take(self.overlap(plane.normal), plane.normal),
        }
    }

    /// All other normals: the one along which the difference of both reaches least far, and what
    /// is better near the faces around it.
    pub(crate) fn pointed(&mut self, size: f64) {
        let (round, partner) = (self.round, self.partner);
        let support = |way: DVec3| partner.support(way) - round.support(-way);
        // The difference of two segments is flat: all its normals are offered as flat ones.
        let Some(least) = least_reach(support, POINTED * size) else { return };
        self.offer(least.direction);
        match partner {
            Partner::Hull(hull) => self.rim_on_edges(hull),
            Partner::Revolved(other) => rims(self, other, &least.nearest_faces(BEGINNINGS)),
            Partner::Plane(_) => {}
        }
    }

    /// The round side on vertices and on edges.
    fn side_of_round(&mut self, hull: &Hull) {
        let round = self.round;
        for &vertex in hull.vertices() {
            let outward = round.side_normal(round.radial(vertex - round.middle));
            // At least as deep as this vertex.
            if round.reach(outward) - vertex.dot(outward) < self.depth - self.margin {
                self.offer(-outward);
            }
        }
        for edge in hull.edges() {
            let [start, end] = edge.vertices.map(|vertex| hull.vertices()[vertex as usize]);
            for outward in side_normals_across(round, end - start).into_iter().flatten() {
                if round.reach(outward) - start.dot(outward) < self.depth - self.margin {
                    self.offer(-outward);
                }
            }
        }
    }

    /// A rim on edges: along the arc between the normals of both faces.
    fn rim_on_edges(&mut self, hull: &Hull) {
        let round = self.round;
        for edge in hull.edges() {
            let [start, end] = edge.vertices.map(|vertex| hull.vertices()[vertex as usize]);
            let normals = edge.faces.map(|face| hull.planes()[face as usize].normal);
            // The overlap with the edge is convex along the chord of the arc.
            let between = normals[1] - normals[0];
            let value = |normal: DVec3| round.reach(-normal) + normal.dot(start);
            let slope = |normal: DVec3| (start - round.support(-normal)).dot(between);
            let values = normals.map(value);
            let [rising, falling] = [slope(normals[0]), -slope(normals[1])];
            let least = if rising >= 0.0 {
                values[0]
            } else if falling >= 0.0 {
                values[1]
            } else {
                // Where both tangents meet.
                let part = (values[1] - values[0] + falling) / (falling + rising);
                values[0] + rising * part.clamp(0.0, 1.0)
            };
            if least >= self.depth - self.margin {
                continue;
            }
            // By the angle: the normals of slivers are nearly opposite, and most of a chord between
            // them is near their ends. The first face has the edge in its own direction.
            let beside = (end - start).cross(normals[0]).normalize();
            let whole = libm::atan2(normals[1].dot(beside), normals[1].dot(normals[0]));
            let normal_at = |angle: f64| libm::cos(angle) * normals[0] + libm::sin(angle) * beside;
            let angle = least_along([0.0, whole], ON_ARC, |angle| value(normal_at(angle)));
            self.offer(normal_at(angle));
        }
    }
}

/// Normals of the round side across an edge.
fn side_normals_across(round: &PlacedRevolved, edge: DVec3) -> [Option<DVec3>; 2] {
    let (along, across, length) = round.split(edge);
    if length == 0.0 {
        return [None; 2];
    }
    let ahead = across / length;
    let beside = round.axis.cross(ahead);
    let cosine = -round.side.y * along / (round.side.x * length);
    if cosine.abs() > 1.0 {
        return [None; 2];
    }
    let sine = (1.0 - cosine * cosine).sqrt();
    [sine, -sine].map(|sine| Some(round.side_normal(cosine * ahead + sine * beside)))
}
