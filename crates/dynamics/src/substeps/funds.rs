//! What a cluster has to close overlaps with: what its bodies' banks hold, and what it dissipates meanwhile. If it spent more, the ledger would take
//! its motion at the frame's end, and a wall that a ball has pressed together would stand still in the air with its overlaps.

/// Of a full bank, with which overlaps begin to close at full speed [1].
const PLENTY: f64 = 0.25;

/// The part of the full speed at which overlaps close if nothing is there to pay for it [1]: where they lift nothing, the ledger takes what that gives
/// and does no harm.
const LEAST: f64 = 0.05;

/// Of one cluster.
#[derive(Clone, Copy)]
pub(super) struct Funds {
    /// At the frame's start [J].
    bank: f64,
    /// What closing overlaps at full speed would have taken so far [J].
    wanted: f64,
    /// Of the speed at which overlaps close, so much is paid for in the next substep [1].
    pub(super) parting: f64,
}

impl Funds {
    /// Nobody asks what closing overlaps takes.
    pub(super) const UNLIMITED: Self = Self { bank: f64::INFINITY, wanted: 0.0, parting: 1.0 };

    /// Of bodies whose banks hold so much, and may hold `most` [J].
    pub(super) fn new(bank: f64, most: f64) -> Self {
        // Nothing is no part of nothing.
        let parting = if most > 0.0 { (bank / (PLENTY * most)).clamp(LEAST, 1.0) } else { LEAST };
        Self { bank, wanted: 0.0, parting }
    }

    /// After a substep, in which contacts have `given` so much to the bodies since the frame's start, and closing all overlaps in full would have taken
    /// as much as is `wanted` with the impulses that acted [J]. The next one is taken to want as much as this one.
    pub(super) fn spend(&mut self, given: f64, wanted: f64) {
        let (left, next) = (self.bank - given, wanted - self.wanted);
        self.wanted = wanted;
        self.parting = if left < next { (left / next).max(LEAST) } else { 1.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It spends what it has, and no more; what it dissipates is there to be spent.
    #[test]
    fn no_more_is_spent_than_is_there() {
        let mut funds = Funds::new(100.0, 100.0);
        assert_eq!(funds.parting, 1.0);
        funds.spend(40.0, 40.0);
        assert_eq!(funds.parting, 1.0);
        funds.spend(80.0, 80.0);
        assert_eq!(funds.parting, 0.5, "20 J are left for what takes 40");
        funds.spend(120.0, 120.0);
        assert_eq!(funds.parting, LEAST);
        funds.spend(-500.0, 160.0);
        assert_eq!(funds.parting, 1.0);
        assert_eq!(Funds::new(0.0, 100.0).parting, LEAST);
        assert_eq!(Funds::new(5.0, 100.0).parting, 0.2);
    }

    /// Where nothing can be banked, as where nothing asks for it, no number goes bad.
    #[test]
    fn nothing_is_no_part_of_nothing() {
        let mut funds = Funds::new(0.0, 0.0);
        assert_eq!(funds.parting, LEAST);
        funds.spend(0.0, 0.0);
        assert_eq!(funds.parting, 1.0);
        funds.spend(1.0, 0.0);
        assert_eq!(funds.parting, LEAST);
        let mut unlimited = Funds::UNLIMITED;
        unlimited.spend(1e300, 2e300);
        assert_eq!(unlimited.parting, 1.0);
    }
}
