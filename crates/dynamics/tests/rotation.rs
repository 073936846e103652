//! The energy of rotation is kept, whatever the tensor and however large the step [Su09 sec. 2].

mod common;

use common::{Random, Tensors};
use frangible_dynamics::{EnergyFix, Inertia, fix_rotational_energy, rotate_second_order};

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
