//! Times of the stages of a frame.

/// Time of each stage by the caller's clock; a stage that runs several times has one sum.
pub(crate) struct StageClock {
    /// The caller's, if there is one [s].
    now: Option<fn() -> f64>,
    last: f64,
    pub(crate) laps: Vec<(&'static str, f64)>,
}

impl StageClock {
    pub(crate) fn new(now: Option<fn() -> f64>) -> Self {
        Self { now, last: now.map_or(0.0, |now| now()), laps: Vec::new() }
    }

    /// Books the time since the last lap [ms] to a stage.
    pub(crate) fn lap(&mut self, stage: &'static str) {
        let now = self.now.map_or(0.0, |now| now());
        let spent = 1e3 * (now - self.last);
        self.last = now;
        match self.laps.iter_mut().find(|lap| lap.0 == stage) {
            Some(lap) => lap.1 += spent,
            None => self.laps.push((stage, spent)),
        }
    }
}
