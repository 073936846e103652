//! Every claim holds; one test for each, so that they run side by side.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible_shots::ShotOptions;
use frangible_shots::claims::{CLAIMS, Claim, Spread, pillar_spread as pillar_spread_of};

fn holds(name: &str) {
    holds_but_for(name, &[]);
}

/// All findings of a claim hold, except quantities listed in `not_yet`, the known limits of
/// `docs/limits.md`.
fn holds_but_for(name: &str, not_yet: &[&str]) {
    let findings = Claim::find(name).unwrap().check();
    for finding in &findings {
        println!("{finding:?}");
    }
    let held = |quantity: &str| !not_yet.iter().any(|part| quantity.contains(part));
    let findings: Vec<_> = findings.iter().filter(|found| held(&found.quantity)).collect();
    assert!(findings.iter().any(|finding| finding.is_bounded()), "{name} can fail");
    assert!(findings.iter().all(|finding| finding.holds()), "{findings:#?}");
}

#[test]
fn exact_rotation() {
    holds("exact-rotation");
}

#[test]
fn million_rotations() {
    holds("million-rotations");
}

#[test]
fn flip_period() {
    holds("flip-period");
}

#[test]
fn rotation_cost() {
    holds("rotation-cost");
}

#[test]
fn free_box() {
    holds("free-box");
}

#[test]
fn top() {
    holds("top");
}

#[test]
fn random_scenes() {
    holds_but_for("random-scenes", &["largest cause"]);
}

#[test]
fn all_shots() {
    holds("all-shots");
}

#[test]
fn safeguards() {
    holds("safeguards");
}

#[test]
#[ignore = "minutes of one core: `frangible verify` measures it; the next one is its short form"]
fn pillar_spread() {
    holds("pillar-spread");
}

/// Findings at 3000 steps per second, recorded by `examples/pillar_spread.rs`, still bound the
/// findings at 30.
#[test]
fn pillar_spreads_as_recorded() {
    let recorded: Vec<Vec<f64>> = include_str!("../../../bench/results/pillar.csv")
        .lines()
        .filter_map(|row| row.strip_prefix("frame-rate,3000,on,"))
        .map(|row| row.split(',').map(|value| value.parse().unwrap()).collect())
        .collect();
    assert_eq!(recorded.len(), 10);
    let fine = |column: usize| recorded.iter().map(|row| row[column]).sum::<f64>() / 10.0;
    let coarse: Vec<_> = (0..10)
        .map(|seed| pillar_spread_of(&ShotOptions { seed, ..ShotOptions::default() }).unwrap())
        .collect();
    let mean = |value: fn(&Spread) -> f64| coarse.iter().map(value).sum::<f64>() / 10.0;
    let [middle, p95] = [mean(|spread| spread.mean) / fine(1), mean(|spread| spread.p95) / fine(2)];
    assert!((middle - 1.0).abs() < 0.15 && (p95 - 1.0).abs() < 0.15, "{middle}, {p95}");
    let [highest, rise] = [mean(|spread| spread.highest) - fine(3), mean(|spread| spread.rise)];
    assert!(highest.abs() < 0.6 && rise < 0.1, "{highest} m, {rise} m");
}

#[test]
#[ignore = "minutes of one core: `frangible verify` measures it; the safeguards' claim has one of its pillars"]
fn pillar_uncorrected() {
    holds("pillar-uncorrected");
}

#[test]
fn incline() {
    holds("incline");
}

#[test]
fn bounces() {
    holds("bounces");
}

#[test]
fn stack() {
    holds("stack");
}

#[test]
fn zigzag_stack() {
    holds("zigzag-stack");
}

#[test]
fn elevator() {
    holds("elevator");
}

#[test]
fn turntable() {
    holds("turntable");
}

#[test]
fn conveyor() {
    holds("conveyor");
}

#[test]
fn swarm() {
    holds("swarm");
}

#[test]
fn settled_pile() {
    holds("settled-pile");
}

#[test]
fn lossless() {
    holds("lossless");
}

#[test]
fn rolling() {
    holds("rolling");
}

#[test]
fn rolling_friction() {
    holds("rolling-friction");
}

#[test]
fn towers() {
    holds("towers");
}

#[test]
fn arch() {
    holds("arch");
}

#[test]
fn slab() {
    holds("slab");
}

#[test]
fn plate() {
    holds("plate");
}

#[test]
fn nut() {
    holds("nut");
}

#[test]
fn cradle() {
    holds("cradle");
}

#[test]
fn card_house() {
    holds("card-house");
}

#[test]
fn load() {
    holds("load");
}

#[test]
fn each_claim_has_its_test() {
    let tests: String = include_str!("claims.rs").split_whitespace().collect();
    for claim in CLAIMS {
        let calls = ["holds", "holds_but_for"].map(|call| format!("{call}(\"{}\"", claim.name));
        assert!(calls.iter().any(|call| tests.contains(call)), "{} is not tested", claim.name);
    }
}

#[test]
fn a_claim_that_nobody_made_is_named() {
    let error = Claim::find("perpetual-motion").unwrap_err().to_string();
    assert!(error.starts_with("unknown claim 'perpetual-motion', must be one of: "), "{error}");
}

#[test]
#[ignore = "a minute of one core: `frangible verify` measures it; `settled_pile` has a heap too"]
fn heap() {
    holds("heap");
}

#[test]
fn walls() {
    holds("walls");
}

#[test]
#[ignore = "a minute of one core: `frangible verify` measures it"]
fn high_walls() {
    holds_but_for("high-walls", &["41 x 8", "51 x 20"]);
}

#[test]
#[ignore = "a minute of one core: `frangible verify` measures it"]
fn wall_of_1000() {
    holds_but_for("wall-of-1000", &["largest way of a brick in a wall of 25", "number of balls"]);
}

#[test]
fn debris() {
    holds_but_for(
        "debris",
        &[
            "ratio 300 and 1000",
            "largest overlap per size, 4 of cube",
            "largest overlap per size, 4 of ball",
            "largest overlap per size, 4 of hull",
        ],
    );
}

#[test]
fn starts_inside() {
    holds("starts-inside");
}

#[test]
fn round_stacks() {
    holds_but_for("round-stacks", &["8 cylinders of radius 0.25", "8 prisms of 32 sides"]);
}

#[test]
fn rows() {
    holds("rows");
}

#[test]
fn rooms() {
    holds("rooms");
}

#[test]
fn toppling_breaks() {
    holds("toppling-breaks");
}

#[test]
fn sliding_breaks() {
    holds("sliding-breaks");
}

#[test]
fn rolling_stays_whole() {
    holds("rolling-stays-whole");
}

#[test]
fn one_piece_is_no_break() {
    holds("one-piece-is-no-break");
}

#[test]
fn blows_pass_through() {
    holds("blows-pass-through");
}

#[test]
#[ignore = "a minute of one core: `frangible verify` measures it"]
fn company() {
    holds("company");
}
