//! Claims of the paper and of this engine, measured: one source for the tests and for `frangible
//! verify`.
//!
//! A claim builds its own small scenes, runs them and returns findings. Findings without bounds are
//! for information.

mod blows;
mod bounce;
mod carried;
mod claim;
mod cradle;
mod debris;
mod energy;
mod fitting;
mod flight;
mod heap;
mod incline;
mod inside;
mod pillar;
mod random_scene;
mod rolling;
mod rooms;
mod rotation;
mod scenes;
mod settled;
mod stacks;
mod standing;
mod swarm;
mod top;
mod walls;
mod watch;

pub use claim::{Claim, Finding, Obstacle, UnknownClaim};
pub use pillar::{Spread, pillar_spread};
pub use walls::{WallState, struck_wall};

/// All claims.
pub const CLAIMS: &[Claim] = &[
    rotation::EXACT,
    rotation::MILLION,
    rotation::FLIP,
    rotation::COST,
    flight::FREE_BOX,
    top::TOP,
    energy::RANDOM_SCENES,
    energy::ALL_SHOTS,
    energy::SAFEGUARDS,
    pillar::SPREAD,
    pillar::UNCORRECTED,
    incline::INCLINE,
    bounce::BOUNCES,
    stacks::STACK,
    stacks::ZIGZAG,
    stacks::ROUND,
    carried::ELEVATOR,
    carried::TURNTABLE,
    carried::CONVEYOR,
    swarm::SWARM,
    settled::SETTLED_PILE,
    heap::HEAP,
    settled::LOSSLESS,
    rolling::ROLLING,
    rolling::ROLLING_FRICTION,
    standing::TOWERS,
    standing::ARCH,
    standing::LOAD,
    standing::COMPANY,
    fitting::SLAB,
    fitting::PLATE,
    fitting::NUT,
    cradle::CRADLE,
    cradle::ROWS,
    standing::CARD_HOUSE,
    walls::STILL,
    walls::HIGH,
    walls::STRUCK,
    debris::DEBRIS,
    inside::INSIDE,
    rooms::ROOMS,
    blows::TOPPLES,
    blows::SLIDES,
    blows::ROLLS,
    blows::ONE_PIECE,
    blows::THROUGH,
];

impl Claim {
    /// The claim of a name.
    ///
    /// # Errors
    /// If there is none.
    pub fn find(name: &str) -> Result<&'static Self, UnknownClaim> {
        let known = || {
            let names: Vec<&str> = CLAIMS.iter().map(|claim| claim.name).collect();
            names.join(", ") + &frangible::nearest(name, &names)
        };
        CLAIMS
            .iter()
            .find(|claim| claim.name == name)
            .ok_or_else(|| UnknownClaim { name: name.into(), known: known() })
    }

    /// Runs its scenes and says what it found, and how large a cause of a change of energy became
    /// in a frame. A scene that cannot be set up is a finding that does not hold.
    pub fn check(&self) -> Vec<Finding> {
        let mut findings = (self.measure)().unwrap_or_else(|obstacle| {
            vec![Finding::at_most(obstacle.to_string(), "1", f64::NAN, 0.0)]
        });
        findings.extend(watch::largest_cause());
        findings
    }
}
