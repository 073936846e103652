//! Points on the surface of a hull.

use super::Hull;
use glam::{DVec3, Vec3};

/// Points on a hull [m], about `spacing` apart: all vertices, then points along edges, then on
/// faces.
pub(crate) fn hull_samples(hull: &Hull, spacing: f64) -> Vec<Vec3> {
    let mut samples = hull.vertices().to_vec();
    for edge in 0..hull.edges().len() {
        let [start, end] = hull.edge_ends(edge);
        // A length that is a multiple of the spacing up to rounding is divided as such.
        let steps = (start.distance(end) / spacing - 1e-9).ceil().max(1.0) as usize;
        samples.extend((1..steps).map(|step| start.lerp(end, step as f64 / steps as f64)));
    }
    for face in 0..hull.faces().len() {
        sample_face(hull, face, spacing, &mut samples);
    }
    samples.into_iter().map(|sample| sample.as_vec3()).collect()
}

/// The nodes of a square lattice along the longest side of a face that are not closer to its rim
/// than half of a step.
fn sample_face(hull: &Hull, face: usize, spacing: f64, samples: &mut Vec<DVec3>) {
    let face = hull.face(face);
    let corner = |at: usize| hull.vertices()[face.vertices[at % face.vertices.len()] as usize];
    let length = |at: usize| corner(at).distance_squared(corner(at + 1));
    let mut longest = 0;
    for at in 1..face.vertices.len() {
        // Sides of equal length up to rounding count as equal: the first of them decides.
        if length(at) > (1.0 + 1e-9) * length(longest) {
            longest = at;
        }
    }
    let origin = corner(longest);
    let Some(along) = (corner(longest + 1) - origin).try_normalize() else { return };
    let across = face.plane.normal.cross(along);

    // The box of the face in the lattice's own coordinates.
    let in_plane = |point: DVec3| ((point - origin).dot(along), (point - origin).dot(across));
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    let mut top = 0.0_f64;
    for at in 0..face.vertices.len() {
        let (x, y) = in_plane(corner(at));
        (low, high, top) = (low.min(x), high.max(x), top.max(y));
    }

    let from_rim = |point: DVec3| {
        let to_side = |at: usize| {
            let inward = face.plane.normal.cross(corner(at + 1) - corner(at)).normalize_or_zero();
            inward.dot(point - corner(at))
        };
        (0..face.vertices.len()).map(to_side).fold(f64::INFINITY, f64::min)
    };
    for row in 1..=(top / spacing) as i64 {
        for column in (low / spacing) as i64..=(high / spacing) as i64 {
            let point = origin + spacing * (column as f64 * along + row as f64 * across);
            if from_rim(point) >= 0.5 * spacing {
                samples.push(point);
            }
        }
    }
}
