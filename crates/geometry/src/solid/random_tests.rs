//! Random solids in random cells.

use super::convex_parts::PlaneSearch;
use super::parts::SolidPart;
use super::random_solids::{random_cells, random_mesh};
use super::*;
use crate::hull::Hull;
use frangible_math::DisjointSets;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

/// Connected surfaces with a positive volume of more than `least` [m^3].
fn outer_shells(solid: &Solid, least: f64) -> usize {
    let mut sets = DisjointSets::new(solid.faces.len());
    solid.edges.iter().for_each(|edge| sets.unite(edge.faces[0], edge.faces[1]));
    let (mesh, of_face) = solid.triangles();
    let mut volume = vec![0.0; solid.faces.len()];
    for (triangle, &face) in of_face.iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - solid.vertices[0]);
        volume[sets.root(face) as usize] += a.dot(b.cross(c)) / 6.0;
    }
    volume.iter().filter(|&&volume| volume > least).count()
}

/// Area of triangles that look the other way than their faces, and of all [m^2].
fn flipped_area(solid: &Solid) -> (f64, f64) {
    let (mesh, of_face) = solid.triangles();
    let (mut flipped, mut all) = (0.0, 0.0);
    for (triangle, &face) in of_face.iter().enumerate() {
        let area = mesh.vector_area(triangle).dot(solid.faces[face as usize].plane.normal);
        flipped += (-area).max(0.0);
        all += area.abs();
    }
    (flipped, all)
}

/// True if an edge of a triangle passes through another one.
fn crosses_itself(mesh: &TriMesh) -> bool {
    let count = mesh.triangles.len();
    let passes = |[p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]| {
        let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
        let apart = volume(a, b, c, p) * volume(a, b, c, q) < 0.0;
        let around = [(a, b), (b, c), (c, a)].map(|(a, b)| volume(p, q, a, b));
        apart && (around.iter().all(|&side| side > 0.0) || around.iter().all(|&side| side < 0.0))
    };
    (0..count).any(|first| {
        let corners = mesh.triangles[first];
        let places = mesh.corners(first);
        (0..count).any(|second| {
            let other = mesh.triangles[second];
            let sides = [[other[0], other[1]], [other[1], other[2]], [other[2], other[0]]];
            sides.iter().any(|side| {
                side.iter().all(|end| !corners.contains(end))
                    && passes(side.map(|end| mesh.positions[end as usize]), places)
            })
        })
    })
}

/// The first of all that is wrong with the parts of a random solid in random cells.
fn fault(seed: u64) -> Option<String> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mesh = random_mesh(&mut rng);
    let Some(solid) = Solid::of_mesh(&mesh) else {
        return Some("not closed".into());
    };
    let (cells, is_general) = random_cells(&mut rng, &solid);
    let (low, high) = solid.bounds();
    let size = (high - low).max_element();
    let rounding = f64::EPSILON * low.abs().max(high.abs()).max_element();
    let volume = solid.mass_properties().volume;
    let parts = solid.cut(&cells);
    let sum: f64 = parts.iter().map(|(_, part)| part.mass.volume).sum();
    let allowed = 1e-9 * volume + 10.0 * rounding * mesh.area();
    if (sum - volume).abs() > allowed {
        return Some(format!("volumes: {:e}", sum / volume - 1.0));
    }
    // A plane along a concave edge, cut by another one, leaves faces that touch themselves.
    let is_simple = is_general && !crosses_itself(&mesh);
    for (cell, part) in &parts {
        let SolidPart { solid, mass } = part;
        if !solid.is_closed() {
            return Some("open".into());
        }
        let (mesh, _) = solid.triangles();
        if !mesh.is_watertight() {
            return Some("open triangles".into());
        }
        let of_mesh = mesh.mass_properties().volume;
        if (of_mesh - mass.volume).abs() > 1e-11 * volume + 10.0 * rounding * size * size {
            return Some(format!("triangles' volume: {of_mesh:e} {:e}", mass.volume));
        }
        let highest = cells[*cell]
            .planes
            .iter()
            .flat_map(|plane| solid.vertices.iter().map(|&vertex| plane.distance(vertex)))
            .fold(f64::NEG_INFINITY, f64::max);
        if highest > 1e-11 * size + 10.0 * rounding {
            return Some(format!("beyond its cell: {:e} {size:e}", highest));
        }
        let shells = outer_shells(solid, 1e-11 * volume + rounding * mesh.area());
        if shells > 1 {
            return Some(format!("{shells} shells"));
        }
        let (flipped, all) = flipped_area(solid);
        if is_simple && flipped > 1e-9 * all + 10.0 * (rounding + 1e-12 * size) * size {
            return Some(format!("flipped: {:e} of {all:e}", flipped / all));
        }
    }
    None
}

/// What is wrong with the parts of a random solid joined again, as long as any two can be; else
/// the number of cracks that are left.
fn fault_of_joining(seed: u64) -> Result<usize, String> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mesh = random_mesh(&mut rng);
    let solid = Solid::of_mesh(&mesh).ok_or("not closed")?;
    let (cells, is_general) = random_cells(&mut rng, &solid);
    let (low, high) = solid.bounds();
    let size = (high - low).max_element();
    let rounding = f64::EPSILON * low.abs().max(high.abs()).max_element();
    let close = 1e-9 * size + 10.0 * rounding;
    let volume = solid.mass_properties().volume;
    let mut parts: Vec<Solid> = solid.cut(&cells).into_iter().map(|(_, part)| part.solid).collect();
    let is_simple = is_general && !crosses_itself(&mesh);
    let mut at = 0;
    while at < parts.len() {
        let other = (0..parts.len())
            .filter(|&other| other != at)
            .find_map(|other| Some((other, parts[at].joined(&parts[other], close)?)));
        let Some((other, both)) = other else {
            at += 1;
            continue;
        };
        let sum = parts[at].mass_properties().volume + parts[other].mass_properties().volume;
        let (drawn, _) = both.triangles();
        if !both.is_closed() || !drawn.is_watertight() {
            return Err("open".into());
        }
        let of_mesh = drawn.mass_properties().volume;
        if (of_mesh - sum).abs() > 1e-11 * volume + 10.0 * rounding * size * size {
            return Err(format!("volume of triangles {of_mesh} {sum}"));
        }
        let (flipped, all) = flipped_area(&both);
        if is_simple && flipped > 1e-8 * all + 10.0 * close * size {
            return Err(format!("flipped: {:e} of {all:e}", flipped / all));
        }
        parts[at] = both;
        parts.remove(other);
        at = 0;
    }
    let cracks = parts.iter().flat_map(|part| &part.faces);
    let cracks = cracks.filter(|face| face.origin == FaceOrigin::Crack).count();
    Ok(cracks)
}

/// What is wrong with the convex parts of a random solid.
fn fault_of_convex_parts(seed: u64) -> Option<String> {
    let mesh = random_mesh(&mut Pcg64Mcg::seed_from_u64(seed));
    let solid = Solid::of_mesh(&mesh)?;
    let (low, high) = solid.bounds();
    let rounding = f64::EPSILON * low.abs().max(high.abs()).max_element();
    let volume = solid.mass_properties().volume;
    let parts = solid.convex_parts(4, 0.25, PlaneSearch::Quick);
    let sum: f64 = parts.iter().map(|part| part.mass.volume).sum();
    let hull = |solid: &Solid| Hull::of_points(&solid.vertices).map_or(0.0, |hull| hull.volume());
    let hulls: f64 = parts.iter().map(|part| hull(&part.solid)).sum();
    let allowed = 1e-9 * volume + 10.0 * rounding * mesh.area();
    let is_right = parts.len() <= 4
        && (sum - volume).abs() < allowed
        && hulls < 1.001 * hull(&solid) + allowed
        && parts.iter().all(|part| part.solid.is_closed());
    (!is_right).then(|| format!("{} parts, {sum} of {volume}, hulls {hulls}", parts.len()))
}

/// Seeds that found faults, and some more.
const SEEDS: [std::ops::Range<u64>; 5] = [0..60, 457..458, 714..715, 2756..2757, 3319..3320];

#[test]
fn parts_in_random_cells_are_solids() {
    for seed in SEEDS.into_iter().flatten() {
        assert_eq!((seed, fault(seed)), (seed, None));
    }
}

#[test]
fn what_was_cut_is_joined_again() {
    let cracks = SEEDS.into_iter().flatten().map(|seed| fault_of_joining(seed).unwrap());
    let whole = cracks.filter(|&cracks| cracks == 0).count();
    // Vertices far from the origin may be more than `close` apart.
    assert!(whole >= WHOLE_AGAIN, "{whole}");
}

/// Of the seeds.
const WHOLE_AGAIN: usize = 40;

#[test]
fn convex_parts_fill_random_solids() {
    for seed in SEEDS.into_iter().flatten() {
        assert_eq!((seed, fault_of_convex_parts(seed)), (seed, None));
    }
}

/// By hand: `cargo test --release -p frangible-geometry -- --ignored thousands`.
fn in_thousands(fault: impl Fn(u64) -> Option<String>) {
    let faults: Vec<(u64, String)> =
        (0..5000).filter_map(|seed| Some((seed, fault(seed)?))).collect();
    assert!(faults.is_empty(), "{} faults: {faults:#?}", faults.len());
}

#[test]
#[ignore = "takes minutes"]
fn thousands_of_random_solids_are_cut() {
    in_thousands(fault);
}

#[test]
#[ignore = "takes minutes"]
fn thousands_of_random_solids_are_made_convex() {
    in_thousands(fault_of_convex_parts);
}

#[test]
#[ignore = "takes minutes"]
fn thousands_of_random_solids_are_joined() {
    in_thousands(|seed| fault_of_joining(seed).err());
}
