//! A face on a face: the part of one over the other [SH74].

use super::axis::{FaceAxis, View};
use super::{Feature, HullPoint};
use glam::DVec3;

/// What a polygon's side lies on.
#[derive(Clone, Copy)]
enum Side {
    /// An edge of the incident hull.
    Incident(u32),
    /// A side of the reference face, by its place around it.
    Reference(usize),
}

/// A corner of the polygon that is clipped.
#[derive(Clone, Copy)]
struct Corner {
    point: DVec3,
    /// What it is, the reference hull being the first.
    feature: Feature,
    /// The polygon's side that begins here.
    side: Side,
}

/// Points of the incident hull's face that lie over a reference face, each with its foot on it. Corners within `close` [m] of the
/// reference face's sides count as lying on them, so that what is flush keeps its features.
pub(crate) fn face_points(
    reference: &View,
    incident: &View,
    axis: &FaceAxis,
    reference_is_first: bool,
    close: f64,
) -> Vec<HullPoint> {
    let plane = reference.planes[axis.face];
    let face = reference.hull.face(axis.face);
    let count = face.vertices.len();
    let mut polygon = incident_polygon(incident, axis.vertex as u32, plane.normal);
    for at in 0..count {
        let [start, end] =
            [at, (at + 1) % count].map(|corner| reference.vertices[face.vertices[corner] as usize]);
        let outward = (end - start).cross(plane.normal).normalize_or_zero();
        let height = |point: DVec3| outward.dot(point - start);
        let crossing = |side: Side| match side {
            Side::Incident(edge) => Feature::Edges(face.edges[at], edge),
            // The corner of the reference face between the two sides.
            Side::Reference(other) => {
                Feature::VertexOfFirst(face.vertices[if (at + 1) % count == other { other } else { at }])
            }
        };
        polygon = clip(&polygon, Side::Reference(at), close, height, crossing);
    }

    let point = |corner: &Corner| {
        let gap = plane.distance(corner.point);
        let foot = corner.point - gap * plane.normal;
        if reference_is_first {
            HullPoint { on: [foot, corner.point], normal: -plane.normal, gap, feature: corner.feature }
        } else {
            HullPoint {
                on: [corner.point, foot],
                normal: plane.normal,
                gap,
                feature: corner.feature.swapped(),
            }
        }
    };
    polygon.iter().map(point).collect()
}

/// Of the faces around a vertex, the one that looks most against `normal`.
fn incident_polygon(incident: &View, vertex: u32, normal: DVec3) -> Vec<Corner> {
    let (mut lowest, mut chosen) = (f64::INFINITY, None);
    for (face, plane) in incident.hull.faces().zip(&incident.planes) {
        let slope = plane.normal.dot(normal);
        if slope < lowest && face.vertices.contains(&vertex) {
            (lowest, chosen) = (slope, Some(face));
        }
    }
    let corner = |(&vertex, &edge): (&u32, &u32)| Corner {
        point: incident.vertices[vertex as usize],
        feature: Feature::VertexOfSecond(vertex),
        side: Side::Incident(edge),
    };
    chosen.map_or(Vec::new(), |face| face.vertices.iter().zip(face.edges).map(corner).collect())
}

/// The part of a polygon at heights of at most `close` [m]; sides that go further up are cut at height 0, where they are what
/// `crossing` says.
fn clip(
    polygon: &[Corner],
    cut: Side,
    close: f64,
    height: impl Fn(DVec3) -> f64,
    crossing: impl Fn(Side) -> Feature,
) -> Vec<Corner> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (at, corner) in polygon.iter().enumerate() {
        let next = &polygon[(at + 1) % polygon.len()];
        let (from, to) = (height(corner.point), height(next.point));
        let (is_out, next_is_out) = (from > close, to > close);
        if !is_out {
            // Where the polygon leaves, the cut takes over.
            let leaves_here = next_is_out && from >= -close;
            kept.push(Corner { side: if leaves_here { cut } else { corner.side }, ..*corner });
        }
        if (from < -close && next_is_out) || (is_out && to < -close) {
            let point = corner.point.lerp(next.point, from / (from - to));
            let side = if is_out { corner.side } else { cut };
            kept.push(Corner { point, feature: crossing(corner.side), side });
        }
    }
    kept
}
