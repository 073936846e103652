//! Walls of loose bricks, untouched and struck.

use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use crate::scenes::bricks::{WALL, Wall};
use crate::shot::{Shot, ShotOptions};
use frangible::{SceneDesc, World};
use glam::DVec3;

/// Nobody touches them.
pub(super) const STILL: Claim = Claim {
    name: "walls",
    says: "walls of loose bricks, cubes, blocks and tiles stand for 20 s at 30 frames per second",
    source: "mechanics",
    measure: || walls(&LOW),
};

/// Twenty times as high as thick, and more.
pub(super) const HIGH: Claim = Claim {
    name: "high-walls",
    says: "walls of loose bricks of 2.7 and 3.3 m stand for 20 s at 30 frames per second",
    source: "mechanics",
    measure: || walls(&HIGH_WALLS),
};

/// The shot's.
pub(super) const STRUCK: Claim = Claim {
    name: "wall-of-1000",
    says: "a wall of 1000 loose bricks stands for 20 s, and ten balls leave of it what they leave at 3000 steps per second",
    source: "mechanics",
    measure: shots_wall,
};

/// One wall per proportion of bricks.
const LOW: [Wall; 5] = [
    Wall { brick: WALL.brick, courses: 13, count: 20, closed: true },
    Wall { brick: [0.2; 3], courses: 11, count: 12, closed: true },
    Wall { brick: [0.6, 0.3, 0.3], courses: 9, count: 10, closed: true },
    Wall { brick: [0.3, 0.02, 0.15], courses: 21, count: 10, closed: true },
    Wall { brick: WALL.brick, courses: 31, count: 4, closed: true },
];

const HIGH_WALLS: [Wall; 2] = [
    Wall { brick: WALL.brick, courses: 41, count: 8, closed: true },
    Wall { brick: WALL.brick, courses: 51, count: 20, closed: true },
];

/// Duration of an untouched wall's test [s].
const STANDS: f64 = 20.0;

/// Maximum drift of a brick in a standing wall [m].
const MOST_MOVED: f64 = 0.01;

/// Until the ball's bricks lie [s].
const FALL: f64 = 5.0;

/// Each strikes elsewhere along the wall.
const BALLS: f64 = 10.0;

/// Tolerance of the remains.
const FEW: f64 = 0.1;

/// Remains after ten balls at 3000 steps per second, recorded by `examples/struck_walls.rs`.
const RECORDED: &str = include_str!("../../../../bench/results/walls.csv");

/// State of a wall at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallState {
    /// Median height of the bricks' centres [m].
    pub median: f64,
    /// Mean height [m].
    pub mean: f64,
    /// Fraction of bricks within half their height of their start.
    pub standing: f64,
    /// The largest way of a brick at any time [m].
    pub moved: f64,
}

/// Runs a scene whose first bodies are the ground and `count` bricks.
fn state_of(scene: &SceneDesc, count: usize, seconds: f64) -> Result<WallState, Obstacle> {
    let mut world = World::build(scene)?;
    let bricks = |world: &World| -> Vec<DVec3> {
        world.bodies().poses[1..=count].iter().map(|pose| pose.position).collect()
    };
    let start = bricks(&world);
    let ways = |world: &World| -> Vec<f64> {
        bricks(world).iter().zip(&start).map(|(now, then)| now.distance(*then)).collect()
    };
    let mut moved = 0.0;
    for _ in 0..(seconds * scene.frames_per_second).round() as u32 {
        step(&mut world);
        moved = largest(ways(&world).into_iter().chain([moved]));
    }
    let mut heights: Vec<f64> = bricks(&world).iter().map(|place| place.y).collect();
    heights.sort_by(f64::total_cmp);
    let standing = ways(&world).iter().filter(|&&way| way < 0.5 * WALL.brick[1]).count();
    Ok(WallState {
        median: heights[count / 2],
        mean: heights.iter().sum::<f64>() / count as f64,
        standing: standing as f64 / count as f64,
        moved,
    })
}

/// State of the shot's wall after the ball of a seed.
///
/// # Errors
/// If its scene cannot be built.
pub fn struck_wall(options: &ShotOptions) -> Result<WallState, Obstacle> {
    state_of(&Shot::find("bricks")?.scene(options)?, WALL.courses * WALL.count, FALL)
}

/// An untouched wall's largest way, and its fall in the median.
fn still(wall: &Wall) -> Result<[Finding; 2], Obstacle> {
    let scene = wall.scene();
    let state = state_of(&scene, scene.bodies.len() - 1, STANDS)?;
    let [length, height, thickness] = wall.brick;
    let of = format!(
        "a wall of {} x {} bricks of {length} x {height} x {thickness} m",
        wall.courses, wall.count
    );
    let fall = 0.5 * wall.courses as f64 * height - state.median;
    Ok([
        Finding::at_most(format!("largest way of a brick in {of}"), "m", state.moved, MOST_MOVED),
        Finding::at_most(format!("median fall of {of}"), "m", fall, MOST_MOVED),
    ])
}

fn walls(walls: &[Wall]) -> Result<Vec<Finding>, Obstacle> {
    Ok(walls.iter().map(still).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Seeds of the balls, and for each the median height, the mean height and the standing share of
/// what it left at 3000 steps.
fn recorded() -> Vec<(u64, [f64; 3])> {
    let row = |row: &str| {
        let mut values = row.strip_prefix("3000,")?.split(',');
        let seed = values.next()?.parse().ok()?;
        let mut next = || values.next()?.parse().ok();
        Some((seed, [next()?, next()?, next()?]))
    };
    RECORDED.lines().filter_map(row).collect()
}

fn shots_wall() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = still(&WALL)?.to_vec();
    let (seeds, fine): (Vec<u64>, Vec<[f64; 3]>) = recorded().into_iter().unzip();
    let left = seeds
        .iter()
        .map(|&seed| struck_wall(&ShotOptions { seed, ..ShotOptions::default() }))
        .map(|wall| wall.map(|wall| [wall.median, wall.mean, wall.standing]))
        .collect::<Result<Vec<_>, _>>()?;
    let mean = |walls: &[[f64; 3]], of: usize| {
        walls.iter().map(|wall| wall[of]).sum::<f64>() / walls.len() as f64
    };
    findings.push(Finding::at_least("number of balls recorded", "1", left.len() as f64, BALLS));
    let quantities =
        [("median height", FEW), ("mean height", FEW), ("standing share", f64::INFINITY)];
    for (of, (name, few)) in quantities.into_iter().enumerate() {
        let ratio = mean(&left, of) / mean(&fine, of);
        let quantity = format!("{name} of what the balls left per that at 3000 steps per second");
        findings.push(Finding::between(quantity, "1", ratio, 1.0 - few, 1.0 + few));
    }
    Ok(findings)
}
