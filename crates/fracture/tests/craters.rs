//! Breaks with a reach, of random bodies and blows.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

mod common;

use common::random_impact;
use frangible_fracture::{
    Bricks, Fragment, Impact, Natural, Pattern, Radial, Reach, Rim, ShatterSettings, Slices,
    Voronoi, interfaces, shatter,
};
use frangible_geometry::{ClosedForm, Compound, Hull, Shape};
use frangible_math::RigidTransform;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn bodies() -> Vec<Shape> {
    let half = DVec3::new(1.0, 0.7, 0.15);
    let part = |x: f64| {
        Hull::cuboid(half).transformed(&RigidTransform::new(DQuat::IDENTITY, DVec3::X * x))
    };
    vec![
        Shape::breakable(ClosedForm::Box { half }, 0.1).unwrap(),
        Shape::breakable(ClosedForm::Sphere { radius: 0.8 }, 0.1).unwrap(),
        Shape::breakable(ClosedForm::Cylinder { radius: 0.3, half_height: 1.0 }, 0.1).unwrap(),
        Shape::compound(Compound::new(vec![part(-1.0), part(1.0)]), 0.1).unwrap(),
    ]
}

fn patterns() -> Vec<(Pattern, Rim)> {
    vec![
        (
            Pattern::natural(&Natural { cells: 60, clustering: 1.5, ..Natural::default() })
                .unwrap(),
            Rim::Bowl,
        ),
        (Pattern::voronoi(&Voronoi { cells: 50, ..Voronoi::default() }).unwrap(), Rim::Bowl),
        (Pattern::radial(&Radial { rings: 3, ..Radial::default() }).unwrap(), Rim::Bowl),
        (Pattern::bricks(&Bricks::default()).unwrap(), Rim::Cells),
        (Pattern::slices(&Slices::default()).unwrap(), Rim::Cells),
    ]
}

/// Sum of volumes, and of volume times centre in the parent's frame.
fn sums(fragments: &[Fragment]) -> (f64, DVec3) {
    fragments.iter().fold((0.0, DVec3::ZERO), |(volume, moment), fragment| {
        let own = fragment.shape.volume;
        (volume + own, moment + own * fragment.parent_from_fragment.translation)
    })
}

/// Fragments and rest are all of the body, where it was; the rest is what is out of reach; all are
/// in contact; and what is left breaks again, five times over.
#[test]
fn craters_in_craters_lose_nothing() {
    let mut random = Pcg64Mcg::seed_from_u64(44);
    let (mut made, mut empty) = (0, 0);
    for body in bodies() {
        for (pattern, rim) in patterns() {
            let mut body = body.clone();
            for _ in 0..5 {
                let impact: Impact = random_impact(&body, &mut random);
                let distance = 0.1 + 0.5 * random.random::<f64>();
                let reach = Some(Reach { distance, rim });
                let twist = 6.0 * random.random::<f64>();
                let settings = ShatterSettings { reach, twist, ..ShatterSettings::default() };
                let fragments = shatter(&body, &pattern, &impact, &settings);
                made += 1;
                if fragments.len() < 2 {
                    empty += 1;
                    continue;
                }
                let (volume, moment) = sums(&fragments);
                assert!((volume / body.volume - 1.0).abs() < 1e-10, "{volume} of {}", body.volume);
                assert!(moment.length() < 1e-10 * body.volume, "{moment}");
                let touching = interfaces(&fragments);
                assert!(touching.iter().all(|contact| contact.area > 0.0));
                for fragment in fragments.iter().filter(|fragment| !fragment.is_rest()) {
                    let at = fragment.parent_from_fragment.translation;
                    let size = fragment.shape.radius();
                    let reach =
                        if rim == Rim::Cells { distance + 2.0 * size } else { 1.4 * distance };
                    let away = at.distance(impact.point_body);
                    assert!(away < reach + 1e-9, "{away} of {reach}");
                }
                let rest = fragments.into_iter().filter(Fragment::is_rest);
                let largest = rest.max_by(|a, b| a.shape.volume.total_cmp(&b.shape.volume));
                let Some(largest) = largest else { break };
                body = largest.shape;
            }
        }
    }
    println!("{empty} of {made} broke nothing");
    assert!(empty * 10 < made, "{empty} of {made} blows broke nothing");
}
