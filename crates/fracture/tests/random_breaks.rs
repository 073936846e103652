//! A thousand random breaks: every kind of pattern, convex and concave bodies, exact and on grids,
//! fragments of fragments.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use frangible_fracture::{
    Bricks, Concrete, Fragment, Impact, Natural, Pattern, Radial, ShatterSettings, Slices,
    Splinters, Voronoi, shatter,
};
use frangible_geometry::{ClosedForm, Geometry, Hull, Shape, TriMesh};
use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use std::collections::BTreeMap;

fn bodies() -> Vec<(&'static str, Shape)> {
    let cuboid = |half| Shape::convex(Hull::cuboid(half), 0.05).unwrap();
    let ring = |point: DVec3| {
        let around = DVec3::new(point.x, 0.0, point.z).length() - 0.35;
        (around * around + point.y * point.y).sqrt() - 0.13
    };
    let half = DVec3::new(0.5, 0.2, 0.4);
    let pierced = |point: DVec3| {
        let hole = 0.17 - DVec3::new(point.x, 0.0, point.z).length();
        (ClosedForm::Box { half }).distance(point).max(hole)
    };
    vec![
        ("exact cuboid", cuboid(DVec3::new(0.5, 0.3, 0.4))),
        ("exact ball", Shape::breakable(ClosedForm::Sphere { radius: 0.5 }, 0.06).unwrap()),
        (
            "cuboid",
            common::sampled_form(ClosedForm::Box { half: DVec3::new(0.5, 0.1, 0.4) }, [20, 4, 16]),
        ),
        ("ball", common::sampled_form(ClosedForm::Sphere { radius: 0.5 }, [16; 3])),
        (
            "cylinder",
            common::sampled_form(
                ClosedForm::Cylinder { radius: 0.3, half_height: 0.6 },
                [10, 20, 10],
            ),
        ),
        (
            "torus",
            common::sampled(
                DVec3::new(-0.5, -0.15, -0.5),
                DVec3::new(0.5, 0.15, 0.5),
                [20, 6, 20],
                ring,
            ),
        ),
        ("pierced box", common::sampled(-half, half, [20, 8, 16], pierced)),
        ("bitten box", common::bitten_box()),
    ]
}

fn patterns(seed: u64) -> Vec<Pattern> {
    vec![
        Pattern::radial(&Radial { rings: 0, seed, ..Radial::default() }).unwrap(),
        Pattern::radial(&Radial { rings: 2, spokes: 7, seed, ..Radial::default() }).unwrap(),
        Pattern::voronoi(&Voronoi { seed, ..Voronoi::default() }).unwrap(),
        Pattern::natural(&Natural { seed, ..Natural::default() }).unwrap(),
        Pattern::slices(&Slices { seed, ..Slices::default() }).unwrap(),
        Pattern::bricks(&Bricks { seed, ..Bricks::default() }).unwrap(),
        Pattern::splinters(&Splinters { seed, ..Splinters::default() }).unwrap(),
        Pattern::concrete(&Concrete { seed, ..Concrete::default() }).unwrap(),
    ]
}

/// Allowed overlap of two pieces, and half of the allowed gap [m]; samples in f32 limit even exact
/// pieces.
fn half_cell(parent: &Shape) -> f64 {
    match &parent.geometry {
        Geometry::Grid(solid) => 0.5 * solid.grid().spacing,
        _ => 1e-7,
    }
}

/// Signed distance of a piece at a point of the parent's body frame [m].
fn distance(fragment: &Fragment, point: DVec3) -> f64 {
    fragment.shape.distance_and_gradient(fragment.parent_from_fragment.inverse().point(point)).0
}

/// The deepest that a piece's samples lie in another piece [m], of every `stride`th.
fn overlap(fragments: &[Fragment], stride: usize) -> f64 {
    let mut deepest = 0.0f64;
    for (at, fragment) in fragments.iter().enumerate() {
        for sample in fragment.shape.samples().iter().step_by(stride) {
            let point = fragment.parent_from_fragment.point(sample.as_dvec3());
            for (_, other) in fragments.iter().enumerate().filter(|&(other, _)| other != at) {
                deepest = deepest.max(-distance(other, point));
            }
        }
    }
    deepest
}

/// Over points of the parent: the largest distance from all pieces, and the largest depth in two
/// pieces [m].
fn gap_and_overlap(
    parent: &Shape,
    fragments: &[Fragment],
    points: usize,
    random: &mut Pcg64Mcg,
) -> [f64; 2] {
    let (low, high) = parent.bounds;
    let mut worst = [0.0f64; 2];
    for _ in 0..points {
        let point =
            low + (high - low) * DVec3::new(random.random(), random.random(), random.random());
        let mut values: Vec<f64> =
            fragments.iter().map(|fragment| distance(fragment, point)).collect();
        values.sort_by(f64::total_cmp);
        // A ball breaks as the polyhedron of its volume.
        let of_parent = match &parent.hull {
            Some(hull) => hull.distance_and_gradient(point).0,
            None => parent.distance_and_gradient(point).0,
        };
        if of_parent < -2.0 * half_cell(parent) {
            worst[0] = worst[0].max(values[0]);
        }
        worst[1] = worst[1].max(-values.get(1).copied().unwrap_or(0.0));
    }
    worst
}

/// True if each edge of a surface is passed once in each direction, and the enclosed volume is
/// positive.
fn is_closed_and_oriented(mesh: &TriMesh) -> bool {
    let mut passed: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for [a, b, c] in &mesh.triangles {
        for edge in [(*a, *b), (*b, *c), (*c, *a)] {
            *passed.entry(edge).or_default() += 1;
        }
    }
    let paired =
        |(&(a, b), &count): (&(u32, u32), &u32)| count == 1 && passed.get(&(b, a)) == Some(&1);
    !passed.is_empty() && passed.iter().all(paired) && mesh.mass_properties().volume > 0.0
}

/// Faults of a break.
fn faults(parent: &Shape, fragments: &[Fragment], random: &mut Pcg64Mcg) -> Vec<String> {
    let mut faults = Vec::new();
    let mut demand = |holds: bool, fault: String| {
        if !holds {
            faults.push(fault);
        }
    };
    let defect = common::defect(parent, fragments, random);
    demand(defect < 1e-10, format!("sums are off by {defect}"));
    let volume: f64 = fragments.iter().map(|fragment| fragment.shape.volume).sum();
    demand(
        (volume / parent.volume - 1.0).abs() < 1e-9,
        format!("{volume} of {} m^3", parent.volume),
    );
    if matches!(parent.geometry, Geometry::Grid(_)) {
        common::assert_voxels_shared_out(parent, fragments);
    }
    let most = half_cell(parent);
    let cells = |distance: f64| 0.5 * distance / most;
    let depth = overlap(fragments, 5);
    demand(depth <= most, format!("samples lie {} cells deep in another piece", cells(depth)));
    let [gap, depth] = gap_and_overlap(parent, fragments, 25, random);
    demand(depth <= most, format!("two pieces overlap by {} cells", cells(depth)));
    demand(gap <= 2.0 * most, format!("a gap of {} cells", cells(gap)));
    faults
}

#[test]
fn a_thousand_random_breaks_keep_what_they_must() {
    let mut random = common::random(41);
    let (mut breaks, mut surfaces, mut whole, mut wrong) = (0, 0, 0, Vec::new());
    let bodies = bodies();
    for seed in 0..17 {
        for (kind, pattern) in patterns(seed).iter().enumerate() {
            for (at, (name, body)) in bodies.iter().enumerate() {
                let impact = common::random_impact(body, &mut random);
                let settings = ShatterSettings::default();
                let fragments = shatter(body, pattern, &impact, &settings);
                if pattern.planar().is_none() && !matches!(body.geometry, Geometry::Grid(_)) {
                    assert!(fragments.is_empty(), "{name}: rough cells need a grid");
                    continue;
                }
                let what = format!("{name}, pattern {kind}, seed {seed}");
                // Large cells may hold all of a body that is struck at its rim.
                if fragments.len() < 2 {
                    whole += 1;
                    continue;
                }
                wrong.extend(
                    faults(body, &fragments, &mut random)
                        .iter()
                        .map(|fault| format!("{what}: {fault}")),
                );
                breaks += 1;
                if (at + kind) % 5 == seed as usize % 5 {
                    for fragment in &fragments {
                        if !is_closed_and_oriented(&fragment.shape.surface().mesh) {
                            wrong.push(format!("{what}: an open surface"));
                        }
                        surfaces += 1;
                    }
                }
                if (at + kind) % 4 == seed as usize % 4 {
                    let largest = fragments
                        .iter()
                        .max_by(|a, b| a.shape.volume.total_cmp(&b.shape.volume))
                        .unwrap();
                    let impact = common::random_impact(&largest.shape, &mut random);
                    let again = shatter(&largest.shape, pattern, &impact, &settings);
                    if again.len() > 1 {
                        let found = faults(&largest.shape, &again, &mut random);
                        wrong.extend(found.iter().map(|fault| format!("{what}, again: {fault}")));
                        breaks += 1;
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} faults:\n{}", wrong.len(), wrong.join("\n"));
    assert!(breaks >= 1000 && surfaces >= 1000, "{breaks} breaks, {surfaces} surfaces");
    assert!(whole <= 20, "{whole} bodies did not break");
}

/// The checks detect their faults: a lost piece, a moved piece, a spinning piece, an open surface.
#[test]
fn the_checks_find_what_is_wrong() {
    let mut random = common::random(42);
    let body = bodies().swap_remove(3).1;
    let h = 2.0 * half_cell(&body);
    let impact = Impact { point_body: DVec3::new(0.0, 0.5, 0.0), normal_body: DVec3::Y };
    let pattern = patterns(1).swap_remove(2);
    let fragments = shatter(&body, &pattern, &impact, &ShatterSettings::default());

    let lost = &fragments[1..];
    assert!(common::defect(&body, lost, &mut random) > 1e-3);
    assert!(gap_and_overlap(&body, lost, 2000, &mut random)[0] > h);

    let mut moved = fragments.clone();
    let toward = -moved[0].parent_from_fragment.translation.normalize();
    moved[0].parent_from_fragment.translation += 3.0 * h * toward;
    assert!(common::defect(&body, &moved, &mut random) > 1e-6);
    assert!(overlap(&moved, 1) > 0.5 * h);

    let mut turned = fragments.clone();
    turned[0].parent_from_fragment.rotation =
        glam::DQuat::from_rotation_x(0.3) * turned[0].parent_from_fragment.rotation;
    assert!(common::defect(&body, &turned, &mut random) > 1e-9);

    let mut open = fragments[0].shape.surface().mesh;
    assert!(is_closed_and_oriented(&open));
    open.triangles[0].swap(0, 1);
    assert!(!is_closed_and_oriented(&open));
    open.triangles.swap_remove(0);
    assert!(!is_closed_and_oriented(&open));
}
