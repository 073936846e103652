//! Analytic answers of the substep loop, and the guarantees of slabs and colours.

use super::constraints::Selection;
use super::group::Group;
use super::slabs::NOWHERE;
use super::slabs::Slabs;
use super::solver_islands::count;
use super::*;
use frangible_bodies::{NewBody, Pair, Pose, StepSettings, SurfaceProperties, Velocity};
use frangible_collision::{FeatureId, ManifoldPoint, find_manifolds};
use frangible_geometry::{ClosedForm, HalfSpace, Shape};
use glam::DQuat;
use std::collections::BTreeSet;
use std::sync::Arc;

const DT: f64 = 1.0 / 30.0;
const G: f64 = 9.81;

fn frame(gravity: f64) -> Frame {
    let settings =
        StepSettings { rotation: frangible_bodies::Rotation::Exact, ..StepSettings::default() };
    Frame { dt: DT, gravity: -gravity * DVec3::Y, settings }
}

fn spawn(
    bodies: &mut Bodies,
    form: ClosedForm,
    motion: Motion,
    [at, linear]: [DVec3; 2],
    [e, mu]: [f64; 2],
) {
    bodies.spawn(NewBody {
        shape: Arc::new(Shape::closed_form(form, 0.1)),
        density: 1000.0,
        motion,
        pose: Pose { position: at, orientation: DQuat::IDENTITY },
        velocity: Velocity { linear, ..Velocity::default() },
        surface: SurfaceProperties::new(e, mu),
    });
}

fn ball(bodies: &mut Bodies, radius: f64, at: DVec3, linear: DVec3, e: f64, mu: f64) {
    spawn(bodies, ClosedForm::Sphere { radius }, Motion::Dynamic, [at, linear], [e, mu]);
}

fn ground(bodies: &mut Bodies) {
    let form = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.0 });
    spawn(bodies, form, Motion::Static, [DVec3::ZERO; 2], [1.0, 1.0]);
}

fn all_pairs(bodies: &Bodies) -> Vec<Pair> {
    let count = bodies.len();
    (0..count).flat_map(|a| (a + 1..count).map(move |b| Pair { first: a, second: b })).collect()
}

/// Steps several frames and returns the last result.
fn run(bodies: &mut Bodies, frame: &Frame, frames: u32) -> Solved {
    let mut warm = ImpulseCache::default();
    let mut last = Solved {
        accounts: FrameAccounts::default(),
        gravity: (DVec3::ZERO, DVec3::ZERO),
        short_of_substeps: 0,
        short_of_impacts: 0,
        confirmed: BTreeMap::new(),
        impacts: Vec::new(),
    };
    for _ in 0..frames {
        let found = find_manifolds(bodies, &all_pairs(bodies), &warm, frame);
        let manifolds: Vec<Manifold> = found.iter().collect();
        last = solve(bodies, (&manifolds, &found.neighbours), &mut warm, frame);
    }
    last
}

/// In a row of touching elastic balls the first stops, and the last leaves with its velocity.
#[test]
fn a_row_of_elastic_balls_passes_its_motion_on() {
    for count in [2, 3, 33, 100] {
        let mut bodies = Bodies::default();
        for number in 0..count {
            let linear = if number == 0 { 3.0 * DVec3::X } else { DVec3::ZERO };
            let gap = if number == 0 { -0.05 } else { 0.0 };
            ball(&mut bodies, 0.1, (0.2 * f64::from(number) + gap) * DVec3::X, linear, 1.0, 0.0);
        }
        run(&mut bodies, &frame(0.0), 1);
        let speeds: Vec<f64> = bodies.velocities.iter().map(|velocity| velocity.linear.x).collect();
        assert!((speeds[count as usize - 1] - 3.0).abs() < 1e-5, "{count}: {speeds:?}");
        assert!(speeds[..count as usize - 1].iter().all(|speed| speed.abs() < 1e-5), "{speeds:?}");
        let momentum: f64 = (0..bodies.len()).map(|i| bodies.masses[i] * speeds[i]).sum();
        assert!((momentum / (3.0 * bodies.masses[0]) - 1.0).abs() < 1e-14);
    }
}

/// A ball on the ground stays: the overlap is below a thousandth of its radius.
#[test]
fn a_ball_lies_still() {
    let mut bodies = Bodies::default();
    ground(&mut bodies);
    ball(&mut bodies, 0.5, 0.5 * DVec3::Y, DVec3::ZERO, 0.0, 0.5);
    run(&mut bodies, &frame(G), 120);
    let (height, speed) = (bodies.poses[1].position.y, bodies.velocities[1].linear.length());
    assert!((0.4995..0.5).contains(&height) && speed < 1e-5, "{height} m, {speed} m/s");
}

/// An elastic ball returns to its initial height, and a ball without restitution stays down.
#[test]
fn balls_bounce_by_their_restitution() {
    let highest = |e: f64| {
        let mut bodies = Bodies::default();
        ground(&mut bodies);
        ball(&mut bodies, 0.1, 1.1 * DVec3::Y, DVec3::ZERO, e, 0.0);
        run(&mut bodies, &frame(G), 14);
        assert!(bodies.poses[1].position.y < 1.0, "it comes down in 0.45 s");
        let heights = (0..16).map(|_| {
            run(&mut bodies, &frame(G), 1);
            bodies.poses[1].position.y - 0.1
        });
        heights.fold(0.0, f64::max)
    };
    for (e, height) in [(1.0, 1.0), (0.5, 0.25)] {
        assert!((highest(e) - height).abs() < 0.02, "{e}: {}", highest(e));
    }
    assert!(highest(0.0) < 0.02);
}

/// A ball deep in the ground recovers at no more than the settings' speed, and keeps no speed
/// afterwards.
#[test]
fn overlaps_close_at_a_bounded_speed() {
    let mut bodies = Bodies::default();
    ground(&mut bodies);
    ball(&mut bodies, 0.5, 0.2 * DVec3::Y, DVec3::ZERO, 0.0, 0.5);
    let frame = frame(G);
    let mut last = 0.2;
    for _ in 0..60 {
        let solved = run(&mut bodies, &frame, 1);
        let height = bodies.poses[1].position.y;
        assert!(
            (height - last) / DT <= frame.settings.recovery_speed,
            "{} m/s",
            (height - last) / DT
        );
        assert!(solved.accounts.causes.projection >= 0.0);
        last = height;
    }
    assert!((0.499..0.5).contains(&last), "{last}");
}

/// A sliding ball begins to roll: five sevenths of its speed remain.
#[test]
fn sliding_becomes_rolling() {
    let mut bodies = Bodies::default();
    ground(&mut bodies);
    ball(&mut bodies, 0.1, 0.1 * DVec3::Y, 2.0 * DVec3::X, 0.0, 0.5);
    run(&mut bodies, &frame(G), 30);
    let speed = bodies.velocities[1].linear.x;
    assert!((speed - 2.0 * 5.0 / 7.0).abs() < 0.01, "{speed}");
}

/// Layers of touching balls, enough for several slabs.
fn heap() -> (Bodies, Vec<Pair>) {
    let mut bodies = Bodies::default();
    ground(&mut bodies);
    for number in 0..4000_u32 {
        let (x, y, z) = (number / 20, number / 5 % 4, number % 5);
        let at = DVec3::new(f64::from(x), f64::from(y) + 0.5, f64::from(z));
        ball(&mut bodies, 0.5, at, DVec3::ZERO, 0.0, 0.5);
    }
    let near =
        |a: usize, b: usize| bodies.poses[a].position.distance(bodies.poses[b].position) < 1.01;
    let mut pairs = Vec::new();
    for a in 1..bodies.len() {
        if bodies.poses[a].position.y < 1.0 {
            pairs.push(Pair { first: 0, second: a });
        }
        pairs.extend(
            (a + 1..bodies.len().min(a + 22))
                .filter(|&b| near(a, b))
                .map(|b| Pair { first: a, second: b }),
        );
    }
    pairs.sort_unstable();
    (bodies, pairs)
}

/// Lines of a slab's manifolds lie in the slab or the next, and lanes of a batch share no movable
/// body.
#[test]
fn slabs_and_colours_share_no_body() {
    let (bodies, pairs) = heap();
    let frame = frame(G);
    let found = find_manifolds(&bodies, &pairs, &ImpulseCache::default(), &frame);
    let manifolds: Vec<Manifold> = found.iter().collect();
    let members: Vec<usize> = (0..manifolds.len()).collect();
    let mut lines = vec![NOWHERE; bodies.len()];
    let slabs = Slabs::new(&bodies, &manifolds, &members, &mut lines);
    assert!(slabs.count() > 8, "{}", slabs.count());
    assert!(lines.iter().all(|&line| line == NOWHERE));
    for (&number, &(slab, lines)) in members.iter().zip(&slabs.places) {
        let Pair { first, second } = manifolds[number].pair;
        for (line, body) in lines.into_iter().zip([first, second]) {
            let own = slabs.starts[slab]..slabs.starts[(slab + 2).min(slabs.count())];
            assert!(slab == slabs.count() || own.contains(&(line as usize)));
            let expected = if body == 0 { None } else { Some(body) };
            assert_eq!(slabs.body_of[line as usize], expected);
        }
    }

    let carried: Vec<&[frangible_collision::CachedImpulse]> = vec![&[]; manifolds.len()];
    let group =
        Group::<Scalar>::new(&bodies, (&manifolds, &carried), (&members, 16), &mut lines, &frame);
    let mut seen = 0;
    for slab in &group.slabs {
        for batch in &group.batches[slab.batches.clone()] {
            let mut taken = BTreeSet::new();
            for &number in
                batch.constraints.iter().filter(|&&number| (number as usize) < manifolds.len())
            {
                seen += 1;
                for line in group.selections[number as usize].lines {
                    let is_fixed = slabs.body_of[line as usize].is_none();
                    assert!(is_fixed || taken.insert(line));
                }
            }
        }
    }
    assert_eq!(seen, manifolds.len());
}

/// Each point of a manifold belongs to exactly one constraint, and all points of a constraint share
/// their normal.
#[test]
fn every_point_is_of_one_constraint() {
    let point = |number: usize| ManifoldPoint {
        anchor_first: DVec3::ZERO,
        anchor_second: DVec3::ZERO,
        rounding: [0.0; 2],
        normal: [DVec3::X, DVec3::Y, DVec3::Z][number % 3],
        feature: FeatureId { is_of_first: true, index: number as u64 },
        approach: 0.0,
        gap: 0.0,
    };
    let points: Vec<ManifoldPoint> = (0..301).map(point).collect();
    let (mut selections, mut room) = (Vec::new(), vec![true; 3]);
    Selection::all(&mut selections, (7, &points), [0, 1], &mut room);
    let mut numbers: Vec<usize> = selections.iter().flat_map(|of| of.points()).collect();
    assert!(selections.iter().all(|of| {
        let first = of.points().next().unwrap();
        of.points().all(|number| number % 3 == first % 3) && of.manifold == 7
    }));
    numbers.sort_unstable();
    assert!(numbers.into_iter().eq(0..301));
}

/// Substeps are powers of two: they grow at once, shrink late and by halves, and respect the
/// settings and the work limit of a frame.
#[test]
fn substeps_do_not_flicker() {
    let frame = frame(G);
    for (needed, last, manifolds, expected) in [
        (0.0, 0, 10, 8),
        (16.1, 16, 10, 32),
        (100.0, 16, 10, 128),
        (1000.0, 16, 10, 128),
        (31.0, 64, 10, 64),
        (24.0, 64, 10, 32),
        (1.0, 128, 10, 64),
        (100.0, 16, 4000, 64),
        (100.0, 16, 100_000, 8),
    ] {
        assert_eq!(count(needed, last, manifolds, &frame), expected, "{needed} {last} {manifolds}");
    }
}
