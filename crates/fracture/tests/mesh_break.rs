//! Cells as cutters, and contacts of the cut pieces.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use frangible_fracture::{
    Concrete, CrossSection, CutPiece, Cutter, Fragment, Impact, Interface, Pattern, Placement,
    Voronoi, break_on_grid, cutters, interfaces, mesh_interfaces, resurfaced,
};
use frangible_geometry::{Hull, Shape, TriMesh};
use glam::DVec3;
use std::sync::Arc;

const HALF: DVec3 = DVec3::new(0.5, 0.3, 0.4);
const IMPACT: Impact = Impact { point_body: DVec3::new(0.1, 0.3, -0.05), normal_body: DVec3::Y };

fn voronoi() -> Pattern {
    Pattern::voronoi(&Voronoi { cells: 18, seed: 5, ..Voronoi::default() }).unwrap()
}

fn patterns() -> [Pattern; 2] {
    [voronoi(), Pattern::concrete(&Concrete { cells: 8, seed: 2, ..Concrete::default() }).unwrap()]
}

fn as_piece(cutter: Cutter) -> CutPiece {
    CutPiece { inner: vec![true; cutter.mesh.triangles.len()], mesh: cutter.mesh }
}

/// A box whose surface is cut into small triangles.
fn fine_box() -> TriMesh {
    resurfaced(&Hull::cuboid(HALF).surface(), 20).unwrap()
}

#[test]
fn cutters_are_closed_and_enclose_the_box() {
    // All cells of a pattern in the middle of the box are in it.
    let impact = Impact { point_body: DVec3::ZERO, ..IMPACT };
    let coarseness = [1.0, 1.0, 4.0];
    let [plane, rough] = patterns();
    for (pattern, coarseness) in [plane, rough.clone(), rough].into_iter().zip(coarseness) {
        let cells = cutters(&pattern, &impact, (-HALF, HALF), coarseness);
        assert_eq!(cells.len(), pattern.len());
        let volume: f64 = cells.iter().map(|cell| cell.mesh.mass_properties().volume).sum();
        let corners = (0..8).map(|n| {
            let sign = |bit: i32| if n >> bit & 1 == 1 { 1.0 } else { -1.0 };
            HALF * DVec3::new(sign(0), sign(1), sign(2))
        });
        let low = cells.iter().map(|cell| cell.mesh.bounds().0).fold(DVec3::INFINITY, DVec3::min);
        let high =
            cells.iter().map(|cell| cell.mesh.bounds().1).fold(DVec3::NEG_INFINITY, DVec3::max);
        for corner in corners {
            assert!((corner - low).min_element() > 1e-7 && (high - corner).min_element() > 1e-7);
        }
        assert!(
            (volume / (high - low).element_product() - 1.0).abs() < 1e-9,
            "they tile their box"
        );

        for cell in &cells {
            assert!(cell.mesh.is_watertight());
            let faces = cell.face.iter().max().unwrap() + 1;
            if pattern.planar().is_some() {
                let hull = Hull::of_points(&cell.mesh.positions).unwrap();
                assert_eq!(faces as usize, hull.faces().count());
            } else {
                assert!(faces as usize <= pattern.len());
            }
        }
    }
}

#[test]
fn cells_beside_the_box_are_left_out() {
    for pattern in patterns() {
        // A blow from above: half of the pattern lies over the box.
        let impact = Impact { point_body: DVec3::new(0.0, HALF.y, 0.0), ..IMPACT };
        let cells = cutters(&pattern, &impact, (-HALF, HALF), 1.0);
        let left_out = cells.iter().filter(|cell| cell.mesh.triangles.is_empty()).count();
        assert!(left_out > 0 && left_out < cells.len(), "{left_out} of {}", cells.len());
        let shown = cells.iter().filter(|cell| !cell.mesh.triangles.is_empty());
        for (low, high) in shown.map(|cell| cell.mesh.bounds()) {
            assert!(low.cmple(HALF).all() && high.cmpge(-HALF).all());
        }
    }
}

#[test]
fn contacts_of_cells_are_those_of_convex_pieces() {
    let pattern = voronoi();
    let impact = Impact { point_body: DVec3::ZERO, ..IMPACT };
    let cells = cutters(&pattern, &impact, (-HALF, HALF), 1.0);
    let convex: Vec<Fragment> = cells
        .iter()
        .map(|cell| {
            let shape = Shape::convex(Hull::of_points(&cell.mesh.positions).unwrap(), 0.1).unwrap();
            Fragment { parent_from_fragment: shape.body_from_grid.inverse(), shape, cell: 0 }
        })
        .collect();
    let of_cells = mesh_interfaces(&cells.into_iter().map(as_piece).collect::<Vec<_>>());
    let of_hulls = interfaces(&convex);
    assert!(of_cells.len() > 30);
    assert_eq!(of_cells.len(), of_hulls.len());
    for (a, b) in of_cells.iter().zip(&of_hulls) {
        assert_eq!((a.a, a.b), (b.a, b.b));
        assert!((a.area - b.area).abs() < 1e-9, "{a:?} {b:?}");
        // A tiny contact has no exact middle.
        assert!(a.area < 1e-6 || (a.centroid - b.centroid).length() < 1e-6);
        assert!(a.area < 1e-6 || (a.normal - b.normal).length() < 1e-6);
    }
}

/// A cell whose piece falls in two, left and right: each has its own neighbour beyond the same
/// crack.
#[test]
fn a_crack_through_two_prongs_has_a_contact_in_each() {
    let half = DVec3::new(0.1, 0.2, 0.1);
    let block = |center: DVec3| {
        let mut mesh = Hull::cuboid(half).surface();
        mesh.positions.iter_mut().for_each(|position| *position += center);
        CutPiece { inner: vec![true; mesh.triangles.len()], mesh }
    };
    // Below the crack in the plane y = 0, then above it.
    let pieces = [
        block(DVec3::new(-0.5, -0.2, 0.0)),
        block(DVec3::new(0.5, -0.2, 0.0)),
        block(DVec3::new(0.5, 0.2, 0.0)),
        block(DVec3::new(-0.5, 0.2, 0.0)),
    ];
    let contacts = mesh_interfaces(&pieces);
    let expected = [(0, 3, -0.5), (1, 2, 0.5)].map(|(a, b, x)| Interface {
        a,
        b,
        area: 0.04,
        centroid: DVec3::X * x,
        normal: DVec3::Y,
        section: Arc::new(CrossSection::square(0.04, DVec3::Y)),
    });
    assert_eq!(contacts.len(), 2);
    for (found, wanted) in contacts.iter().zip(&expected) {
        assert_eq!((found.a, found.b), (wanted.a, wanted.b));
        assert!((found.area - wanted.area).abs() < 1e-12);
        assert!((found.centroid - wanted.centroid).length() < 1e-12);
        assert!((found.normal - wanted.normal).length() < 1e-12);
    }
}

#[test]
fn pieces_on_a_grid_lie_where_the_cells_are() {
    let mesh = fine_box();
    for pattern in [voronoi()] {
        let (volume, pieces) = break_on_grid(&mesh, &pattern, &IMPACT, 40).unwrap();
        assert!((volume / (8.0 * HALF.element_product()) - 1.0).abs() < 0.01);
        let sum: f64 = pieces.iter().map(|piece| piece.shape.volume).sum();
        assert!((sum / volume - 1.0).abs() < 1e-9, "{}", sum / volume - 1.0);

        // The middle of each piece that is convex lies in its cell, in the frame of the mesh.
        let corners = std::array::from_fn(|n| {
            let sign = |bit: usize| if n >> bit & 1 == 1 { 1.0 } else { -1.0 };
            HALF * DVec3::new(sign(0), sign(1), sign(2))
        });
        let placement = Placement::around(&pattern, &IMPACT, &corners);
        for piece in pieces.iter().filter(|piece| piece.shape.volume > 0.01 * volume) {
            let center = piece.parent_from_fragment.translation;
            let from_point =
                placement.grid_from_pattern.transpose() * (center - placement.point_grid);
            let center_pattern = placement.center_pattern + from_point / placement.scale;
            assert_eq!(pattern.region_at(center_pattern), Some(piece.cell as usize));
        }
    }
}
