//! The energy of rotation is kept, whatever the tensor and however large the step [Su09 sec. 2].

mod common;

use common::{Random, Tensors};
use frangible_bodies::{
    EnergyFix, Inertia, Pose, Rotation, Velocity, advance, fix_rotational_energy,
    rotate_second_order,
};
use glam::{DQuat, DVec3};

const DT: f64 = 1.0 / 30.0;

/// Median, 99th percentile and maximum.
fn spread(values: &mut [f64]) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [values[values.len() / 2], values[values.len() / 100 * 99], values[values.len() - 1]]
}

#[test]
fn one_step_keeps_the_energy_and_without_the_fix_it_does_not() {
    for tensors in Tensors::ALL {
        let mut random = Random::new(1);
        let (mut before, mut after) = (Vec::new(), Vec::new());
        let (mut fallbacks, mut most_rounds) = (0, 0);
        for _ in 0..200_000 {
            let inertia = Inertia::new(1.0, random.moments(tensors));
            let start = random.orientation();
            let momentum = random.angular_momentum(start, &inertia, DT);
            let energy_0 = inertia.rotational_energy(start, momentum);

            let rotated = rotate_second_order(start, momentum, &inertia, DT);
            let (fixed, fix) = fix_rotational_energy(rotated, momentum, &inertia, energy_0);
            match fix {
                EnergyFix::CorrectedByPrincipalAxis { rounds, .. } => {
                    fallbacks += 1;
                    most_rounds = most_rounds.max(rounds);
                }
                EnergyFix::Unresolved { .. } | EnergyFix::TooSlow => {
                    panic!("{tensors:?} {inertia:?} {momentum}: {fix:?}")
                }
                _ => {}
            }
            before.push((inertia.rotational_energy(rotated, momentum) / energy_0 - 1.0).abs());
            after.push((inertia.rotational_energy(fixed, momentum) / energy_0 - 1.0).abs());
            assert!((fixed.length() - 1.0).abs() < 1e-15);
        }

        let (without, with) = (spread(&mut before), spread(&mut after));
        let [show_without, show_with] =
            [without, with].map(|[a, b, c]| format!("{a:.1e} / {b:.1e} / {c:.1e}"));
        println!(
            "{tensors:?}: {show_without} becomes {show_with}; {fallbacks} fallbacks, {most_rounds} rounds"
        );
        assert!(with[2] <= 1e-11, "{tensors:?}: {with:?}");
        assert!(
            !matches!(tensors, Tensors::Physical) || without[2] > 10.0,
            "a thin body gains energy without the fix"
        );
    }
}

/// Any energy between the extremes can be reached, from any orientation.
#[test]
fn any_attainable_energy_is_reached() {
    for tensors in Tensors::ALL {
        let mut random = Random::new(4);
        let mut errors = Vec::new();
        for _ in 0..200_000 {
            let inertia = Inertia::new(1.0, random.moments(tensors));
            let [start, other] = [0; 2].map(|_| random.orientation());
            let momentum = random.angular_momentum(start, &inertia, DT);
            let target = inertia.rotational_energy(other, momentum);
            let (fixed, fix) = fix_rotational_energy(start, momentum, &inertia, target);
            assert!(
                !matches!(fix, EnergyFix::Unresolved { .. }),
                "{tensors:?} {inertia:?}: {fix:?}"
            );
            errors.push((inertia.rotational_energy(fixed, momentum) / target - 1.0).abs());
        }
        let worst = spread(&mut errors)[2];
        println!("{tensors:?}: worst {worst:.1e}");
        assert!(worst <= 1e-11);
    }
}

/// L within 1e-20 to 0.1 of a principal axis, where L x omega vanishes.
#[test]
fn momentum_near_a_principal_axis_is_no_obstacle() {
    for tensors in Tensors::ALL {
        let mut random = Random::new(5);
        let (mut errors, mut fallbacks) = (Vec::new(), 0);
        for case in 0..200_000 {
            let inertia = Inertia::new(1.0, random.moments(tensors));
            let other = random.orientation();
            let offset = random.log_uniform(1e-20, 0.1) * random.direction();
            let momentum_body = DVec3::AXES[case % 3] + offset;
            // In the body's own frame the offset survives the rounding; in others it is rounded as
            // it would be.
            let start = if case % 2 == 0 { DQuat::IDENTITY } else { random.orientation() };
            let momentum = start * momentum_body;
            let target = inertia.rotational_energy(other, momentum);
            let (fixed, fix) = fix_rotational_energy(start, momentum, &inertia, target);
            assert!(
                !matches!(fix, EnergyFix::Unresolved { .. }),
                "{tensors:?} {inertia:?} {momentum}: {fix:?}"
            );
            fallbacks += u32::from(matches!(fix, EnergyFix::CorrectedByPrincipalAxis { .. }));
            errors.push((inertia.rotational_energy(fixed, momentum) / target - 1.0).abs());
        }
        let worst = spread(&mut errors)[2];
        println!("{tensors:?}: worst {worst:.1e}, {fallbacks} fallbacks");
        assert!(worst <= 1e-11 && fallbacks > 1000);
    }
}

/// Each step measures its own energy, so errors could add up. They stay at rounding; without the
/// fix they do not.
#[test]
fn a_thousand_steps_do_not_drift() {
    for tensors in Tensors::ALL {
        let mut random = Random::new(6);
        let (mut drifts, mut uncorrected) = (Vec::new(), Vec::new());
        for _ in 0..500 {
            let inertia = Inertia::new(1.0, random.moments(tensors));
            let start = Pose { position: DVec3::ZERO, orientation: random.orientation() };
            let angular_momentum = random.angular_momentum(start.orientation, &inertia, DT);
            let velocity = Velocity { linear: DVec3::ZERO, angular_momentum };
            let energy_0 = inertia.rotational_energy(start.orientation, angular_momentum);
            for (energy_fix, errors) in [(true, &mut drifts), (false, &mut uncorrected)] {
                let end = (0..1000).fold(start, |pose, _| {
                    advance(&pose, &velocity, &inertia, DT, Rotation::SecondOrder { energy_fix })
                });
                let energy = inertia.rotational_energy(end.orientation, angular_momentum);
                errors.push((energy / energy_0 - 1.0).abs());
            }
        }
        let (drift, without) = (spread(&mut drifts)[2], spread(&mut uncorrected)[2]);
        println!("{tensors:?}: drift {drift:.1e}, without the fix {without:.1e}");
        assert!(drift < 1e-9 && without > 0.1);
    }
}
