//! Islands with equal substep counts: graph colouring of their constraints, and the substep loop.

use super::constraints::{Selection, Source};
use super::contact_batch::ContactBatch;
use super::impact_log::Impact;
use super::joint_lanes::companions;
use super::restitution::{ImpactBudget, propagate_impacts};
use super::slabs::{Slab, Slabs};
use super::solver_bodies::{Lines, SolverBodies};
use super::solver_islands::CONTACT_RATE;
use super::speculative_contacts::{LOOKS_AGAIN, SpeculativeContacts, is_confirmed, may_pierce};
use super::substep::{Softness, Substep};
use super::timeline::Timeline;
use super::touching::{Place, Touching};
use frangible_bodies::{Bodies, Frame, Pair};
use frangible_collision::{CachedImpulse, FixedNeighbours, Manifold};
use frangible_math::{Instructions, LANES, Single, cancel, prefetch, threads};
use glam::Vec3;
use std::cell::OnceCell;
use std::ops::Range;
use std::slice::from_ref;

/// Damping ratio of penetration recovery. With 10 [Cat24] walls at rest keep moving at 5 cm/s, with
/// this value at 0.2 mm/s.
const DAMPING_RATIO: f64 = 0.5;

/// Time constant of penetration recovery, in frames: overlap beyond the load's spring deflection
/// decays to 1/e. With 2, towers of seventy cubes fall; with 8, they lean.
const RECOVERY_FRAMES: f64 = 4.0;

/// Minimum approach speed of a bounce without gravity [m/s]. With gravity the threshold is
/// gravity's speed gain in a frame, the approach speed of resting contacts.
const LEAST_BOUNCE: f64 = 1e-3;

/// Batches per task of [`Group::ask`]: ten microseconds of work.
const SHARE: usize = 64;

/// Number of graph colours; constraints of one colour share no movable body. Constraints beyond get
/// a colour each.
const COLOURS: u32 = 128;

/// Islands in the substep loop.
pub(super) struct Group<I> {
    pub(super) bodies: SolverBodies,
    /// One entry per constraint.
    pub(super) selections: Vec<Selection>,
    pub(super) batches: Vec<ContactBatch<I>>,
    /// First line of each slab and of the remainder, and their end.
    starts: Vec<usize>,
    /// The last entry is the remainder: manifolds across more than two slabs.
    pub(super) slabs: Vec<Slab>,
    /// Built on first use.
    touching: OnceCell<Touching>,
    pub(super) speculative: SpeculativeContacts,
    /// Impacts in the lanes of bodies that may break.
    pub(super) impacts: Vec<Impact>,
    pub(super) budget: ImpactBudget,
    pub(super) substeps: u32,
    /// Length of a substep [s].
    pub(super) h: f64,
}

impl<I: Instructions> Group<I> {
    /// Builds the group of the manifolds `members`. `lines` is scratch memory, one entry per body,
    /// all [`NOWHERE`](super::slabs::NOWHERE) before and after.
    pub(super) fn new(
        bodies: &Bodies,
        (manifolds, carried): (&[Manifold], &[&[CachedImpulse]]),
        (members, substeps): (&[usize], u32),
        lines: &mut [u32],
        frame: &Frame,
    ) -> Self {
        let h = frame.dt / f64::from(substeps);
        let slabs = Slabs::new(bodies, manifolds, members, lines);
        let source = |selection: &Selection| {
            let number = selection.manifold as usize;
            Source { manifold: &manifolds[number], carried: carried[number] }
        };
        let mut selections = Vec::with_capacity(members.len() + members.len() / 4);
        let mut is_done = Vec::new();
        let mut of_slabs = vec![Vec::new(); slabs.count() + 1];
        for (&number, &(slab, lines)) in members.iter().zip(&slabs.places) {
            let first = selections.len();
            let manifold = (number, manifolds[number].points);
            Selection::all(&mut selections, manifold, lines, &mut is_done);
            of_slabs[slab].extend(first as u32..selections.len() as u32);
        }
        let is_movable: Vec<bool> = (slabs.body_of.iter())
            .map(|body| body.is_some_and(|i| !bodies.inertias[i].is_infinite()))
            .collect();

        // Colour each slab, then fill its batches.
        let acts_in = |selection: &Selection| source(selection).acts_in(selection, (h, frame));
        let colours = Colours { selections: &selections, is_movable: &is_movable };
        let room = || vec![0; slabs.body_of.len()];
        let orders: Vec<Vec<(u32, u32)>> =
            threads::map_with(of_slabs, members.len(), room, |taken, members| {
                colours.order(members, acts_in, taken)
            });
        let companions = companions(&selections, &is_movable);
        let mut batches = Vec::new();
        let mut all = Vec::with_capacity(orders.len());
        for (number, order) in orders.iter().enumerate() {
            let (begin, first_line) = (batches.len(), slabs.first_line(number));
            let count =
                order.chunk_by(|a, b| a.0 == b.0).map(|colour| colour.len().div_ceil(LANES));
            batches.resize_with(begin + count.sum::<usize>(), || ContactBatch::empty(first_line));
            all.push(Slab { batches: begin..batches.len(), first_line });
        }
        let mut cut = Cut::of(&mut batches);
        let batches_of = |slab: &Slab| cut.take(slab.batches.clone());
        let mut work: Vec<_> = all.iter().map(batches_of).zip(orders).collect();
        threads::for_each(&mut work, members.len(), |(batches, order)| {
            let lanes = order.chunk_by(|a, b| a.0 == b.0).flat_map(|colour| colour.chunks(LANES));
            for (batch, lanes) in batches.iter_mut().zip(lanes) {
                for (lane, &(_, number)) in lanes.iter().enumerate() {
                    let selection = &selections[number as usize];
                    let source = source(selection);
                    let constraint = source.constraint(selection, bodies, (h, frame));
                    batch.companions.set(lane, companions[number as usize]);
                    batch.breakable.set(lane, may_break(bodies, source.manifold.pair));
                    batch.fill(lane, (number, &constraint));
                    batch.unconfirmed.set(lane, !is_confirmed(bodies, &source, frame));
                }
            }
        });
        let body_of = slabs.body_of;
        let mut places = vec![Place::new(0, 0); selections.len()];
        for (at, batch) in batches.iter().enumerate() {
            for (lane, &number) in batch.constraints.iter().enumerate() {
                if let Some(place) = places.get_mut(number as usize) {
                    *place = Place::new(at, lane);
                }
            }
        }
        let speculative = SpeculativeContacts::new(&batches, places, members.len());
        let budget = ImpactBudget::of_frame(batches.len());
        Self {
            bodies: SolverBodies::new(bodies, body_of, frame.dt),
            selections,
            batches,
            starts: slabs.starts,
            slabs: all,
            touching: OnceCell::new(),
            speculative,
            impacts: Vec::new(),
            budget,
            substeps,
            h,
        }
    }

    /// All substeps of the frame: gravity, impacts, warm starting, soft sweep, drift, rigid sweep.
    pub(super) fn run(
        &mut self,
        bodies: &Bodies,
        contacts: (&[Manifold], &FixedNeighbours),
        frame: &Frame,
    ) {
        let bounce = (frame.gravity.length() * frame.dt).max(LEAST_BOUNCE);
        let substep = Substep {
            h: Single::splat(self.h),
            per_second: Single::splat(1.0 / self.h),
            soft: Softness::new(CONTACT_RATE / self.h, DAMPING_RATIO, self.h),
            recovery_rate: Single::splat(1.0 / (RECOVERY_FRAMES * frame.dt)),
            recovery_speed: Single::splat(frame.settings.recovery_speed),
            bounce_velocity: Single::splat(-bounce),
        };
        let kick = (self.h * frame.gravity).as_vec3();
        let has_bounces = self.batches.iter().any(|batch| batch.bounces.any());
        let mut timeline = has_bounces.then(|| Timeline::new(&self.bodies, self.batches.len()));
        for number in 0..self.substeps {
            cancel::check();
            let time_left = f64::from(self.substeps - number) * self.h;
            self.bodies.kick(kick);
            self.ask(&substep);
            self.confirm(bodies, contacts, (time_left, kick), frame);
            if let Some(timeline) = &mut timeline {
                self.bounce(timeline, (bodies, contacts), (time_left, kick), frame, &substep);
            }
            self.bodies.end_impacts(kick);
            self.sweep(
                #[inline(always)]
                |batch, lines| batch.warm_start(lines, &substep),
            );
            self.sweep(
                #[inline(always)]
                |batch, lines| batch.solve::<true>(lines, &substep),
            );
            for at in self.confirm(bodies, contacts, (time_left, Vec3::ZERO), frame) {
                let batch = &mut self.batches[at];
                let lines = &mut self.bodies.lines(batch.first_line..self.bodies.lines.len());
                I::run(
                    #[inline(always)]
                    || batch.solve::<true>(lines, &substep),
                );
            }
            self.end_confirmation();
            self.bodies.drift(self.h as f32, kick.length());
            self.spin((bodies, contacts.0), frame);
            self.sweep(
                #[inline(always)]
                |batch, lines| batch.solve::<false>(lines, &substep),
            );
        }
    }

    /// True if the frame had no time left for some of its impacts or detections.
    pub(super) fn is_short(&self) -> bool {
        self.budget.is_short() || self.speculative.looks == 0
    }

    /// Finds the speculative contacts that would act in this substep.
    fn ask(&mut self, substep: &Substep<I>) {
        let Self { bodies, batches, speculative, .. } = self;
        let asking = speculative.asking();
        let shares = speculative.batches().chunks(SHARE);
        let mut cut = Cut::of(batches);
        let mut work: Vec<(&[usize], &mut [ContactBatch<I>])> =
            shares.map(|share| (share, cut.take(share[0]..share[share.len() - 1] + 1))).collect();
        let bodies = &*bodies;
        threads::for_each(&mut work, LANES * speculative.batches().len(), |(share, batches)| {
            for &at in *share {
                let batch = &mut batches[at - share[0]];
                I::run(
                    #[inline(always)]
                    || batch.ask(&bodies.lines[batch.first_line..], substep),
                );
                if batch.asks.any() {
                    asking.insert(at);
                }
            }
        });
    }

    /// Impacts of a substep, and of the pairs that they bring together.
    fn bounce(
        &mut self,
        timeline: &mut Timeline,
        (bodies, contacts): (&Bodies, (&[Manifold], &FixedNeighbours)),
        now: (f64, Vec3),
        frame: &Frame,
        substep: &Substep<I>,
    ) {
        self.budget.begin_substep();
        while !self.budget.is_spent() {
            cancel::check();
            let Self { batches, bodies: solver_bodies, touching, speculative, budget, .. } = self;
            let touching = touching.get_or_init(|| Touching::new(batches, solver_bodies));
            let (times, asking) = ((&mut *timeline, touching), speculative.asking());
            I::run(
                #[inline(always)]
                || propagate_impacts(batches, solver_bodies, times, asking, budget, substep),
            );
            if self.confirm(bodies, contacts, now, frame).is_empty() {
                break;
            }
        }
        let (time_left, _) = now;
        self.keep_impacts(&mut timeline.impacts, (bodies, contacts.0), frame.dt - time_left);
    }

    /// Visits all batches: even slabs in parallel, then odd slabs in parallel, then the remainder.
    #[inline(always)]
    fn sweep(&mut self, visit: impl Fn(&mut ContactBatch<I>, &mut Lines) + Send + Sync) {
        let things = self.selections.len();
        let Self { bodies, batches, starts, slabs, speculative, .. } = self;
        let asking = speculative.asking();
        let visit_batches = |first: usize, batches: &mut [ContactBatch<I>], lines: &mut Lines| {
            I::run(
                #[inline(always)]
                || {
                    for at in 0..batches.len() {
                        // Prefetch explicitly: the hardware prefetcher does not predict the next
                        // batch.
                        if let Some(next) = batches.get(at + 1) {
                            prefetch(from_ref(next));
                        }
                        visit(&mut batches[at], lines);
                        if batches[at].asks.any() {
                            asking.insert(first + at);
                        }
                    }
                },
            );
        };
        let Some((rest, slabs)) = slabs.split_last() else { return };
        for parity in 0..2 {
            let mut work = Vec::with_capacity(slabs.len() / 2 + 1);
            let mut lines = Cut::of(&mut bodies.lines);
            let mut batches = Cut::of(batches);
            for (number, slab) in slabs.iter().enumerate().skip(parity).step_by(2) {
                let range = slab.first_line..starts[(number + 2).min(starts.len() - 2)];
                let inverse_inertias = &bodies.inverse_inertias[range.clone()];
                let lines = Lines { bodies: lines.take(range), inverse_inertias };
                work.push((slab.batches.start, batches.take(slab.batches.clone()), lines));
            }
            threads::for_each(&mut work, things, |(first, batches, lines)| {
                visit_batches(*first, batches, lines);
            });
        }
        let lines = &mut bodies.lines(0..bodies.lines.len());
        visit_batches(rest.batches.start, &mut batches[rest.batches.clone()], lines);
    }

    /// Rotates fast-spinning bodies exactly. Contacts of far-turned bodies are detected again in the
    /// next substep, unless they press: other features come near.
    fn spin(&mut self, (bodies, manifolds): (&Bodies, &[Manifold]), frame: &Frame) {
        self.bodies.spin(bodies, frame.settings.rotation, self.h);
        if self.bodies.turned.is_empty() {
            return;
        }
        let Self { bodies: solver_bodies, batches, touching, speculative, selections, .. } = self;
        let touching = touching.get_or_init(|| Touching::new(batches, solver_bodies));
        for &line in &solver_bodies.turned {
            let is_fast = solver_bodies.spin_speed(line) * frame.dt > LOOKS_AGAIN;
            for place in touching.lanes(line) {
                let (batch, lane) = (&mut batches[place.batch()], place.lane());
                batch.is_stale = true;
                let selection = &selections[batch.constraints[lane] as usize];
                let pair = manifolds[selection.manifold as usize].pair;
                if is_fast && !batch.presses(lane) && may_pierce(bodies, pair) {
                    batch.unconfirmed.set(lane, true);
                    batch.asks.set(lane, true);
                    speculative.asking.insert(place.batch());
                }
            }
        }
    }
}

/// True if an impact may break a body of the pair, or its bonds.
fn may_break(bodies: &Bodies, pair: Pair) -> bool {
    pair.both().into_iter().any(|i| bodies.strength(i).is_finite() || bodies.surfaces[i].glued)
}

/// Splits mutable sub-slices off the front of a slice.
struct Cut<'a, T> {
    left: &'a mut [T],
    begin: usize,
}

impl<'a, T> Cut<'a, T> {
    fn of(all: &'a mut [T]) -> Self {
        Self { left: all, begin: 0 }
    }

    /// Returns `range` of the original slice; must start at or after the end of earlier ranges.
    fn take(&mut self, range: Range<usize>) -> &'a mut [T] {
        let (_, from) = std::mem::take(&mut self.left).split_at_mut(range.start - self.begin);
        let (taken, left) = from.split_at_mut(range.len());
        (self.left, self.begin) = (left, range.end);
        taken
    }
}

/// Greedy graph colouring: constraints of one colour share no movable body.
struct Colours<'a> {
    selections: &'a [Selection],
    /// Indexed by solver line.
    is_movable: &'a [bool],
}

impl Colours<'_> {
    /// Constraint indices by colour; within a colour sorted by first active substep, then by
    /// descending point count. `taken` is scratch memory, one entry per line, zero before and
    /// after.
    fn order(
        &self,
        members: Vec<u32>,
        acts_in: impl Fn(&Selection) -> u16,
        taken: &mut [u128],
    ) -> Vec<(u32, u32)> {
        let movable_lines = |number: u32| {
            let lines = self.selections[number as usize].lines.map(|line| line as usize);
            lines.into_iter().filter(|&line| self.is_movable[line])
        };
        let mut overflow = COLOURS - 1;
        let mut order: Vec<(u32, u16, usize, u32)> = Vec::with_capacity(members.len());
        for &number in &members {
            let used = movable_lines(number).fold(0, |used, line| used | taken[line]);
            let mut colour = (!used).trailing_zeros();
            if colour >= COLOURS - 1 {
                colour = overflow;
                overflow += 1;
            } else {
                movable_lines(number).for_each(|line| taken[line] |= 1 << colour);
            }
            let selection = &self.selections[number as usize];
            let fewer = usize::MAX - selection.points().len();
            order.push((colour, acts_in(selection), fewer, number));
        }
        members.iter().flat_map(|&number| movable_lines(number)).for_each(|line| taken[line] = 0);
        order.sort_unstable();
        order.into_iter().map(|(colour, .., number)| (colour, number)).collect()
    }
}
