//! Scenes that are a demo, a test and a benchmark at once, a file each; and what is promised, as
//! measurements.

pub mod claims;
mod random;
mod scenes;
mod shot;

pub use scenes::SHOTS;
pub use shot::{Shot, ShotError, ShotOptions};
