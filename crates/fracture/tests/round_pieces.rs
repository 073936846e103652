//! Pieces of balls and cylinders are drawn as parts of them, not of the polyhedra that collide.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use frangible_fracture::{Impact, Natural, Pattern, Radial, ShatterSettings, Voronoi, shatter};
use frangible_geometry::{ClosedForm, Shape, Surface};
use glam::DVec3;
use std::collections::BTreeMap;

/// The largest angle between two outer triangles that share an edge [degrees]; panics unless each
/// edge has two triangles.
fn bend(surface: &Surface) -> f64 {
    let normal = |triangle: usize| {
        let [a, b, c] = surface.mesh.corners(triangle);
        (b - a).cross(c - a)
    };
    let mut of_edge: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (number, &[a, b, c]) in surface.mesh.triangles.iter().enumerate() {
        for edge in [(a, b), (b, c), (c, a)] {
            assert!(of_edge.insert(edge, number).is_none());
        }
    }
    let mut largest = 0.0f64;
    for (&(a, b), &left) in &of_edge {
        let right = of_edge[&(b, a)];
        // Slivers at the rims have normals of their own.
        let (low, high) = surface.mesh.bounds();
        let large =
            |triangle: usize| normal(triangle).length() > 1e-3 * (high - low).length_squared();
        if !surface.interior[left] && !surface.interior[right] && large(left) && large(right) {
            largest = largest.max(normal(left).angle_between(normal(right)).to_degrees());
        }
    }
    largest
}

fn volume(surface: &Surface) -> f64 {
    surface.mesh.mass_properties().volume
}

#[test]
fn outer_faces_lie_on_the_round_body() {
    let patterns = [
        Pattern::voronoi(&Voronoi { cells: 40, ..Voronoi::default() }).unwrap(),
        Pattern::natural(&Natural { cells: 60, ..Natural::default() }).unwrap(),
        Pattern::radial(&Radial { rings: 2, ..Radial::default() }).unwrap(),
    ];
    for form in [
        ClosedForm::Sphere { radius: 0.3 },
        ClosedForm::Sphere { radius: 25.0 },
        ClosedForm::Cylinder { radius: 0.2, half_height: 0.3 },
    ] {
        let body = Shape::breakable(form, 0.05).unwrap();
        let size = form.bounds().1.x;
        for pattern in &patterns {
            for point in [DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.6, 0.5, -0.4)] {
                let impact =
                    Impact { point_body: point.normalize() * size, normal_body: point.normalize() };
                let mut sum = 0.0;
                for fragment in shatter(&body, pattern, &impact, &ShatterSettings::default()) {
                    // Broken once more, it is still part of the same ball.
                    let again =
                        shatter(&fragment.shape, pattern, &impact, &ShatterSettings::default());
                    let mut parts = 0.0;
                    for (shape, to_parent) in again
                        .iter()
                        .map(|part| {
                            (
                                &part.shape,
                                fragment.parent_from_fragment.after(&part.parent_from_fragment),
                            )
                        })
                        .chain([(&fragment.shape, fragment.parent_from_fragment)])
                    {
                        let surface = shape.surface();
                        // Parts of the polyhedron beyond the ball are not drawn.
                        if shape.volume < 2e-3 * body.volume {
                            continue;
                        }
                        let bend = bend(&surface);
                        assert!(
                            // The polyhedra that collide bend by up to 36 degrees.
                            bend < 28.0 || matches!(form, ClosedForm::Cylinder { .. }),
                            "{bend} of {} at {}",
                            shape.volume / body.volume,
                            pattern.len()
                        );
                        for (triangle, &inner) in surface.interior.iter().enumerate() {
                            for corner in surface.mesh.corners(triangle) {
                                let off = form.distance(to_parent.point(corner));
                                // At a cylinder's caps cracks lead a little beyond them.
                                let is_ball = matches!(form, ClosedForm::Sphere { .. });
                                let beyond = if is_ball { 1e-9 } else { 1e-3 };
                                assert!(
                                    off < beyond * size && (inner || off > -1e-9 * size),
                                    "{form:?}: {off}"
                                );
                            }
                        }
                        parts += volume(&surface);
                    }
                    let own = volume(&fragment.shape.surface());
                    let counted = |shape: &Shape| shape.volume >= 2e-3 * body.volume;
                    if !again.is_empty()
                        && again.iter().all(|part| counted(&part.shape))
                        && counted(&fragment.shape)
                    {
                        assert!((parts / own - 2.0).abs() < 0.05, "{}", parts / own);
                    }
                    sum += own;
                }
                let whole = form.mass_properties().unwrap().volume;
                assert!((sum / whole - 1.0).abs() < 0.012, "{form:?}: {}", sum / whole);
            }
        }
    }
}
