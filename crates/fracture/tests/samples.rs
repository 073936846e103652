//! Samples lie on their own fragment, whatever form the body has that breaks [Su09 sec. 4.2
//! "Surface Particles"].

#![allow(clippy::unwrap_used, clippy::panic, reason = "a panic is how a test fails")]

mod common;

use frangible_fracture::{
    Bricks, Concrete, Fragment, Natural, Pattern, Radial, ShatterSettings, Slices, Splinters,
    Voronoi, shatter,
};
use frangible_geometry::{Geometry, Shape};
use glam::DVec3;
use proptest::prelude::*;

/// Distance to a box around `center`.
fn to_box(point: DVec3, center: DVec3, half: DVec3) -> f64 {
    let beyond = (point - center).abs() - half;
    beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
}

/// Bodies with limbs, in units of a voxel of the U.
fn body(kind: usize) -> Shape {
    let half = DVec3::new(30.0, 20.0, 10.0);
    let sampled = |voxels: [usize; 3], distance: &dyn Fn(DVec3) -> f64| {
        let scale = half / DVec3::from(voxels.map(|n| n as f64));
        common::sampled(-half, half, voxels, |point| {
            distance(point) / (2.0 * scale.max_element()).max(1.0)
        })
    };
    let slot = |x: f64, width: f64, point: DVec3| {
        -to_box(point, DVec3::new(x, 10.0, 0.0), DVec3::new(width, 20.0, 100.0))
    };
    match kind {
        // A U.
        0 => sampled([60, 40, 20], &|point| {
            to_box(point, DVec3::ZERO, half).max(-to_box(
                point,
                DVec3::Y * 10.0,
                DVec3::new(18.0, 18.0, 30.0),
            ))
        }),
        // A ring.
        1 => sampled([60, 40, 20], &|point| {
            let around = DVec3::new(point.x / 1.5, point.y, 0.0).length() - 14.0;
            DVec3::new(around, 0.0, point.z).length() - 5.0
        }),
        // A comb.
        2 => sampled([60, 40, 20], &|point| {
            let teeth = [-20.0, -7.0, 7.0, 20.0].map(|x| slot(x, 4.0, point));
            teeth.into_iter().fold(to_box(point, DVec3::ZERO, half), f64::max)
        }),
        // Two arms across, one behind the other.
        3 => sampled([60, 40, 20], &|point| {
            let arm =
                |y: f64, z: f64| to_box(point, DVec3::new(0.0, y, z), DVec3::new(30.0, 3.0, 3.0));
            let joint = to_box(point, DVec3::X * -25.0, DVec3::new(5.0, 16.0, 9.0));
            arm(12.0, -5.0).min(arm(-12.0, 5.0)).min(joint)
        }),
        // A body with a head and two ears.
        _ => sampled([60, 40, 20], &|point| {
            let ball = |x: f64, y: f64, z: f64, r: f64| point.distance(DVec3::new(x, y, z)) - r;
            let ear = |z: f64| {
                let along = DVec3::new(0.5, 0.8, 0.3 * z.signum()).normalize();
                let from = point - DVec3::new(15.0, 2.0, z);
                let at = from.dot(along).clamp(0.0, 16.0);
                from.distance(along * at) - 1.8
            };
            ball(-12.0, -5.0, 0.0, 10.0).min(ball(10.0, 0.0, 0.0, 7.0)).min(ear(4.0)).min(ear(-4.0))
        }),
    }
}

/// Of each kind.
fn pattern(kind: usize, seed: u64) -> Pattern {
    match kind {
        0 => Pattern::radial(&Radial { spokes: 9, rings: 2, jitter: 0.7, seed }),
        1 => Pattern::voronoi(&Voronoi { cells: 25, seed, ..Voronoi::default() }),
        2 => Pattern::natural(&Natural { cells: 30, seed, ..Natural::default() }),
        3 => Pattern::slices(&Slices {
            cells: 12,
            seed,
            axis: DVec3::new(1.0, 0.3, 0.2),
            ..Slices::default()
        }),
        4 => Pattern::bricks(&Bricks { seed, ..Bricks::default() }),
        5 => Pattern::splinters(&Splinters { seed, ..Splinters::default() }),
        _ => Pattern::concrete(&Concrete { cells: 20, seed, ..Concrete::default() }),
    }
    .unwrap()
}

/// The farthest that a sample lies from a voxel of its fragment, infinite beyond two or three, and
/// from its surface [voxels].
fn farthest(fragments: &[Fragment]) -> [f64; 2] {
    let mut worst = [0.0f64; 2];
    for fragment in fragments {
        let Geometry::Grid(solid) = &fragment.shape.geometry else { panic!("on a grid") };
        let (grid, coverage) = (solid.grid(), solid.coverage());
        for sample in fragment.shape.samples() {
            let in_grid = fragment.shape.body_from_grid.inverse().point(sample.as_dvec3());
            let at = grid.lattice_from_point(in_grid);
            let near = |axis: usize| {
                let middle = libm::round(at[axis]) as i64;
                (middle - 3).max(0)..(middle + 4).min(grid.dims[axis] as i64)
            };
            let mut nearest = f64::INFINITY;
            for (k, j) in near(2).flat_map(|k| near(1).map(move |j| (k, j))) {
                for i in near(0)
                    .filter(|&i| coverage[grid.index(i as usize, j as usize, k as usize)] > 0.0)
                {
                    let apart = (at - DVec3::new(i as f64, j as f64, k as f64)).abs() - 0.5;
                    nearest = nearest.min(apart.max(DVec3::ZERO).length());
                }
            }
            worst[0] = worst[0].max(nearest);
            let distance = fragment.shape.distance_and_gradient(sample.as_dvec3()).0;
            worst[1] = worst[1].max(distance.abs() / grid.spacing);
        }
    }
    worst
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn samples_lie_on_their_own_fragment(at in 0..35_usize, seed in 0..1000_u64) {
        let body = body(at % 5);
        let mut random = common::random(seed);
        let impact = common::random_impact(&body, &mut random);
        let fragments = shatter(&body, &pattern(at / 5, seed), &impact, &ShatterSettings::default());
        let [from_voxels, from_surface] = farthest(&fragments);
        prop_assert!(from_voxels <= 1.5, "a sample lies {from_voxels} voxels off its fragment");
        prop_assert!(from_surface <= 1.5, "a sample lies {from_surface} voxels off its surface");
        let samples: usize = fragments.iter().map(|fragment| fragment.shape.samples().len()).sum();
        prop_assert!(samples >= body.samples().len(), "each of the body's samples is handed on");
    }
}
