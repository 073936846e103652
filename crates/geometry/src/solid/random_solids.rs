//! Random solids and cells.

use super::cell_tree::Cell;
use super::*;
use crate::hull::Hull;
use glam::DQuat;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// [rad], [m], or any other unit.
fn between(rng: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

fn below(rng: &mut Pcg64Mcg, count: usize) -> usize {
    rng.random_range(0..count)
}

fn point(rng: &mut Pcg64Mcg) -> DVec3 {
    DVec3::new(between(rng, -1.0, 1.0), between(rng, -1.0, 1.0), between(rng, -1.0, 1.0))
}

fn direction(rng: &mut Pcg64Mcg) -> DVec3 {
    point(rng).normalize_or(DVec3::Z)
}

fn add(mesh: &mut TriMesh, other: &TriMesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(&other.positions);
    mesh.triangles.extend(other.triangles.iter().map(|corners| corners.map(|at| at + first)));
}

/// The hull of some points within two metres.
fn convex(rng: &mut Pcg64Mcg) -> TriMesh {
    let count = 4 + below(rng, 30);
    let points: Vec<DVec3> = (0..count).map(|_| point(rng)).collect();
    Hull::of_points(&points).unwrap_or(Hull::cuboid(DVec3::ONE)).surface()
}

/// A ball of rings, whose radius differs from vertex to vertex, or a torus of them.
fn ringed(rng: &mut Pcg64Mcg, is_torus: bool) -> TriMesh {
    let (along, around) = (5 + below(rng, 7) as u32, 3 + below(rng, 9) as u32);
    let rough = between(rng, 0.0, if is_torus { 0.2 } else { 0.7 });
    let mut mesh = TriMesh::default();
    let turn = std::f64::consts::TAU;
    for ring in 0..along {
        for at in 0..around {
            let radius = 1.0 - rough * rng.random::<f64>();
            let v = turn * f64::from(at) / f64::from(around);
            let place = if is_torus {
                let u = turn * f64::from(ring) / f64::from(along);
                let out = 1.0 + 0.4 * radius * libm::cos(v);
                DVec3::new(out * libm::cos(u), out * libm::sin(u), 0.4 * radius * libm::sin(v))
            } else {
                let u = turn / 2.0 * f64::from(ring + 1) / f64::from(along + 1);
                let out = libm::sin(u);
                radius * DVec3::new(out * libm::cos(v), out * libm::sin(v), libm::cos(u))
            };
            mesh.positions.push(place);
        }
    }
    let rings = if is_torus { along } else { along - 1 };
    for ring in 0..rings {
        for at in 0..around {
            let vertex = |ring: u32, at: u32| ring % along * around + at % around;
            let [a, b] = [vertex(ring, at), vertex(ring, at + 1)];
            let [c, d] = [vertex(ring + 1, at), vertex(ring + 1, at + 1)];
            mesh.triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    if !is_torus {
        let poles = mesh.positions.len() as u32;
        mesh.positions.extend([0.9 * DVec3::Z, -0.9 * DVec3::Z]);
        let last = (along - 1) * around;
        for at in 0..around {
            let next = (at + 1) % around;
            mesh.triangles.extend([[poles, at, next], [poles + 1, last + next, last + at]]);
        }
    }
    mesh
}

/// The boundary of some cubes of a lattice, which may touch along edges and at corners and leave
/// cavities; its vertices may be moved a little.
fn cubes(rng: &mut Pcg64Mcg) -> TriMesh {
    let side = 2 + below(rng, 3) as i32;
    let share = between(rng, 0.3, 0.9);
    let count = (side * side * side) as usize;
    let mut is_full: Vec<bool> = (0..count).map(|_| rng.random::<f64>() < share).collect();
    is_full[0] = true;
    let full = |at: [i32; 3]| {
        let inside = at.iter().all(|&at| (0..side).contains(&at));
        inside && is_full[((at[0] * side + at[1]) * side + at[2]) as usize]
    };
    let vertex = |at: [i32; 3]| ((at[0] * (side + 1) + at[1]) * (side + 1) + at[2]) as u32;
    let moves = if rng.random() { 0.2 } else { 0.0 };
    let mut mesh = TriMesh::default();
    for n in 0..(side + 1).pow(3) {
        let at = DVec3::new(
            f64::from(n / (side + 1).pow(2)),
            f64::from(n / (side + 1) % (side + 1)),
            f64::from(n % (side + 1)),
        );
        mesh.positions.push(at + moves * point(rng));
    }
    for n in 0..side.pow(3) {
        let at = [n / (side * side), n / side % side, n % side];
        for axis in 0..3 {
            for up in [0, 1] {
                let mut beside = at;
                beside[axis] += 2 * up - 1;
                if !full(at) || full(beside) {
                    continue;
                }
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |x: i32, y: i32| {
                    let mut corner = at;
                    corner[axis] += up;
                    corner[u] += x;
                    corner[v] += y;
                    vertex(corner)
                };
                let mut loops = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if up == 0 {
                    loops.reverse();
                }
                let [a, b, c, d] = loops;
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

fn one_mesh(rng: &mut Pcg64Mcg) -> TriMesh {
    let mut mesh = match below(rng, 4) {
        0 => convex(rng),
        1 => ringed(rng, false),
        2 => ringed(rng, true),
        _ => cubes(rng),
    };
    if below(rng, 3) == 0 {
        // Its copy within, turned inside out, and perhaps once more: exact for convex meshes only.
        let hull = Hull::of_points(&mesh.positions);
        mesh = hull.map_or(mesh, |hull| hull.surface());
        let middle = mesh.mass_properties().center;
        for (number, scale) in [0.6, 0.3].into_iter().take(1 + below(rng, 2)).enumerate() {
            let mut inner = mesh.clone();
            inner
                .triangles
                .truncate(Hull::of_points(&mesh.positions).unwrap().surface().triangles.len());
            inner.positions.iter_mut().for_each(|at| *at = middle + scale * (*at - middle));
            if number == 0 {
                inner.flip();
            }
            add(&mut mesh, &inner);
        }
    }
    mesh
}

/// One to four solids of any form, thin, tiny, huge or far away.
pub(super) fn random_mesh(rng: &mut Pcg64Mcg) -> TriMesh {
    let mut mesh = TriMesh::default();
    let count = if below(rng, 4) == 0 { 2 + below(rng, 3) } else { 1 };
    for number in 0..count {
        let mut one = one_mesh(rng);
        let (low, high) = one.bounds();
        // Side by side: their boxes touch.
        let shift = 2.0 * number as f64;
        one.positions.iter_mut().for_each(|at| {
            *at = 2.0 * (*at - low) / (high - low).max_element() + shift * DVec3::X;
        });
        add(&mut mesh, &one);
    }
    let thin = |rng: &mut Pcg64Mcg| {
        if below(rng, 3) == 0 { libm::pow(10.0, -between(rng, 0.0, 4.0)) } else { 1.0 }
    };
    let stretch = DVec3::new(thin(rng), thin(rng), 1.0);
    let turn = if rng.random() {
        DQuat::from_axis_angle(direction(rng), between(rng, 0.0, 6.0))
    } else {
        DQuat::IDENTITY
    };
    let scale = [1.0, 1.0, 1e-3, 1e3][below(rng, 4)];
    let away = [0.0, 0.0, 1e4][below(rng, 3)] * direction(rng);
    for at in &mut mesh.positions {
        *at = away + scale * (turn * (*at * stretch));
    }
    mesh
}

/// All cells between planes.
fn cells_between(planes: &[HalfSpace], bounds: (DVec3, DVec3)) -> Vec<Cell> {
    (0..1 << planes.len())
        .map(|bits: usize| {
            let side = |(at, plane): (usize, &HalfSpace)| {
                if bits >> at & 1 == 1 { plane.flipped() } else { *plane }
            };
            Cell { planes: planes.iter().enumerate().map(side).collect(), bounds }
        })
        .collect()
}

/// Cells around random points; else those between planes through vertices, edges and faces, and
/// false.
pub(super) fn random_cells(rng: &mut Pcg64Mcg, solid: &Solid) -> (Vec<Cell>, bool) {
    let (low, high) = solid.bounds();
    let place = |rng: &mut Pcg64Mcg| low + (high - low) * (0.5 + 0.5 * point(rng));
    if rng.random() {
        let sites: Vec<DVec3> = (0..2 + below(rng, 20)).map(|_| place(rng)).collect();
        let cell = |&site: &DVec3| {
            let planes = sites.iter().filter(|&&other| other != site).map(|&other| {
                let normal = (other - site).normalize();
                HalfSpace { normal, offset: normal.dot(0.5 * (site + other)) }
            });
            Cell { planes: planes.collect(), bounds: (low, high) }
        };
        return (sites.iter().map(cell).collect(), true);
    }
    let vertex = |rng: &mut Pcg64Mcg| solid.vertices[below(rng, solid.vertices.len())];
    let mut planes = Vec::new();
    for _ in 0..1 + below(rng, 4) {
        let (normal, through) = match below(rng, 5) {
            0 => (direction(rng), place(rng)),
            1 => (direction(rng), vertex(rng)),
            2 => {
                let [a, b, c] = [vertex(rng), vertex(rng), vertex(rng)];
                ((b - a).cross(c - a).normalize_or(DVec3::X), a)
            }
            3 => {
                let edge = solid.edges[below(rng, solid.edges.len())];
                let [a, b] = edge.ends.map(|end| solid.vertices[end as usize]);
                ((b - a).cross(direction(rng)).normalize_or(DVec3::X), a)
            }
            _ => {
                let edge = solid.edges[below(rng, solid.edges.len())];
                let plane = solid.faces[edge.faces[0] as usize].plane;
                (plane.normal, solid.vertices[edge.ends[0] as usize])
            }
        };
        planes.push(HalfSpace { normal, offset: normal.dot(through) });
    }
    (cells_between(&planes, (low, high)), false)
}
