//! Contacts of a body of revolution with a mesh in closed form: its side and its rims with the
//! insides of triangles; then, where edges and corners stand out, those.

use crate::narrow_phase::mesh::edge_sweep::{ASIDE, MeshEdge, flush};
use crate::narrow_phase::mesh::hull_mesh::support;
use crate::narrow_phase::mesh::mesh_contact::{Meets, MeshContact, side_of};
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use crate::narrow_phase::mesh::round_motion::RoundMotion;
use crate::narrow_phase::revolved::features::Area;
use crate::narrow_phase::revolved::partner::Partner;
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use crate::narrow_phase::revolved::round_point::RoundPoint;
use crate::narrow_phase::revolved::separation::{Separation, contact_separation, separation};
use frangible_geometry::{EdgeKind, HalfSpace, Revolved, RevolvedEnd, Sides};
use glam::{DVec2, DVec3};

/// Depth of overlaps with a triangle, relative to the body's radius [1]: a body deeper behind its
/// plane lies beside it.
const DEPTH: f64 = 0.25;

/// Cosine of the least angle at an edge whose rim is not met, as for polyhedra [1].
const STEEP: f64 = 0.9;

/// Cosine of the angle between planes that count as one [1].
const FLAT: f64 = 1.0 - 1e-9;

/// Numbers of points where a side leaves a triangle: beyond those of the body's own features.
const CUT: u64 = 64;

/// Appends the contacts of a body of revolution.
pub(crate) fn round_contacts(
    motion: &mut MeshMotion,
    round: &Revolved,
    contacts: &mut Vec<MeshContact>,
) {
    let mesh = motion.mesh;
    let (low, high) = motion.swept_bounds(motion.body_shape().bounds);
    let mut triangles = Vec::new();
    mesh.visit_box(low, high, |triangle| triangles.push(triangle));
    let on_faces = RoundMesh { of: RoundMotion::new(motion, round) };
    let (mut passing, first) = (Vec::new(), contacts.len());
    for &triangle in &triangles {
        on_faces.face(triangle, contacts, &mut passing);
    }
    triangles.retain(|&triangle| !mesh.owns_nothing(triangle));
    if triangles.is_empty() {
        contacts.append(&mut passing);
        return;
    }
    let _ = support(motion, contacts);
    let on_edges = RoundMesh { of: RoundMotion::new(motion, round) };
    for &triangle in &triangles {
        for corner in 0..3 {
            if mesh.owns_edge(triangle, corner) {
                on_edges.edge(triangle, corner, contacts);
            }
            if mesh.owns_vertex(triangle, corner) {
                on_edges.corner(mesh.triangles()[triangle][corner] as usize, contacts);
            }
        }
    }
    // A body that touches anything moves on another way.
    if contacts[first..].iter().any(|contact| on_edges.of.touches(contact)) {
        contacts.append(&mut passing);
    }
    if contacts.is_empty() {
        wedged(&on_edges, &triangles, contacts);
    }
}

/// Appends a contact of a body whose rim has gone past an edge or a corner, which alone gives way
/// aside: that with the triangle along which it comes out of all of it.
fn wedged(of: &RoundMesh, triangles: &[usize], contacts: &mut Vec<MeshContact>) {
    let (round, mesh) = (&of.of.start, of.of.motion.mesh);
    let mut best: Option<(Separation, usize)> = None;
    for &triangle in triangles {
        let corners = mesh.corners(triangle);
        let outward = mesh.normal(triangle);
        let height = |up: DVec3| -round.reach(-up) - round.rounding - up.dot(corners[0]);
        if height(outward) > 0.0 || height(-outward) > 0.0 {
            continue;
        }
        let along = |corner: usize| {
            let edge = MeshEdge::of(mesh, triangle, corner)?;
            let length = edge.ends[0].distance(edge.ends[1]);
            let partner = Partner::Revolved(segment(edge.ends[0], edge.along, length));
            let size = of.of.motion.pair_motion.size;
            let normal = separation(round, &partner, size, mesh.normal(triangle)).normal;
            let heights = corners.map(|corner| corner.dot(normal));
            let at = (1..3).fold(0, |a, b| if heights[b] > heights[a] { b } else { a });
            let gap = -round.reach(-normal) - round.rounding - heights[at];
            let vertex = mesh.triangles()[triangle][at] as usize;
            Some((corner, Separation { gap, normal, on: None }, vertex))
        };
        let ways: Vec<_> = (0..3).filter_map(along).collect();
        // Along one of them the body is beside the triangle.
        if ways.iter().any(|(_, way, _)| way.gap > 0.0) {
            continue;
        }
        for (corner, way, vertex) in ways {
            let is_behind =
                mesh.sides() == Sides::One && mesh.normal(triangle).dot(way.normal) < 0.0;
            let is_better = best.is_none_or(|(best, _)| way.gap > best.gap);
            if mesh.owns_edge(triangle, corner) && !is_behind && is_better {
                best = Some((way, vertex));
            }
        }
    }
    if let Some((Separation { gap, normal, .. }, vertex)) = best
        && gap >= -DEPTH * of.of.motion.pair_motion.size
    {
        of.push_corner(vertex, (normal, 0.0), contacts);
    }
}

struct RoundMesh<'a> {
    of: RoundMotion<'a>,
}

/// A touch at an instant [s] of a way.
struct Met<'a> {
    of: RoundMotion<'a>,
    separation: Separation,
    time: f64,
}

impl RoundMesh<'_> {
    /// Contacts with the inside of a triangle, on the side where the body's middle is; apart those
    /// at points that pass it.
    fn face(
        &self,
        triangle: usize,
        contacts: &mut Vec<MeshContact>,
        passing: &mut Vec<MeshContact>,
    ) {
        let (of, mesh) = (&self.of, self.of.motion.mesh);
        let (mut corners, mut normal) = (mesh.corners(triangle), mesh.normal(triangle));
        if (of.start.middle - corners[0]).dot(normal) < 0.0 {
            if mesh.sides() == Sides::One {
                return;
            }
            corners.swap(1, 2);
            normal = -normal;
        }
        let plane = HalfSpace { normal, offset: normal.dot(corners[0]) };
        let partner = Partner::Plane(plane);
        let Some(touch) = of.touch(&partner, normal) else { return };
        let round = of.placed(touch.time);
        let separation = Separation { gap: touch.gap, normal, on: None };
        let area = Area::Triangle(corners, plane);
        let points = of.points(&round, &partner, (separation, touch.time), |instant, found| {
            instant.on_area(area, found);
            found.retain(|point| {
                self.is_own(triangle, (&round, touch.time), point)
                    && of.is_seen(triangle, (&round, touch.time), point)
            });
        });
        let depth = DEPTH * of.motion.pair_motion.size;
        for point in points.iter().filter(|point| point.gap() >= -depth) {
            let number = if self.is_cut(&round, point) {
                CUT + 3 * triangle as u64 + point.id
            } else {
                point.id
            };
            let feature = (Meets::PointOnFace(side_of(normal)), number);
            let contact = of.contact(point, touch.time, feature);
            if of.passes(point, touch.time) {
                passing.extend(contact);
            } else {
                contacts.extend(contact);
            }
        }
    }

    /// True for a point of the side that is at neither of its ends.
    fn is_cut(&self, round: &PlacedRevolved, point: &RoundPoint) -> bool {
        let along = (point.on_surfaces()[0] - round.middle).dot(round.axis);
        let thin = self.of.motion.thin;
        point.rim.is_none() && round.ends.iter().all(|end| (along - end.height).abs() > thin)
    }

    /// True for a point that belongs to this triangle: not where a side goes on over the next one,
    /// and not on the rim of a triangle beyond whose edge the body lies; there or, as something
    /// else may bear the body, where it is without gravity.
    fn is_own(
        &self,
        triangle: usize,
        (round, time): (&PlacedRevolved, f64),
        point: &RoundPoint,
    ) -> bool {
        let MeshMotion { mesh, thin, rim, .. } = *self.of.motion;
        let corners = mesh.corners(triangle);
        let foot = point.anchors[1].point;
        let is_cut = self.is_cut(round, point);
        let turn = point.normal.dot(mesh.normal(triangle)).signum();
        let sag = self.of.sag(time);
        // A sheet bears a body on either of its sides.
        let fronts: &[f64] = if mesh.sides() == Sides::Two { &[1.0, -1.0] } else { &[turn] };
        let is_over = |corner: usize, inward: DVec3| {
            let Some(next) = mesh.neighbour_normal(triangle, corner) else { return false };
            fronts.iter().any(|&front| {
                let next = front * next;
                // Only an edge that stands out has a rim.
                if next.dot(point.normal) >= STEEP || next.dot(inward) >= 0.0 {
                    return false;
                }
                let gap = -round.reach(-next) - round.rounding - next.dot(corners[corner]);
                // The back of a fold is not met from before the other part of it.
                let is_behind = front != turn && next.dot(round.middle - corners[corner]) > 0.0;
                is_behind || gap.max(gap - sag.dot(next)) >= -rim
            })
        };
        (0..3).all(|corner| {
            let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
            let inward = turn * point.normal.cross(to - from).normalize_or_zero();
            let off = inward.dot(foot - from);
            match mesh.edge_kind(triangle, corner) {
                EdgeKind::Flat => !is_cut || off.abs() > thin,
                EdgeKind::Border => true,
                EdgeKind::Concave if mesh.sides() == Sides::One => true,
                EdgeKind::Concave | EdgeKind::Convex => {
                    off.min(off - sag.dot(inward)) > rim || !is_over(corner, inward)
                }
            }
        })
    }

    /// Contacts with an edge that stands out.
    fn edge(&self, triangle: usize, corner: usize, contacts: &mut Vec<MeshContact>) {
        let Some(edge) = MeshEdge::of(self.of.motion.mesh, triangle, corner) else { return };
        let length = edge.ends[0].distance(edge.ends[1]);
        let segment = segment(edge.ends[0], edge.along, length);
        let id = (3 * triangle + corner) as u64 * 0x9e37;
        let stands_out =
            |normal: DVec3| normal.dot(edge.along).abs() <= ASIDE && edge.stands_out(normal, ASIDE);
        let Some(mut met) = self.meets(&segment, stands_out) else { return };
        if met.of.meet(&met.separation, met.time) {
            met.separation.normal = edge.flush(met.separation.normal);
        }
        let (normal, time) = (met.separation.normal, met.time);
        let mesh = self.of.motion.mesh;
        let is_border = mesh.edge_kind(triangle, corner) == EdgeKind::Border;
        if is_border && self.passes_over(mesh.normal(triangle), edge.ends[0], (normal, time)) {
            return;
        }
        Self::push(&segment, &met, (&edge, id), contacts);
    }

    /// The contact with a corner that stands out.
    fn corner(&self, vertex: usize, contacts: &mut Vec<MeshContact>) {
        let mesh = self.of.motion.mesh;
        let at = mesh.positions()[vertex];
        let point = segment(at, DVec3::Y, 0.0);
        let around = || mesh.around(vertex).iter().map(|&triangle| mesh.normal(triangle as usize));
        let is_in_front = |normal: DVec3| {
            mesh.sides() == Sides::Two || around().any(|outward| outward.dot(normal) > 0.0)
        };
        let stands_out = |normal: DVec3| is_in_front(normal) && mesh.is_peak(vertex, normal, ASIDE);
        let Some(Met { of, separation, time }) = self.meets(&point, stands_out) else { return };
        let mut normal = separation.normal;
        if of.meet(&separation, time) {
            normal = flush(normal, around());
        }
        let is_border = around().next().filter(|first| around().all(|n| n.dot(*first) > FLAT));
        if is_border.is_some_and(|outward| self.passes_over(outward, at, (normal, time))) {
            return;
        }
        RoundMesh { of }.push_corner(vertex, (normal, time), contacts);
    }

    /// True for a body that meets the border of a triangle aside at an instant, but is over the
    /// triangle's plane then and at the frame's start: without gravity, which something else
    /// bears. A cylinder that slid from one flush mesh to the next lost half of its speed.
    fn passes_over(&self, outward: DVec3, on_plane: DVec3, (normal, time): (DVec3, f64)) -> bool {
        let motion = self.of.motion;
        let up = (self.of.start.middle - on_plane).dot(outward).signum() * outward;
        let gap = |round: &PlacedRevolved| -round.reach(-up) - round.rounding - on_plane.dot(up);
        let sag = self.of.sag(time);
        let lowest = gap(&self.of.start).min(gap(&self.of.placed(time)) - sag.dot(up));
        normal.dot(up).abs() < ASIDE && lowest >= -motion.rim
    }

    /// Appends the contact with a corner along a normal at an instant.
    fn push_corner(
        &self,
        vertex: usize,
        (normal, time): (DVec3, f64),
        contacts: &mut Vec<MeshContact>,
    ) {
        let at = self.of.motion.mesh.positions()[vertex];
        let (of, round) = (&self.of, self.of.placed(time));
        let gap = -round.reach(-normal) - round.rounding - at.dot(normal);
        let on_core = at + (gap + round.rounding) * normal;
        let separation = Separation { gap, normal, on: Some([on_core, at]) };
        let partner = Partner::Plane(HalfSpace { normal, offset: at.dot(normal) });
        let points = of.points(&round, &partner, (separation, time), |instant, found| {
            found.push(instant.nearest());
        });
        for point in &points {
            contacts.extend(of.contact(point, time, (Meets::FaceOnCorner, vertex as u64)));
        }
    }

    /// The first touch with a segment, if it stands out along the normal.
    fn meets(
        &self,
        segment: &PlacedRevolved,
        stands_out: impl Fn(DVec3) -> bool,
    ) -> Option<Met<'_>> {
        let (of, partner) = (self.of, Partner::Revolved(*segment));
        let touch = of.touch(&partner, of.start.middle - segment.middle)?;
        let (of, touch) = of.grazed(&partner, &touch).unwrap_or((of, touch));
        let limits = (of.motion.pair_motion.size, of.close);
        let round = of.placed(touch.time);
        let found = contact_separation(&round, &partner, limits, touch.normal);
        if found.gap < -DEPTH * limits.0 {
            return None;
        }
        // A face's or a side's normal that is nearly as good may point aside.
        let is_met = stands_out(found.normal)
            || stands_out(separation(&round, &partner, limits.0, found.normal).normal);
        is_met.then_some(Met { of, separation: found, time: touch.time })
    }

    /// Appends the contacts with an edge, along normals at which it stands out.
    fn push(
        segment: &PlacedRevolved,
        met: &Met,
        (edge, id): (&MeshEdge, u64),
        contacts: &mut Vec<MeshContact>,
    ) {
        let Met { of, separation, time } = met;
        let (round, partner) = (of.placed(*time), Partner::Revolved(*segment));
        let at = (*separation, *time);
        let points = of.points(&round, &partner, at, |instant, found| instant.points(found));
        // A passing body has no other normals than that of its closest approach.
        let meets = of.meet(separation, *time);
        let stands_out = |point: &&RoundPoint| {
            point.normal == separation.normal || meets && edge.stands_out(point.normal, ASIDE)
        };
        for point in points.iter().filter(stands_out) {
            let feature = (Meets::EdgeOnEdge, id + point.id);
            contacts.extend(of.contact(point, *time, feature));
        }
    }
}

/// A segment as a body of revolution.
fn segment(from: DVec3, along: DVec3, length: f64) -> PlacedRevolved {
    let end = |height: f64| RevolvedEnd { height, radius: 0.0 };
    PlacedRevolved {
        middle: from,
        axis: along,
        across: along.any_orthonormal_vector(),
        ends: [end(0.0), end(length)],
        rounding: 0.0,
        side: DVec2::X,
    }
}

#[cfg(test)]
mod tests;
