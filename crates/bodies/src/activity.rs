//! The activity of a body in the last frames.

/// The activity of a body in the last frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Activity {
    /// Of its island in the last frame.
    pub substeps: Substeps,
    /// Its calm and its sleep.
    pub drowsiness: Drowsiness,
}

/// The substeps of an island; none if it touched nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Substeps {
    /// How many there were.
    pub count: u32,
    /// How many would have done.
    pub needed: f32,
}

impl Substeps {
    /// The larger of both numbers.
    pub fn max(self, other: Self) -> Self {
        Self { count: self.count.max(other.count), needed: self.needed.max(other.needed) }
    }
}

/// The calm of a body, by which it falls asleep, from frame to frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drowsiness {
    /// In so many frames, one after the other, it has been slow, and has touched the same others,
    /// of which none was driven.
    pub slow_for: u32,
    /// Those others, as a number: the sum of one for each.
    pub touching: u64,
    /// True if it slept in the last frame.
    pub is_asleep: bool,
}
