//! Rotation without torque in closed form, against numbers to 40 digits (docs/adr/008).

use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use crate::random::Random;
use frangible::bodies::{Inertia, Pose, Rotation, Velocity, advance, rotate_exact};
use glam::{DQuat, DVec3};
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;
use std::time::Instant;

/// Against the reference.
pub(super) const EXACT: Claim = Claim {
    name: "exact-rotation",
    says: "orientations after 0.01 to 100 rad in a step match 77 rotations to 40 digits, and the energy stays",
    source: "docs/adr/008",
    measure: exact_rotation,
};

/// Rounding that is alike in every step would add up.
pub(super) const MILLION: Claim = Claim {
    name: "million-rotations",
    says: "a million steps of free rotation keep the energy",
    source: "Su09 sec. 2",
    measure: million_rotations,
};

/// A spin about the axis of the middle moment.
pub(super) const FLIP: Claim = Claim {
    name: "flip-period",
    says: "a spin near the intermediate axis turns over in the period 4 K / lambda of its polhode",
    source: "Landau & Lifshitz, Mechanics, sec. 37",
    measure: flip_period,
};

/// Time.
pub(super) const COST: Claim = Claim {
    name: "rotation-cost",
    says: "the closed form costs no more than the paper's rotation with its energy fix",
    source: "docs/adr/008",
    measure: rotation_cost,
};

/// Frame time of the paper's shots [s].
const DT: f64 = 1.0 / 30.0;

/// The paper's rule.
const SECOND_ORDER: Rotation = Rotation::SecondOrder { energy_fix: true };

/// A row of `data/exact_rotation.csv`, which `data/exact_rotation_reference.py` wrote.
struct Reference {
    near_separatrix: bool,
    /// [rad]
    turn: f64,
    start: DQuat,
    momentum: DVec3,
    inertia: Inertia,
    /// [s]
    dt: f64,
    end: DQuat,
}

impl Reference {
    fn all() -> impl Iterator<Item = Self> {
        let rows = include_str!("../../data/exact_rotation.csv").lines().skip(1);
        rows.filter_map(|row| {
            let (kind, numbers) = row.split_once(',')?;
            let v: Vec<f64> = numbers.split(',').filter_map(|number| number.parse().ok()).collect();
            (v.len() == 16).then(|| Self {
                near_separatrix: kind == "near_separatrix",
                turn: v[0],
                start: DQuat::from_slice(&v[1..5]),
                momentum: DVec3::from_slice(&v[5..8]),
                inertia: Inertia {
                    inverse_mass: 1.0,
                    inverse_moments: DVec3::from_slice(&v[8..11]),
                },
                dt: v[11],
                end: DQuat::from_slice(&v[12..16]),
            })
        })
    }
}

/// Angle of the rotation between two orientations [rad], with all digits where it is small.
fn angle_between(a: DQuat, b: DQuat) -> f64 {
    let between = a.conjugate() * b;
    2.0 * libm::atan2(between.xyz().length(), between.w.abs())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn exact_rotation() -> Result<Vec<Finding>, Obstacle> {
    let (mut error, mut error_near, mut energy_error) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (mut count, mut second_order) = (0, Vec::new());
    for Reference { near_separatrix, turn, start, momentum, inertia, dt, end } in Reference::all() {
        count += 1;
        let rotated = rotate_exact(start, momentum, &inertia, dt);
        let worst = if near_separatrix { &mut error_near } else { &mut error };
        *worst = largest([*worst, angle_between(rotated, end)]);
        let energy = |at: DQuat| inertia.rotational_energy(at, momentum);
        energy_error = largest([energy_error, (energy(rotated) / energy(start) - 1.0).abs()]);

        // The paper's rule with its fix has the same energy, but another phase.
        if turn >= 3.0 {
            let pose = Pose { position: DVec3::ZERO, orientation: start };
            let velocity = Velocity { linear: DVec3::ZERO, angular_momentum: momentum };
            let turned = advance(&pose, &velocity, &inertia, dt, SECOND_ORDER).orientation;
            second_order.push(angle_between(turned, end));
        }
    }
    Ok(vec![
        Finding::between("rotations compared", "1", f64::from(count), 77.0, 77.0),
        Finding::at_most("largest error of the angle", "rad", error, 1e-12),
        Finding::at_most("the same next to a separatrix", "rad", error_near, 1e-11),
        Finding::at_most("largest change of the energy in a step", "1", energy_error, 1e-14),
        Finding::beside(
            "median error of the angle from 3 rad on, paper's rotation",
            "rad",
            median(second_order),
        ),
    ])
}

fn million_rotations() -> Result<Vec<Finding>, Obstacle> {
    let mut random = Random::new(9);
    // A thin body magnifies the rounding of its orientation.
    let bodies = [
        ("brick", DVec3::new(2.5, 1.0, 2.0), 1e-12),
        ("rod of 100:1", DVec3::new(1.0104, 0.0104, 1.0004), 1e-11),
    ];
    let mut findings = Vec::new();
    for (name, moments, most) in bodies {
        let inertia = Inertia::new(1.0, moments);
        let mut worst: f64 = 0.0;
        for turn in [0.03, 0.3, 1.0, 7.0] {
            let start = random.orientation();
            let direction = random.direction();
            let momentum =
                turn / (DT * inertia.angular_velocity(start, direction).length()) * direction;
            let energy = inertia.rotational_energy(start, momentum);
            let mut orientation = start;
            for _ in 0..1_000_000 {
                orientation = rotate_exact(orientation, momentum, &inertia, DT);
                let change = inertia.rotational_energy(orientation, momentum) / energy - 1.0;
                worst = largest([worst, change.abs()]);
            }
        }
        let quantity =
            format!("largest change of the energy in a million steps of 0.03 to 7 rad, {name}");
        findings.push(Finding::at_most(quantity, "1", worst, most));
    }
    Ok(findings)
}

fn flip_period() -> Result<Vec<Finding>, Obstacle> {
    let moments = DVec3::new(1.0, 2.0, 3.0);
    let inertia = Inertia::new(1.0, moments);
    let momentum = DVec3::new(0.02, 2.0, 0.05);
    // The part of L along the intermediate axis, and when it changes sign near a time.
    let along =
        |t: f64| (rotate_exact(DQuat::IDENTITY, momentum, &inertia, t).conjugate() * momentum).y;
    let crossing = |near: f64| {
        let (mut low, mut high) = (near - 1.0, near + 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if along(low) * along(middle) > 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };

    // Its first crossing, by steps; the others half periods after it.
    let period = period_of_polhode(moments, momentum);
    let near = (0..200).map(|step| 0.5 * f64::from(step)).find(|&t| along(t) <= 0.0);
    let first = crossing(near.unwrap_or(f64::NAN));
    let error = |halves: f64| {
        let measured = (crossing(first + halves * 0.5 * period) - first) / halves * 2.0;
        (measured / period - 1.0).abs()
    };
    let worst = largest([1.0, 2.0, 7.0].map(error));
    Ok(vec![
        Finding::beside("period", "s", period),
        Finding::at_most("error of the period over 1, 2 and 7 flips", "1", worst, 1e-10),
    ])
}

/// 4 K / lambda [s]: 2E and L^2 give lambda^2 and m; K is the integral of 1 / sqrt(1 - m sin^2)
/// over a quarter turn, by the midpoint rule, which converges exponentially on a period.
fn period_of_polhode(moments: DVec3, momentum: DVec3) -> f64 {
    let energy_twice = momentum.dot(momentum / moments);
    let momentum_squared = momentum.length_squared();
    let [i1, i2, i3] = moments.to_array();
    let (mut lambda_squared, mut m) = (
        (i3 - i2) * (momentum_squared - energy_twice * i1) / (i1 * i2 * i3),
        (i2 - i1) * (energy_twice * i3 - momentum_squared)
            / ((i3 - i2) * (momentum_squared - energy_twice * i1)),
    );
    if m > 1.0 {
        (lambda_squared, m) = (lambda_squared * m, 1.0 / m);
    }
    let points = 2000;
    let integrand = |i: u32| {
        let sine = libm::sin(FRAC_PI_2 * (f64::from(i) + 0.5) / f64::from(points));
        FRAC_PI_2 / f64::from(points) / (1.0 - m * sine * sine).sqrt()
    };
    4.0 * (0..points).map(integrand).sum::<f64>() / lambda_squared.sqrt()
}

fn rotation_cost() -> Result<Vec<Finding>, Obstacle> {
    // Boxes with edges within a factor of ten that turn by up to 1 rad in a frame.
    let mut random = Random::new(1);
    let body = |_| {
        let edges = DVec3::from_array([0; 3].map(|_| libm::pow(10.0, random.between(-1.0, 0.0))));
        let squares = edges * edges;
        let inertia = Inertia::new(1.0, (DVec3::splat(squares.element_sum()) - squares) / 12.0);
        let pose = Pose { position: DVec3::ZERO, orientation: random.orientation() };
        let direction = random.direction();
        let rate = inertia.angular_velocity(pose.orientation, direction).length();
        let angular_momentum = random.between(0.0, 1.0) / (DT * rate) * direction;
        (pose, Velocity { linear: random.direction(), angular_momentum }, inertia)
    };
    let bodies: Vec<_> = (0..4000).map(body).collect();
    let nanoseconds = |rotation: Rotation| {
        let start = Instant::now();
        for (pose, velocity, inertia) in &bodies {
            black_box(advance(black_box(pose), velocity, inertia, DT, rotation));
        }
        start.elapsed().as_secs_f64() * 1e9 / bodies.len() as f64
    };

    // Rule by rule in each pass, so that a busy moment of the machine strikes both.
    let passes: Vec<[f64; 2]> =
        (0..51).map(|_| [Rotation::Exact, SECOND_ORDER].map(nanoseconds)).collect();
    let ratio = median(passes.iter().map(|[exact, paper]| exact / paper).collect());
    let [exact, paper] = [0, 1].map(|rule| median(passes.iter().map(|pass| pass[rule]).collect()));
    Ok(vec![
        Finding::at_most("median time for a body that turns by up to 1 rad", "ns", exact, 400.0),
        Finding::beside("the same, paper's rotation", "ns", paper),
        Finding::at_most("ratio of the two", "1", ratio, 1.25),
    ])
}
