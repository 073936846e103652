use super::points::Touching;
use super::*;
use crate::clusters::Member;
use crate::contact_rows::{Beat, RowImpulse, Stage};
use crate::contact_sweep::Given;
use crate::instructions::Scalar;
use crate::manifold::{Manifold, ManifoldFinder, ManifoldPoint, find_manifolds};
use crate::warm_start::{Carried, PointImpulse, WarmStart};
use crate::{Contactant, Frame, Motion, NewBody, Pose, StepSettings, Velocity};
use frangible_geometry::{ClosedForm, Shape};
use glam::{DQuat, Vec3};
use proptest::prelude::*;
use std::sync::Arc;

/// Two cubes of a metre, the second above the first.
fn cubes(gap: f64, turn: f64, linear: [DVec3; 2], spin: [DVec3; 2]) -> Bodies {
    let mut bodies = Bodies::default();
    for side in 0..2 {
        let shape = Arc::new(Shape::closed_form(ClosedForm::Box { half: DVec3::splat(0.5) }, 0.1));
        let height = side as f64 * (1.0 + gap);
        bodies.spawn(NewBody {
            shape,
            density: 1.0,
            motion: Motion::Dynamic,
            pose: Pose {
                position: height * DVec3::Y,
                orientation: DQuat::from_rotation_x(side as f64 * turn),
            },
            velocity: Velocity { linear: linear[side], angular_momentum: spin[side] / 6.0 },
            contactant: Contactant::new(0.0, 0.5),
        });
    }
    bodies
}

/// A batch of the only pair of two bodies.
fn batch_of(bodies: &Bodies, manifold: Manifold, step: &Frame) -> (Movers, Batch<Scalar>) {
    batch_in(false, bodies, manifold, step)
}

/// The same in a heap, or not.
fn batch_in(is_in_heap: bool, bodies: &Bodies, manifold: Manifold, step: &Frame) -> (Movers, Batch<Scalar>) {
    let touching = Touching { manifolds: &[manifold], carried: &[&[]], near: step.sag() };
    let movers = Movers::new::<Scalar>(bodies, vec![0, 1]);
    let member = Member { manifold: 0, locals: [0, 1], stiffness: 1.0, is_in_heap };
    let mut batch = Batch::new((bodies, &movers), &[member], touching, step.dt);
    batch.follow_points(&movers, None);
    (movers, batch)
}

proptest! {
    /// Rows that are left behind as far are too far to touch within a substep at any of their points; when they follow, they are where they
    /// would have been.
    #[test]
    fn rows_behind_the_near_ones_cannot_touch(
        gap in 1e-4..8e-3_f64,
        turn in -0.01..0.01_f64,
        linear in prop::array::uniform6(-1.0..1.0_f64),
        spin in prop::array::uniform6(-1.0..1.0_f64),
        speed in 0.0..2.0_f64,
    ) {
        let frame = Frame { dt: 1.0 / 30.0, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
        let step = Frame { dt: frame.dt / 8.0, ..frame };
        let pair_of = |v: [f64; 6]| [DVec3::new(v[0], v[1], v[2]), DVec3::new(v[3], v[4], v[5])].map(|v| speed * v);
        let bodies = cubes(gap, turn, pair_of(linear), pair_of(spin));
        let found = find_manifolds(&bodies, &[Pair { first: 0, second: 1 }], &WarmStart::default(), &frame);
        let manifolds: Vec<Manifold> = found.iter().collect();
        prop_assume!(!manifolds.is_empty());
        let (mut movers, mut batch) = batch_of(&bodies, manifolds[0], &step);
        for _ in 0..4 {
            let near = batch.near_rows;
            let sides = Sides::of(&batch.sides(&movers));
            batch.follow_all(&movers);
            for at in 0..batch.rows.len() {
                let closing = batch.point(at, batch.shared_basis()).closing(&sides.rates).get(0);
                let gap = batch.rows[at].gap.get(0);
                prop_assert!(at < near || gap > closing * step.dt, "row {at} of {near} near ones: {gap} m, {closing} m/s");
            }
            movers.drift::<Scalar>(&bodies, &step);
            batch.follow_points(&movers, Some(step.dt));
        }
    }
}

/// Two cubes that meet only if one of them is struck have no points while they are further apart than a blow of the speed that is told, which may come at any
/// time, pushes them in a substep; then they have, before they come any nearer.
#[test]
fn what_may_be_struck_has_points_in_time() {
    /// Substeps before the blow.
    const BLOW: u32 = 2;
    let frame = Frame { dt: 1.0 / 30.0, gravity: DVec3::ZERO, settings: StepSettings::default() };
    let step = Frame { dt: frame.dt / 8.0, ..frame };
    for (gap, struck) in [(0.05, 2.0), (0.05, 13.0), (0.3, 2.0), (0.3, 13.0), (0.3, 50.0)] {
        // The lowest edge of the upper one is that much lower than if it were not turned.
        let (sine, cosine) = libm::sincos(0.3);
        let lower = 0.5 * (sine + cosine - 1.0);
        let bodies = cubes(gap + lower, 0.3, [DVec3::ZERO; 2], [DVec3::ZERO; 2]);
        let watched = Manifold { pair: Pair { first: 0, second: 1 }, points: &[], struck };
        let (mut movers, mut batch) = batch_of(&bodies, watched, &step);
        let mut finder = ManifoldFinder::default();
        for done in 0..8 {
            let rest = Frame { dt: f64::from(8 - done) * step.dt, ..step };
            if batch.refresh((&bodies, &movers), &mut finder, &rest) {
                batch.follow_points(&movers, None);
            }
            let left = gap - movers.pose(0).position.y;
            let (has_points, is_near) = (!batch.rows.is_empty(), left <= struck * step.dt);
            assert!(has_points || !is_near, "{gap} m, {struck} m/s, substep {done}: {left} m");
            assert!(is_near || !has_points || done > BLOW, "{gap} m, {struck} m/s, substep {done}: {left} m");

            if done == BLOW {
                movers.set_velocity(0, 0.9 * struck * DVec3::Y, DVec3::ZERO);
            }
            movers.drift::<Scalar>(&bodies, &step);
            batch.follow_points(&movers, Some(step.dt));
        }
    }
}

/// In a heap a pair is looked at for being struck only if the blow would drive one half through the other within a substep: two cubes of 1 m, 5 cm apart, at 240 substeps a
/// second from 120 m/s on. Elsewhere it is in any case, as soon as the blow could bring them together.
#[test]
fn in_heaps_only_what_gets_through_is_watched() {
    let frame = Frame { dt: 1.0 / 30.0, gravity: DVec3::ZERO, settings: StepSettings::default() };
    let step = Frame { dt: frame.dt / 8.0, ..frame };
    let bodies = cubes(0.05, 0.0, [DVec3::ZERO; 2], [DVec3::ZERO; 2]);
    for (is_in_heap, struck, is_watched) in
        [(false, 13.0, true), (true, 13.0, false), (true, 119.0, false), (true, 121.0, true)]
    {
        let manifold = Manifold { pair: Pair { first: 0, second: 1 }, points: &[], struck };
        let (movers, mut batch) = batch_in(is_in_heap, &bodies, manifold, &step);
        let finds = batch.refresh((&bodies, &movers), &mut ManifoldFinder::default(), &frame);
        assert_eq!((finds, !batch.rows.is_empty()), (is_watched, is_watched), "{is_in_heap}, {struck} m/s");

        // A blow drives it no further than half through the other one before it is looked at.
        let patch = &batch.rest.patches[0];
        let unseen = patch.rests_for() + struck * step.dt;
        assert!(is_watched || unseen <= 0.5 || unseen <= step.sag() + struck * step.dt, "{unseen} m");
    }
}

/// A batch of one pair of three cubes on top of each other, its points and what they carry.
struct Stack {
    bodies: Bodies,
    movers: Movers,
    batches: Vec<Batch<Scalar>>,
    step: Frame,
}

impl Stack {
    /// With a batch for each pair, of which each point carries something, different before and after the drift.
    fn new() -> Self {
        let step = Frame { dt: 1.0 / 240.0, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
        let mut bodies = cubes(0.0, 0.0, [DVec3::ZERO; 2], [DVec3::ZERO; 2]);
        let shape = bodies.shapes[0].clone();
        bodies.spawn(NewBody {
            shape,
            density: 1.0,
            motion: Motion::Dynamic,
            pose: Pose { position: DVec3::new(0.2, 2.0, 0.1), orientation: DQuat::IDENTITY },
            velocity: Velocity { linear: DVec3::ZERO, angular_momentum: DVec3::ZERO },
            contactant: Contactant::new(0.0, 0.5),
        });
        for (i, velocity) in bodies.velocities.iter_mut().enumerate() {
            velocity.linear = 2e-5 * DVec3::new(1.0, -0.5, i as f64);
            velocity.angular_momentum = 3e-6 * DVec3::new(i as f64, 1.0, -0.5);
        }
        let pairs = [Pair { first: 0, second: 1 }, Pair { first: 1, second: 2 }];
        let found = find_manifolds(&bodies, &pairs, &WarmStart::default(), &step);
        let manifolds: Vec<Manifold> = found.iter().collect();
        let carried: [&[Carried]; 2] = [&[], &[]];
        let touching = Touching { manifolds: &manifolds, carried: &carried, near: step.sag() };
        let movers = Movers::new::<Scalar>(&bodies, vec![0, 1, 2]);
        let batch = |manifold: usize| {
            let locals = [manifold as u32, manifold as u32 + 1];
            let member = Member { manifold, locals, stiffness: 1.0, is_in_heap: false };
            let mut batch = Batch::<Scalar>::new((&bodies, &movers), &[member], touching, step.dt);
            batch.follow_points(&movers, None);
            for (at, row) in batch.rows.iter_mut().enumerate() {
                for (stage, impulse) in row.impulses.iter_mut().enumerate() {
                    let size = 1e-3 * (1.0 + at as f64 + 0.3 * stage as f64 + manifold as f64);
                    impulse.normal.set(0, size);
                    impulse.tangent[0].set(0, 0.2 * size);
                    impulse.tangent[1].set(0, -0.1 * size);
                }
            }
            batch.carrying_rows = [batch.rows.len(); 2];
            batch
        };
        let batches = vec![batch(0), batch(1)];
        Self { bodies, movers, batches, step }
    }

    /// Bodies get velocities that their paces follow.
    fn store(&mut self, linear: DVec3, angular: DVec3) {
        (0..3).for_each(|local| self.movers.set_velocity(local, linear, angular));
    }

    /// Sums over all bodies: momentum, angular momentum about the world's origin, and energy.
    fn totals(&self) -> (DVec3, DVec3, f64) {
        let mut totals = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for i in 0..3 {
            let (pose, Velocity { linear, angular_momentum }) = self.movers.state(&self.bodies, i as u32);
            let mass = self.bodies.masses[i];
            let spin = self.bodies.inertias[i].inverse_tensor(pose.orientation) * angular_momentum;
            totals.0 += mass * linear;
            totals.1 += pose.position.cross(mass * linear) + angular_momentum;
            totals.2 += 0.5 * mass * linear.length_squared() + 0.5 * spin.dot(angular_momentum)
                - mass * self.step.gravity.dot(pose.position);
        }
        totals
    }
}

/// A batch lies down if nothing of its bodies is faster than a tenth of a millimetre in a second, and is to get up if anything is faster than a millimetre.
#[test]
fn what_hardly_moves_lies_down_until_it_moves() {
    let Stack { movers, mut batches, bodies, step } = Stack::new();
    let mut batch = batches.swap_remove(0);
    let mut stack = Stack { movers, batches: vec![], bodies, step };
    let mut lies = |linear: DVec3, angular: DVec3, rests: bool| {
        stack.movers.set_velocity(0, linear, angular);
        stack.movers.set_velocity(1, DVec3::ZERO, DVec3::ZERO);
        if rests {
            return !batch.is_stirred(&stack.movers);
        }
        stack.movers.find_who_may_rest(stack.step.dt);
        batch.lie_down(&stack.movers);
        batch.rests
    };
    assert!(!lies(1.1e-4 * DVec3::X, DVec3::ZERO, false));
    assert!(!lies(DVec3::ZERO, 1.2e-4 * DVec3::Z, false), "a corner is 0.87 m from the centre");
    assert!(lies(8e-5 * DVec3::X, 2e-5 * DVec3::Z, false));
    assert!(lies(9e-4 * DVec3::X, DVec3::ZERO, true));
    assert!(!lies(1.1e-3 * DVec3::X, DVec3::ZERO, true));
    assert!(stack.movers.any_rests(&[0; LANES]));
    batch.get_up(&stack.movers);
    assert!(!stack.movers.any_rests(&[0; LANES]));
}

/// What a point carried goes on as it was in the world, wherever its normal points by now; but nothing pulls.
#[test]
fn forces_go_on_where_normals_have_turned() {
    let bodies = cubes(0.0, 0.0, [DVec3::ZERO; 2], [DVec3::ZERO; 2]);
    let step = Frame { dt: 1.0 / 240.0, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
    let point = ManifoldPoint {
        anchor_first: DVec3::new(0.1, 0.5, 0.2),
        anchor_second: DVec3::new(0.1, -0.5, 0.2),
        rounding: [0.0; 2],
        normal: DVec3::new(0.6, -0.8, 0.0),
        sample: (true, 7),
        approach: 0.0,
        gap: 0.0,
    };
    let pair = Pair { first: 0, second: 1 };
    let (presses, pulls) = (DVec3::new(1.0, -5.0, 0.5), DVec3::new(-4.0, -1.0, 3.0));
    let forces =
        [presses, pulls].map(|force| PointImpulse { normal: 5.0, force: force.as_vec3(), twist: Vec3::ZERO });
    let touching = Touching {
        manifolds: &[Manifold { pair, points: &[point], struck: 0.0 }],
        carried: &[&[Carried { sample: point.sample, forces }]],
        near: step.sag(),
    };
    let movers = Movers::new::<Scalar>(&bodies, vec![0, 1]);
    let member = Member { manifold: 0, locals: [0, 1], stiffness: 1.0, is_in_heap: false };
    let batch = Batch::<Scalar>::new((&bodies, &movers), &[member], touching, step.dt);
    let across = pulls - pulls.dot(point.normal) * point.normal;
    for (stage, force) in [presses, across].into_iter().enumerate() {
        let RowImpulse { normal, tangent } = batch.rows[0].impulses[stage];
        let impulse = batch.directions.of(0).basis().in_world(normal, tangent).get(0);
        assert!((impulse - step.dt * force).length() < 1e-8, "{impulse}");
        assert!(normal.get(0) >= 0.0);
    }
}

/// What leans is fast, and what holds it gets up, once what it was in balance with gives it nothing any more.
#[test]
fn what_leans_on_nothing_falls() {
    let (mut stack, mut given) = (Stack::new(), Given::ZERO);
    stack.store(DVec3::ZERO, DVec3::ZERO);
    stack.movers.find_who_may_rest(stack.step.dt);
    stack.batches[0].lie_down(&stack.movers);
    stack.batches[1].lean(&stack.movers);
    stack.movers.kick(&stack.step, Stage::BeforeDrift);
    assert!(stack.batches[0].is_stirred(&stack.movers), "nothing has acted yet");
    stack.batches[1].go_on(&stack.movers, &Beat::new(Stage::BeforeDrift, &stack.step), &mut given);
    assert!(!stack.batches[0].is_stirred(&stack.movers), "it is in balance");
    stack.batches[1].rows.iter_mut().for_each(|row| row.clear(0));
    stack.movers.kick(&stack.step, Stage::AfterDrift);
    stack.batches[1].go_on(&stack.movers, &Beat::new(Stage::AfterDrift, &stack.step), &mut given);
    assert!(stack.batches[0].is_stirred(&stack.movers), "it has parted");
}

/// What rests and what leans on it go on as they move while what acts on them is the same, and the books balance, those of energy to single precision: also
/// where it is another, and where all gets up in the midst of a substep.
#[test]
fn what_rests_is_in_balance() {
    let mut stack = Stack::new();
    let (linear, angular) = (DVec3::new(3e-5, -4e-5, 2e-5), DVec3::new(2e-5, 1e-5, -3e-5));
    stack.store(linear, angular);
    stack.movers.find_who_may_rest(stack.step.dt);
    stack.batches[0].lie_down(&stack.movers);
    stack.batches[1].lean(&stack.movers);
    assert!(stack.batches[0].rests);
    for number in 0..4 {
        if number == 2 {
            stack.batches[1].rows[0].impulses[0].normal.set(0, 4e-3);
        }
        let before = (stack.totals(), stack.movers.gravity, stack.movers.held());
        let mut given = Given::ZERO;
        let given_before: f64 = stack.batches.iter().map(|batch| batch.given.sum()).sum();
        for stage in [Stage::BeforeDrift, Stage::AfterDrift] {
            if stage == Stage::AfterDrift {
                stack.movers.drift::<Scalar>(&stack.bodies, &stack.step);
            }
            stack.movers.kick(&stack.step, stage);
            for batch in stack.batches.iter_mut().filter(|batch| !batch.rests) {
                batch.follow_points(&stack.movers, None);
                batch.go_on(&stack.movers, &Beat::new(stage, &stack.step), &mut given);
                batch.give_exactly(&stack.movers, &batch.sides(&stack.movers), &mut given);
            }
            if number == 3 && stage == Stage::BeforeDrift {
                stack.batches[0].get_up(&stack.movers);
            }
        }
        let given: f64 = stack.batches.iter().map(|batch| batch.given.sum()).sum::<f64>() - given_before;
        let (totals, gravity, held) = (stack.totals(), stack.movers.gravity, stack.movers.held());
        let (from_gravity, from_rest) = (
            (gravity.0 - before.1.0, gravity.1 - before.1.1),
            (held.impulse - before.2.impulse, held.moment - before.2.moment),
        );
        assert!((totals.0 - before.0.0 - from_gravity.0 - from_rest.0).length() < 1e-15, "{number}");
        assert!((totals.1 - before.0.1 - from_gravity.1 - from_rest.1).length() < 1e-15, "{number}");
        let energy = given + held.energy - before.2.energy;
        assert!(
            (totals.2 - before.0.2 - energy).abs() < 1e-6 * energy.abs().max(1e-4),
            "{number}: {} {energy}",
            totals.2 - before.0.2
        );

        // The lowest one rests, the next one leans.
        let moved = |i: u32| (stack.movers.state(&stack.bodies, i).1.linear - linear).length();
        assert_eq!(moved(0) == 0.0, number < 3, "{number}");
        assert_eq!(moved(1) < 1e-12, number < 2, "{number}: {}", moved(1));
        assert!(moved(2) > 1e-3, "{number}");
    }
}

/// Polyhedra in a heap keep their points for longer, unless they have few: these may only pass each other, and are looked at before they could touch.
#[test]
fn in_heaps_points_last_longer() {
    let cubes = cubes(0.0, 0.0, [DVec3::ZERO; 2], [DVec3::ZERO; 2]);
    let balls = {
        let mut balls = Bodies::default();
        for height in [0.0, 1.0] {
            balls.spawn(NewBody {
                shape: Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1)),
                density: 1.0,
                motion: Motion::Dynamic,
                pose: Pose { position: height * DVec3::Y, orientation: DQuat::IDENTITY },
                velocity: Velocity::default(),
                contactant: Contactant::new(0.0, 0.5),
            });
        }
        balls
    };
    let step = Frame { dt: 1.0 / 240.0, gravity: DVec3::ZERO, settings: StepSettings::default() };
    let found = find_manifolds(&cubes, &[Pair { first: 0, second: 1 }], &WarmStart::default(), &step);
    let points = found.iter().next().map(|manifold| manifold.points.to_vec()).unwrap_or_default();
    assert_eq!(points.len(), 4);
    for (bodies, is_in_heap, count, stale) in [
        (&cubes, false, 4, STALE),
        (&cubes, true, 4, STALE_IN_HEAPS),
        (&cubes, true, 1, STALE),
        (&cubes, true, 0, STALE),
        (&balls, true, 4, STALE),
    ] {
        let pair = Pair { first: 0, second: 1 };
        let manifold = Manifold { pair, points: &points[..count], struck: 0.0 };
        let (_, batch) = batch_in(is_in_heap, bodies, manifold, &step);
        let patch = &batch.rest.patches[0];
        assert_eq!(patch.rests_for(), stale * patch.size, "{count} points, in a heap: {is_in_heap}");
    }
}
