//! The same input gives the same bits: with every width of the solver, on any number of threads,
//! and from one version to the next unless we say so.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::bodies::StepSettings;
use frangible::math::Width;
use frangible::{SceneDesc, World, step};
use frangible_shots::{Shot, ShotOptions};
use std::fmt::Write;

/// Frames of each shot.
const FRAMES: u32 = 120;

/// Balls, boxes, pieces of boxes, heaps, what breaks on the grid, and as many bodies as threads are
/// worth while for.
const SHOTS: [&str; 6] = ["stack", "plank", "wall", "pillar", "cylinder", "bricks"];

fn scene(shot: &str) -> SceneDesc {
    Shot::find(shot).unwrap().scene(&ShotOptions::default()).unwrap()
}

/// A world after some frames.
fn after(scene: &SceneDesc, frames: u32, width: Width, threads: usize) -> World {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut world = World::build(scene).unwrap();
        let settings = StepSettings { width, ..*world.settings() };
        world.set_settings(settings).unwrap();
        for _ in 0..frames {
            step(&mut world);
        }
        world
    })
}

/// Each width on another number of threads.
const WAYS: [(Width, usize); 4] =
    [(Width::Scalar, 1), (Width::Sse2, 2), (Width::Avx2, 3), (Width::Avx512, 8)];

#[test]
fn every_width_on_any_number_of_threads_ends_in_the_recorded_state() {
    let mut states = String::new();
    for shot in SHOTS {
        let scene = scene(shot);
        let of = |(width, threads)| after(&scene, FRAMES, width, threads).state_hash();
        let [alone, others @ ..] = WAYS.map(of);
        for (other, (width, threads)) in others.into_iter().zip(&WAYS[1..]) {
            assert_eq!(other, alone, "{shot} with {width:?} on {threads} threads");
        }
        writeln!(states, "{shot} {alone:016x}").unwrap();
    }
    let recorded = include_str!("same_bits.txt");
    assert_eq!(
        states, recorded,
        "the states after {FRAMES} frames have changed. If the change is meant, say so in \
         CHANGELOG.md and put the new ones into crates/shots/tests/same_bits.txt"
    );
}

/// A heap is large enough to be halved, and its halves again, when each has more than 2,048 pairs:
/// threads take a half each, and meet at the pairs between them.
#[test]
fn a_heap_in_halves_ends_in_the_same_state() {
    let mut heap = scene("pile-spread");
    heap.bodies.truncate(8000);
    let alone = after(&heap, 24, Width::Avx512, 1);
    let pairs = alone.penetrations().len();
    assert!(pairs > 4 * 2048, "{pairs} of its pairs overlap");
    for threads in [2, 3, 8] {
        let shared = after(&heap, 24, Width::Avx512, threads);
        assert_eq!(shared.state_hash(), alone.state_hash(), "on {threads} threads");
    }
    assert_eq!(after(&heap, 24, Width::Sse2, 2).state_hash(), alone.state_hash(), "with SSE2");
}

/// What the playground simulates from a link is what this engine does.
#[test]
fn a_story_of_the_playground_ends_in_its_recorded_state() {
    let story: serde_json::Value =
        serde_json::from_str(include_str!("../../../web/test/story.json")).unwrap();
    let mut world =
        World::build(&SceneDesc::from_json(story["scene"].as_str().unwrap()).unwrap()).unwrap();
    let actions = story["actions"].as_array().unwrap();
    for frame in 0..story["frames"].as_u64().unwrap() {
        for action in actions.iter().filter(|action| action["frame"] == frame) {
            world.add_body(&frangible::read(action["add"].clone(), "add").unwrap()).unwrap();
        }
        step(&mut world);
    }
    assert!(world.bodies().len() > 20);
    let told = "web/test/story.json has another hash than";
    assert_eq!(story["hash"], format!("{:016x}", world.state_hash()), "{told}");
}

/// The same bodies sleep in the same frames.
#[test]
fn a_heap_that_may_sleep_ends_in_the_same_state() {
    const SLEEPING: u32 = 300;
    let mut heap = scene("pile-spread");
    heap.bodies.truncate(1000);
    heap.sleep = true;
    let alone = after(&heap, SLEEPING, Width::Avx512, 1);
    let asleep = alone.bodies().ids.iter().filter(|&&id| alone.is_asleep(id)).count();
    assert!(asleep > 100 && asleep < alone.bodies().len(), "{asleep}");
    for (width, threads) in [(Width::Sse2, 2), (Width::Scalar, 3), (Width::Avx2, 8)] {
        let same = after(&heap, SLEEPING, width, threads);
        assert_eq!(same.state_hash(), alone.state_hash(), "with {width:?} on {threads} threads");
    }
}
