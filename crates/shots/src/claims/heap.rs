//! Final shapes of heaps.

use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle};
use crate::scenes::piles::pile;
use crate::shot::ShotOptions;
use frangible::World;

/// Rubble in a pit.
pub(super) const HEAP: Claim = Claim {
    name: "heap",
    says: "rubble that falls into a pit comes to lie as high as in fine steps, and does not hang in the air on its way",
    source: "docs/adr/010",
    measure: measured,
};

/// Pieces along, up and across: of more pairs than are solved with care, and of less.
const HEAPS: [[usize; 3]; 2] = [[8, 9, 8], [7, 7, 7]];

/// Number of heaps in the mean of the largest rise: late topples are random.
const SEEDS: u64 = 8;

/// Number of heaps in the comparison of mean heights with fine steps: a single heap varies from 1 %
/// lower to 5 % higher, by whether a piece rests on others or rolls off.
const COMPARED: u64 = 3;

/// Their mean is no more than this [m]. It is 0.02 mm; where what is jammed was parted by turns
/// along a face and across edges, it was 0.13, and with one stage of impulses between two drifts,
/// instead of two, heaps rose by 0.4.
const MOST_RISE: f64 = 6e-5;

/// Settling time [s].
const FALL: f64 = 3.0;

/// Final state of a heap.
struct Fallen {
    /// Mean of its pieces [m].
    height: f64,
    /// The most that it rose by in a frame of the second half of that time, in which nothing but
    /// small pieces still bounces [m].
    rise: f64,
    /// Of all islands in all frames, those whose velocities the ledger scaled down.
    scaled: f64,
}

fn fallen(counts: [usize; 3], seed: u64, frames_per_second: f64) -> Result<Fallen, Obstacle> {
    let mut scene = pile(counts, true, &ShotOptions { seed, ..ShotOptions::default() })?;
    scene.frames_per_second = frames_per_second;
    let mut world = World::build(&scene)?;
    let (mut islands, mut scaled, mut rise) = (0, 0, 0.0_f64);
    let frames = (FALL * frames_per_second) as u32;
    for frame in 0..frames {
        let before = mean_height(&world);
        let balance = step(&mut world).balance;
        islands += balance.islands;
        scaled += balance.scaled;
        if 2 * frame > frames {
            rise = rise.max(mean_height(&world) - before);
        }
    }
    Ok(Fallen { height: mean_height(&world), rise, scaled: scaled as f64 / islands as f64 })
}

/// Of all pieces [m].
fn mean_height(world: &World) -> f64 {
    let bodies = world.bodies();
    let pieces = (0..bodies.len()).filter(|&i| !bodies.inertias[i].is_infinite());
    let heights: Vec<f64> = pieces.map(|i| bodies.poses[i].position.y).collect();
    heights.iter().sum::<f64>() / heights.len() as f64
}

fn measured() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for counts in HEAPS {
        let heaps =
            (0..SEEDS).map(|seed| fallen(counts, seed, 30.0)).collect::<Result<Vec<_>, _>>()?;
        let fine =
            (0..COMPARED).map(|seed| fallen(counts, seed, 300.0)).collect::<Result<Vec<_>, _>>()?;
        let of = format!("{} pieces", counts.iter().product::<usize>());
        let quantity =
            format!("height of {of} per that at 300 frames per second, mean of {COMPARED} heaps");
        let height = |heaps: &[Fallen]| heaps.iter().map(|heap| heap.height).sum::<f64>();
        let ratio = height(&heaps[..COMPARED as usize]) / height(&fine);
        findings.push(Finding::between(quantity, "1", ratio, 0.97, 1.03));
        let quantity =
            format!("largest rise of {of} in a frame when they lie, mean of {SEEDS} heaps");
        let rise = heaps.iter().map(|heap| heap.rise).sum::<f64>() / SEEDS as f64;
        findings.push(Finding::at_most(quantity, "m", rise, MOST_RISE));
        let quantity = format!("share of islands whose motion was scaled down, {of}");
        let scaled = heaps.iter().map(|heap| heap.scaled).fold(0.0, f64::max);
        findings.push(Finding::at_most(quantity, "1", scaled, 1e-2));
    }
    Ok(findings)
}
