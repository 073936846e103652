//! The paper's wall, struck at three places with one pattern [Su09 fig. 4].

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use common::{solid, wall};
use frangible_fracture::{Fragment, Impact, Pattern, Radial, ShatterSettings, shatter};
use frangible_geometry::{ClosedForm, Shape};
use glam::DVec3;

const PLACES: [DVec3; 3] =
    [DVec3::new(0.0, 0.2, 0.0), DVec3::new(1.71, 0.2, 1.13), DVec3::new(-2.33, -0.2, 0.57)];

fn strike(wall: &Shape, pattern: &Pattern, place: DVec3) -> Vec<Fragment> {
    let impact = Impact { point_body: place, normal_body: DVec3::Y * place.y.signum() };
    shatter(wall, pattern, &impact, &ShatterSettings::default())
}

/// Where the fragments meet: of a fine lattice on the struck face the point that is nearest to all
/// of them.
fn meeting_point(fragments: &[Fragment], y: f64) -> DVec3 {
    let farthest = |point: &DVec3| {
        let value = |fragment: &Fragment| solid(&fragment.shape).value(*point).abs();
        fragments.iter().map(value).fold(0.0, f32::max)
    };
    let lattice = (-145..=145).flat_map(|i| (-95..=95).map(move |k| (f64::from(i), f64::from(k))));
    let points = lattice.map(|(i, k)| DVec3::new(0.02 * i, y, 0.02 * k));
    points.min_by(|a, b| farthest(a).total_cmp(&farthest(b))).unwrap()
}

#[test]
fn cracks_meet_at_the_impact_point() {
    let wall = wall();
    let h = solid(&wall).grid().spacing;
    let pattern = Pattern::radial(&Radial::default()).unwrap();
    for place in PLACES {
        let fragments = strike(&wall, &pattern, place);
        assert_eq!(fragments.len(), 12);
        let met = meeting_point(&fragments, place.y);
        assert!((met - place).length() < h, "struck at {place}, cracks meet at {met}");

        // The planes themselves contain it exactly, and each fragment keeps its two.
        for fragment in &fragments {
            let cuts = &solid(&fragment.shape).outline.cuts;
            assert_eq!(cuts.len(), 2);
            assert!(cuts.iter().all(|cut| cut.distance(place).abs() < 1e-12));
        }
    }
}

/// Small pieces where the blow fell, large ones far from it, and other pieces for each place.
#[test]
fn pieces_grow_with_the_distance_from_the_blow() {
    let wall = wall();
    let pattern = Pattern::radial(&Radial { rings: 3, ..Radial::default() }).unwrap();
    let mut largest = Vec::new();
    for place in PLACES {
        let fragments = strike(&wall, &pattern, place);
        let mean = |near: bool| {
            let distance =
                |fragment: &Fragment| (fragment.parent_from_fragment.translation - place).length();
            let volumes = fragments.iter().filter(|fragment| (distance(fragment) < 1.0) == near);
            let (count, sum) = volumes.fold((0.0, 0.0), |(count, sum), fragment| {
                (count + 1.0, sum + fragment.shape.volume)
            });
            assert!(count >= 5.0);
            sum / count
        };
        assert!(mean(false) > 4.0 * mean(true), "{place}: {} {}", mean(false), mean(true));
        largest.push(fragments.iter().map(|fragment| fragment.shape.volume).fold(0.0, f64::max));
    }
    for a in 0..3 {
        for b in 0..a {
            assert!((largest[a] / largest[b] - 1.0f64).abs() > 0.01, "{largest:?}");
        }
    }
}

/// Wedges keep the exact corners of their cracks, where they meet on both faces of the wall. Two of
/// the twelve do not: between the nodes their tips fall apart, and the crumbs join a neighbour.
#[test]
fn fragments_have_sharp_corners() {
    let wall = wall();
    let h = solid(&wall).grid().spacing;
    let pattern = Pattern::radial(&Radial::default()).unwrap();
    let place = PLACES[1];
    let mut exact = 0;
    for fragment in strike(&wall, &pattern, place) {
        for corner in [place, place - DVec3::Y * 0.4] {
            let corner = fragment.parent_from_fragment.inverse().point(corner);
            let distances =
                fragment.shape.samples().iter().map(|sample| (sample.as_dvec3() - corner).length());
            let nearest = distances.fold(f64::INFINITY, f64::min);
            assert!(nearest < 5.0 * h, "a corner is {nearest} m from the next sample");
            exact += usize::from(nearest < 1e-5);
        }
    }
    assert!(exact >= 20, "{exact} of 24 corners are exact");
}

#[test]
fn a_closed_form_does_not_break() {
    let shape = Shape::closed_form(ClosedForm::Sphere { radius: 1.0 }, 0.1);
    let pattern = Pattern::radial(&Radial::default()).unwrap();
    assert!(strike(&shape, &pattern, DVec3::Y).is_empty());
}
