//! The same input gives the same bits: with every width of the solver, and from one version to the next unless we say so.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::dynamics::Width;
use frangible::{World, step};
use frangible_shots::{Shot, ShotOptions};
use std::fmt::Write;

/// Frames of each shot.
const FRAMES: u32 = 300;

/// Balls, boxes, pieces of boxes, heaps, and what breaks on the grid.
const SHOTS: [&str; 5] = ["stack", "plank", "wall", "pillar", "cylinder"];

/// Of the world after the last frame.
fn state_hash(shot: &str, width: Width) -> u64 {
    let mut world = World::build(&Shot::find(shot).unwrap().scene(&ShotOptions::default()).unwrap()).unwrap();
    world.settings_mut().width = width;
    for _ in 0..FRAMES {
        step(&mut world);
    }
    world.state_hash()
}

#[test]
fn every_width_ends_in_the_same_state_and_that_is_the_recorded_one() {
    let mut states = String::new();
    for shot in SHOTS {
        let widest = state_hash(shot, Width::Avx512);
        for width in [Width::Scalar, Width::Sse2, Width::Avx2] {
            assert_eq!(state_hash(shot, width), widest, "{shot} with {width:?}");
        }
        writeln!(states, "{shot} {widest:016x}").unwrap();
    }
    let recorded = include_str!("same_bits.txt");
    assert_eq!(
        states, recorded,
        "the states after {FRAMES} frames have changed. If the change is meant, say so in CHANGELOG.md and put the new ones into \
         crates/shots/tests/same_bits.txt"
    );
}
