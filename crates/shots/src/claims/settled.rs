//! Where nothing is wrong, the ledger has nothing to do.

use super::scenes::{METHODS, cube, run, world};
use super::{Claim, Finding, Obstacle};
use frangible::{BodyDesc, step};

/// A heap at rest.
pub(super) const SETTLED_PILE: Claim = Claim {
    name: "settled-pile",
    says: "in a settled pile fewer than 1 % of the islands have to be balanced",
    source: "docs/adr/009",
    measure: settled_pile,
};

fn settled_pile() -> Result<Vec<Finding>, Obstacle> {
    let mut bodies = vec![BodyDesc::ground(0.0)];
    for i in 0..30 {
        let [x, y, z] = [i % 3, i / 9, i / 3 % 3].map(f64::from);
        let position = [0.8 * x + 0.1 * y, 0.6 + 1.2 * y, 0.8 * z - 0.1 * y];
        bodies.push(BodyDesc { position, angular_velocity: [x, y, z], ..BodyDesc::new("cube", cube(0.6)) });
    }
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let mut world = world(method, bodies.clone())?;
        run(&mut world, 300);
        let (mut islands, mut scaled) = (0, 0);
        for _ in 0..150 {
            let balance = step(&mut world).balance;
            islands += balance.islands;
            scaled += balance.scaled;
        }
        let share = scaled as f64 / islands as f64;
        findings.push(Finding::at_most(format!("share of islands balanced, {name}"), "1", share, 0.01));
    }
    Ok(findings)
}
