//! The numbers of a step, with their sources.

use frangible_math::Width;
use frangible_math::check::{Check, Checked, require};
use serde::{Deserialize, Serialize};

/// Iteration counts of `Method::Paper` (the authors' values), and switches of both methods.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepSettings {
    /// Passes over all colliding pairs [GBF03 sec. 4].
    pub collision_passes: u32,
    /// Impulses on one pair in one pass.
    pub collision_pair_iterations: u32,
    /// Passes over the contact graph [GBF03 sec. 6].
    pub contact_passes: u32,
    /// Sweeps over one level of the graph in one pass.
    pub contact_level_iterations: u32,
    /// Impulses on one pair in one sweep.
    pub contact_pair_iterations: u32,
    /// Sweeps over one level in shock propagation [GBF03 sec. 7].
    pub shock_level_iterations: u32,
    /// Impulses on one pair in one such sweep.
    pub shock_pair_iterations: u32,
    /// Sweeps over one level in push-out [GBF03 sec. 8]; the part of the gap that is closed grows
    /// from sweep to sweep.
    pub push_out_level_iterations: u32,
    /// Moves of one pair in one such sweep.
    pub push_out_pair_iterations: u32,
    /// Passes in which bodies may break; what is struck after the last of them bears the blow until
    /// the next frame.
    pub breaking_passes: u32,
    /// Rotation of free bodies; the paper's rule is second order with its energy fix.
    pub rotation: Rotation,
    /// Clamp the impulses of collisions and of velocity contact [Su09 sec. 3].
    pub impulse_clamp: bool,
    /// Let no island end a frame with more energy than it may have.
    pub ledger: bool,
    /// Least number of substeps of an island that touches anything, a power of two: 2 for a draft,
    /// 4 for a game, 8 by default, 16 for film.
    pub substeps: u32,
    /// Maximum number of substeps of an island. Loads and impacts beyond overlap further.
    pub most_substeps: u32,
    /// Speed at which overlaps close at most [m/s].
    pub recovery_speed: f64,
    /// Maximum energy that an island may bank for later use [J/kg]: 0.1 lifts it by a centimetre,
    /// the speculative margins of two frames.
    pub bank_cap: f64,
    /// Let islands that stand still sleep; off, all bodies are awake in every frame. Only the
    /// frame-rate method does.
    pub sleep: bool,
    /// The widest instructions to use. All of them give the same bits.
    #[serde(skip, default = "widest")]
    pub width: Width,
}

fn widest() -> Width {
    StepSettings::default().width
}

/// The rule by which a free body turns. All of them keep angular momentum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rotation {
    /// The closed form: kinetic energy and orientation to round-off at any rate (docs/adr/008).
    Exact,
    /// Second order in the time step [SSF08].
    SecondOrder {
        /// Turn on to the kinetic energy from before the step [Su09 sec. 2]. The phase stays second
        /// order.
        energy_fix: bool,
    },
}

impl Default for StepSettings {
    fn default() -> Self {
        Self {
            collision_passes: 10,
            collision_pair_iterations: 20,
            contact_passes: 10,
            contact_level_iterations: 2,
            contact_pair_iterations: 20,
            shock_level_iterations: 2,
            shock_pair_iterations: 10,
            push_out_level_iterations: 2,
            push_out_pair_iterations: 5,
            breaking_passes: 8,
            rotation: Rotation::SecondOrder { energy_fix: true },
            impulse_clamp: true,
            ledger: true,
            substeps: 8,
            most_substeps: 128,
            recovery_speed: 3.0,
            bank_cap: 0.1,
            sleep: false,
            width: Width::Avx512,
        }
    }
}

/// Most substeps of a frame.
pub const MOST_SUBSTEPS: u32 = 1024;

/// Most passes, sweeps or impulses of a loop: beyond it a frame would seem to hang.
const MOST_ITERATIONS: u32 = 1000;

impl Check for StepSettings {
    fn check(&self) -> Checked {
        let counts = [
            self.collision_passes,
            self.collision_pair_iterations,
            self.contact_passes,
            self.contact_level_iterations,
            self.contact_pair_iterations,
            self.shock_level_iterations,
            self.shock_pair_iterations,
            self.push_out_level_iterations,
            self.push_out_pair_iterations,
            self.breaking_passes,
        ];
        let is_bounded = counts.iter().all(|&count| count <= MOST_ITERATIONS);
        require(is_bounded, "iteration counts of at most 1000")?;
        let are_powers = self.substeps.is_power_of_two() && self.most_substeps.is_power_of_two();
        let in_order = self.substeps <= self.most_substeps && self.most_substeps <= MOST_SUBSTEPS;
        let rule = "powers of two as numbers of substeps, the least at most the most, at most 1024";
        require(are_powers && in_order, rule)?;
        let is_speed = self.recovery_speed > 0.0 && self.recovery_speed <= 1e12;
        require(is_speed, "a recovery speed above 0 m/s")?;
        require((0.0..=1e12).contains(&self.bank_cap), "a bank of 0 J/kg or more")
    }
}

/// Constants of one frame, common to all stages.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Length of the frame, or of a part of it [s].
    pub dt: f64,
    /// [m/s^2]
    pub gravity: glam::DVec3,
    /// Iteration counts and switches.
    pub settings: StepSettings,
}

/// Minimum gravity in the speculative margin [m/s^2]. Without gravity, touching bodies with
/// rounding gaps still need contact points for impacts.
const LEAST_GRAVITY: f64 = 1.0;

/// Speculative margin relative to the free fall from rest in one frame [1]. With nearly twice as
/// much a heap of two layers at rest has a twelfth more rows, and takes a sixth longer.
const FALL: f64 = 1.1;

impl Frame {
    /// Speculative margin: resting bodies within this separation may touch within the frame [m].
    #[inline]
    pub fn speculative_margin(&self) -> f64 {
        FALL * 0.5 * self.gravity.length().max(LEAST_GRAVITY) * self.dt * self.dt
    }

    /// Minimum closing speed of an impact within the speculative margin [m/s]: with gravity's
    /// acceleration a slower approach travels less than two margins in a frame.
    #[inline]
    pub fn impact_speed(&self) -> f64 {
        (1.0 + FALL * (FALL - 1.0)).sqrt() * self.gravity.length() * self.dt
    }
}
