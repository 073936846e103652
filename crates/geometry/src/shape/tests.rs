use super::*;
use crate::grid::Grid;
use crate::half_space::HalfSpace;
use crate::level_set::LevelSet;
use glam::DQuat;

#[test]
fn a_solid_that_lies_askew_finds_its_principal_frame() {
    let half = DVec3::new(0.5, 0.2, 0.3);
    let form = ClosedForm::Box { half };
    let grid_from_form = RigidTransform::new(
        DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.6),
        DVec3::new(3.0, -1.0, 2.0),
    );
    let form_from_grid = grid_from_form.inverse();
    let reach = DVec3::splat(half.length());
    let center = grid_from_form.translation;
    let grid = Grid::around_box(center - reach, center + reach, [48; 3], 2);
    let level_set =
        LevelSet::sample(grid, |p| form.distance_and_gradient(form_from_grid.point(p)).0);
    let corner_grid = grid_from_form.point(half);
    let shape =
        Shape::from_grid_solid(GridSolid::from_level_set(level_set), vec![corner_grid.as_vec3()])
            .unwrap();

    // Moments match the formula's in any order, and the vertex matches up to signs.
    let exact = Shape::closed_form(form, 0.1);
    let sorted = |v: DVec3| {
        let mut sorted = v.abs().to_array();
        sorted.sort_by(f64::total_cmp);
        DVec3::from_array(sorted)
    };
    assert!((shape.volume / exact.volume - 1.0).abs() < 1e-3);
    assert!((sorted(shape.unit_moments) / sorted(exact.unit_moments) - 1.0).length() < 2e-2);
    assert!((sorted(shape.samples()[0].as_dvec3()) - sorted(half)).length() < 2e-3);

    // Distances are those of the formula, seen from the body.
    for point in [DVec3::new(0.3, 0.5, -0.2), DVec3::new(0.0, 0.1, 0.4), DVec3::new(-0.5, 0.0, 0.1)]
    {
        let point_form = form_from_grid.point(shape.body_from_grid.inverse().point(point));
        let (distance, gradient) = shape.distance_and_gradient(point);
        assert!((distance - form.distance_and_gradient(point_form).0).abs() < 0.5 * grid.spacing);
        assert!((gradient.length() - 1.0).abs() < 1e-6);
        let ahead = shape.distance_and_gradient(point + 0.01 * gradient).0;
        assert!((ahead - distance - 0.01).abs() < 2e-3);
    }

    // Bounds hold every corner, with less than two voxels to spare.
    let body_from_form = shape.body_from_grid.after(&grid_from_form);
    let reach = sorted(body_from_form.matrix().x_axis);
    assert!(reach.z > 0.999);
    let (low, high) = (sorted(shape.bounds.0), sorted(shape.bounds.1));
    assert!(
        (low - sorted(half)).min_element() > -1e-3
            && (low - sorted(half)).max_element() < 2.0 * grid.spacing
    );
    assert!(
        (high - sorted(half)).min_element() > -1e-3
            && (high - sorted(half)).max_element() < 2.0 * grid.spacing
    );
}

#[test]
fn a_wall_on_its_own_grid_is_exact() {
    let form = ClosedForm::Box { half: DVec3::new(3.0, 0.2, 2.0) };
    let solid = GridSolid::from_closed_form(form, [150, 10, 100], 2).unwrap();
    let (shape, exact) =
        (Shape::from_grid_solid(solid, Vec::new()).unwrap(), Shape::closed_form(form, 0.1));
    assert!((shape.volume / exact.volume - 1.0).abs() < 1e-11);
    assert!((shape.unit_moments / exact.unit_moments - 1.0).length() < 1e-9);
    assert!((shape.body_from_grid.rotation.w - 1.0).abs() < 1e-12);
    assert!((shape.bounds.1 - exact.bounds.1).length() < 1e-9);
}

#[test]
fn what_has_no_mass_says_so() {
    let ground = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.0 });
    assert_eq!(GridSolid::from_closed_form(ground, [4; 3], 2).unwrap_err(), NoMass);
    let shape = Shape::closed_form(ground, 0.1);
    assert_eq!((shape.volume, shape.samples().len()), (0.0, 0));
    assert_eq!(shape.distance_and_gradient(DVec3::new(4.0, 1.5, 2.0)), (1.5, DVec3::Y));

    let grid = Grid { origin: DVec3::ZERO, spacing: 0.1, dims: [4; 3] };
    let empty = GridSolid::from_level_set(LevelSet::new(grid, vec![1.0; grid.len()]));
    assert_eq!(Shape::from_grid_solid(empty, Vec::new()).unwrap_err(), NoMass);
}
