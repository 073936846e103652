//! The closed form keeps the energy, meets analytic answers, and stays finite in degenerate cases.
//! The claim `exact-rotation` compares it with a 40-digit reference.

mod common;

use common::{Random, Tensors};
use frangible_bodies::{Inertia, Pose, Rotation, Velocity, advance, rotate_exact};
use glam::{DQuat, DVec3};

/// Frame time of the paper's shots [s].
const DT: f64 = 1.0 / 30.0;
const WITHOUT_FIX: Rotation = Rotation::SecondOrder { energy_fix: false };
const WITH_FIX: Rotation = Rotation::SecondOrder { energy_fix: true };

/// Angle of the rotation between two orientations [rad], with all digits where it is small.
fn angle_between(a: DQuat, b: DQuat) -> f64 {
    let between = a.conjugate() * b;
    2.0 * libm::atan2(between.xyz().length(), between.w.abs())
}

fn rotate(
    orientation: DQuat,
    angular_momentum: DVec3,
    inertia: &Inertia,
    dt: f64,
    rule: Rotation,
) -> DQuat {
    let pose = Pose { position: DVec3::ZERO, orientation };
    advance(&pose, &Velocity { linear: DVec3::ZERO, angular_momentum }, inertia, dt, rule)
        .orientation
}

/// Relative energy error per radian of orientation error: |L x omega| / (2 E).
fn energy_condition(orientation: DQuat, momentum: DVec3, inertia: &Inertia) -> f64 {
    let omega = inertia.angular_velocity(orientation, momentum);
    momentum.cross(omega).length() / inertia.rotational_energy(orientation, momentum)
}

/// The orientation itself is rounded, which a body of moments 1 : 1e6 magnifies up to a thousand
/// times.
#[test]
fn one_step_keeps_the_energy_of_any_body() {
    for tensors in Tensors::ALL {
        let mut random = Random::new(1);
        let mut worst: f64 = 0.0;
        for case in 0..200_000 {
            let inertia = Inertia::new(1.0, random.moments(tensors));
            let start = random.orientation();
            let mut momentum = random.angular_momentum(start, &inertia, DT);
            if case % 4 == 0 {
                // Near a principal axis.
                let offset = random.log_uniform(1e-20, 0.1) * random.direction();
                momentum = momentum.length() * (start * (DVec3::AXES[case / 4 % 3] + offset));
            }
            let end = rotate_exact(start, momentum, &inertia, DT);
            let [energy_0, energy] = [start, end].map(|at| inertia.rotational_energy(at, momentum));
            let condition = 1.0
                + energy_condition(start, momentum, &inertia)
                + energy_condition(end, momentum, &inertia);
            worst = worst.max((energy / energy_0 - 1.0).abs() / condition);
            assert!((end.length() - 1.0).abs() < 1e-15, "{inertia:?} {momentum}");
        }
        println!("{tensors:?}: {worst:.1e}");
        assert!(worst < 1e-14, "{tensors:?}: {worst:.1e}");
    }
}

/// Two steps are one as long as both, the second one forward or back in time.
#[test]
fn steps_compose() {
    for tensors in [Tensors::Mild, Tensors::Physical, Tensors::Arbitrary] {
        let mut random = Random::new(2);
        let mut errors: Vec<f64> = (0..50_000)
            .map(|case: usize| {
                let inertia = Inertia::new(1.0, random.moments(tensors));
                let start = random.orientation();
                let momentum = random.angular_momentum(start, &inertia, DT);
                let part = [0.3, 1.3][case % 2];
                let halfway = rotate_exact(start, momentum, &inertia, part * DT);
                let twice = rotate_exact(halfway, momentum, &inertia, (1.0 - part) * DT);
                let fastest = momentum.length() * inertia.inverse_moments.max_element() * DT;
                angle_between(twice, rotate_exact(start, momentum, &inertia, DT)) / (1.0 + fastest)
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        let [median, high] = [errors[errors.len() / 2], errors[errors.len() / 100 * 99]];
        println!("{tensors:?}: {median:.1e}, {high:.1e}");
        assert!(median < 1e-15 && high < 1e-12, "{tensors:?}: {median:.1e}, {high:.1e}");
    }
}

/// A symmetric top precesses about L at the rate |L| / I1, and spins about its own axis [Goldstein,
/// sec. 5.7].
#[test]
fn symmetric_tops_precess_at_the_analytic_rate() {
    let mut random = Random::new(3);
    for axis in 0..3 {
        for axial in [1e-6, 0.3, 1.0, 1.7, 1e6] {
            let mut moments = DVec3::ONE;
            moments[axis] = axial;
            let inertia = Inertia::new(1.0, moments);
            for _ in 0..100 {
                let start = random.orientation();
                let momentum = random.log_uniform(1e-3, 1e3) * random.direction();
                let along = (start.conjugate() * momentum)[axis];
                let spin = (1.0 / axial - 1.0) * along * DT;
                let expected = DQuat::from_scaled_axis(DT * momentum)
                    * start
                    * DQuat::from_scaled_axis(spin * DVec3::AXES[axis]);
                let end = rotate_exact(start, momentum, &inertia, DT);
                let error = angle_between(end, expected);
                let rate = momentum.length() * inertia.inverse_moments.max_element() * DT;
                assert!(error < 1e-15 * (4.0 + rate), "{moments} {momentum}: {error:.1e}");
            }
        }
    }
}

/// Spheres, rest, spins about a principal axis, infinite inertia: each has its simple answer.
#[test]
fn steady_spins_are_rotations_about_a_fixed_axis() {
    let mut random = Random::new(4);
    let start = random.orientation();
    for turn in [0.0, 1e-300, 1e-160, 1e-9, 0.1, 3.0, 100.0] {
        for moments in [DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 1.0, 2.0)] {
            let inertia = Inertia::new(1.0, moments);
            for (i, axis) in DVec3::AXES.into_iter().enumerate() {
                for sign in [1.0, -1.0] {
                    // In the body's own frame, so that rounding does not tilt the unstable spin.
                    let spin = sign * turn * axis;
                    let end = rotate_exact(DQuat::IDENTITY, moments[i] * spin, &inertia, 1.0);
                    let expected = DQuat::from_scaled_axis(spin);
                    assert!(
                        angle_between(end, expected) < 1e-15 * (1.0 + turn),
                        "{moments} {spin}"
                    );
                }
            }
        }
        let momentum = turn * random.direction();
        let end = rotate_exact(start, momentum, &Inertia::new(1.0, DVec3::ONE), 1.0);
        assert!(
            angle_between(end, DQuat::from_scaled_axis(momentum) * start) < 1e-15 * (2.0 + turn)
        );
        assert_eq!(rotate_exact(start, momentum, &Inertia::INFINITE, 1.0), start);
    }
    let brick = Inertia::new(1.0, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(rotate_exact(start, DVec3::ZERO, &brick, DT), start);
    assert_eq!(rotate_exact(start, DVec3::ONE, &brick, 0.0), start);
}

/// On and next to the separatrix, and for spins that no frame resolves, the energy stays and
/// nothing overflows.
#[test]
fn separatrices_and_huge_steps_stay_finite_and_keep_the_energy() {
    let mut random = Random::new(5);
    for case in 0..20_000 {
        let moments = random.moments([Tensors::Mild, Tensors::Physical][case % 2]);
        let inertia = Inertia::new(1.0, moments);
        let (mut order, rate) = ([0, 1, 2], inertia.inverse_moments.to_array());
        order.sort_by(|&i, &j| rate[i].total_cmp(&rate[j]));
        let [low, middle, high] = order;

        // z^2 (high - middle) = x^2 (middle - low), up to a small part.
        let mut direction = DVec3::ZERO;
        let size = random.log_uniform(1e-30, 1.0);
        direction[low] = size * (rate[high] - rate[middle]).sqrt();
        direction[high] =
            size * (rate[middle] - rate[low]).sqrt() * (1.0 + random.log_uniform(1e-18, 1e-3));
        direction[middle] = rate[middle].sqrt();
        let start = if case % 3 == 0 { DQuat::IDENTITY } else { random.orientation() };
        let direction = start * direction.normalize();
        let turn = random.log_uniform(1e-3, 1e15);
        let momentum = turn / inertia.angular_velocity(start, direction).length() * direction;

        let end = rotate_exact(start, momentum, &inertia, 1.0);
        let [energy_0, energy] = [start, end].map(|at| inertia.rotational_energy(at, momentum));
        let condition = 1.0
            + energy_condition(start, momentum, &inertia)
            + energy_condition(end, momentum, &inertia);
        let error = (energy / energy_0 - 1.0).abs() / condition;
        assert!(error < 1e-14, "{moments} {momentum}: {error:.1e}");
        assert!((end.length() - 1.0).abs() < 1e-15);
    }
    for turn in [1e20, 1e100, 1e150] {
        let end = rotate_exact(
            DQuat::IDENTITY,
            turn * DVec3::ONE,
            &Inertia::new(1.0, DVec3::new(1.0, 2.0, 3.0)),
            DT,
        );
        assert!((end.length() - 1.0).abs() < 1e-15, "{turn}: {end}");
    }
}

/// Non-finite input returns non-finite output at once and without a panic: the quarantine detects
/// it.
#[test]
fn what_is_not_finite_neither_hangs_nor_panics() {
    let brick = Inertia::new(1.0, DVec3::new(1.0, 2.0, 3.0));
    for bad in [f64::NAN, f64::INFINITY, f64::MAX] {
        assert!(!rotate_exact(DQuat::IDENTITY, DVec3::new(bad, 1.0, 2.0), &brick, DT).is_finite());
        assert!(!rotate_exact(DQuat::IDENTITY, bad * DVec3::ONE, &brick, DT).is_finite());
    }
    assert!(
        !rotate_exact(DQuat::from_xyzw(f64::NAN, 0.0, 0.0, 1.0), DVec3::ONE, &brick, DT)
            .is_finite()
    );
}

/// Orientation after `time` by the classic Runge-Kutta rule of fourth order.
fn runge_kutta(start: DQuat, momentum: DVec3, inertia: &Inertia, time: f64, steps: u32) -> DQuat {
    let h = time / f64::from(steps);
    let slope = |q: DQuat| {
        let omega = inertia.angular_velocity(q.normalize(), momentum);
        DQuat::from_vec4((0.5 * omega).extend(0.0)) * q
    };
    (0..steps).fold(start, |q, _| {
        let k1 = slope(q);
        let k2 = slope(q + k1 * (0.5 * h));
        let k3 = slope(q + k2 * (0.5 * h));
        let k4 = slope(q + k3 * h);
        (q + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0)).normalize()
    })
}

/// A long thin box at 35 rad/s, 1.2 rad in a frame, for 10 s of 30 Hz.
#[test]
fn thin_box_keeps_energy_and_phase_for_ten_seconds() {
    let half_extents = DVec3::new(1.0, 0.1, 0.02);
    let squares = half_extents * half_extents;
    let inertia = Inertia::new(1.0, (DVec3::splat(squares.element_sum()) - squares) / 3.0);
    let start = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.7, 0.2);
    let momentum =
        start * (DVec3::new(35.0, 5.0, -3.0).normalize() * 35.0 / inertia.inverse_moments);
    assert!((inertia.angular_velocity(start, momentum).length() - 35.0).abs() < 1e-12);
    let energy_0 = inertia.rotational_energy(start, momentum);

    let frames = 300;
    let reference = runge_kutta(start, momentum, &inertia, 10.0, 1_000_000);
    let coarser = runge_kutta(start, momentum, &inertia, 10.0, 500_000);
    assert!(angle_between(reference, coarser) < 1e-9, "the reference has converged");

    let fly = |rule: Rotation| {
        let mut drift: f64 = 0.0;
        let end = (0..frames).fold(start, |at, _| {
            let next = rotate(at, momentum, &inertia, DT, rule);
            drift = drift.max(inertia.rotational_energy(next, momentum) / energy_0 - 1.0);
            next
        });
        (
            angle_between(end, reference),
            inertia.rotational_energy(end, momentum) / energy_0 - 1.0,
            drift,
        )
    };
    let exact = fly(Rotation::Exact);
    let fixed = fly(WITH_FIX);
    let bare = fly(WITHOUT_FIX);
    println!("exact {exact:?}, with the fix {fixed:?}, without {bare:?}");
    assert!(exact.0 < 1e-9 && exact.1.abs() < 1e-12, "{exact:?}");

    // All of them keep L, which is an input; the fix keeps the energy, but not the phase; without
    // it energy grows.
    assert!(fixed.1.abs() < 1e-9 && fixed.0 > 0.1, "{fixed:?}");
    assert!(bare.2 > 0.1, "{bare:?}");
}

/// Spin that friction has all but stopped, down to the smallest numbers there are, leaves a unit
/// quaternion.
#[test]
fn vanishing_spin_keeps_the_orientation_of_unit_length() {
    let start = DQuat::from_xyzw(0.1, -0.4, 0.3, 0.86).normalize();
    for moments in [DVec3::ONE, DVec3::new(1.0, 2.0, 2.5), DVec3::new(1e-3, 5.0, 5.0)] {
        let inertia = Inertia::new(1.0, moments);
        for exponent in -323..0 {
            let momentum = DVec3::new(1.0, -2.0, 0.5) * libm::pow(10.0, f64::from(exponent));
            let end = rotate_exact(start, momentum, &inertia, 1.0 / 30.0);
            assert!((end.length() - 1.0).abs() < 1e-14, "1e{exponent}: {}", end.length());
        }
    }
}
