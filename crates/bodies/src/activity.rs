//! The activity of a body in the last frames.

use serde::{Deserialize, Serialize};

/// The activity of a body in the last frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Activity {
    /// Of its island in the last frame.
    pub substeps: Substeps,
    /// Its calm and its sleep.
    pub drowsiness: Drowsiness,
}

/// The substeps of an island; none if it touched nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Substeps {
    /// Number of substeps taken.
    pub count: u32,
    /// Number of substeps needed.
    pub needed: f32,
}

impl Substeps {
    /// The larger of both numbers.
    pub fn max(self, other: Self) -> Self {
        Self { count: self.count.max(other.count), needed: self.needed.max(other.needed) }
    }
}

/// The calm of a body, by which it falls asleep, from frame to frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Drowsiness {
    /// Number of consecutive frames as a slow body with unchanged neighbours and no driven body in
    /// its island.
    pub slow_for: u32,
    /// Sum of the neighbours' hashes.
    pub touching: u64,
    /// True if the body slept in the last frame.
    pub is_asleep: bool,
}
