//! State of a body that waits.

use frangible_bodies::Velocity;

/// When a waiting body starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Starts {
    /// In the step from this frame.
    AtFrame(u64),
    /// In the frame in which it is hit.
    WhenStruck,
}

/// State of a body that waits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waiting {
    pub(crate) starts: Starts,
    /// When it starts.
    pub(crate) velocity: Velocity,
}
