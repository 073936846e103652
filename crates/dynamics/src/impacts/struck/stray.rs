//! How far bodies may stray from their ballistic ways.

/// How far a body may stray from its ballistic way because it is struck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stray {
    /// Because of the body that may push it furthest, by its dense index, and because of all others
    /// [m].
    pub(super) most: (f64, usize),
    pub(super) otherwise: f64,
}

impl Stray {
    pub(super) const NONE: Self = Self { most: (0.0, usize::MAX), otherwise: 0.0 };

    /// As far as it matters to another body, which meets it on their ways if they meet by each
    /// other alone [m].
    pub(super) fn against(&self, other: usize) -> f64 {
        if self.most.1 == other { self.otherwise } else { self.most.0 }
    }

    /// Another body may push it so far [m].
    pub(super) fn add(&mut self, stray: f64, by: usize) {
        if by == self.most.1 {
            self.most.0 = self.most.0.max(stray);
        } else if stray > self.most.0 {
            (self.most, self.otherwise) = ((stray, by), self.most.0);
        } else {
            self.otherwise = self.otherwise.max(stray);
        }
    }
}
