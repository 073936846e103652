//! Lanes that may have joint impacts.

use super::constraints::{MOST_POINTS, Selection};
use super::contact_batch::ContactBatch;
use super::solver_bodies::SolverBodies;
use super::touching::Place;
use frangible_math::Instructions;
use glam::DMat3;

/// For each constraint: true if one of its bodies has other constraints with the same partner, and
/// so may have joint impacts. `is_movable` is indexed by solver line.
pub(super) fn companions(selections: &[Selection], is_movable: &[bool]) -> Vec<bool> {
    // Line that moves of a constraint with a fixed body.
    let with_fixed = |selection: &Selection| {
        let [first, second] = selection.lines.map(|line| line as usize);
        match [is_movable[first], is_movable[second]] {
            [true, false] => Some(first),
            [false, true] => Some(second),
            _ => None,
        }
    };
    let mut counts = vec![0_u32; is_movable.len()];
    selections.iter().filter_map(with_fixed).for_each(|line| counts[line] += 1);
    // Constraints of one pair follow each other.
    let of_pairs = selections.chunk_by(|a, b| a.manifold == b.manifold);
    let has_companion = |of_pair: &[Selection], selection: &Selection| {
        of_pair.len() > 1 || with_fixed(selection).is_some_and(|line| counts[line] > 1)
    };
    of_pairs
        .flat_map(|of_pair| of_pair.iter().map(move |selection| (of_pair, selection)))
        .map(|(of_pair, selection)| has_companion(of_pair, selection))
        .collect()
}

/// All fixed bodies.
pub(super) const FIXED: usize = usize::MAX;

/// Line of the other body of a line's lane, or [`FIXED`].
pub(super) fn partner<I: Instructions>(
    batches: &[ContactBatch<I>],
    bodies: &SolverBodies,
    (line, place): (usize, Place),
) -> usize {
    let [first, second] = batches[place.batch()].lines_of(place.lane());
    let other = if first == line { second } else { first };
    if bodies.lines[other].is_movable() { other } else { FIXED }
}

/// Inverse masses [1/kg] and inertias [1/(kg m^2)] of the bodies that move.
pub(super) fn inverses(lines: [usize; 2], bodies: &SolverBodies) -> Vec<(f64, DMat3)> {
    let movable = lines.into_iter().filter(|&line| line != FIXED);
    movable.map(|line| bodies.inverse_mass_and_inertia(line)).collect()
}

/// A lane in a joint impact.
pub(super) struct Member {
    pub(super) place: Place,
    /// Side of the body whose impacts they are.
    pub(super) side: usize,
    /// Normal impulses of its points [N s].
    pub(super) impulses: [f64; MOST_POINTS],
    /// Sum of these, times the distances from where the normal impulse of the joint impact acts
    /// [N s m].
    pub(super) twist_arm: f64,
}
