//! Drawn cells break bodies on grids, convex or not.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use frangible_fracture::{Fragment, Impact, Pattern, ShatterSettings, Voronoi, shatter};
use frangible_geometry::{ClosedForm, Shape, TriMesh};
use glam::{DVec2, DVec3};

const HALF: DVec3 = DVec3::new(0.5, 0.5, 0.3);

/// A block on a grid, struck in the middle of its upper side along z.
fn block() -> (Shape, Impact) {
    let body = common::sampled_form(ClosedForm::Box { half: HALF }, [20, 20, 12]);
    (body, Impact { point_body: DVec3::new(0.0, 0.0, HALF.z), normal_body: DVec3::Z })
}

/// A prism over a polygon that its corner `middle` sees all of, from z = -1 to 1.
fn prism(polygon: &[DVec2], middle: usize) -> TriMesh {
    let count = polygon.len();
    let mut mesh = TriMesh {
        positions: [-1.0, 1.0]
            .iter()
            .flat_map(|&z| polygon.iter().map(move |p| p.extend(z)))
            .collect(),
        triangles: Vec::new(),
    };
    let [lower, upper] = [0, count].map(|layer| move |at: usize| (layer + at % count) as u32);
    for at in 0..count {
        let next = at + 1;
        mesh.triangles.push([lower(at), lower(next), upper(next)]);
        mesh.triangles.push([lower(at), upper(next), upper(at)]);
        if at != middle && next % count != middle {
            mesh.triangles.push([lower(middle), lower(next), lower(at)]);
            mesh.triangles.push([upper(middle), upper(at), upper(next)]);
        }
    }
    mesh
}

/// Three quarters of a cube, and the quarter of it that they leave.
fn corner_and_quarter() -> Pattern {
    let corner = [(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)];
    let quarter = [(0, 0), (1, 0), (1, 1), (0, 1)];
    let points = |corners: &[(i32, i32)]| -> Vec<DVec2> {
        corners.iter().map(|&(x, y)| DVec2::new(f64::from(x), f64::from(y))).collect()
    };
    Pattern::drawn(&[prism(&points(&corner), 3), prism(&points(&quarter), 0)], "corner.obj")
        .unwrap()
}

/// Mass, momentum and energy are the parent's, each voxel has one owner, and no sample lies half a
/// cell deep in another piece.
fn assert_whole(body: &Shape, fragments: &[Fragment]) {
    assert!(common::defect(body, fragments, &mut common::random(61)) < 1e-10);
    common::assert_voxels_shared_out(body, fragments);
    let most = 0.5 * common::solid(body).grid().spacing;
    for (at, fragment) in fragments.iter().enumerate() {
        assert!(fragment.shape.samples().len() >= 4);
        for sample in fragment.shape.samples() {
            let point = fragment.parent_from_fragment.point(sample.as_dvec3());
            for (_, other) in fragments.iter().enumerate().filter(|&(other, _)| other != at) {
                let own = other.parent_from_fragment.inverse().point(point);
                let depth = -other.shape.distance_and_gradient(own).0;
                assert!(depth <= most, "a sample of piece {at} lies {depth} m deep in another");
            }
        }
    }
}

/// The pieces are the cells: one of them wraps around the other.
#[test]
fn a_drawn_corner_breaks_out() {
    let (body, impact) = block();
    let fragments = shatter(&body, &corner_and_quarter(), &impact, &ShatterSettings::default());
    assert_whole(&body, &fragments);
    assert_eq!(fragments.iter().map(|fragment| fragment.cell).collect::<Vec<_>>(), [0, 1]);

    // To the last layer of cells.
    let layer = 0.05 * (HALF.x + HALF.y) * 2.0 * HALF.z;
    for (fragment, part) in fragments.iter().zip([0.75, 0.25]) {
        assert!(
            (fragment.shape.volume - part * body.volume).abs() < layer,
            "{}",
            fragment.shape.volume
        );
    }
    let quarter = fragments[1].parent_from_fragment.translation;
    assert!((quarter - DVec3::new(0.25, 0.25, 0.0)).length() < 0.05, "{quarter}");

    // The hollow of the corner and its filling, in the parent's frame.
    for (point, owner) in [(DVec3::new(0.2, 0.2, 0.0), 1), (DVec3::new(0.2, -0.2, 0.0), 0)] {
        for (at, fragment) in fragments.iter().enumerate() {
            let own = fragment.parent_from_fragment.inverse().point(point);
            assert_eq!(fragment.shape.distance_and_gradient(own).0 < 0.0, at == owner, "{point}");
        }
    }
}

/// Drawn convex cells break a body into the same pieces as their planes.
#[test]
fn drawn_cells_break_as_the_planes_they_were_drawn_from() {
    let half_extent = DVec3::new(1.0, 0.8, 0.6);
    for seed in 0..4 {
        let planar =
            Pattern::voronoi(&Voronoi { cells: 7, seed, half_extent, ..Voronoi::default() })
                .unwrap();
        let meshes: Vec<TriMesh> =
            (0..planar.len()).map(|cell| planar.region_mesh(cell, f64::INFINITY)).collect();
        let drawn = Pattern::drawn(&meshes, "cells.obj").unwrap();
        let (block, impact) = block();
        let bitten = common::bitten_box();
        let rim = Impact { point_body: bitten.samples()[0].as_dvec3(), normal_body: DVec3::Y };
        for (body, impact) in [(block, impact), (bitten, rim)] {
            let [exact, found] = [&planar, &drawn].map(|pattern| {
                let fragments = shatter(&body, pattern, &impact, &ShatterSettings::default());
                assert_whole(&body, &fragments);
                fragments
            });
            // Volumes of what each cell holds, to a tenth of a layer of cells around it.
            let h = common::solid(&body).grid().spacing;
            let held = |fragments: &[Fragment], cell: usize| -> f64 {
                let own = fragments.iter().filter(|fragment| fragment.cell as usize == cell);
                own.map(|fragment| fragment.shape.volume).sum()
            };
            assert!(found.len() >= 2);
            for cell in 0..planar.len() {
                let [a, b] = [held(&exact, cell), held(&found, cell)];
                assert!(
                    (a - b).abs() <= 0.1 * h * 6.0 * a.max(b).powf(2.0 / 3.0) + 30.0 * h.powi(3),
                    "{a} {b}"
                );
            }
        }
    }
}
