//! Contact lanes of each body.

use super::contact_batch::ContactBatch;
use super::solver_bodies::SolverBodies;
use frangible_math::LANES;

/// A lane of a batch.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// Batch index times lane count plus lane.
    number: u32,
}

impl Place {
    pub(super) fn new(batch: usize, lane: usize) -> Self {
        Self { number: (batch * LANES + lane) as u32 }
    }

    pub(super) fn batch(self) -> usize {
        self.number as usize / LANES
    }

    pub(super) fn lane(self) -> usize {
        self.number as usize % LANES
    }
}

/// Contact lanes of each solver line, except lines of static bodies.
pub(super) struct Touching {
    /// Offset of each line's lanes in `places`, and the end.
    starts: Vec<u32>,
    places: Vec<Place>,
}

impl Touching {
    pub(super) fn new<I>(batches: &[ContactBatch<I>], bodies: &SolverBodies) -> Self {
        let lanes = |(at, batch): (usize, &ContactBatch<I>)| {
            let place = move |lane: usize| Place::new(at, lane);
            batch.lines().into_iter().flat_map(move |lines| {
                lines.into_iter().enumerate().map(move |(lane, line)| (line, place(lane)))
            })
        };
        let all = || batches.iter().enumerate().flat_map(lanes);
        let is_asked = |&(line, _): &(usize, Place)| bodies.body_of[line].is_some();
        let mut starts = vec![0; bodies.body_of.len() + 1];
        all().filter(is_asked).for_each(|(line, _)| starts[line + 1] += 1);
        (1..starts.len()).for_each(|line| starts[line] += starts[line - 1]);
        let mut next = starts.clone();
        let mut places = vec![Place { number: 0 }; starts[bodies.body_of.len()] as usize];
        for (line, place) in all().filter(is_asked) {
            places[next[line] as usize] = place;
            next[line] += 1;
        }
        Self { starts, places }
    }

    /// Lanes of a line, in batch order.
    pub(super) fn lanes(&self, line: usize) -> &[Place] {
        &self.places[self.starts[line] as usize..self.starts[line + 1] as usize]
    }
}
