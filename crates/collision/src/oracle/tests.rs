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
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Compared quantities. All errors but the angle are relative to the smaller body's radius, or to the
/// distance if that is larger.
const NAMES: [&str; 7] = [
    // A normal of the narrow phase separates further than the oracle's best: the oracle's own error.
    "oracle",
    // The separation found is neither that along the normal found nor the true one.
    "untrue", // The true separation is larger than the one found.
    "worse",
    // Angle to the true normal, where no other one is as good within 1e-7 [rad].
    "normal",
    // The deepest point of a manifold of bodies that overlap, beyond what faces are preferred by.
    "overlap",
    // The nearest point of a manifold of bodies within a tenth of the size of each other.
    "apart", // Depth of overlaps without a manifold.
    "missed",
];

/// Largest errors. A manifold's normal may be as good within 5e-4 of the size
/// (`PREFERENCE`); the points of bodies that are apart are then as far beside the nearest ones as
/// that normal is off.
const LIMITS: [f64; 7] = [1e-6, 1e-6, 1e-6, 1e-3, 1e-3, 1e-2, 1e-6];

/// Overlap along a preferred face beyond the least one, relative to it: 0.3 / (1 - 0.3).
const PREFERRED: f64 = 0.43;

/// Worst errors of a pair of kinds, each with its seed, and how many are too large.
#[derive(Default)]
struct Worst {
    values: [(f64, u64); 7],
    counts: [usize; 7],
}

impl Worst {
    fn see(&mut self, which: usize, value: f64, seed: u64) {
        if value > self.values[which].0 || value.is_nan() {
            self.values[which] = (value, seed);
        }
        if value > LIMITS[which] || value.is_nan() {
            self.counts[which] += 1;
        }
    }

    fn report(&self) -> String {
        let all = NAMES.iter().zip(self.values).zip(self.counts);
        let parts = all.map(|((name, (value, seed)), count)| {
            let of = if value > 0.0 { format!(" #{seed}") } else { String::new() };
            let count = if count > 0 { format!(" ({count} too large)") } else { String::new() };
            format!("{name} {value:.1e}{of}{count}")
        });
        parts.collect::<Vec<_>>().join(", ")
    }
}

/// The deepest point of the manifold of two bodies at rest. Without gravity: with it, the points
/// are those of a touch later in the frame.
fn deepest(drawn: &Drawn) -> Option<ManifoldPoint> {
    let frame = Frame { dt: 1.0 / 30.0, gravity: DVec3::ZERO, settings: StepSettings::default() };
    let mut bodies = Bodies::default();
    let poses = [drawn.second_from_first, RigidTransform::IDENTITY];
    for (at, (shape, pose)) in drawn.shapes.iter().zip(poses).enumerate() {
        bodies.spawn(NewBody {
            shape: Arc::new(shape.clone()),
            density: 1000.0,
            motion: if at == 1 { Motion::Static } else { Motion::Dynamic },
            pose: Pose { position: pose.translation, orientation: pose.rotation },
            velocity: Velocity::default(),
            surface: SurfaceProperties::new(0.0, 0.5),
        });
    }
    let (pair, mut finder) = (Pair { first: 0, second: 1 }, ManifoldFinder::default());
    let manifold = finder.find(&bodies, pair, &ImpulseCache::default(), &frame)?;
    manifold.points.iter().copied().min_by(|a, b| a.gap.total_cmp(&b.gap))
}

fn compare(kinds: [Kind; 2], seed: u64, worst: &mut Worst) {
    let drawn = Draw::new(seed).pair(kinds);
    let size = drawn.size;
    let (mut gap, normal) = drawn.truth();
    let shapes = [ConvexShape::of(&drawn.shapes[0]), ConvexShape::of(&drawn.shapes[1])];
    let is_compound = drawn.parts.iter().any(|parts| parts.len() > 1);
    if !is_compound {
        let found = pair_separation(shapes, &drawn.second_from_first, size);
        let (found, found_normal) = found.unwrap();
        // A normal of the narrow phase that the oracle has missed is true as well.
        let along = drawn.along(found_normal);
        let size = size.max(gap);
        worst.see(0, (along - gap) / size, seed);
        gap = gap.max(along);
        // A normal that is a little off separates large bodies less than it should.
        let off = (found - along).abs().min((found - gap).abs());
        worst.see(1, off / size, seed);
        worst.see(2, (gap - found) / size, seed);
        let is_as_good = gap < 1e-3 * size && along > gap - 1e-7 * size;
        if !is_as_good {
            worst.see(3, found_normal.angle_between(normal), seed);
        }
    }
    match deepest(&drawn) {
        Some(met) if gap <= 0.0 => {
            // The way out of a part that leads into no other one may be longer.
            let off = if is_compound { met.gap - gap } else { (met.gap - gap).abs() };
            worst.see(4, (off + PREFERRED * gap).max(0.0) / size, seed);
        }
        Some(_) if gap > 0.1 * size => {}
        Some(met) => worst.see(5, (met.gap - gap).abs() / size, seed),
        None => worst.see(6, (-gap / size).max(0.0), seed),
    }
}

/// Every two kinds; a half-space is the second one.
fn all_kinds() -> impl Iterator<Item = [Kind; 2]> {
    let with = |at: usize| KINDS[at..].iter().map(move |&second| [KINDS[at], second]);
    (0..KINDS.len()).flat_map(with).filter_map(|kinds| match kinds {
        [Kind::HalfSpace, Kind::HalfSpace] => None,
        [Kind::HalfSpace, other] => Some([other, Kind::HalfSpace]),
        kinds => Some(kinds),
    })
}

/// Some pairs of each two kinds, hulls that are nearly none among them. Manifolds of compounds leave
/// out shallow points that neighbouring parts cover.
#[test]
fn separations_are_those_of_the_oracle() {
    for kinds in all_kinds() {
        let mut worst = Worst::default();
        (0..40).for_each(|seed| compare(kinds, seed, &mut worst));
        assert!(worst.counts.iter().all(|&count| count == 0), "{kinds:?}: {}", worst.report());
    }
}

/// Pairs that failed once.
#[test]
fn what_the_narrow_phase_missed_it_finds() {
    use Kind::*;
    for (kinds, seed) in [
        // Touching, and taken as apart by 1e-5 of the size: one body is ten thousand times larger.
        ([Hull, Cylinder], 75),
        ([Cylinder, Cylinder], 1296),
        ([Cone, Cone], 1315),
        ([Box, Cone], 1424),
        // A rim deep in a sliver, whose faces look in opposite directions.
        ([Hull, Cylinder], 1676),
        ([Hull, Cone], 1495),
        // Hulls with nearly coplanar faces, none of them over the other body.
        ([Hull, Hull], 620),
        ([Hull, Hull], 2829),
        // Apart, with points that overlapped, or that were further away.
        ([Box, Hull], 836),
        ([Box, Hull], 1560),
        ([Hull, Hull], 1365),
        ([Hull, Hull], 2600),
        ([Hull, Hull], 3532),
        ([Box, Box], 216),
        ([Box, Box], 2092),
        // A rim of a cylinder of 18 m, its other points out of reach.
        ([Cylinder, Cone], 1953),
        // A side nearly parallel to an edge.
        ([Box, Capsule], 1_384_729),
        ([Hull, Capsule], 1_192_900),
        ([Hull, Cylinder], 1_032_384),
        ([Box, Cylinder], 1_122_232),
        // Deep inside of a compound.
        ([Compound, Compound], 121),
        // Below a seam, and over none of its faces.
        ([Box, Compound], 1_001_027),
        ([Hull, Compound], 9_005_210),
        // Nearly parallel edges, one ten thousand times as long: triangles whose normal is rounding.
        ([Box, Box], 9_044_494),
        ([Box, Box], 9_082_383),
        ([Box, Box], 9_173_557),
        ([Box, Capsule], 9_103_003),
        ([Box, Capsule], 9_164_680),
        // Apart by a millionth of the size: the way between corners so far away is rounding.
        ([Box, Box], 9_007_397),
        ([Box, Box], 9_136_883),
        ([Box, Box], 9_158_257),
        ([Box, Capsule], 9_093_392),
        // A distance that rounding holds while its normal still turns.
        ([Cylinder, Capsule], 9_081_118),
        ([Hull, Capsule], 9_022_944),
        // The deepest point on a long edge that rises from it.
        ([Hull, Cylinder], 9_003_759),
        ([Hull, Cylinder], 9_001_959),
        ([Hull, Capsule], 9_003_759),
        ([Hull, Cone], 9_003_759),
        ([Box, Capsule], 9_382_971),
        ([Box, Capsule], 9_856_476),
        ([Box, Cone], 9_005_394),
        // Hulls with merged faces beside thin triangles.
        ([Ball, Hull], 9_090_360),
        ([Ball, Hull], 9_149_348),
        ([Hull, Hull], 9_019_726),
        // An edge of a sliver, taken as overlapping its face.
        ([Box, Hull], 9_003_370),
        // Touching, and the search for closest points ended on a corner that it knew.
        ([Box, Cone], 20_088_148),
        ([Box, Cone], 20_773_678),
        // The least overlap in another valley than the six best of 160 directions.
        ([Cone, Cone], 20_009_781),
        ([Cone, Cone], 20_019_448),
        ([Cylinder, Cone], 20_018_488),
        // The oracle itself: a centre on a capsule's axis, and a rim on an edge.
        ([Ball, Capsule], 9_005_266),
        ([Box, Cone], 9_009_301),
    ] {
        let mut worst = Worst::default();
        compare(kinds, seed, &mut worst);
        assert!(
            worst.counts.iter().all(|&count| count == 0),
            "{kinds:?} #{seed}: {}",
            worst.report()
        );
    }
}

/// A million pairs of every two kinds, or as many as `ORACLE_PAIRS` says, or as are done in
/// `ORACLE_SECONDS` each, or of the kinds in `ORACLE_ONLY` (`[Box, Hull]`); prints the seeds of pairs
/// with too large errors, and the worst errors. `make oracle` runs it.
#[test]
#[ignore = "takes hours"]
fn a_million_pairs() {
    let of = |name: &str, or: u64| std::env::var(name).map_or(or, |value| value.parse().unwrap());
    let (count, seconds) = (of("ORACLE_PAIRS", 1_000_000), of("ORACLE_SECONDS", u64::MAX));
    // Other pairs than the test that always runs.
    let first = of("ORACLE_FIRST", 1_000_000);
    let only = std::env::var("ORACLE_ONLY").unwrap_or_default();
    for kinds in all_kinds().filter(|kinds| format!("{kinds:?}").contains(&only)) {
        let (mut worst, start, mut done) = (Worst::default(), Instant::now(), 0);
        while done < count && start.elapsed() < Duration::from_secs(seconds) {
            let before = worst.counts;
            compare(kinds, first + done, &mut worst);
            let is_worse = |&at: &usize| before[at] != worst.counts[at];
            let which: Vec<&str> = (0..7).filter(is_worse).map(|at| NAMES[at]).collect();
            if !which.is_empty() {
                println!("{kinds:?} #{}: {}", first + done, which.join(", "));
            }
            done += 1;
        }
        let time = 1e6 * start.elapsed().as_secs_f64() / done as f64;
        println!("{kinds:?}: {done} pairs, {time:.0} us each: {}", worst.report());
    }
}
