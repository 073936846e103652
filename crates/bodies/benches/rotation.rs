//! Time of one torque-free rotation on one core: `cargo bench -p frangible-bodies --bench
//! rotation`. Prints the rows of `bench/results/rotation.csv`: medians over passes of the mean over
//! bodies.

#[path = "../tests/common/mod.rs"]
mod common;

use common::Random;
use frangible_bodies::{Inertia, Pose, Rotation, Velocity, advance};
use glam::DVec3;
use std::hint::black_box;
use std::time::Instant;

const DT: f64 = 1.0 / 30.0;
const BODIES: usize = 4000;
const PASSES: usize = 101;

type Body = (Pose, Velocity, Inertia);

/// Random boxes with edges within a factor of ten, that turn by up to `turn` [rad] in a frame.
fn boxes(turn: f64) -> Vec<Body> {
    let mut random = Random::new(1);
    let body = |_| {
        let edges = DVec3::from_array([0; 3].map(|_| random.log_uniform(0.1, 1.0)));
        let squares = edges * edges;
        let inertia = Inertia::new(1.0, (DVec3::splat(squares.element_sum()) - squares) / 12.0);
        let pose = Pose { position: DVec3::ZERO, orientation: random.orientation() };
        let direction = random.direction();
        let rate = inertia.angular_velocity(pose.orientation, direction).length();
        let angular_momentum = random.uniform(0.0, turn) / (DT * rate) * direction;
        (pose, Velocity { linear: random.vector(), angular_momentum }, inertia)
    };
    (0..BODIES).map(body).collect()
}

/// Time of one pass over all bodies, for each [ns].
fn pass(bodies: &[Body], rotation: Rotation) -> f64 {
    let start = Instant::now();
    for (pose, velocity, inertia) in bodies {
        black_box(advance(black_box(pose), velocity, inertia, DT, rotation));
    }
    start.elapsed().as_secs_f64() * 1e9 / bodies.len() as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    println!("turn_up_to_rad,exact_ns,second_order_with_fix_ns,second_order_ns,exact_over_fix");
    for turn in [0.01, 0.1, 1.0, 3.0, 10.0, 100.0] {
        let bodies = boxes(turn);
        let rules = [
            Rotation::Exact,
            Rotation::SecondOrder { energy_fix: true },
            Rotation::SecondOrder { energy_fix: false },
        ];
        // Interleave the rules within each pass: a busy moment of the machine then affects all of
        // them.
        let times: Vec<[f64; 3]> =
            (0..PASSES).map(|_| rules.map(|rule| pass(&bodies, rule))).collect();
        let [exact, fixed, bare] =
            [0, 1, 2].map(|i| median(times.iter().map(|row| row[i]).collect()));
        println!("{turn},{exact:.1},{fixed:.1},{bare:.1},{:.2}", exact / fixed);
    }
}
