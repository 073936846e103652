//! Two bodies.

use crate::bodies::Bodies;
use crate::body_id::BodyId;
use serde::{Deserialize, Serialize};

/// A pair of bodies, by dense index; the first has the smaller one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Pair {
    /// Body on which an impulse `j` acts.
    pub first: usize,
    /// `-j` acts on it.
    pub second: usize,
}

impl Pair {
    /// Its bodies.
    #[inline]
    pub fn both(self) -> [usize; 2] {
        [self.first, self.second]
    }

    /// By which its bodies are known over the frames.
    #[inline]
    pub fn ids(self, bodies: &Bodies) -> [BodyId; 2] {
        [bodies.ids[self.first], bodies.ids[self.second]]
    }
}
