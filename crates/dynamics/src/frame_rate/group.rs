//! The islands that take as many substeps: their constraints in colours, and the substeps.

use super::constraints::{Constraint, Source};
use super::contact_batch::ContactBatch;
use super::kernels::{Softness, Substep};
use super::restitution::{Timeline, propagate_impacts};
use super::slabs::{Slab, Slabs};
use super::solver_bodies::{Lines, SolverBodies};
use super::solver_islands::CONTACT_RATE;
use frangible_bodies::{Bodies, Frame};
use frangible_collision::{Carried, Manifold};
use frangible_math::{Instructions, LANES, Single, threads};

/// Damping ratio of overlaps that close. With 10 [Cat24] walls keep a motion of 5 cm/s, with
/// this of 0.2 mm/s.
const DAMPING_RATIO: f64 = 0.5;

/// Overlaps beyond what the load explains close to 1/e of them in so many frames: in two, towers
/// of seventy cubes fall; in eight, they lean.
const RECOVERY_FRAMES: f64 = 4.0;

/// Slower than this nothing bounces where there is no gravity [m/s]. Where there is, approach
/// speeds must be above what it gives in a frame: what rests approaches so fast.
const LEAST_BOUNCE: f64 = 1e-3;

/// Constraints of which no two share a movable body are of one colour; there are so many
/// colours before the rest has one each.
const COLOURS: u32 = 128;

/// Islands on their way through a frame.
pub(super) struct Group<I> {
    pub(super) bodies: SolverBodies,
    pub(super) constraints: Vec<Constraint>,
    /// First line of each slab and of the rest, and their end.
    starts: Vec<usize>,
    /// The last one is the rest.
    pub(super) slabs: Vec<Slab<I>>,
    pub(super) substeps: u32,
    /// Of a substep [s].
    pub(super) h: f64,
}

impl<I: Instructions> Group<I> {
    /// Of some manifolds. `lines` is room of one entry for each body, all of them
    /// [`NOWHERE`](super::slabs::NOWHERE), before and after.
    pub(super) fn new(
        bodies: &Bodies,
        (manifolds, carried): (&[Manifold], &[&[Carried]]),
        (members, substeps): (&[usize], u32),
        lines: &mut [u32],
        frame: &Frame,
    ) -> Self {
        let h = frame.dt / f64::from(substeps);
        let slabs = Slabs::new(bodies, manifolds, members, lines);
        let mut constraints = Vec::with_capacity(members.len());
        let mut of_slabs = vec![Vec::new(); slabs.count() + 1];
        for (&number, &(slab, lines)) in members.iter().zip(&slabs.places) {
            let manifold = &manifolds[number];
            let source = Source { number, manifold, carried: carried[number], lines };
            let first = constraints.len();
            source.add_to(&mut constraints, bodies, (h, frame));
            of_slabs[slab].extend(first as u32..constraints.len() as u32);
        }
        let solver_bodies = SolverBodies::new(bodies, slabs.body_of.clone(), frame.dt);
        let mut order = Colours::new(solver_bodies.lines.len());
        let slab = |(number, members): (usize, &Vec<u32>)| {
            let first_line = slabs.first_line(number);
            let order = order.of(&constraints, members);
            Slab { batches: batches(&constraints, order, first_line), first_line }
        };
        let slabs_of = of_slabs.iter().enumerate().map(slab).collect();
        Self {
            bodies: solver_bodies,
            constraints,
            starts: slabs.starts,
            slabs: slabs_of,
            substeps,
            h,
        }
    }

    /// All substeps of the frame: gravity, impacts, warm starting, soft sweep, drift, rigid sweep.
    pub(super) fn run(&mut self, bodies: &Bodies, frame: &Frame) {
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
        let has_bounces = self.slabs.iter().flat_map(|slab| &slab.batches).any(bounces);
        let mut timeline = Timeline::new(&self.bodies);
        self.sweep(
            #[inline(always)]
            |batch, lines| batch.prepare(lines),
        );
        for _ in 0..self.substeps {
            self.bodies.kick(kick);
            if has_bounces {
                let Self { slabs, bodies, .. } = self;
                I::run(
                    #[inline(always)]
                    || propagate_impacts(slabs, bodies, &mut timeline, &substep),
                );
            }
            self.sweep(
                #[inline(always)]
                |batch, lines| batch.warm_start(lines, &substep),
            );
            self.sweep(
                #[inline(always)]
                |batch, lines| batch.solve::<true>(lines, &substep),
            );
            self.bodies.drift(self.h as f32, kick.length());
            self.spin(bodies, frame);
            self.sweep(
                #[inline(always)]
                |batch, lines| batch.solve::<false>(lines, &substep),
            );
        }
    }

    /// Visits all batches: those of even slabs at a time, of odd ones, and the rest.
    #[inline(always)]
    fn sweep(&mut self, visit: impl Fn(&mut ContactBatch<I>, &mut Lines) + Send + Sync) {
        let things = self.constraints.len();
        let Self { bodies, starts, slabs, .. } = self;
        let visit_slab = |batches: &mut [ContactBatch<I>], lines: &mut Lines| {
            I::run(
                #[inline(always)]
                || {
                    for batch in batches {
                        visit(batch, lines);
                    }
                },
            );
        };
        let (rest, slabs) = match slabs.split_last_mut() {
            Some(split) => split,
            None => return,
        };
        for parity in 0..2 {
            let mut work = Vec::with_capacity(slabs.len() / 2 + 1);
            let (mut left, mut begin) = (bodies.lines.as_mut_slice(), 0);
            for (number, slab) in slabs.iter_mut().enumerate().skip(parity).step_by(2) {
                let end = starts[(number + 2).min(starts.len() - 2)];
                let (_, from) = std::mem::take(&mut left).split_at_mut(slab.first_line - begin);
                let (own, after) = from.split_at_mut(end - slab.first_line);
                let inverse_inertias = &bodies.inverse_inertias[slab.first_line..end];
                work.push((&mut slab.batches, Lines { bodies: own, inverse_inertias }));
                (left, begin) = (after, end);
            }
            threads::for_each(&mut work, things, |(batches, lines)| visit_slab(batches, lines));
        }
        let lines = &mut bodies.lines(0..bodies.lines.len());
        visit_slab(&mut rest.batches, lines);
    }

    /// Turns what spins fast exactly, and prepares what has turned too far anew.
    fn spin(&mut self, bodies: &Bodies, frame: &Frame) {
        self.bodies.spin(bodies, frame.settings.rotation, self.h);
        if self.bodies.turned.is_empty() {
            return;
        }
        let Self { bodies, slabs, .. } = self;
        let mut has_turned = vec![false; bodies.lines.len()];
        bodies.turned.iter().for_each(|&line| has_turned[line] = true);
        for Slab { batches, first_line } in slabs {
            let has_turned = &has_turned[*first_line..];
            let lines = &bodies.lines(*first_line..bodies.lines.len());
            for batch in batches {
                if batch.ids.iter().flatten().any(|&line| has_turned[line as usize]) {
                    I::run(
                        #[inline(always)]
                        || batch.prepare(lines),
                    );
                }
            }
        }
    }
}

fn bounces<I>(batch: &ContactBatch<I>) -> bool {
    batch.bounces.any()
}

/// Batches of constraints in this order, with their lines from `first_line` on.
fn batches<I: Instructions>(
    constraints: &[Constraint],
    order: Vec<(u32, u32)>,
    first_line: usize,
) -> Vec<ContactBatch<I>> {
    let mut batches: Vec<ContactBatch<I>> = Vec::with_capacity(order.len() / LANES + 16);
    let mut last_colour = None;
    let mut lane = 0;
    for (colour, number) in order {
        if last_colour != Some(colour) || lane == LANES {
            batches.push(ContactBatch::empty());
            lane = 0;
        }
        last_colour = Some(colour);
        let constraint = &constraints[number as usize];
        if let Some(batch) = batches.last_mut() {
            batch.fill(lane, (number, constraint), first_line);
        }
        lane += 1;
    }
    batches
}

/// Greedy colours: constraints of one colour share no movable body.
struct Colours {
    /// Which are taken at each line.
    taken: Vec<u128>,
}

impl Colours {
    fn new(lines: usize) -> Self {
        Self { taken: vec![0; lines] }
    }

    /// Some constraints by colour, those with most points first.
    fn of(&mut self, constraints: &[Constraint], members: &[u32]) -> Vec<(u32, u32)> {
        let movable_lines = |number: u32| {
            let constraint = &constraints[number as usize];
            let movable = (0..2).filter(|&side| constraint.is_movable[side]);
            movable.map(|side| constraint.lines[side] as usize)
        };
        let mut overflow = COLOURS - 1;
        let mut order: Vec<(u32, usize, u32)> = Vec::with_capacity(members.len());
        for &number in members {
            let used = movable_lines(number).fold(0, |used, line| used | self.taken[line]);
            let mut colour = (!used).trailing_zeros();
            if colour >= COLOURS - 1 {
                colour = overflow;
                overflow += 1;
            } else {
                movable_lines(number).for_each(|line| self.taken[line] |= 1 << colour);
            }
            let points = constraints[number as usize].points.len();
            order.push((colour, usize::MAX - points, number));
        }
        members
            .iter()
            .flat_map(|&number| movable_lines(number))
            .for_each(|line| self.taken[line] = 0);
        order.sort_unstable();
        order.into_iter().map(|(colour, _, number)| (colour, number)).collect()
    }
}
