//! Every claim holds.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible_shots::claims::{CLAIMS, Claim};

/// One test for each claim, so that they run side by side.
macro_rules! claims {
    ($($name:ident),* $(,)?) => {
        $(#[test]
        fn $name() {
            holds(&stringify!($name).replace('_', "-"));
        })*

        #[test]
        fn each_claim_has_its_test() {
            let tested = [$(stringify!($name)),*].map(|name| name.replace('_', "-"));
            assert_eq!(tested.to_vec(), CLAIMS.iter().map(|claim| claim.name).collect::<Vec<_>>());
        }
    };
}

claims![random_scenes, safeguards, incline, bounces, stack, zigzag_stack, elevator, swarm, settled_pile,];

fn holds(name: &str) {
    let findings = Claim::find(name).unwrap().check();
    assert!(findings.iter().any(|finding| finding.is_bounded()), "{name} can fail");
    for finding in &findings {
        println!("{finding:?}");
    }
    assert!(findings.iter().all(|finding| finding.holds()), "{findings:#?}");
}

#[test]
fn a_claim_that_nobody_made_is_named() {
    let error = Claim::find("perpetual-motion").unwrap_err().to_string();
    assert!(
        error.starts_with("unknown claim 'perpetual-motion', must be one of: random-scenes, "),
        "{error}"
    );
}
