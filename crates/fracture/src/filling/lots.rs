//! Choices by weights.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// A choice by weights.
pub(super) struct Lots {
    /// Sums of the weights up to each.
    sums: Vec<f64>,
}

impl Lots {
    pub(super) fn new(weights: impl Iterator<Item = f64>) -> Self {
        let mut sum = 0.0;
        let sums = weights.map(|weight| {
            sum += weight.max(0.0);
            sum
        });
        Self { sums: sums.collect() }
    }

    pub(super) fn sum(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    pub(super) fn draw(&self, random: &mut Pcg64Mcg) -> usize {
        let lot = self.sum() * random.random::<f64>();
        self.sums.partition_point(|&sum| sum <= lot).min(self.sums.len() - 1)
    }
}
