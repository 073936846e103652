//! State of a body that waits, and the speed of a hit.

use frangible_bodies::{Frame, Velocity};
use serde::{Deserialize, Serialize};

/// An approach is a hit above the smaller one of a speed [m/s] and a share of what gravity gives
/// in a frame [1], without gravity's gain in the frame: that of a fall by half a millimetre.
/// Resting bodies come slower: a mesh that is set down on a waiting one at 9 mm/s, a stack of ten
/// cubes at 14 mm/s, the free half of a wall of bricks at the waiting half at 53 mm/s.
const HIT_SPEED: f64 = 0.1;
const HIT_SHARE: f64 = 0.3;

/// When a waiting body starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Starts {
    /// In the step from this frame.
    AtFrame(u64),
    /// In the frame in which it is hit.
    WhenStruck,
}

/// State of a body that waits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Waiting {
    pub(crate) starts: Starts,
    /// When it starts.
    pub(crate) velocity: Velocity,
}

/// Approaches above this speed are hits [m/s]; without gravity all are.
pub(crate) fn least_hit(frame: &Frame) -> f64 {
    HIT_SPEED.min(HIT_SHARE * frame.gravity.length() * frame.dt)
}
