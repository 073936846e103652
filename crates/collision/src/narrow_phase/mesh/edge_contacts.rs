//! Edges of a hull against edges of a mesh, where both stand out along their common normal: their
//! arcs on the Gauss map meet [Gregorius13].

use crate::narrow_phase::mesh::edge_sweep::MeshEdge;
use crate::narrow_phase::mesh::hull_way::{HullWay, Instant, Way};
use crate::narrow_phase::mesh::mesh_contact::{Meets, MeshContact, feature_of};
use crate::narrow_phase::mesh::near_features::{NearEdge, bit};
use frangible_geometry::HullEdge;
use glam::DVec3;
use std::cell::LazyCell;

/// Sine of the angle below which edges are parallel [1]: corners and faces meet there.
const PARALLEL: f64 = 1e-2;

/// Sine of the angle by which a normal may leave an edge's arc [1]: a face that rests on an edge
/// has its normal at the end of its own edges' arcs. Resting bodies turn by less.
const ASIDE: f64 = 5e-3;

/// Edges of a hull on their ways.
pub(crate) struct HullEdges<'a> {
    hull_way: &'a HullWay<'a>,
    /// Around each on all ways, grown by the speculative margin, mesh frame [m].
    bounds: Vec<[DVec3; 2]>,
    /// From each edge into its faces at right angles to it, body frame.
    into: Vec<[DVec3; 2]>,
}

impl<'a> HullEdges<'a> {
    pub(crate) fn new(hull_way: &'a HullWay<'a>) -> Self {
        let HullWay { motion, hull, .. } = *hull_way;
        let margin = motion.pair_motion.near + motion.thin;
        let bounds = |edge: &HullEdge| {
            let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            for way in hull_way.ways() {
                for instant in 0..way.instants.len() {
                    let vertices = way.vertices(instant);
                    for vertex in edge.vertices {
                        let end = vertices[vertex as usize];
                        bounds = [bounds[0].min(end), bounds[1].max(end)];
                    }
                }
            }
            [bounds[0] - margin, bounds[1] + margin]
        };
        let into = |edge: &HullEdge| {
            let [from, to] = edge.vertices.map(|vertex| hull.vertices()[vertex as usize]);
            let along = (to - from).normalize_or(DVec3::X);
            // The first face has the edge in its own direction.
            let normals = edge.faces.map(|face| hull.planes()[face as usize].normal);
            [normals[0].cross(along), -normals[1].cross(along)]
        };
        Self {
            hull_way,
            bounds: hull.edges().iter().map(bounds).collect(),
            into: hull.edges().iter().map(into).collect(),
        }
    }
}

/// Appends the contacts of some edges of the mesh with those of a hull.
pub(crate) fn edge_contacts(
    hull_edges: &HullEdges,
    edges: &[NearEdge],
    contacts: &mut Vec<MeshContact>,
) {
    let HullWay { motion, hull, .. } = *hull_edges.hull_way;
    for &NearEdge { triangle, corner, part, depth, near_faces } in edges {
        let (low, high) = (part[0].min(part[1]) - depth, part[0].max(part[1]) + depth);
        let corners = motion.mesh.corners(triangle);
        let ends = [corners[corner], corners[(corner + 1) % 3]];
        let Some(along) = (ends[1] - ends[0]).try_normalize() else { continue };
        let edge = LazyCell::new(|| MeshEdge::of(motion.mesh, triangle, corner));
        for (number, own) in hull.edges().iter().enumerate() {
            let bits = bit(own.faces[0] as usize) | bit(own.faces[1] as usize);
            let [own_low, own_high] = hull_edges.bounds[number];
            let may_touch =
                near_faces & bits == bits && own_low.cmple(high).all() && low.cmple(own_high).all();
            if !may_touch {
                continue;
            }
            // Mixed, so that pairs of edges seldom share an id.
            let id = (3 * triangle + corner) as u64 * 0x9e37 + number as u64;
            let (hull_way, into) = (hull_edges.hull_way, hull_edges.into[number]);
            let pair = EdgePair { hull_way, own, into, ends, along, edge: &edge, id };
            contacts.extend(hull_way.ways().find_map(|way| pair.contact(way)));
        }
    }
}

struct EdgePair<'a, F> {
    hull_way: &'a HullWay<'a>,
    own: &'a HullEdge,
    /// From it into its faces at right angles to it, body frame.
    into: [DVec3; 2],
    /// Of the mesh's edge [m], and its direction.
    ends: [DVec3; 2],
    along: DVec3,
    /// The mesh edge where the hull meets it; made on first use.
    edge: &'a LazyCell<Option<MeshEdge>, F>,
    id: u64,
}

impl<F: FnOnce() -> Option<MeshEdge>> EdgePair<'_, F> {
    /// The first contact on a way of the body; see
    /// [`corner_contacts`](super::hull_faces::corner_contacts).
    fn contact(&self, way: &Way) -> Option<MeshContact> {
        let HullWay { motion, hull, inside, .. } = *self.hull_way;
        let near = motion.pair_motion.near;
        let ends_at = |instant: usize| {
            let vertices = way.vertices(instant);
            let [from, to] = self.own.vertices;
            [vertices[from as usize], vertices[to as usize]]
        };
        for part in 1..way.instants.len() {
            let [before, after] = [&way.instants[part - 1], &way.instants[part]];
            let [from, to] = [ends_at(part - 1), ends_at(part)];
            let Some(normal) = self.normal(from, before) else { continue };
            let start = (from[0] - self.ends[0]).dot(normal);
            let end = (to[0] - self.ends[0]).dot(normal);
            let overlaps = start <= 0.0;
            // Edges that come near at the frame's end are met in the next.
            if overlaps && part > 1 || start > near && end > 0.0 {
                continue;
            }
            let touches = overlaps || end <= 0.0;
            let at = if overlaps {
                0.0
            } else if end <= 0.0 {
                start / (start - end)
            } else if end < start {
                1.0
            } else {
                0.0
            };
            let lerped = [from[0].lerp(to[0], at), from[1].lerp(to[1], at)];
            let turned = if at < 0.5 { before } else { after };
            let Some(normal) = self.normal(lerped, turned) else { continue };
            let Some((part_of_own, on_mesh)) = crossing(lerped, self.ends, motion.thin) else {
                continue;
            };
            let edge = self.edge.as_ref()?;
            if !self.stand_out(edge, normal, turned) {
                continue;
            }
            let [own_from, own_to] = self.own.vertices;
            let vertices = hull.vertices();
            let (own_from, own_to) = (vertices[own_from as usize], vertices[own_to as usize]);
            let on_body = own_from.lerp(own_to, part_of_own);
            let on_hull = lerped[0].lerp(lerped[1], part_of_own);
            // The hull's inside lies beyond the mesh's edge.
            let inside = on_hull + turned.rotation * (inside - on_body);
            if (inside - on_mesh).dot(normal) <= 0.0 {
                continue;
            }
            let depth = if overlaps { -start } else { 0.0 };
            let time = before.time + at * (after.time - before.time);
            let met_at = on_body + turned.body_from_mesh.direction(on_mesh - on_hull);
            let carried = match way.is_supported && motion.is_borne {
                true => met_at,
                false => {
                    let part = ([before.time, after.time], at);
                    met_at + motion.without_sag(part, &turned.mesh_from_body)
                }
            };
            let is_on_rim = |at: DVec3| self.is_on_rim(edge, (at, depth), turned);
            if is_on_rim(met_at) || is_on_rim(carried) {
                continue;
            }
            let last = self.hull_way.supported_way();
            let last = last.vertices(last.instants.len() - 1)[self.own.vertices[0] as usize];
            let ends_behind = (last + (on_hull - lerped[0]) - on_mesh).dot(normal) < -motion.thin;
            if ends_behind && !(overlaps && part == 1) && !(touches && way.is_supported) {
                continue;
            }
            return Some(MeshContact {
                on_body,
                rounding: 0.0,
                on_mesh,
                normal: edge.within_arc(normal),
                time,
                feature: feature_of(Meets::EdgeOnEdge, self.id),
            });
        }
        None
    }

    /// The unit normal of both edges, towards the hull; `None` if they are parallel.
    fn normal(&self, ends: [DVec3; 2], instant: &Instant) -> Option<DVec3> {
        let own = ends[1] - ends[0];
        let across = own.cross(self.along);
        if across.length_squared() <= PARALLEL * PARALLEL * own.length_squared() {
            return None;
        }
        let normal = across.try_normalize()?;
        let inward = instant.rotation * (self.into[0] + self.into[1]);
        Some(if inward.dot(normal) < 0.0 { -normal } else { normal })
    }

    /// True for a point of the mesh, body frame, that lies less deep under another face than under
    /// the edge, or on that face's rim, if the mesh's edge stands out towards it.
    fn is_on_rim(
        &self,
        edge: &MeshEdge,
        (point_body, depth): (DVec3, f64),
        instant: &Instant,
    ) -> bool {
        let HullWay { motion, hull, .. } = *self.hull_way;
        let least = -motion.rim.max(depth);
        hull.planes().iter().enumerate().any(|(face, plane)| {
            let is_own = self.own.faces.contains(&(face as u32));
            !is_own
                && plane.distance(point_body) >= least
                && edge.stands_out(-(instant.rotation * plane.normal), ASIDE)
        })
    }

    /// True if both edges are the furthest around themselves along the normal.
    fn stand_out(&self, edge: &MeshEdge, normal: DVec3, instant: &Instant) -> bool {
        edge.stands_out(normal, ASIDE)
            && self.into.iter().all(|&into| (instant.rotation * into).dot(normal) >= -ASIDE)
    }
}

/// Where two straight lines are nearest, as a fraction of the first edge and a point of the second,
/// if both edges, longer by `beyond` [m], hold it.
fn crossing(first: [DVec3; 2], second: [DVec3; 2], beyond: f64) -> Option<(f64, DVec3)> {
    let (u, v, apart) = (first[1] - first[0], second[1] - second[0], first[0] - second[0]);
    let (uu, vv, uv) = (u.length_squared(), v.length_squared(), u.dot(v));
    let determinant = uu * vv - uv * uv;
    if determinant <= 0.0 {
        return None;
    }
    let (a, b) = (u.dot(apart), v.dot(apart));
    let (s, t) = ((uv * b - vv * a) / determinant, (uu * b - uv * a) / determinant);
    let within = |part: f64, squared: f64| {
        let more = beyond / squared.sqrt();
        (-more..=1.0 + more).contains(&part)
    };
    (within(s, uu) && within(t, vv)).then(|| (s, second[0] + t * v))
}
