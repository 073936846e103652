//! A pattern is laid onto the point of impact, along the normal, around all of the body.

mod common;

use frangible_fracture::{Impact, Pattern, Placement, ShatterSettings, align_pattern, shatter};
use frangible_geometry::Shape;
use glam::{DMat3, DVec3};

/// The eight corners of a shape's bounds, body frame.
fn corners(shape: &Shape) -> Vec<DVec3> {
    let (low, high) = shape.bounds;
    let pick = |bit: bool, axis: usize| if bit { high[axis] } else { low[axis] };
    (0..8).map(|n| DVec3::new(pick(n & 1 > 0, 0), pick(n & 2 > 0, 1), pick(n & 4 > 0, 2))).collect()
}

/// Largest distance of grid points in units of the pattern's box: 1 on its wall.
fn reach(
    pattern: &Pattern,
    placement: &Placement,
    points_grid: impl Iterator<Item = DVec3>,
) -> f64 {
    let grid_from_pattern = placement.grid_from_pattern;
    points_grid
        .map(|point| {
            let turned = grid_from_pattern.transpose() * (point - placement.point_grid);
            ((turned / placement.scale + placement.center_pattern) / pattern.half_extent)
                .abs()
                .max_element()
        })
        .fold(0.0, f64::max)
}

#[test]
fn the_pattern_lies_on_the_blow_and_just_encloses_the_body() {
    let mut random = common::random(21);
    for (name, body) in common::bodies() {
        for mut pattern in common::patterns(3) {
            // Fracture centres anywhere in the box.
            pattern.center = 0.8 * pattern.half_extent * common::direction(&mut random);
            let impact = common::random_impact(&body, &mut random);
            let placement = Placement::new(&pattern, &impact, &body);

            let struck_grid = body.body_from_grid.inverse().point(impact.point_body);
            assert!((placement.point(pattern.center) - struck_grid).length() < 1e-14);
            let ahead =
                placement.point(pattern.center + DVec3::Z) - placement.point(pattern.center);
            let normal_body = body.body_from_grid.direction(ahead) / placement.scale;
            assert!((normal_body - impact.normal_body).length() < 1e-12, "{name}");
            let r = placement.grid_from_pattern;
            assert!(
                (r * r.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12) && r.determinant() > 0.0
            );

            let corners = corners(&body);
            let corners_grid =
                corners.iter().map(|&corner| body.body_from_grid.inverse().point(corner));
            let reach = reach(&pattern, &placement, corners_grid);
            assert!((reach - 1.0).abs() < 1e-12, "{name}: {reach}");
        }
    }
}

#[test]
fn planes_move_with_their_points() {
    let body = common::bitten_box();
    let mut random = common::random(22);
    for pattern in common::patterns(4) {
        let impact = common::random_impact(&body, &mut random);
        let placement = Placement::new(&pattern, &impact, &body);
        let aligned = align_pattern(&pattern, &impact, &body);
        for (before, after) in pattern.planar().unwrap().iter().zip(&aligned) {
            for _ in 0..10 {
                let point = common::direction(&mut random);
                let expected = placement.scale * before.distance(point);
                assert!((after.distance(placement.point(point)) - expected).abs() < 1e-12);
            }
            for cut in &after.cuts {
                assert!((cut.half_space.normal.length() - 1.0).abs() < 1e-15);
                assert!(
                    cut.face.iter().all(|&corner| cut.half_space.distance(corner).abs() < 1e-9)
                );
            }
        }
    }
}

/// Struck on its face, a wall is broken along its length and height, whichever face it is.
#[test]
fn the_twist_follows_the_longest_edge() {
    let wall = common::wall();
    let pattern = common::patterns(1).swap_remove(0);
    for (normal, x) in [(DVec3::Y, DVec3::X), (DVec3::NEG_Y, DVec3::X), (DVec3::X, DVec3::Z)] {
        let impact = Impact { point_body: DVec3::new(1.0, 0.2, 0.5), normal_body: normal };
        let placement = Placement::new(&pattern, &impact, &wall);
        assert!((placement.grid_from_pattern.x_axis - x).length() < 1e-9, "{normal}");
    }
}

/// The authors' code maps the pattern's cells one to one onto the body's, and body parts beyond the
/// pattern vanish. At half of our scale this happens; at our scale it cannot.
#[test]
fn a_pattern_that_does_not_enclose_the_body_loses_parts_of_it() {
    let body = common::wall();
    let solid = common::solid(&body);
    let grid = solid.grid();
    let pattern = common::patterns(1).swap_remove(2);
    let impact = Impact { point_body: DVec3::new(1.0, 0.2, 0.5), normal_body: DVec3::Y };
    let placement = Placement::new(&pattern, &impact, &body);
    let lost = |placement: Placement| {
        let beyond = |&node: &usize| {
            let [i, j, k] = grid.coordinates(node);
            reach(&pattern, &placement, std::iter::once(grid.node(i, j, k))) > 1.0
        };
        let coverage = solid.coverage();
        let material = |node: usize| f64::from(coverage[node]) * grid.voxel_volume();
        (0..grid.len()).filter(beyond).map(material).sum::<f64>() / body.volume
    };
    assert!(lost(Placement { scale: 0.5 * placement.scale, ..placement }) > 0.2);
    assert_eq!(lost(placement), 0.0);
    let fragments = shatter(&body, &pattern, &impact, &ShatterSettings::default());
    let kept: f64 = fragments.iter().map(|fragment| fragment.shape.volume).sum();
    assert!((kept / body.volume - 1.0).abs() < 1e-12);
}
