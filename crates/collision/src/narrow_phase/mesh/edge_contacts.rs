//! Edges of a hull against edges of a mesh, where both stand out along their common normal: their
//! arcs on the Gauss map meet [Gregorius13].

use crate::narrow_phase::mesh::edge_sweep::MeshEdge;
use crate::narrow_phase::mesh::mesh_contact::{Meets, MeshContact, feature_of};
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use frangible_geometry::{HalfSpace, Hull};
use frangible_math::RigidTransform;
use glam::DVec3;

/// Sine of the angle below which edges are parallel [1]: corners and faces meet there.
const PARALLEL: f64 = 1e-2;

/// Sine of the angle by which a normal may leave an edge's arc [1]: a face that rests on an edge
/// has its normal at the end of its own edges' arcs. Resting bodies turn by less.
const ASIDE: f64 = 5e-3;

/// Depth of overlaps of edges, relative to the smaller body's radius [1].
const DEPTH: f64 = 0.25;

/// A hull's edge at all instants of a frame, mesh frame.
struct HullEdgeWay {
    edge: u32,
    /// Body frame [m].
    ends: [DVec3; 2],
    /// At the instants of free flight, and of the way along what the body touches [m].
    flight: Vec<[DVec3; 2]>,
    supported: Vec<[DVec3; 2]>,
    /// Around all of them, grown by the speculative margin [m].
    bounds: [DVec3; 2],
    /// Its faces.
    faces: [u32; 2],
    /// From the edge into its faces at right angles to it, body frame.
    into: [DVec3; 2],
}

/// All edges of a hull on their ways.
pub(crate) struct HullEdges {
    edges: Vec<HullEdgeWay>,
    /// Planes of the hull, body frame.
    faces: Vec<HalfSpace>,
    /// The same at the start and the end of the frame, mesh frame.
    planes: Vec<[HalfSpace; 2]>,
    /// An edge of the mesh that lies deeper than this under a face does not touch that face's
    /// edges [m].
    depth: f64,
}

impl HullEdges {
    pub(crate) fn new(motion: &MeshMotion, hull: &Hull) -> Self {
        let margin = motion.pair_motion.near + motion.thin;
        let depth = 2.0 * margin + DEPTH * motion.pair_motion.size;
        let way = |(number, edge): (usize, &frangible_geometry::HullEdge)| {
            let ends = edge.vertices.map(|vertex| hull.vertices()[vertex as usize]);
            let along = (ends[1] - ends[0]).normalize_or(DVec3::X);
            // The first face has the edge in its own direction.
            let normals = edge.faces.map(|face| hull.planes()[face as usize].normal);
            let into = [normals[0].cross(along), -normals[1].cross(along)];
            let seen = |instants: &[(f64, RigidTransform)]| -> Vec<[DVec3; 2]> {
                instants.iter().map(|(_, seen_from)| ends.map(|end| seen_from.point(end))).collect()
            };
            let (flight, supported) = (seen(&motion.instants), seen(&motion.supported));
            let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            for &end in flight.iter().chain(&supported).flatten() {
                bounds = [bounds[0].min(end), bounds[1].max(end)];
            }
            let bounds = [bounds[0] - margin, bounds[1] + margin];
            HullEdgeWay {
                edge: number as u32,
                ends,
                flight,
                supported,
                bounds,
                faces: edge.faces,
                into,
            }
        };
        let ends = [&motion.instants[0].1, &motion.instants[motion.instants.len() - 1].1];
        let plane = |plane: &HalfSpace| {
            ends.map(|mesh_from_body| {
                let normal = mesh_from_body.direction(plane.normal);
                HalfSpace { normal, offset: plane.offset + normal.dot(mesh_from_body.translation) }
            })
        };
        Self {
            edges: hull.edges().iter().enumerate().map(way).collect(),
            faces: hull.planes().to_vec(),
            planes: hull.planes().iter().map(plane).collect(),
            depth,
        }
    }

    /// For each face, whether an edge of the mesh stays deep under it; gives the depth of overlaps
    /// at the start that are possible [m].
    fn hidden(&self, ends: [DVec3; 2], hidden: &mut Vec<bool>) -> f64 {
        hidden.clear();
        let mut is_apart = false;
        hidden.extend(self.planes.iter().map(|[start, end]| {
            let [a, b] = ends.map(|at| start.distance(at));
            is_apart |= a.min(b) > 0.0;
            let later = end.distance(ends[0]).max(end.distance(ends[1]));
            a.max(b).max(later) < -self.depth
        }));
        if is_apart { 0.0 } else { self.depth }
    }
}

/// Appends the contacts of some edges of the mesh with those of a hull around a point [m].
pub(crate) fn edge_contacts(
    motion: &MeshMotion,
    hull_edges: &HullEdges,
    inside: DVec3,
    edges: &[(usize, usize)],
    contacts: &mut Vec<MeshContact>,
) {
    let mut hidden = Vec::new();
    for &(triangle, corner) in edges {
        let corners = motion.mesh.corners(triangle);
        let ends = [corners[corner], corners[(corner + 1) % 3]];
        let depth = hull_edges.hidden(ends, &mut hidden);
        let (low, high) = (ends[0].min(ends[1]) - depth, ends[0].max(ends[1]) + depth);
        let may_touch = |own: &&HullEdgeWay| {
            let [own_low, own_high] = own.bounds;
            own_low.cmple(high).all()
                && low.cmple(own_high).all()
                && !own.faces.iter().any(|&face| hidden[face as usize])
        };
        let mut near = hull_edges.edges.iter().filter(may_touch).peekable();
        if near.peek().is_none() {
            continue;
        }
        let Some(edge) = MeshEdge::of(motion.mesh, triangle, corner) else { continue };
        for own in near {
            // Mixed, so that pairs of edges seldom share an id.
            let id = (3 * triangle + corner) as u64 * 0x9e37 + u64::from(own.edge);
            let pair = EdgePair { motion, own, faces: &hull_edges.faces, edge: &edge, inside, id };
            let on_supported = pair.contact(&motion.supported, &own.supported, true);
            let on_flight = || pair.contact(&motion.instants, &own.flight, false);
            contacts.extend(on_supported.or_else(on_flight));
        }
    }
}

struct EdgePair<'a> {
    motion: &'a MeshMotion<'a>,
    own: &'a HullEdgeWay,
    faces: &'a [HalfSpace],
    edge: &'a MeshEdge,
    /// Body frame [m].
    inside: DVec3,
    id: u64,
}

impl EdgePair<'_> {
    /// The first contact on a way of the body; see
    /// [`corner_contacts`](super::hull_faces::corner_contacts).
    fn contact(
        &self,
        instants: &[(f64, RigidTransform)],
        ends: &[[DVec3; 2]],
        is_supported: bool,
    ) -> Option<MeshContact> {
        let near = self.motion.pair_motion.near;
        for part in 1..ends.len() {
            let [from, to] = [ends[part - 1], ends[part]];
            let Some(normal) = self.normal(from, &instants[part - 1].1) else { continue };
            let [start, end] = [from, to].map(|ends| (ends[0] - self.edge.ends[0]).dot(normal));
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
            let lerped = [0, 1].map(|side| from[side].lerp(to[side], at));
            let turned = if at < 0.5 { &instants[part - 1].1 } else { &instants[part].1 };
            let Some(normal) = self.normal(lerped, turned) else { continue };
            let Some((part_of_own, on_mesh)) = crossing(lerped, self.edge.ends, self.motion.thin)
            else {
                continue;
            };
            let on_body = self.own.ends[0].lerp(self.own.ends[1], part_of_own);
            let on_hull = lerped[0].lerp(lerped[1], part_of_own);
            // The hull's inside lies beyond the mesh's edge.
            let inside = on_hull + turned.direction(self.inside - on_body);
            if !self.stand_out(normal, turned) || (inside - on_mesh).dot(normal) <= 0.0 {
                continue;
            }
            let depth = if overlaps { -start } else { 0.0 };
            let (begin, until) = (instants[part - 1].0, instants[part].0);
            let time = begin + at * (until - begin);
            let met_at = on_body + turned.inverse().direction(on_mesh - on_hull);
            let carried = match is_supported && self.motion.is_borne {
                true => met_at,
                false => met_at + self.motion.without_sag(([begin, until], at), turned),
            };
            if self.is_on_rim(met_at, depth, turned) || self.is_on_rim(carried, depth, turned) {
                continue;
            }
            let last = self.own.supported.last().map_or(0.0, |ends| {
                let moved = ends[0] + (on_hull - lerped[0]);
                (moved - on_mesh).dot(normal)
            });
            let ends_behind = last < -self.motion.thin;
            if ends_behind && !(overlaps && part == 1) && !(touches && is_supported) {
                continue;
            }
            return Some(MeshContact {
                on_body,
                rounding: 0.0,
                on_mesh,
                normal: self.edge.within_arc(normal),
                time,
                feature: feature_of(Meets::EdgeOnEdge, self.id),
            });
        }
        None
    }

    /// The unit normal of both edges, towards the hull; `None` if they are parallel.
    fn normal(&self, ends: [DVec3; 2], mesh_from_body: &RigidTransform) -> Option<DVec3> {
        let own = ends[1] - ends[0];
        let across = own.cross(self.edge.along);
        if across.length_squared() <= PARALLEL * PARALLEL * own.length_squared() {
            return None;
        }
        let normal = across.try_normalize()?;
        let inward = mesh_from_body.direction(self.own.into[0] + self.own.into[1]);
        Some(if inward.dot(normal) < 0.0 { -normal } else { normal })
    }

    /// True for a point of the mesh, body frame, that lies less deep under another face than under
    /// the edge, or on that face's rim, if the mesh's edge stands out towards it.
    fn is_on_rim(&self, point_body: DVec3, depth: f64, mesh_from_body: &RigidTransform) -> bool {
        let MeshMotion { rim, .. } = *self.motion;
        self.faces.iter().enumerate().any(|(face, plane)| {
            let is_own = self.own.faces.contains(&(face as u32));
            !is_own
                && plane.distance(point_body) >= -rim.max(depth)
                && self.edge.stands_out(-mesh_from_body.direction(plane.normal), ASIDE)
        })
    }

    /// True if both edges are the furthest around themselves along the normal.
    fn stand_out(&self, normal: DVec3, mesh_from_body: &RigidTransform) -> bool {
        let own =
            self.own.into.iter().all(|&into| mesh_from_body.direction(into).dot(normal) >= -ASIDE);
        own && self.edge.stands_out(normal, ASIDE)
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
