//! Corners of a mesh that stand out against faces of a hull.

use crate::narrow_phase::mesh::hull_way::{HullWay, Instant, Way};
use crate::narrow_phase::mesh::mesh_contact::{Meets, MeshContact, feature_of};
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use crate::narrow_phase::mesh::triangle_sweep::Sweep;
use frangible_geometry::HullFace;
use glam::DVec3;

/// Sine of the angle by which an edge of the mesh may rise over a hull's face that a corner of it
/// touches [1]: resting bodies turn by less.
const RISES: f64 = 5e-3;

/// Appends the contacts of some vertices of the mesh with faces of the hull.
pub(crate) fn corner_contacts(
    hull_way: &HullWay,
    vertices: &[usize],
    contacts: &mut Vec<MeshContact>,
) {
    for &vertex in vertices {
        let corner = Corner { hull_way, vertex };
        contacts.extend(hull_way.ways().find_map(|way| corner.contact(way)));
    }
}

struct Corner<'a> {
    hull_way: &'a HullWay<'a>,
    vertex: usize,
}

impl Corner<'_> {
    /// The first contact on a way of the body. On that of its free flight it must not end behind
    /// the face on that which what it touches leaves it.
    fn contact(&self, way: &Way) -> Option<MeshContact> {
        let motion = self.hull_way.motion;
        let corner = motion.mesh.positions()[self.vertex];
        for (part, pair) in way.instants.windows(2).enumerate() {
            let [from, to] = [&pair[0], &pair[1]];
            let points = [from.body_from_mesh.point(corner), to.body_from_mesh.point(corner)];
            let is_held = way.is_supported && motion.is_borne;
            let without_sag = |at: f64| match is_held {
                true => DVec3::ZERO,
                false => motion.without_sag(([from.time, to.time], at), &from.mesh_from_body),
            };
            let met = self.meeting(points, part == 0, from, &without_sag);
            let Some((face, sweep)) = met else { continue };
            let plane = face.plane;
            let last = self.hull_way.supported_end().map(|last| last.body_from_mesh.point(corner));
            let ends_behind = last.is_some_and(|last| plane.distance(last) < -motion.thin);
            let overlaps = sweep.touches && part == 0 && sweep.at == 0.0;
            if !overlaps && ends_behind && !(sweep.touches && way.is_supported) {
                continue;
            }
            let time = from.time + sweep.at * (to.time - from.time);
            let at = points[0].lerp(points[1], sweep.at);
            let turned = if sweep.at < 0.5 { from } else { to };
            return Some(MeshContact {
                on_body: at - plane.distance(at) * plane.normal,
                rounding: 0.0,
                on_mesh: corner,
                normal: -(turned.rotation * plane.normal),
                time,
                feature: feature_of(Meets::FaceOnCorner, self.vertex as u64),
            });
        }
        None
    }

    /// The face that the corner meets on a straight way, body frame; `without_sag` moves its points
    /// to where they are without gravity.
    fn meeting(
        &self,
        way: [DVec3; 2],
        is_first: bool,
        instant: &Instant,
        without_sag: &dyn Fn(f64) -> DVec3,
    ) -> Option<(HullFace<'_>, Sweep)> {
        let HullWay { motion, hull, inside, .. } = *self.hull_way;
        let near = motion.pair_motion.near;
        let is_inside = hull.planes().iter().all(|plane| plane.distance(way[0]) <= motion.thin);
        let carried_way = way[1] + without_sag(1.0) - way[0];
        let closing = |face: &HullFace| -carried_way.dot(face.plane.normal);
        let mut best: Option<(HullFace, Sweep)> = None;
        for (number, plane) in hull.planes().iter().enumerate() {
            let [start, end] = [plane.distance(way[0]), plane.distance(way[1])];
            let is_towards = (way[0] - inside).dot(plane.normal) > 0.0;
            // Corners that come near at the frame's end are met in the next.
            if start > near && end > 0.0 || is_inside && !is_towards {
                continue;
            }
            // A face is met from behind only by what overlaps the hull at the start.
            let stays_behind = start.max(end) < -motion.thin;
            if stays_behind && !(is_inside && is_first) {
                continue;
            }
            let face = hull.face(number);
            let Some(sweep) = self.sweep(&face, way, is_inside && is_first) else { continue };
            let outward = instant.rotation * plane.normal;
            if !motion.mesh.is_peak(self.vertex, -outward, RISES) {
                continue;
            }
            let met_at = way[0].lerp(way[1], sweep.at);
            let carried = met_at + without_sag(sweep.at);
            let is_on_rim = |point: DVec3| self.is_on_rim(number, point, instant);
            if !is_inside && (is_on_rim(met_at) || is_on_rim(carried)) {
                continue;
            }
            // Of faces that it overlaps, the one with the least depth, and among those on whose
            // rims it is the one that it slides along; else what comes first.
            let is_better = |best: &(HullFace, Sweep)| match (sweep.touches, best.1.touches) {
                (true, true) if is_inside => {
                    let slower = closing(&best.0) - closing(&face);
                    let on_rims = sweep.least.min(best.1.least) >= -motion.rim;
                    if on_rims && slower.abs() > motion.thin {
                        slower > 0.0
                    } else {
                        sweep.least > best.1.least
                    }
                }
                (true, true) => sweep.at < best.1.at,
                (false, false) => sweep.least < best.1.least,
                (touches, _) => touches,
            };
            if best.as_ref().is_none_or(is_better) {
                best = Some((face, sweep));
            }
        }
        best.filter(|(_, sweep)| sweep.touches || sweep.least <= near)
    }

    /// True if the corner meets a face on its rim and stands out towards the face beyond: resting,
    /// the body overlaps it there a little.
    fn is_on_rim(&self, face: usize, point: DVec3, instant: &Instant) -> bool {
        let HullWay { motion, hull, .. } = *self.hull_way;
        hull.planes().iter().enumerate().any(|(other, plane)| {
            let is_near = other != face && plane.distance(point) >= -motion.rim;
            is_near && {
                let outward = instant.rotation * plane.normal;
                motion.mesh.is_peak(self.vertex, -outward, RISES)
            }
        })
    }

    /// Meeting with the inside of a face.
    fn sweep(&self, face: &HullFace, way: [DVec3; 2], overlaps: bool) -> Option<Sweep> {
        let HullWay { motion: MeshMotion { thin, .. }, hull, .. } = *self.hull_way;
        let [start, end] = [face.plane.distance(way[0]), face.plane.distance(way[1])];
        let gap = |at: f64| start + at * (end - start);
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        let corners = face.vertices.iter().map(|&vertex| hull.vertices()[vertex as usize]);
        let next = corners.clone().cycle().skip(1);
        for (corner, next) in corners.zip(next) {
            let inward = face.plane.normal.cross(next - corner);
            let most = -thin * inward.length();
            let before = inward.dot(way[0] - corner) - most;
            let after = inward.dot(way[1] - corner) - most;
            if before < 0.0 && after < 0.0 {
                return None;
            }
            if before < 0.0 {
                first = first.max(before / (before - after));
            } else if after < 0.0 {
                last = last.min(before / (before - after));
            }
        }
        if first > last {
            return None;
        }
        let [on_entry, on_exit] = [gap(first), gap(last)];
        if on_entry <= 0.0 {
            let is_met = overlaps || on_entry >= -thin;
            return is_met.then_some(Sweep { at: first, touches: true, least: on_entry });
        }
        if on_exit <= 0.0 {
            return Some(Sweep { at: start / (start - end), touches: true, least: 0.0 });
        }
        let at = if on_exit < on_entry { last } else { first };
        Some(Sweep { at, touches: false, least: on_entry.min(on_exit) })
    }
}
