//! What contact points carry from one substep, and from one frame, to the next.

use crate::pair::Pair;
use crate::{Bodies, BodyId};
use glam::DVec3;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;

/// The last substep's impulses of each contact point that acted, before and after its drift.
#[derive(Clone, Debug, Default)]
pub struct WarmStart {
    points: Vec<Carried>,
    of_pair: HashMap<[BodyId; 2], Range<usize>, BuildHasherDefault<IdHasher>>,
}

/// Mixes the few numbers of a pair's ids; nobody chooses them with ill intent.
#[derive(Clone, Copy, Debug, Default)]
struct IdHasher(u64);

impl Hasher for IdHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(byte.into()));
    }

    fn write_u32(&mut self, number: u32) {
        self.write_u64(number.into());
    }

    fn write_u64(&mut self, number: u64) {
        // Multiplication by an odd number near the golden ratio of 2^64: Fibonacci hashing.
        self.0 = (self.0.rotate_left(23) ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

/// A contact point and what it carried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// Whether it is a sample or feature of the pair's first body, and which.
    pub sample: (bool, u64),
    /// Before and after the drift.
    pub impulses: [PointImpulse; 2],
}

/// What acts at one contact point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointImpulse {
    /// Along the normal, not negative [N s].
    pub normal: f64,
    /// Across it, world frame [N s].
    pub tangent: DVec3,
    /// Of rolling and spinning friction, world frame [N m s].
    pub twist: DVec3,
}

impl WarmStart {
    /// The points of a pair that carried.
    pub fn of_pair(&self, bodies: &Bodies, pair: Pair) -> &[Carried] {
        self.of_pair.get(&ids(bodies, pair)).map_or(&[], |range| &self.points[range.clone()])
    }

    /// What a point carried.
    pub fn get(&self, bodies: &Bodies, pair: Pair, sample: (bool, u64)) -> Option<&Carried> {
        self.of_pair(bodies, pair).iter().find(|carried| carried.sample == sample)
    }

    /// Keeps the points of a pair that has none yet.
    pub(crate) fn keep(&mut self, bodies: &Bodies, pair: Pair, carried: impl Iterator<Item = Carried>) {
        let start = self.points.len();
        self.points.extend(carried);
        if self.points.len() > start {
            self.of_pair.insert(ids(bodies, pair), start..self.points.len());
        }
    }
}

fn ids(bodies: &Bodies, pair: Pair) -> [BodyId; 2] {
    [pair.first, pair.second].map(|i| bodies.ids[i])
}
