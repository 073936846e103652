//! Solver islands of bodies that may touch within the frame, and their substep counts.

use super::solver_bodies::{TURN, is_round};
use crate::energy::islands::root;
use crate::frame_rate::sleep::Sleep;
use frangible_bodies::{Bodies, Frame, Inertia, Pair, Substeps};
use frangible_collision::{CachedImpulse, Manifold, ManifoldPoint};
use frangible_math::threads;
use glam::DVec3;
use std::collections::BTreeMap;

/// Contact frequency as a fraction of the substep rate [1]: higher frequencies vibrate [Cat24].
/// With half of it a wall of 1,000 bricks overlaps four times as far.
pub(super) const CONTACT_RATE: f64 = 0.25;

/// Overlap of a resting contact under load, relative to the smaller body's radius [1]. With half of
/// it 9,000 pieces in two layers overlap by a median of 0.03 mm instead of 0.05, for a fifth more
/// time.
const RESTING_DEPTH: f64 = 2e-3;

/// Overlap of a resting contact times island height, relative to the squared radius [1]: tall
/// stacks lean until they fall if contacts yield more. Towers of fifty cubes stand with this value,
/// and fall with twice as much.
const LEANING_DEPTH: f64 = 0.03;

/// Overlap of a heavy body's impact on a lighter body, relative to half of the thinner body's
/// thickness [1].
const IMPACT_DEPTH: f64 = 0.2;

/// Half-life [s] of a solver island's substep demand. Counts grow at once, and shrink only if the
/// demand is below [`SHRINKS_BELOW`] of half the count: a swaying tower must not alternate between
/// stiff and soft. With a tenth of the half-life, or with a fraction of 1, a tower of fifty cubes
/// moves with 10 or 8 J after four seconds, instead of 0.04.
const HALF_LIFE: f64 = 0.5;
const SHRINKS_BELOW: f64 = 0.75;

/// Target nutation of a body of revolution per substep [rad]: both ends of an axis that nutates
/// further meet the ground out of step. Without it short capsules at 600 rad/s jump by 1.4 m, and
/// cylinders of 1 cm lose 3 percent of 14 m/s in 10 s; with it they lose 0.001 percent.
const NUTATION: f64 = 0.5;

/// Limit of manifolds times substeps of an island in a frame; larger islands take fewer substeps,
/// but never below the settings' minimum. With half of it a wall of 51 courses and 1,000 bricks
/// falls, while an impact on a wall of 1,000 takes two thirds of the time.
const MOST_WORK: usize = 1 << 18;

/// Manifolds per bundle of islands: enough to fill the lanes of each colour, and small enough for a
/// core's own cache (0.2 MiB).
const BUNDLE: usize = 512;

/// Islands with equal substep counts, solved together.
pub(super) struct Bundle {
    pub(super) substeps: u32,
    /// Indices of manifolds with points.
    pub(super) members: Vec<usize>,
}

/// All islands of a frame.
pub(super) struct IslandGroups {
    pub(super) bundles: Vec<Bundle>,
    /// Per body, by dense index; zero for sleeping bodies and bodies without contacts.
    pub(super) substeps: Vec<Substeps>,
    /// Number of islands with fewer substeps than their demand.
    pub(super) short_of_substeps: usize,
    pub(super) sleep: Sleep,
}

impl IslandGroups {
    pub(super) fn new(
        bodies: &Bodies,
        manifolds: &[Manifold],
        carried: &[&[CachedImpulse]],
        frame: &Frame,
    ) -> Self {
        let is_fixed: Vec<bool> = bodies.inertias.iter().map(Inertia::is_infinite).collect();
        let mut islands = islands(&is_fixed, manifolds);
        let sleep = Sleep::extract(bodies, (manifolds, carried), &mut islands, frame);

        let forgets = libm::exp2(-frame.dt / HALF_LIFE) as f32;
        let (mut bundles, mut open): (Vec<Bundle>, BTreeMap<u32, usize>) = Default::default();
        let mut substeps = vec![Substeps::default(); bodies.len()];
        let mut is_counted = vec![[false; 2]; bodies.len()];
        let mut short_of_substeps = 0;
        let turns = threads::list(bodies.len(), |i| substeps_of_turn(bodies, i, frame));
        for island in islands {
            let pairs = island.iter().map(|&number| manifolds[number].pair);
            let stack = Stack::of(bodies, pairs, &mut is_counted, frame);
            let (mut needed, mut last) = (0.0_f64, Substeps::default());
            for &number in &island {
                let manifold = &manifolds[number];
                needed = needed.max(substeps_of_pair(
                    bodies,
                    manifold,
                    (carried[number], &stack),
                    frame,
                ));
                for i in manifold.pair.both().into_iter().filter(|&i| !is_fixed[i]) {
                    needed = needed.max(turns[i]);
                    last = last.max(bodies.activities[i].substeps);
                }
            }
            // A demand beyond the count is an impact's, which is over.
            let remembered = forgets * last.needed.min(last.count as f32);
            let needed = (needed as f32).max(remembered);
            let count = count(needed, last.count, island.len(), frame);
            short_of_substeps += usize::from((count as f32) < needed);
            let bodies_of = island.iter().flat_map(|&number| manifolds[number].pair.both());
            bodies_of.for_each(|i| substeps[i] = Substeps { count, needed });
            match open.get(&count).map(|&at| &mut bundles[at].members) {
                Some(members) if members.len() + island.len() <= BUNDLE => members.extend(island),
                _ => {
                    open.insert(count, bundles.len());
                    bundles.push(Bundle { substeps: count, members: island });
                }
            }
        }
        // Sort by pair, independent of the islands.
        bundles.iter_mut().for_each(|bundle| bundle.members.sort_unstable());
        Self { bundles, substeps, short_of_substeps, sleep }
    }
}

/// Indices of each island's manifolds with points, ordered by first manifold.
fn islands(is_fixed: &[bool], manifolds: &[Manifold]) -> Vec<Vec<usize>> {
    let mut parent: Vec<u32> = (0..is_fixed.len() as u32).collect();
    let touching = || manifolds.iter().enumerate().filter(|(_, of)| !of.points.is_empty());
    for (_, Manifold { pair: Pair { first, second }, .. }) in touching() {
        if !is_fixed[*first] && !is_fixed[*second] {
            let [a, b] = [*first, *second].map(|i| root(&mut parent, i as u32));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut number_of = vec![usize::MAX; is_fixed.len()];
    let mut islands: Vec<Vec<usize>> = Vec::new();
    for (number, Manifold { pair, .. }) in touching() {
        let movable = if is_fixed[pair.first] { pair.second } else { pair.first };
        let island = &mut number_of[root(&mut parent, movable as u32) as usize];
        if *island == usize::MAX {
            *island = islands.len();
            islands.push(Vec::new());
        }
        islands[*island].push(number);
    }
    islands
}

/// Height and weight of an island.
struct Stack {
    /// Extent of the bodies' centres along gravity [m].
    height: f64,
    /// Island weight per mass of bodies on fixed bodies [m/s^2]: the mean load of ground contacts
    /// at rest, as new contacts have no load yet.
    ground_load: f64,
}

impl Stack {
    /// `is_counted` marks bodies already counted, in the island and on the ground.
    fn of(
        bodies: &Bodies,
        pairs: impl Iterator<Item = Pair>,
        is_counted: &mut [[bool; 2]],
        frame: &Frame,
    ) -> Self {
        let down = frame.gravity.normalize_or_zero();
        let (mut low, mut high, mut masses) = (f64::INFINITY, f64::NEG_INFINITY, [0.0; 2]);
        for pair in pairs {
            let is_fixed = pair.both().map(|i| bodies.inertias[i].is_infinite());
            for side in (0..2).filter(|&side| !is_fixed[side]) {
                let i = pair.both()[side];
                let depth = down.dot(bodies.poses[i].position);
                (low, high) = (low.min(depth), high.max(depth));
                for (of, counts) in [true, is_fixed[1 - side]].into_iter().enumerate() {
                    if counts && !std::mem::replace(&mut is_counted[i][of], true) {
                        masses[of] += bodies.masses[i];
                    }
                }
            }
        }
        let [all, on_ground] = masses;
        let gravity = frame.gravity.length();
        let ground_load = if on_ground > 0.0 { gravity * all / on_ground } else { 0.0 };
        Self { height: (high - low).max(0.0), ground_load }
    }
}

/// Substep count, the settings' minimum times a power of two, for an island of `manifolds`.
pub(super) fn count(needed: f32, last: u32, manifolds: usize, frame: &Frame) -> u32 {
    let least = frame.settings.substeps;
    let most = frame.settings.most_substeps.max(least);
    let mut count = least;
    while (count as f32) < needed && count < most {
        count *= 2;
    }
    let half = last / 2;
    if count <= half {
        let is_enough = needed <= SHRINKS_BELOW as f32 * half as f32;
        count = if is_enough { half } else { last };
    }
    while count > least && count as usize * manifolds > MOST_WORK {
        count /= 2;
    }
    count.max(least)
}

/// Substeps for a bounded contact overlap: the spring's stiffness follows from the lighter body's
/// mass and the contact frequency, and its damping stops an impact in a quarter period.
fn substeps_of_pair(
    bodies: &Bodies,
    Manifold { pair, points, .. }: &Manifold,
    (carried, stack): (&[CachedImpulse], &Stack),
    frame: &Frame,
) -> f64 {
    let both = [pair.first, pair.second];
    let movable = || both.into_iter().filter(|&i| !bodies.inertias[i].is_infinite());
    let lightest = movable().map(|i| bodies.masses[i]).fold(f64::INFINITY, f64::min);
    let heaviest = movable().map(|i| bodies.masses[i]).fold(0.0, f64::max);
    let size = both.map(|i| bodies.radii[i]).into_iter().fold(f64::INFINITY, f64::min);
    let frequency = std::f64::consts::TAU * CONTACT_RATE / frame.dt;

    // The load is the cached impulse, or the heavier body's weight if it rests on the lighter body.
    let force: f64 = carried.iter().map(|point| f64::from(point.force.normal)).sum();
    let first_is_heavier = bodies.masses[pair.first] == heaviest;
    let down = points.iter().map(|point| {
        let towards_lighter = if first_is_heavier { -point.normal } else { point.normal };
        frame.gravity.dot(towards_lighter)
    });
    let mut load = (force / lightest).max(heaviest / lightest * down.fold(0.0, f64::max));
    if movable().count() == 1 {
        load = load.max(stack.ground_load);
    }
    let depth = (RESTING_DEPTH * size).min(LEANING_DEPTH * size * size / stack.height);
    let at_rest = (load / depth).sqrt() / frequency;
    at_rest
        .max(presses(bodies, both, points) / frequency)
        .max(impact_turn(bodies, both, points, frame) / TURN)
}

/// Angle by which the impacts at a manifold's points turn one of its bodies until the frame ends
/// [rad]: from each touch to the next one the impulse acts at the mean of the points that have
/// touched. Without it corners of one in ten random hulls and compounds come through a thin plate
/// that they hit; with it, of one in sixteen.
fn impact_turn(bodies: &Bodies, both: [usize; 2], points: &[ManifoldPoint], frame: &Frame) -> f64 {
    let time = |point: &ManifoldPoint| point.gap.max(0.0) / point.approach;
    let is_impact =
        |point: &&ManifoldPoint| point.approach > frame.impact_speed() && time(point) < frame.dt;
    let mut touches: Vec<&ManifoldPoint> = points.iter().filter(is_impact).collect();
    touches.sort_by(|a, b| time(a).total_cmp(&time(b)));
    let rebound = 1.0 + bodies.pair_surface(both[0], both[1]).restitution.max(0.0);

    let (mut anchors, mut turns) = ([DVec3::ZERO; 2], [0.0; 2]);
    for (number, point) in touches.iter().enumerate() {
        anchors[0] += point.anchor_first;
        anchors[1] += point.anchor_second;
        let until = touches.get(number + 1).map_or(frame.dt, |next| time(next));
        let share = 1.0 / (number + 1) as f64;
        let (mut inverse_mass, mut spins) = (0.0, [0.0; 2]);
        for side in 0..2 {
            let (inertia, pose) = (&bodies.inertias[both[side]], &bodies.poses[both[side]]);
            let moment = (pose.orientation * (share * anchors[side])).cross(point.normal);
            let spin = inertia.inverse_tensor(pose.orientation) * moment;
            inverse_mass += inertia.inverse_mass + moment.dot(spin);
            spins[side] = if is_round(inertia) { 0.0 } else { spin.length() };
        }
        for side in 0..2 {
            let per_impulse = (until - time(point)) * spins[side];
            turns[side] += per_impulse * rebound * point.approach / inverse_mass;
        }
    }
    turns[0].max(turns[1])
}

/// Speed at which the heavier body may press the lighter body, in units of the allowed overlap
/// [1/s]; effective masses at the contact tell heavy from light.
fn presses(bodies: &Bodies, both: [usize; 2], points: &[ManifoldPoint]) -> f64 {
    let half_extent = |i: usize| {
        let (low, high) = bodies.shapes[i].bounds;
        0.5 * (high - low).min_element()
    };
    let thin = both.map(half_extent).into_iter().fold(f64::INFINITY, f64::min);
    let of_point = |point: &ManifoldPoint| {
        let inverse_mass = |side: usize| {
            let (i, anchor) = (both[side], [point.anchor_first, point.anchor_second][side]);
            let (inertia, pose) = (&bodies.inertias[i], &bodies.poses[i]);
            let moment = (pose.orientation * anchor).cross(point.normal);
            inertia.inverse_mass + moment.dot(inertia.inverse_tensor(pose.orientation) * moment)
        };
        let [first, second] = [0, 1].map(inverse_mass);
        let (light, heavy) = (first.max(second), first.min(second));
        // Fixed bodies have ratio 1: no pressing.
        let ratio = if heavy > 0.0 { light / heavy } else { 1.0 };
        point.approach * (ratio.sqrt() - 1.0)
    };
    let fast = points.iter().filter(|point| point.approach > 0.0);
    fast.map(of_point).fold(0.0, f64::max) / (IMPACT_DEPTH * thin)
}

fn substeps_of_turn(bodies: &Bodies, i: usize, frame: &Frame) -> f64 {
    let inertia = &bodies.inertias[i];
    if inertia.is_infinite() || is_round(inertia) {
        return 0.0;
    }
    let pose = &bodies.poses[i];
    let spin = bodies.spin(i, pose, &bodies.velocities[i]);
    // Anchors on the axis of a body of revolution stay, at any spin about it; but its axis nutates.
    let sweeping = bodies.sweeping_spin(i, pose, spin);
    let DVec3 { x, y, .. } = inertia.inverse_moments;
    let nutation = (spin - sweeping).length() * x / y;
    (sweeping.length() / TURN).max(nutation / NUTATION) * frame.dt
}
