//! Points on surfaces: what is tested against other bodies' level sets.

use crate::ClosedForm;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Points on the surface of a formula in its frame [m], about `spacing` [m] apart, with the corners, edges and rims.
/// None for a half-space: what lies on it has the samples.
pub fn closed_form_samples(form: &ClosedForm, spacing: f64) -> Vec<Vec3> {
    match *form {
        ClosedForm::HalfSpace(_) => Vec::new(),
        ClosedForm::Sphere { radius } => sphere_samples(radius, spacing),
        ClosedForm::Box { half } => box_samples(half, spacing),
        ClosedForm::Cylinder { radius, half_height } => cylinder_samples(radius, half_height, spacing),
    }
}

/// Number of steps of at most `spacing` along `length`, at least `least`.
fn steps(length: f64, spacing: f64, least: usize) -> usize {
    // A length that is a multiple of the spacing up to rounding is divided as such.
    ((length / spacing - 1e-9).ceil() as usize).max(least)
}

/// A spiral of equal areas: each point is as far from its neighbours on the same turn as from the next turn.
fn sphere_samples(radius: f64, spacing: f64) -> Vec<Vec3> {
    let golden_angle = PI * (3.0 - 5.0f64.sqrt());
    let count = steps(4.0 * PI * radius * radius, spacing * spacing, 12);
    let point = |n: usize| {
        let y = 1.0 - (2 * n + 1) as f64 / count as f64;
        let ring = (1.0 - y * y).sqrt();
        let angle = golden_angle * n as f64;
        (radius * DVec3::new(ring * libm::cos(angle), y, ring * libm::sin(angle))).as_vec3()
    };
    (0..count).map(point).collect()
}

/// The outer nodes of a lattice with a node on each corner.
fn box_samples(half: DVec3, spacing: f64) -> Vec<Vec3> {
    let counts = half.to_array().map(|half| steps(2.0 * half, spacing, 1));
    let at = |axis: usize, n: usize| half[axis] * (2.0 * n as f64 / counts[axis] as f64 - 1.0);
    let mut samples = Vec::new();
    for k in 0..=counts[2] {
        for j in 0..=counts[1] {
            // Rows inside the box have only their two ends on the surface.
            let on_face = k == 0 || k == counts[2] || j == 0 || j == counts[1];
            let stride = if on_face { 1 } else { counts[0] };
            for i in (0..=counts[0]).step_by(stride) {
                samples.push(DVec3::new(at(0, i), at(1, j), at(2, k)).as_vec3());
            }
        }
    }
    samples
}

/// Rings around the side, from rim to rim, and smaller rings on both caps down to their middles.
fn cylinder_samples(radius: f64, half_height: f64, spacing: f64) -> Vec<Vec3> {
    let mut samples = Vec::new();
    let mut ring = |radius: f64, y: f64| {
        let count = steps(TAU * radius, spacing, if radius > 0.0 { 6 } else { 1 });
        for n in 0..count {
            let angle = TAU * n as f64 / count as f64;
            samples.push(DVec3::new(radius * libm::cos(angle), y, radius * libm::sin(angle)).as_vec3());
        }
    };
    let rows = steps(2.0 * half_height, spacing, 1);
    for row in 0..=rows {
        ring(radius, half_height * (2.0 * row as f64 / rows as f64 - 1.0));
    }
    let rings = steps(radius, spacing, 1);
    for inner in 0..rings {
        for y in [-half_height, half_height] {
            ring(radius * inner as f64 / rings as f64, y);
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest distance from points of the surface, found by projecting a fine lattice, to the nearest sample.
    fn largest_gap(form: &ClosedForm, samples: &[Vec3]) -> f64 {
        let (low, high) = form.bounds();
        let n = 20;
        let mut largest = 0.0f64;
        for index in 0..n * n * n {
            let fraction =
                DVec3::new(f64::from(index % n), f64::from(index / n % n), f64::from(index / n / n)) + 0.5;
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
        ];
        for form in &forms {
            for spacing in [0.1, 0.23, 5.0] {
                let samples = closed_form_samples(form, spacing);
                for sample in &samples {
                    assert!(form.distance_and_gradient(sample.as_dvec3()).0.abs() < 1e-7);
                }
                if spacing < 1.0 {
                    // Half of the diagonal of a square of that edge, and a little for the curvature.
                    let gap = largest_gap(form, &samples);
                    assert!(gap < 0.85 * spacing, "{form:?} {spacing}: {gap}");
                    for (n, sample) in samples.iter().enumerate() {
                        let nearest =
                            samples[..n].iter().map(|s| s.distance(*sample)).fold(f32::INFINITY, f32::min);
                        assert!(f64::from(nearest) > 0.3 * spacing, "{form:?} {spacing}: {nearest}");
                    }
                } else {
                    assert!((8..=13).contains(&samples.len()) || samples.len() == 14, "{}", samples.len());
                }
            }
        }
    }

    #[test]
    fn a_box_has_its_corners_and_points_along_its_edges() {
        let half = DVec3::new(0.5, 0.2, 0.33);
        let samples = closed_form_samples(&ClosedForm::Box { half }, 0.1);
        let faces_touched =
            |s: &Vec3| (s.as_dvec3().abs() - half).abs().to_array().iter().filter(|d| **d < 1e-7).count();
        assert_eq!(samples.iter().filter(|s| faces_touched(s) == 3).count(), 8);
        assert_eq!(samples.iter().filter(|s| faces_touched(s) == 2).count(), 4 * (9 + 3 + 6));
        assert!(samples.iter().all(|s| faces_touched(s) > 0));
    }
}
