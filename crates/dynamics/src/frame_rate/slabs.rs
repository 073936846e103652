//! Slabs of a group: its bodies sorted along the longest axis and cut into runs. Constraints of a
//! slab touch bodies of this slab and the next. Even slabs can be solved in parallel, then odd
//! slabs, with the same result for any number of threads.

use frangible_bodies::{Bodies, Inertia, Motion};
use frangible_collision::Manifold;
use glam::DVec3;
use std::ops::Range;

/// Marks bodies without a solver line.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Bodies per slab: few pairs reach across more than two slabs, even in a falling heap, and eight
/// threads still share a pile of a few thousand. With slabs of 512 manifolds instead, two thirds of
/// the batches of 9,000 falling pieces reach across more than two slabs.
const SLAB: usize = 384;

/// Constraints of one thread, solved colour by colour.
pub(super) struct Slab {
    /// Range in the group's batches.
    pub(super) batches: Range<usize>,
    /// First solver line of the constraints.
    pub(super) first_line: usize,
}

/// Solver lines of a group, and the slab of each manifold.
pub(super) struct Slabs {
    /// Body of each line; `None` for lines of static bodies.
    pub(super) body_of: Vec<Option<usize>>,
    /// First line of each slab and of the remainder, and their end. The first line of a slab is
    /// fixed; kinematic bodies have a line in each slab that touches them.
    pub(super) starts: Vec<usize>,
    /// Slab and lines of each manifold; the last slab is the remainder.
    pub(super) places: Vec<(usize, [u32; 2])>,
}

impl Slabs {
    /// Builds the slabs of the manifolds `members`. `lines` is scratch memory, one entry per body,
    /// all [`NOWHERE`] before and after.
    pub(super) fn new(
        bodies: &Bodies,
        manifolds: &[Manifold],
        members: &[usize],
        lines: &mut [u32],
    ) -> Self {
        let is_movable = |i: &usize| !Inertia::is_infinite(&bodies.inertias[*i]);
        let pairs = || members.iter().map(|&number| manifolds[number].pair.both());
        let mut movable = Vec::new();
        for i in pairs().flatten().filter(is_movable) {
            if lines[i] == NOWHERE {
                lines[i] = 0;
                movable.push(i);
            }
        }
        let count = (movable.len() / SLAB).max(1);
        if count > 1 {
            let axis = longest_axis(movable.iter().map(|&i| bodies.poses[i].position));
            let along = |i: usize| bodies.poses[i].position[axis];
            movable.sort_unstable_by(|&a, &b| along(a).total_cmp(&along(b)).then(a.cmp(&b)));
        }
        let slab_of_rank = |rank: usize| rank * count / movable.len();
        movable.iter().enumerate().for_each(|(rank, &i)| lines[i] = slab_of_rank(rank) as u32);
        let first_rank = |slab: usize| (slab * movable.len()).div_ceil(count);

        // Manifolds across more than two slabs go to the remainder.
        let slab_of = |pair: [usize; 2]| {
            let slabs = pair.into_iter().filter(is_movable).map(|i| lines[i] as usize);
            let (least, most) = slabs.fold((count, 0), |(a, b), slab| (a.min(slab), b.max(slab)));
            if most > least + 1 { count } else { least }
        };
        let slabs: Vec<usize> = pairs().map(slab_of).collect();
        let is_kinematic = |i: usize| matches!(bodies.motions[i], Motion::Kinematic { .. });
        let mut kinematic: Vec<(usize, usize)> = Vec::new();
        for (pair, &slab) in pairs().zip(&slabs) {
            kinematic.extend(pair.into_iter().filter(|&i| is_kinematic(i)).map(|i| (slab, i)));
        }
        kinematic.sort_unstable();
        kinematic.dedup();

        let mut all = Self { body_of: Vec::new(), starts: Vec::new(), places: Vec::new() };
        let mut kinematic_lines = Vec::with_capacity(kinematic.len());
        let mut driven = kinematic.iter().peekable();
        for slab in 0..=count {
            all.starts.push(all.body_of.len());
            all.body_of.push(None);
            while let Some(&(_, i)) = driven.next_if(|&&(of, _)| of == slab) {
                kinematic_lines.push(all.body_of.len() as u32);
                all.body_of.push(Some(i));
            }
            let own = if slab < count { first_rank(slab)..first_rank(slab + 1) } else { 0..0 };
            for &i in &movable[own] {
                lines[i] = all.body_of.len() as u32;
                all.body_of.push(Some(i));
            }
        }
        all.starts.push(all.body_of.len());

        for (pair, slab) in pairs().zip(slabs) {
            let fixed = if slab < count { all.starts[slab] as u32 } else { 0 };
            let line = |i: usize| {
                if lines[i] != NOWHERE {
                    return lines[i];
                }
                kinematic.binary_search(&(slab, i)).map_or(fixed, |at| kinematic_lines[at])
            };
            all.places.push((slab, pair.map(line)));
        }
        movable.iter().for_each(|&i| lines[i] = NOWHERE);
        all
    }

    /// Number of slabs, without the remainder.
    pub(super) fn count(&self) -> usize {
        self.starts.len() - 2
    }

    /// First line of the slab's constraints; the remainder touches all lines.
    pub(super) fn first_line(&self, slab: usize) -> usize {
        if slab < self.count() { self.starts[slab] } else { 0 }
    }
}

/// Longest axis of the bounding box of some points.
fn longest_axis(points: impl Iterator<Item = DVec3>) -> usize {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.fold(none, |(low, high), at| (low.min(at), high.max(at)));
    let extent = high - low;
    (0..3).rev().max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0)
}
