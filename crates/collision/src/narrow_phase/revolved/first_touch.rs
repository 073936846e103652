//! First touch of two bodies within a frame, or their closest approach, by their separation at any
//! instant (conservative advancement [Mir96]).

use crate::narrow_phase::pair_motion::MOST_STEPS;
use glam::DVec3;

/// Bisections of a frame for the time of closest approach: to a thousandth of it.
const HALVINGS: u32 = 10;

/// Fraction of the overlap of a grazing pair that a pair may get deeper in a frame without a look
/// for its closest approach [1]: bodies at rest do not need one.
pub(crate) const DEEPER: f64 = 0.05;

/// Two bodies at an instant of the frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apart {
    /// [s]
    pub(crate) time: f64,
    /// Separation of the surfaces [m].
    pub(crate) gap: f64,
    /// Unit, from the second body to the first, world frame.
    pub(crate) normal: DVec3,
    /// Separating speed of the closest points along the normal [m/s].
    pub(crate) parting: f64,
}

/// Two bodies on their ways.
pub(crate) struct Meeting<'a> {
    /// Both at an instant; the direction is a guess of the normal.
    pub(crate) at: &'a dyn Fn(f64, DVec3) -> Apart,
    /// Upper bound of the closing speed along a normal of any two points from an instant on [m/s];
    /// negative if all separate.
    pub(crate) closing: &'a dyn Fn(f64, DVec3) -> f64,
    /// [s]
    pub(crate) dt: f64,
    /// Separation of a touch [m].
    pub(crate) touch: f64,
    /// Bodies that come no nearer within the frame have no contact [m].
    pub(crate) near: f64,
}

impl Meeting<'_> {
    /// First touch after an instant, or the closest approach; `None` for bodies that pass far from
    /// each other.
    pub(crate) fn first_touch(&self, start: Apart) -> Option<Apart> {
        let mut here = start;
        for _ in 0..MOST_STEPS {
            if here.gap <= self.touch {
                return Some(here);
            }
            let closing = (self.closing)(here.time, here.normal).max(0.0);
            let left = self.dt - here.time;
            if here.gap > closing * left {
                let nearest = here.gap - closing * left;
                return (nearest <= self.near).then(|| self.nearest(here));
            }
            here = (self.at)(here.time + here.gap / closing, here.normal);
        }
        Some(here)
    }

    /// Closest approach after an instant of bodies that overlap no deeper than `grazing` [m] until
    /// the frame's end.
    pub(crate) fn grazed(&self, from: Apart, grazing: f64) -> Option<Apart> {
        let nearest = self.nearest(from);
        if nearest.gap <= -grazing {
            return None;
        }
        // A body that moves on from an edge is as near on the face behind it, on its whole line.
        let later = (self.at)(0.5 * (nearest.time + self.dt), nearest.normal);
        let is_as_near = later.gap <= nearest.gap + DEEPER * grazing;
        let found = if is_as_near { later } else { nearest };
        (found.gap > -grazing).then_some(found)
    }

    /// Closest approach after an instant, or the frame's end.
    pub(crate) fn nearest(&self, from: Apart) -> Apart {
        if from.parting >= 0.0 {
            return from;
        }
        let (mut before, mut after) = (from, (self.at)(self.dt, from.normal));
        if after.parting < 0.0 {
            return after;
        }
        for _ in 0..HALVINGS {
            let middle = (self.at)(0.5 * (before.time + after.time), before.normal);
            if middle.parting < 0.0 { before = middle } else { after = middle }
        }
        // Of curved surfaces the instant between both is exact to the square of their distance.
        // Where a body passes the edge of a face, one of them is on the face.
        let part = before.parting / (before.parting - after.parting);
        let between = (self.at)(before.time + part * (after.time - before.time), before.normal);
        let slowest = |a: &Apart, b: &Apart| a.parting.abs().total_cmp(&b.parting.abs());
        [before, after, between].into_iter().min_by(slowest).unwrap_or(after)
    }
}
