//! Every claim holds; one test for each, so that they run side by side.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible_shots::claims::{CLAIMS, Claim};

fn holds(name: &str) {
    let findings = Claim::find(name).unwrap().check();
    assert!(findings.iter().any(|finding| finding.is_bounded()), "{name} can fail");
    for finding in &findings {
        println!("{finding:?}");
    }
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
    holds("random-scenes");
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
fn pillar_spread() {
    holds("pillar-spread");
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
fn each_claim_has_its_test() {
    for claim in CLAIMS {
        let call = format!("    holds(\"{}\");", claim.name);
        assert!(include_str!("claims.rs").contains(&call), "{} is not tested", claim.name);
    }
}

#[test]
fn a_claim_that_nobody_made_is_named() {
    let error = Claim::find("perpetual-motion").unwrap_err().to_string();
    assert!(error.starts_with("unknown claim 'perpetual-motion', must be one of: "), "{error}");
}
