//! Deviations of bodies from their ballistic paths.

/// Upper bound of a body's deviation from its ballistic path after impacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Deviation {
    /// Largest deviation [m] with the dense index of its source, and the largest deviation by any
    /// other source [m].
    pub(super) most: (f64, usize),
    pub(super) otherwise: f64,
}

impl Deviation {
    pub(super) const NONE: Self = Self { most: (0.0, usize::MAX), otherwise: 0.0 };

    /// Deviation with respect to `other` [m]. The impact with `other` is excluded: the pair's own
    /// contact already covers it.
    pub(super) fn against(&self, other: usize) -> f64 {
        if self.most.1 == other { self.otherwise } else { self.most.0 }
    }

    /// Registers a deviation [m] caused by the body `by`.
    pub(super) fn add(&mut self, deviation: f64, by: usize) {
        if by == self.most.1 {
            self.most.0 = self.most.0.max(deviation);
        } else if deviation > self.most.0 {
            (self.most, self.otherwise) = ((deviation, by), self.most.0);
        } else {
            self.otherwise = self.otherwise.max(deviation);
        }
    }
}
