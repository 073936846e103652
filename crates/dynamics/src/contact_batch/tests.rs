use super::points::Touching;
use super::*;
use crate::clusters::Member;
use crate::instructions::Scalar;
use crate::manifold::{Manifold, find_manifolds};
use crate::warm_start::{Carried, WarmStart};
use crate::{Contactant, Frame, Motion, NewBody, Pose, StepSettings, Velocity};
use frangible_geometry::{ClosedForm, Shape};
use glam::DQuat;
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
        let carried: [&[Carried]; 1] = [&[]];
        let touching = Touching { manifolds: &manifolds, carried: &carried };
        let mut movers = Movers::new::<Scalar>(&bodies, vec![0, 1]);
        let member = Member { manifold: 0, locals: [0, 1], stiffness: 1.0 };
        let mut batch = Batch::<Scalar>::new((&bodies, &movers), &[member], touching, step.dt);
        batch.follow(&movers, None);
        for _ in 0..4 {
            let near = batch.near_rows;
            let sides = batch.sides(&movers);
            batch.follow_all(&movers, &sides);
            for at in 0..batch.rows.len() {
                let closing = batch.point(at, batch.shared_basis()).closing(&sides).get(0);
                let gap = batch.rows[at].gap.get(0);
                prop_assert!(at < near || gap > closing * step.dt, "row {at} of {near} near ones: {gap} m, {closing} m/s");
            }
            movers.drift::<Scalar>(&bodies, &step);
            batch.follow(&movers, Some(step.dt));
        }
    }
}

/// A pair is calm while nothing of its bodies is faster than a hundredth of a millimetre in a second, until gravity kicks or a pass acts.
#[test]
fn only_what_hardly_moves_is_calm() {
    let step = Frame { dt: 1.0 / 240.0, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
    let bodies = cubes(0.0, 0.0, [DVec3::ZERO; 2], [DVec3::ZERO; 2]);
    let found = find_manifolds(&bodies, &[Pair { first: 0, second: 1 }], &WarmStart::default(), &step);
    let manifolds: Vec<Manifold> = found.iter().collect();
    let carried: [&[Carried]; 1] = [&[]];
    let touching = Touching { manifolds: &manifolds, carried: &carried };
    let mut movers = Movers::new::<Scalar>(&bodies, vec![0, 1]);
    let member = Member { manifold: 0, locals: [0, 1], stiffness: 1.0 };
    let mut batch = Batch::<Scalar>::new((&bodies, &movers), &[member], touching, step.dt);
    movers.kick(&step);
    assert!(!batch.is_calm(&movers), "both fall");
    let stored = |linear: DVec3, angular: DVec3| {
        let mut sides = batch.sides(&movers);
        sides[0].linear = Lanes3::splat(linear);
        sides[0].angular = Lanes3::splat(angular);
        sides[1].linear = Lanes3::ZERO;
        batch.store(&movers, &sides);
        batch.is_calm(&movers)
    };
    assert!(stored(9e-6 * DVec3::X, DVec3::ZERO) && !stored(1.1e-5 * DVec3::X, DVec3::ZERO));
    assert!(
        stored(DVec3::ZERO, 1e-5 * DVec3::Z) && !stored(DVec3::ZERO, 1.2e-5 * DVec3::Z),
        "a corner is 0.87 m from the centre"
    );
    assert!(stored(DVec3::ZERO, DVec3::ZERO));
    batch.is_open = true;
    assert!(!batch.is_calm(&movers), "its books are open");
}
