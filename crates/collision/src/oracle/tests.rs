//! The narrow phase against the oracle, in random pairs of every two shapes.

use crate::impulse_cache::ImpulseCache;
use crate::manifold::ManifoldPoint;
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::finder::ManifoldFinder;
use crate::narrow_phase::pair_separation::pair_separation;
use crate::oracle::draw::{Draw, Drawn, KINDS, Kind};
use frangible_bodies::{
    Bodies, Frame, Motion, NewBody, Pair, Pose, StepSettings, SurfaceProperties, Velocity,
};
use frangible_math::RigidTransform;
use glam::DVec3;
use std::fmt::Write;
use std::sync::Arc;

/// Worst errors of a pair of kinds.
#[derive(Default)]
struct Worst {
    values: [(f64, u64); 7],
    counts: [usize; 7],
}

const NAMES: [&str; 7] = ["oracle", "untrue", "worse", "normal", "overlap", "apart", "missed"];

impl Worst {
    fn see(&mut self, which: usize, value: f64, seed: u64, limit: f64) {
        if value > self.values[which].0 || value.is_nan() {
            self.values[which] = (value, seed);
        }
        if !(value <= limit) {
            self.counts[which] += 1;
        }
    }
}

/// The deepest point of the manifold of two bodies at rest.
fn deepest(drawn: &Drawn, finder: &mut ManifoldFinder) -> Option<ManifoldPoint> {
    let frame = Frame { dt: 1.0 / 30.0, gravity: DVec3::ZERO, settings: StepSettings::default() };
    let mut bodies = Bodies::default();
    let poses = [drawn.second_from_first, RigidTransform::IDENTITY];
    for (at, (shape, pose)) in drawn.shapes.iter().zip(poses).enumerate() {
        let motion = if at == 1 { Motion::Static } else { Motion::Dynamic };
        bodies.spawn(NewBody {
            shape: Arc::new(shape.clone()),
            density: 1000.0,
            motion,
            pose: Pose { position: pose.translation, orientation: pose.rotation },
            velocity: Velocity::default(),
            surface: SurfaceProperties::new(0.0, 0.5),
        });
    }
    let pair = Pair { first: 0, second: 1 };
    let manifold = finder.find(&bodies, pair, &ImpulseCache::default(), &frame)?;
    manifold.points.iter().copied().min_by(|a, b| a.gap.total_cmp(&b.gap))
}

fn compare(kinds: [Kind; 2], seed: u64, worst: &mut Worst) {
    let drawn = Draw::new(seed).pair(kinds);
    let size = drawn.size;
    let (mut gap, normal) = drawn.truth();
    let shapes = [ConvexShape::of(&drawn.shapes[0]), ConvexShape::of(&drawn.shapes[1])];
    if drawn.parts.iter().all(|parts| parts.len() <= 1) {
        let found = pair_separation(shapes, &drawn.second_from_first, size);
        let (found, found_normal) = found.unwrap();
        // A normal of the narrow phase that the oracle has missed is true as well.
        let along = drawn.along(found_normal);
        let size = size.max(gap);
        worst.see(0, (along - gap) / size, seed, 1e-6);
        gap = gap.max(along);
        // Of bodies apart a normal that is a little off separates large ones less than it should.
        let off = (found - along).abs().min((found - gap).abs());
        worst.see(1, off / size, seed, 1e-6);
        worst.see(2, (gap - found) / size, seed, 1e-6);
        let is_as_good = gap < 1e-3 * size && along > gap - 1e-7 * size;
        if !is_as_good {
            worst.see(3, found_normal.angle_between(normal), seed, 1e-3);
        }
    }
    let met = deepest(&drawn, &mut ManifoldFinder::default());
    match met {
        Some(met) if gap <= 0.0 => {
            worst.see(4, ((met.gap - gap).abs() + 0.43 * gap).max(0.0) / size, seed, 1e-3);
        }
        Some(_) if gap > 0.1 * size => {}
        Some(met) => worst.see(5, (met.gap - gap).abs() / size, seed, 1e-3),
        None => worst.see(6, (-gap / size).max(0.0), seed, 1e-6),
    }
}

fn run(count: u64) -> String {
    let mut report = String::new();
    for (at, &first) in KINDS.iter().enumerate() {
        for &second in &KINDS[at..] {
            if first == Kind::HalfSpace {
                continue;
            }
            let kinds = if second == Kind::Compound && first == Kind::HalfSpace {
                [second, first]
            } else {
                [first, second]
            };
            let mut worst = Worst::default();
            let start = std::time::Instant::now();
            for seed in 0..count {
                compare(kinds, seed, &mut worst);
            }
            let time = start.elapsed().as_secs_f64() / count as f64;
            write!(report, "{kinds:?} {:.0} us:", 1e6 * time).unwrap();
            for (name, ((value, seed), count)) in
                NAMES.iter().zip(worst.values.iter().zip(worst.counts))
            {
                write!(report, " {name} {value:.1e} ({count}, #{seed})").unwrap();
            }
            report.push('\n');
        }
    }
    report
}

#[test]
fn separations_are_those_of_the_oracle() {
    let count = std::env::var("ORACLE_PAIRS").map_or(300, |count| count.parse().unwrap());
    println!("{}", run(count));
}

#[test]
#[ignore]
fn show() {
    let of = |name: &str| std::env::var(name).unwrap();
    let kind = |name: &str| *KINDS.iter().find(|kind| format!("{kind:?}") == name).unwrap();
    let kinds = [kind(&of("A")), kind(&of("B"))];
    for seed in of("SEEDS").split(',') {
        let drawn = Draw::new(seed.parse().unwrap()).pair(kinds);
        println!(
            "{seed}: {:?}\n  {:?}\n  at {:?}",
            drawn.shapes[0].geometry, drawn.shapes[1].geometry, drawn.second_from_first
        );
        let (gap, normal) = drawn.truth();
        let size = drawn.size;
        println!(
            "  size {size} radii {} {} truth {gap} ({}) {normal}",
            drawn.shapes[0].radius(),
            drawn.shapes[1].radius(),
            gap / size
        );
        let shapes = [ConvexShape::of(&drawn.shapes[0]), ConvexShape::of(&drawn.shapes[1])];
        if let Some((found, n)) = pair_separation(shapes, &drawn.second_from_first, size) {
            println!(
                "  found {found} ({}) {n} along {} ({})",
                found / size,
                drawn.along(n),
                drawn.along(n) / size
            );
        }
        println!("  {:?}", deepest(&drawn, &mut ManifoldFinder::default()));
    }
}
