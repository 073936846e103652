//! Face against face: clips the incident face by the sides of the reference face [SH74].

use crate::narrow_phase::hull_hull::hull_point::{Feature, HullPoint};
use crate::narrow_phase::hull_hull::placement::View;
use crate::narrow_phase::hull_hull::scratch::Corner;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::hull_hull::scratch::Side;
use crate::narrow_phase::hull_hull::separating_axis::FaceAxis;
use glam::DVec3;

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
    let Scratch { polygon, clipped, points, .. } = scratch;
    let plane = reference.plane(axis.face);
    let face = reference.hull.face(axis.face);
    let count = face.vertices.len();
    incident_polygon(&incident, axis.vertex as u32, plane.normal, polygon);
    let mut start = reference.vertex(face.vertices[0] as usize);
    for at in 0..count {
        // Skip sides without vertices beyond.
        let next = (at + 1) % count;
        let end = reference.vertex(face.vertices[next] as usize);
        let outward = (end - start).cross(plane.normal);
        let mut highest = 0.0_f64;
        for corner in polygon.iter_mut() {
            corner.beyond = outward.dot(corner.point - start);
            highest = highest.max(corner.beyond);
        }
        start = end;
        if highest <= 0.0 {
            continue;
        }
        let scale = 1.0 / outward.length();
        if scale * highest <= close {
            continue;
        }
        polygon.iter_mut().for_each(|corner| corner.beyond *= scale);
        let crossing = |side: Side| match side {
            Side::Incident(edge) => Feature::Edges(face.edges[at], edge),
            // The corner of the reference face between the two sides.
            Side::Reference(other) => {
                Feature::VertexOfFirst(face.vertices[if next == other { other } else { at }])
            }
        };
        clip(polygon, Side::Reference(at), close, crossing, clipped);
        std::mem::swap(polygon, clipped);
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
