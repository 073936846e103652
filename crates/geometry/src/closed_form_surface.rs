//! Triangles on closed forms, for drawing.

use crate::closed_form::ClosedForm;
use crate::mesh::TriMesh;
use crate::revolved::RevolvedEnd;
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Sides of a cylinder, as the whole one is drawn.
pub(crate) const DRAWN_SIDES: u32 = 48;

/// The closed surface of a formula in its frame; vertices lie on it exactly. Empty for a
/// half-space.
pub fn closed_form_surface(form: &ClosedForm) -> TriMesh {
    match *form {
        ClosedForm::HalfSpace(_) => TriMesh::default(),
        ClosedForm::Sphere { radius } => ball(radius),
        ClosedForm::Box { half } => cuboid(half),
        ClosedForm::Cylinder { radius, half_height } => cylinder(radius, half_height),
        ClosedForm::Capsule { radius, half_height } => {
            // Rings of both half balls, from end to end; the middle ones are the side's.
            const RINGS: u32 = DRAWN_SIDES / 4;
            let ring = |n: u32, up: f64| {
                let angle = FRAC_PI_2 * f64::from(n) / f64::from(RINGS);
                let height = up * (half_height + radius * libm::sin(angle));
                RevolvedEnd { height, radius: radius * libm::cos(angle) }
            };
            let low = (0..RINGS).rev().map(|n| ring(n, -1.0));
            let rings: Vec<RevolvedEnd> = low.chain((0..RINGS).map(|n| ring(n, 1.0))).collect();
            let tip = half_height + radius;
            turned(&rings, [-tip, tip])
        }
        ClosedForm::Cone { radius, height } => {
            let (low, high) = (-0.25 * height, 0.75 * height);
            turned(&[RevolvedEnd { height: low, radius }], [low, high])
        }
    }
}

/// An icosahedron with its edges halved and moved to the sphere, three times: 1280 triangles.
fn ball(radius: f64) -> TriMesh {
    const HALVINGS: usize = 3;
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let mut directions: Vec<DVec3> = Vec::new();
    for axis in 0..3 {
        for (u, v) in [(1.0, golden), (-1.0, golden), (-1.0, -golden), (1.0, -golden)] {
            let mut corner = DVec3::ZERO;
            (corner[axis], corner[(axis + 1) % 3]) = (u, v);
            directions.push(corner.normalize());
        }
    }
    // The faces are the triples of mutual neighbours, which are 63.4 degrees apart.
    let neighbours = |a: usize, b: usize| directions[a].dot(directions[b]) > 0.4;
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for a in 0..directions.len() {
        for b in (a + 1..directions.len()).filter(|&b| neighbours(a, b)) {
            for c in (b + 1..directions.len()).filter(|&c| neighbours(a, c) && neighbours(b, c)) {
                let outward = directions[a].cross(directions[b]).dot(directions[c]) > 0.0;
                triangles
                    .push(if outward { [a, b, c] } else { [a, c, b] }.map(|vertex| vertex as u32));
            }
        }
    }

    for _ in 0..HALVINGS {
        let mut middles: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for &[a, b, c] in &triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    directions.push((directions[p as usize] + directions[q as usize]).normalize());
                    directions.len() as u32 - 1
                })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    TriMesh {
        positions: directions.into_iter().map(|direction| radius * direction).collect(),
        triangles,
    }
}

/// Two triangles for each face.
fn cuboid(half: DVec3) -> TriMesh {
    let sign = |bit: usize| if bit & 1 == 1 { 1.0 } else { -1.0 };
    let positions =
        (0..8).map(|c| half * DVec3::new(sign(c), sign(c >> 1), sign(c >> 2))).collect();
    let mut triangles = Vec::with_capacity(12);
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let high = 1 << axis;
        triangles.extend([[high, high + u, high + u + v], [high, high + u + v, high + v]]);
        triangles.extend([[0, u + v, u], [0, v, u + v]]);
    }
    TriMesh { positions, triangles }
}

/// A prism and two fans.
fn cylinder(radius: f64, half_height: f64) -> TriMesh {
    const SIDES: u32 = DRAWN_SIDES;
    let mut positions = vec![DVec3::new(0.0, -half_height, 0.0), DVec3::new(0.0, half_height, 0.0)];
    let mut triangles = Vec::with_capacity(4 * SIDES as usize);
    for side in 0..SIDES {
        let angle = TAU * f64::from(side) / f64::from(SIDES);
        let (x, z) = (radius * libm::cos(angle), radius * libm::sin(angle));
        positions.extend([DVec3::new(x, -half_height, z), DVec3::new(x, half_height, z)]);
        let (low, next) = (2 + 2 * side, 2 + 2 * ((side + 1) % SIDES));
        triangles.extend([
            [low, low + 1, next],
            [next, low + 1, next + 1],
            [0, low, next],
            [1, next + 1, low + 1],
        ]);
    }
    TriMesh { positions, triangles }
}

/// Rings around the y axis, from the lowest, and fans from them to two points of the axis.
fn turned(rings: &[RevolvedEnd], tips: [f64; 2]) -> TriMesh {
    const SIDES: u32 = DRAWN_SIDES;
    let mut positions = vec![tips[0] * DVec3::Y, tips[1] * DVec3::Y];
    for ring in rings {
        positions.extend((0..SIDES).map(|side| {
            let angle = TAU * f64::from(side) / f64::from(SIDES);
            let (x, z) = (libm::cos(angle), libm::sin(angle));
            DVec3::new(ring.radius * x, ring.height, ring.radius * z)
        }));
    }
    let mut triangles = Vec::new();
    let last = 2 + SIDES * (rings.len() as u32 - 1);
    for side in 0..SIDES {
        let next = (side + 1) % SIDES;
        triangles.push([0, 2 + side, 2 + next]);
        for ring in 0..rings.len() as u32 - 1 {
            let (low, high) = (2 + SIDES * ring, 2 + SIDES * (ring + 1));
            triangles.push([low + side, high + side, low + next]);
            triangles.push([low + next, high + side, high + next]);
        }
        triangles.push([1, last + next, last + side]);
    }
    TriMesh { positions, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_are_closed_and_enclose_the_volume() {
        let forms = [
            (ClosedForm::Sphere { radius: 0.7 }, 0.01),
            (ClosedForm::Box { half: DVec3::new(0.5, 0.2, 0.9) }, 1e-14),
            (ClosedForm::Cylinder { radius: 0.4, half_height: 0.3 }, 0.01),
            (ClosedForm::Capsule { radius: 0.4, half_height: 0.3 }, 0.01),
            (ClosedForm::Cone { radius: 0.4, height: 0.3 }, 0.01),
        ];
        for (form, tolerance) in forms {
            let mesh = closed_form_surface(&form);
            let mut balance: BTreeMap<(u32, u32), i32> = BTreeMap::new();
            let mut volume = 0.0;
            for (n, &[a, b, c]) in mesh.triangles.iter().enumerate() {
                for (p, q) in [(a, b), (b, c), (c, a)] {
                    assert!(balance.insert((p, q), 1).is_none());
                }
                let [a, b, c] = mesh.corners(n);
                volume += a.dot(b.cross(c)) / 6.0;
            }
            assert!(balance.keys().all(|&(p, q)| balance.contains_key(&(q, p))));
            assert!(
                (volume / form.mass_properties().unwrap().volume - 1.0).abs() < tolerance,
                "{form:?}: {volume}"
            );
            for &position in &mesh.positions {
                let inside = form.distance(position);
                assert!(inside.abs() < 1e-12);
            }
        }
    }
}
