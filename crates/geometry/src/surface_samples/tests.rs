use super::*;

/// Largest distance from points of the surface, found by projecting a fine lattice, to the
/// nearest sample.
fn largest_gap(form: &ClosedForm, samples: &[Vec3]) -> f64 {
    let (low, high) = form.bounds();
    let n = 20;
    let mut largest = 0.0f64;
    for index in 0..n * n * n {
        let fraction =
            DVec3::new(f64::from(index % n), f64::from(index / n % n), f64::from(index / n / n))
                + 0.5;
        let point = low + (high - low) * fraction / f64::from(n);
        let (distance, gradient) = form.distance_and_gradient(point);
        let foot = (point - distance * gradient).as_vec3();
        let nearest = samples.iter().map(|s| s.distance(foot)).fold(f32::INFINITY, f32::min);
        largest = largest.max(f64::from(nearest));
    }
    largest
}

#[test]
fn formulas_are_covered_on_the_surface() {
    let forms = [
        ClosedForm::Sphere { radius: 0.5 },
        ClosedForm::Box { half: DVec3::new(0.5, 0.2, 0.33) },
        ClosedForm::Cylinder { radius: 0.3, half_height: 0.4 },
        ClosedForm::Capsule { radius: 0.2, half_height: 0.3 },
        ClosedForm::Cone { radius: 0.3, height: 0.8 },
    ];
    for form in &forms {
        for spacing in [0.1, 0.23, 5.0] {
            let samples = closed_form_samples(form, spacing);
            for sample in &samples {
                assert!(form.distance_and_gradient(sample.as_dvec3()).0.abs() < 1e-7);
            }
            if spacing < 1.0 {
                // Half of the diagonal of a square of that edge, and a little for the
                // curvature.
                let gap = largest_gap(form, &samples);
                assert!(gap < 0.85 * spacing, "{form:?} {spacing}: {gap}");
                for (n, sample) in samples.iter().enumerate() {
                    let nearest = samples[..n]
                        .iter()
                        .map(|s| s.distance(*sample))
                        .fold(f32::INFINITY, f32::min);
                    assert!(f64::from(nearest) > 0.3 * spacing, "{form:?} {spacing}: {nearest}");
                }
            } else {
                assert!(
                    (8..=14).contains(&samples.len()) || samples.len() == 26,
                    "{}",
                    samples.len()
                );
            }
        }
    }
}

#[test]
fn a_box_has_its_corners_and_points_along_its_edges() {
    let half = DVec3::new(0.5, 0.2, 0.33);
    let samples = closed_form_samples(&ClosedForm::Box { half }, 0.1);
    let faces_touched = |s: &Vec3| {
        (s.as_dvec3().abs() - half).abs().to_array().iter().filter(|d| **d < 1e-7).count()
    };
    assert_eq!(samples.iter().filter(|s| faces_touched(s) == 3).count(), 8);
    assert_eq!(samples.iter().filter(|s| faces_touched(s) == 2).count(), 4 * (9 + 3 + 6));
    assert!(samples.iter().all(|s| faces_touched(s) > 0));
}

#[test]
fn a_box_on_a_grid_has_its_corners_and_edges() {
    let half = DVec3::new(0.5, 0.2, 0.35);
    let solid = GridSolid::from_closed_form(ClosedForm::Box { half }, [25, 10, 18], 2).unwrap();
    let spacing = 0.1;
    let samples = surface_samples(&solid, spacing);
    let on_faces = |s: &Vec3| {
        (s.as_dvec3().abs() - half).abs().to_array().iter().filter(|d| **d < 1e-6).count()
    };
    assert_eq!(samples.iter().filter(|s| on_faces(s) == 3).count(), 8);
    assert!(samples.iter().all(|s| on_faces(s) > 0));
    // Along each edge no gap is wider than what fits no further point, plus a voxel.
    for axis in 0..3 {
        for (u, v) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let mut along: Vec<f64> = samples
                .iter()
                .filter(|s| on_faces(s) >= 2)
                .map(|s| s.as_dvec3())
                .filter(|s| s[(axis + 1) % 3] * u > 0.0 && s[(axis + 2) % 3] * v > 0.0)
                .filter(|s| (s[(axis + 1) % 3].abs() - half[(axis + 1) % 3]).abs() < 1e-6)
                .filter(|s| (s[(axis + 2) % 3].abs() - half[(axis + 2) % 3]).abs() < 1e-6)
                .map(|s| s[axis])
                .collect();
            along.sort_by(f64::total_cmp);
            let widest = along.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
            assert!(widest < 1.4 * spacing + 1.1 * solid.grid().spacing, "{axis}: {widest}");
        }
    }
    assert!(largest_gap(&ClosedForm::Box { half }, &samples) < 1.2 * spacing);
}

/// A ball known only from its samples, and cut: on the surface, apart, everywhere, and always
/// the same.
#[test]
fn sampled_solids_are_covered_on_their_surface() {
    let ball = ClosedForm::Sphere { radius: 0.8 };
    let grid = Grid::around_box(DVec3::NEG_ONE, DVec3::ONE, [30; 3], 2);
    let level_set = LevelSet::sample(grid, |p| ball.distance_and_gradient(p).0);
    let solid = GridSolid::from_level_set(level_set);
    let spacing = 0.15;
    let samples = surface_samples(&solid, spacing);
    assert_eq!(samples, surface_samples(&solid, spacing));
    for (n, sample) in samples.iter().enumerate() {
        assert!(f64::from(solid.value(sample.as_dvec3()).abs()) < 1e-3 * grid.spacing);
        let nearest =
            samples[..n].iter().map(|s| s.distance(*sample)).fold(f32::INFINITY, f32::min);
        assert!(f64::from(nearest) > 0.5 * spacing);
    }
    assert!(largest_gap(&ball, &samples) < 1.2 * spacing);
    // A lattice of this spacing has 4 pi r^2 / spacing^2 points.
    let expected = 4.0 * PI * 0.64 / (spacing * spacing);
    assert!(
        (0.7..1.5).contains(&(samples.len() as f64 / expected)),
        "{} {expected}",
        samples.len()
    );
}

#[test]
fn both_sides_of_a_thin_plate_are_sampled() {
    let half = DVec3::new(0.5, 0.02, 0.5);
    let solid = GridSolid::from_closed_form(ClosedForm::Box { half }, [50, 2, 50], 2).unwrap();
    let samples = surface_samples(&solid, 0.2);
    let above = samples.iter().filter(|s| s.y > 0.019).count();
    let below = samples.iter().filter(|s| s.y < -0.019).count();
    assert!(
        above > 25 && below > 25 && above + below == samples.len(),
        "{above} {below} {}",
        samples.len()
    );
}
