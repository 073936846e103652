//! Structures that stand by shape and friction, and fall without.

use super::scenes::ball;
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use crate::scenes::arch::{FRICTION as STONE, arch};
use crate::scenes::card_house::{FRICTION as PAPER, card_house};
use crate::scenes::towers::{LOAD_RATIO, load, pyramid, tower, with_company};
use frangible::{BodyDesc, SceneDesc, World};
use glam::DVec3;

/// Up.
pub(super) const TOWERS: Claim = Claim {
    name: "towers",
    says: "towers of 10, 20 and 50 cubes and a pyramid of 210 stand for 10 s at 30 frames per second",
    source: "mechanics",
    measure: towers,
};

/// A thousandfold.
pub(super) const LOAD: Claim = Claim {
    name: "load",
    says: "ten cubes bear one that is a thousand times as heavy as each of them for 10 s",
    source: "mechanics",
    measure: loads,
};

/// Or alone.
pub(super) const COMPANY: Claim = Claim {
    name: "company",
    says: "a tower and a load on a slab that can move stand alike whether 300 cubes stand elsewhere on it or none",
    source: "mechanics",
    measure: companies,
};

/// Of stones.
pub(super) const ARCH: Claim = Claim {
    name: "arch",
    says: "an arch of 15 loose stones stands for 10 s, and falls if they are smooth",
    source: "[Hey66]",
    measure: || of_friction("arch", arch, STONE, 0.1),
};

/// Of cards.
pub(super) const CARD_HOUSE: Claim = Claim {
    name: "card-house",
    says: "a house of 40 cards stands for 10 s, and falls if they are smooth or a ball strikes it",
    source: "mechanics",
    measure: card_houses,
};

/// Maximum drift of a standing body in 10 s [m].
const MOST_DRIFT: f64 = 0.02;

/// Maximum sway of the highest tower, of 25 m, and maximum settlement of loaded or jointed
/// structures [m].
const MOST_SWAY: f64 = 0.1;

/// Duration [frames].
const FRAMES: u32 = 300;

/// The largest way of any body [m], and the largest sinking of any [m].
fn drift(scene: &SceneDesc) -> Result<[f64; 2], Obstacle> {
    let mut world = World::build(scene)?;
    let start = world.bodies().poses.clone();
    for _ in 0..FRAMES {
        step(&mut world);
    }
    let moves = || -> Vec<DVec3> {
        world
            .bodies()
            .poses
            .iter()
            .zip(&start)
            .map(|(now, then)| now.position - then.position)
            .collect()
    };
    Ok([largest(moves().iter().map(|by| by.length())), largest(moves().iter().map(|by| -by.y))])
}

fn stands(name: &str, scene: &SceneDesc, most: f64) -> Result<[Finding; 2], Obstacle> {
    let [moved, sunk] = drift(scene)?;
    Ok([
        Finding::at_most(format!("largest drift of {name}"), "m", moved, most),
        Finding::beside(format!("of this, downward, of {name}"), "m", sunk),
    ])
}

fn towers() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (count, most) in [(10, MOST_DRIFT), (20, MOST_DRIFT), (50, MOST_SWAY)] {
        findings.extend(stands(&format!("a tower of {count}"), &tower(count), most)?);
    }
    findings.extend(stands("a pyramid", &pyramid(), MOST_DRIFT)?);
    Ok(findings)
}

fn loads() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for ratio in [10.0, LOAD_RATIO] {
        findings.extend(stands(
            &format!("a stack under a load of {ratio}"),
            &load(ratio),
            MOST_SWAY,
        )?);
    }
    Ok(findings)
}

/// Maximum influence of 300 distant cubes on a drift [m].
const MOST_CHANGE: f64 = 1e-3;

fn companies() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    let stand = [
        ("a tower of 20", tower(20)),
        ("a stack under a load of 100", load(100.0)),
        ("a stack under a load of 1000", load(LOAD_RATIO)),
    ];
    for (name, scene) in stand {
        let mut drifts = [0.0; 2];
        for (drift, company) in drifts.iter_mut().zip([0, 300]) {
            let count = scene.bodies.len();
            let mut world = World::build(&with_company(scene.clone(), company))?;
            let start = positions(&world, count);
            for _ in 0..FRAMES {
                step(&mut world);
            }
            let ways = positions(&world, count).into_iter().zip(&start);
            *drift = largest(ways.map(|(now, then)| now.distance(*then)));
        }
        let [alone, in_company] = drifts;
        let quantity = format!("largest drift of {name} beside 300 cubes");
        findings.push(Finding::at_most(quantity, "m", in_company, MOST_SWAY));
        let quantity = format!("the same less that of {name} alone");
        findings.push(Finding::at_most(quantity, "m", (in_company - alone).abs(), MOST_CHANGE));
    }
    Ok(findings)
}

/// Of the first bodies [m].
fn positions(world: &World, count: usize) -> Vec<DVec3> {
    world.bodies().poses[..count].iter().map(|pose| pose.position).collect()
}

fn card_houses() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = stands("a house of cards", &card_house(PAPER), MOST_DRIFT)?.to_vec();
    let [moved, _] = drift(&card_house(0.1))?;
    findings.push(Finding::at_least("the same with friction 0.1", "m", moved, 5.0 * MOST_SWAY));

    // Of a few kilograms, at a card of the lowest storey; how far the cards got.
    let mut scene = card_house(PAPER);
    let cards = scene.bodies.len();
    scene.bodies.push(BodyDesc {
        position: [-3.0, 0.25, 0.0],
        linear_velocity: [8.0, 0.0, 0.0],
        density: 7800.0,
        ..BodyDesc::new("ball", ball(0.05))
    });
    let mut struck = World::build(&scene)?;
    let start = positions(&struck, cards);
    for _ in 0..FRAMES {
        step(&mut struck);
    }
    let moved = largest(
        positions(&struck, cards).iter().zip(&start).map(|(now, then)| now.distance(*then)),
    );
    findings.push(Finding::at_least("the same, struck by a ball", "m", moved, 5.0 * MOST_SWAY));
    Ok(findings)
}

fn of_friction(
    name: &str,
    build: fn(f64) -> SceneDesc,
    rough: f64,
    smooth: f64,
) -> Result<Vec<Finding>, Obstacle> {
    let mut findings = stands(name, &build(rough), MOST_SWAY)?.to_vec();
    let [moved, _] = drift(&build(smooth))?;
    let quantity = format!("the same with friction {smooth} instead of {rough}");
    findings.push(Finding::at_least(quantity, "m", moved, 5.0 * MOST_SWAY));
    Ok(findings)
}
