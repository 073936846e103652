//! Face against face: clips the incident face by the sides of the reference face [SH74].

use crate::narrow_phase::hull_hull::hull_point::{Feature, HullPoint};
use crate::narrow_phase::hull_hull::placement::View;
use crate::narrow_phase::hull_hull::reference_sides::Sides;
use crate::narrow_phase::hull_hull::scratch::Corner;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::hull_hull::scratch::Side;
use crate::narrow_phase::hull_hull::separating_axis::FaceAxis;
use crate::narrow_phase::hull_hull::turning_clip::clip_in_turn;
use glam::DVec3;

/// Largest product of the numbers of corners of two faces up to which all corners are compared with
/// all sides [1]. Without turns prisms of 1000 sides on each other take 7 instead of 0.7 ms.
const FEW_CROSSINGS: usize = 1 << 10;

/// Finds points of the incident hull's face over a reference face, each with its foot point.
/// Vertices within `close` [m] of the reference face's sides count as inside: flush contacts keep
/// their features.
pub(crate) fn face_points(
    [reference, incident]: [View; 2],
    axis: &FaceAxis,
    reference_is_first: bool,
    close: f64,
    scratch: &mut Scratch,
) {
    let Scratch { polygon, clipped, links, points, .. } = scratch;
    let plane = reference.plane(axis.face);
    let face = reference.hull.face(axis.face);
    incident_polygon(&incident, axis.vertex as u32, plane.normal, polygon);
    let sides = Sides { reference: &reference, face: &face, normal: plane.normal };
    if face.vertices.len() * polygon.len() <= FEW_CROSSINGS {
        clip_by_all(&sides, close, polygon, clipped);
    } else {
        clip_in_turn(&sides, close, polygon, links);
    }

    let point = |corner: &Corner| {
        let gap = plane.distance(corner.point);
        let foot = corner.point - gap * plane.normal;
        if reference_is_first {
            HullPoint {
                on: [foot, corner.point],
                normal: -plane.normal,
                gap,
                feature: corner.feature,
            }
        } else {
            let feature = corner.feature.swapped();
            HullPoint { on: [corner.point, foot], normal: plane.normal, gap, feature }
        }
    };
    points.clear();
    points.extend(polygon.iter().map(point));
}

/// Clips a polygon by the sides of a face with a tolerance of `close` [m].
pub(crate) fn clip_by_all(
    sides: &Sides,
    close: f64,
    polygon: &mut Vec<Corner>,
    clipped: &mut Vec<Corner>,
) {
    for (at, (start, outward)) in sides.outward().enumerate() {
        // Skip sides without vertices beyond.
        let mut highest = 0.0_f64;
        for corner in polygon.iter_mut() {
            corner.beyond = outward.dot(corner.point - start);
            highest = highest.max(corner.beyond);
        }
        if highest <= 0.0 {
            continue;
        }
        let scale = 1.0 / outward.length();
        if scale * highest <= close {
            continue;
        }
        polygon.iter_mut().for_each(|corner| corner.beyond *= scale);
        clip(polygon, Side::Reference(at), close, |side| sides.crossing(at, side), clipped);
        std::mem::swap(polygon, clipped);
    }
}

/// Polygon of the face around a vertex that is most opposed to `normal`.
fn incident_polygon(incident: &View, vertex: u32, normal: DVec3, polygon: &mut Vec<Corner>) {
    let hull = incident.hull;
    let normal = incident.into_hull(normal);
    let (mut lowest, mut chosen) = (f64::INFINITY, 0);
    for edge in hull.edges().iter().filter(|edge| edge.vertices.contains(&vertex)) {
        for face in edge.faces {
            let slope = hull.planes()[face as usize].normal.dot(normal);
            if slope < lowest || (slope == lowest && face < chosen) {
                (lowest, chosen) = (slope, face);
            }
        }
    }
    let face = hull.face(chosen as usize);
    let corner = |(&vertex, &edge): (&u32, &u32)| Corner {
        point: incident.vertex(vertex as usize),
        feature: Feature::VertexOfSecond(vertex),
        side: Side::Incident(edge),
        beyond: 0.0,
    };
    polygon.clear();
    polygon.extend(face.vertices.iter().zip(face.edges).map(corner));
}

/// Clips a polygon by a side with a tolerance of `close` [m]; `crossing` names the feature of each
/// new vertex.
fn clip(
    polygon: &[Corner],
    cut: Side,
    close: f64,
    crossing: impl Fn(Side) -> Feature,
    kept: &mut Vec<Corner>,
) {
    kept.clear();
    for (at, corner) in polygon.iter().enumerate() {
        let next = &polygon[if at + 1 == polygon.len() { 0 } else { at + 1 }];
        let (from, to) = (corner.beyond, next.beyond);
        let (is_out, next_is_out) = (from > close, to > close);
        if !is_out {
            // The clipping side begins at the polygon's exit.
            let leaves_here = next_is_out && from >= -close;
            kept.push(Corner { side: if leaves_here { cut } else { corner.side }, ..*corner });
        }
        if (from < -close && next_is_out) || (is_out && to < -close) {
            let point = corner.point.lerp(next.point, from / (from - to));
            let side = if is_out { corner.side } else { cut };
            kept.push(Corner { point, feature: crossing(corner.side), side, beyond: 0.0 });
        }
    }
}
