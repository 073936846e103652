//! What the solver does for an island: more for what carries much through few.

use crate::manifold::Manifold;
use crate::threads;
use crate::{Bodies, Frame};
use glam::DVec3;

/// How often the pairs of a cluster act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Effort {
    /// Small steps of a frame.
    pub(crate) substeps: u32,
    /// Passes over all pairs at each stage of a substep, every other one backwards.
    pub(crate) passes: u32,
    /// How much stiffer its contacts may be than those that carry one body.
    pub(crate) stiffest: f64,
    /// How what meets fast is stopped, and bounces.
    pub(crate) meeting: Meeting,
    /// The most impacts that follow each other; others follow in the next substep. With one, what is struck passes nothing on. And the most
    /// passes over what they squeeze.
    pub(crate) impacts: u32,
    /// Whether it stands and carries much through few. Then overlaps close in full, or it sinks: with less a load of 1000 on ten cubes falls.
    pub(crate) carries_much: bool,
}

/// How what meets fast in a substep acts, before all else does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    /// Passes over all that does; one more where it bounces.
    pub(crate) passes: u32,
    /// Passes to and fro over the points of one pair within each of them.
    pub(crate) together: u32,
}

/// A cube that lands flat keeps 1e-3 of the turn that one pass over its points gives it.
const MEETING: Meeting = Meeting { passes: 4, together: 8 };

/// In heaps nobody sees that. While `pile-deep` falls together a fifth of the time and more went into it: with this it takes 0.88 of the time, in the mean, its overlaps are as deep, and it is calm as soon.
const MEETING_IN_HEAPS: Meeting = Meeting { passes: 2, together: 2 };

/// Small steps of a frame. With four of them stacks of ten drift by centimetres, and what falls in a heap is pressed into it.
const SUBSTEPS: u32 = 8;

/// The same of heaps that creep: 0.85 of the time. At 30 frames a second their contacts are as stiff as with eight, as with fewer they would not be; with four `pile-spread` hardly comes
/// to rest.
const SUBSTEPS_OF_CREEPING_HEAPS: u32 = 6;

/// A heap creeps if no more than so much of its pairs do not [1]: with a tenth `pile-table`, from which some still roll off, gains a twentieth less.
const RESTLESS: f64 = 0.3;

/// Islands of more pairs than this are heaps: each piece leans on many, and none of them has to balance.
const HEAP_PAIRS: usize = 2048;

/// Loads up to which one pass is enough, in units of what is lighter: so much do heaps of a few layers carry.
const LIGHT: f64 = 4.0;

/// Passes to and fro for each unit of the load: it has to get through as many others.
const PASSES_PER_LOAD: f64 = 0.5;

/// The fewest passes that are worth it: stiffer contacts sway with less.
const FEWEST_PASSES: f64 = 3.0;

/// The most passes.
const MOST_PASSES: f64 = 32.0;

/// Pairs times passes for one island: more is not in real time.
const BUDGET: f64 = 1024.0;

/// The same for all towers in a frame, and for all other islands together. Rubble under large chunks sinks a little if it gets too little, and figure 8
/// has much of it; but of sixty towers of thirty cubes all fall within 10 s if they share as little, and none moves by 2 cm with this, at 26 ms a frame.
const BUDGET_OF_TOWERS: f64 = 16_384.0;
const BUDGET_OF_OTHERS: f64 = 4096.0;

/// Bodies of which each rests on the next one, from which on they are a tower.
const TOWER: usize = 8;

/// How much stiffer contacts may be for each pass: what is stiffer than its passes have settled sways.
const STIFFER_PER_PASS: f64 = 6.0;

/// Speed [m/s] below which bodies stand: what was struck and flies carries nothing, and stiff contacts would fling it. Measured, not derived:
/// with 0.5 a load of 1:1000 falls while it settles, and without it figure 7's fragments are flung.
const STANDS: f64 = 2.0;

/// The cosine between a normal and the vertical from which on one body rests on the other.
const RESTS: f64 = 0.1;

impl Effort {
    /// What a cluster of some pairs takes that carry little. With one pass, to before the drift and fro after it, turned stacks drift by
    /// centimetres; heaps bear it. In a heap nobody sees who strikes whom next.
    pub(crate) fn of_size(pairs: usize) -> Self {
        let (passes, meeting, impacts) =
            if pairs > HEAP_PAIRS { (1, MEETING_IN_HEAPS, 1) } else { (2, MEETING, 32) };
        Self { substeps: SUBSTEPS, passes, meeting, stiffest: 1.0, impacts, carries_much: false }
    }

    /// The same of an island, of whose pairs some have a body that does not creep.
    pub(crate) fn of_island(pairs: usize, restless: usize) -> Self {
        let usual = Self::of_size(pairs);
        let creeps = usual.is_for_heap() && restless as f64 <= RESTLESS * pairs as f64;
        Self { substeps: if creeps { SUBSTEPS_OF_CREEPING_HEAPS } else { usual.substeps }, ..usual }
    }

    /// Whether it is for a heap.
    pub(crate) fn is_for_heap(&self) -> bool {
        self.passes == 1
    }

    /// Whether what is calm rests. On stiffer contacts it does not: it sways slowly, and a tower of 50 cubes would drift by 18 cm instead of 1. What gets
    /// no more than others sways anyway: a hundred towers of 20 cubes by 23 cm within 10 s, and by 12 if they do not rest.
    pub(crate) fn rests(&self) -> bool {
        self.stiffest <= 1.0
    }

    /// What those of some islands take that carry much, if they are small enough for that, and the load of each of their pairs.
    pub(crate) fn of_islands(
        bodies: &Bodies,
        manifolds: &[Manifold],
        islands: &[Vec<usize>],
        frame: &Frame,
    ) -> Vec<Option<(Self, Vec<f64>)>> {
        let Some(up) = (-frame.gravity).try_normalize() else {
            return islands.iter().map(|_| None).collect();
        };
        let carriers = threads::list(bodies.len(), |i| Carrier::new(bodies, i, up));
        let carries = |places: &mut Vec<u32>, island: &Vec<usize>| {
            Self::carries_much(&carriers, (manifolds, up), island, places)
        };
        let room = || vec![NOBODY; bodies.len()];
        let loads: Vec<Option<Loads>> =
            threads::map_with(islands.iter().collect(), manifolds.len(), room, carries);

        // Where many do, each gets less.
        let (mut of_towers, mut of_others) = (0.0, 0.0);
        for loads in loads.iter().flatten() {
            let effort = Self::of_load(loads.of_pairs.len(), loads.most(), 1.0);
            let passes = effort.map_or(0.0, |effort| 0.5 * f64::from(effort.passes));
            *(if loads.is_tower() { &mut of_towers } else { &mut of_others }) +=
                passes * loads.of_pairs.len() as f64;
        }
        let shares = [BUDGET_OF_OTHERS / of_others, BUDGET_OF_TOWERS / of_towers].map(|share| share.min(1.0));
        let of = |loads: Option<Loads>| {
            let loads = loads?;
            let share = shares[usize::from(loads.is_tower())];
            Some((Self::of_load(loads.of_pairs.len(), loads.most(), share)?, loads.of_pairs))
        };
        loads.into_iter().map(of).collect()
    }

    /// The loads of an island, if it stands and may get more effort than others.
    fn carries_much(
        carriers: &[Carrier],
        (manifolds, up): (&[Manifold], DVec3),
        island: &[usize],
        places: &mut [u32],
    ) -> Option<Loads> {
        let stands = |&at: &usize| bodies_of(&manifolds[at]).iter().all(|&i| carriers[i].stands);
        if FEWEST_PASSES * island.len() as f64 > BUDGET || !island.iter().all(stands) {
            return None;
        }
        loads(carriers, (manifolds, up), island, places)
    }

    /// By the largest load, a share of it; those that would get too little get no more than others. Soft contact gives by what it carries, and high stacks buckle by that; stiff contact takes more passes.
    fn of_load(pairs: usize, load: f64, share: f64) -> Option<Self> {
        let wanted = (PASSES_PER_LOAD * load).min(BUDGET / pairs as f64).min(MOST_PASSES);
        if load <= LIGHT || wanted < FEWEST_PASSES {
            return None;
        }
        let passes = (share * wanted).floor();
        let others = Self { carries_much: true, ..Self::of_size(pairs) };
        let is_enough = passes >= FEWEST_PASSES;
        let more = Self { passes: 2 * passes as u32, stiffest: STIFFER_PER_PASS * passes, ..others };
        Some(if is_enough { more } else { others })
    }
}

/// A body, as far as loads go: those of a heap lie side by side.
#[derive(Clone, Copy)]
struct Carrier {
    /// Along gravity, backwards [m].
    height: f64,
    /// [kg]; 0 if impulses do not move it.
    mass: f64,
    /// [1/kg]
    inverse_mass: f64,
    /// See [`STANDS`].
    stands: bool,
}

impl Carrier {
    fn new(bodies: &Bodies, i: usize, up: DVec3) -> Self {
        let inertia = &bodies.inertias[i];
        Self {
            height: bodies.poses[i].position.dot(up),
            mass: if inertia.is_infinite() { 0.0 } else { bodies.masses[i] },
            inverse_mass: inertia.inverse_mass,
            stands: bodies.velocities[i].linear.length() < STANDS,
        }
    }

    fn is_mobile(&self) -> bool {
        self.inverse_mass > 0.0
    }
}

fn bodies_of(manifold: &Manifold) -> [usize; 2] {
    [manifold.pair.first, manifold.pair.second]
}

/// A body of an island that moves, and what rests on it.
struct Loaded {
    /// Dense index.
    body: u32,
    /// Along gravity, backwards [m].
    height: f64,
    /// It and what rests on it [kg].
    mass: f64,
    /// On how many it rests, and where these begin among all supports.
    supports: usize,
    begin: usize,
    /// The most bodies of which each rests on the next one, down to it.
    high: usize,
}

/// What a body rests on.
#[derive(Clone, Copy)]
struct Support {
    /// The places of the one above and of the one below among the loaded ones; this one is [`NOBODY`] if it does not move.
    upper: u32,
    lower: u32,
    /// Place of the pair in its island.
    pair: usize,
    /// Inverse mass of the lighter one [1/kg].
    lightness: f64,
}

/// Not among the loaded ones.
const NOBODY: u32 = u32::MAX;

/// What an island carries.
struct Loads {
    /// Of each pair, in units of the lighter one's weight.
    of_pairs: Vec<f64>,
    /// The most bodies of which each rests on the next one.
    high: usize,
}

impl Loads {
    fn most(&self) -> f64 {
        self.of_pairs.iter().copied().fold(0.0, f64::max)
    }

    fn is_tower(&self) -> bool {
        self.high >= TOWER
    }
}

/// What an island carries: each body hands its own weight and what rests on it to those that it rests on, in equal parts, from the highest down. None if
/// no pair can carry more than is [`LIGHT`]. `places` has room for all bodies: all are [`NOBODY`], and are so again at the end.
fn loads(
    carriers: &[Carrier],
    (manifolds, up): (&[Manifold], DVec3),
    island: &[usize],
    places: &mut [u32],
) -> Option<Loads> {
    // No pair carries more than all of them weigh: no more than what each weighs as often as it is in a pair.
    let mobile = island.iter().flat_map(|&at| bodies_of(&manifolds[at])).map(|i| &carriers[i]);
    let (weights, lightest) = mobile.fold((0.0, 0.0), |(weights, lightest): (f64, f64), carrier| {
        (weights + carrier.mass, lightest.max(carrier.inverse_mass))
    });
    if weights * lightest < LIGHT {
        return None;
    }

    // Who is in it, and who rests on whom.
    let mut loaded: Vec<Loaded> = Vec::with_capacity(island.len() + 1);
    let mut supports: Vec<Support> = Vec::with_capacity(island.len());
    for (number, &at) in island.iter().enumerate() {
        let pair = bodies_of(&manifolds[at]);
        // Between the normal of its first point and the vertical.
        let cosine = manifolds[at].points.first().map_or(0.0, |point| point.normal.dot(up));
        let [first, second] = pair.map(|i| {
            let (place, carrier) = (&mut places[i], &carriers[i]);
            if *place == NOBODY && carrier.is_mobile() {
                *place = loaded.len() as u32;
                let Carrier { height, mass, .. } = *carrier;
                loaded.push(Loaded { body: i as u32, height, mass, supports: 0, begin: 0, high: 1 });
            }
            *place
        });
        let (upper, lower) = if cosine > 0.0 { (first, second) } else { (second, first) };
        if cosine.abs() > RESTS && upper != NOBODY {
            let [a, b] = pair.map(|i| carriers[i].inverse_mass);
            supports.push(Support { upper, lower, pair: number, lightness: a.max(b) });
            loaded[upper as usize].supports += 1;
        }
    }
    loaded.iter().for_each(|loaded| places[loaded.body as usize] = NOBODY);
    let weight: f64 = loaded.iter().map(|loaded| loaded.mass).sum();
    if weight * lightest < LIGHT {
        return None;
    }

    // Those of each body lie together.
    let mut end = 0;
    for loaded in &mut loaded {
        loaded.begin = end;
        end += loaded.supports;
    }
    let mut of_uppers = supports.clone();
    for support in supports {
        let begin = &mut loaded[support.upper as usize].begin;
        of_uppers[*begin] = support;
        *begin += 1;
    }

    // From the highest down.
    let mut order: Vec<(f64, u32, u32)> =
        (0..).zip(&loaded).map(|(at, loaded)| (loaded.height, loaded.body, at)).collect();
    order.sort_unstable_by(|(height, a, _), (other, b, _)| other.total_cmp(height).then(a.cmp(b)));
    let mut of_pairs = vec![0.0; island.len()];
    for (.., upper) in order {
        let Loaded { mass, supports, begin: end, high, .. } = loaded[upper as usize];
        let share = mass / supports as f64;
        for support in &of_uppers[end - supports..end] {
            of_pairs[support.pair] = share * support.lightness;
            if let Some(lower) = loaded.get_mut(support.lower as usize) {
                lower.mass += share;
                lower.high = lower.high.max(high + 1);
            }
        }
    }
    Some(Loads { of_pairs, high: loaded.iter().map(|loaded| loaded.high).max()? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifold::ManifoldPoint;
    use crate::pair::Pair;
    use crate::{Contactant, Motion, NewBody, Pose, StepSettings, Velocity};
    use frangible_geometry::{ClosedForm, Shape};
    use glam::DQuat;
    use std::sync::Arc;

    /// Where many islands carry much, each gets less, but towers share more between them than heavy chunks on small ones do; what gets no stiffer contacts
    /// than others rests like others.
    #[test]
    fn towers_have_a_budget_of_their_own() {
        const COUNT: usize = 60;
        const HIGH: usize = 30;
        let shape = Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1));
        let point = ManifoldPoint {
            anchor_first: DVec3::ZERO,
            anchor_second: DVec3::ZERO,
            rounding: [0.5; 2],
            normal: -DVec3::Y,
            sample: (true, 0),
            approach: 0.0,
            gap: 0.0,
        };
        let points = [point];
        let mut bodies = Bodies::default();
        let (mut manifolds, mut islands) = (Vec::new(), Vec::new());
        // The lowest first; of each the densities.
        let mut stack = |densities: &[f64]| {
            let mut island = Vec::new();
            for (level, &density) in densities.iter().enumerate() {
                let first = bodies.len();
                bodies.spawn(NewBody {
                    shape: shape.clone(),
                    density,
                    motion: Motion::Dynamic,
                    pose: Pose { position: level as f64 * DVec3::Y, orientation: DQuat::IDENTITY },
                    velocity: Velocity::default(),
                    contactant: Contactant::new(0.0, 0.5),
                });
                if level + 1 < densities.len() {
                    island.push(manifolds.len());
                    let pair = Pair { first, second: first + 1 };
                    manifolds.push(Manifold { pair, points: &points, struck: 0.0 });
                }
            }
            islands.push(island);
        };
        for _ in 0..COUNT {
            stack(&[1.0; HIGH]);
            (0..4).for_each(|_| stack(&[&[1.0; TOWER - 2][..], &[100.0]].concat()));
        }
        let frame = Frame { dt: 1.0 / 30.0, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
        let of = |islands: &[Vec<usize>]| -> Vec<Effort> {
            Effort::of_islands(&bodies, &manifolds, islands, &frame)
                .into_iter()
                .map(|of| of.unwrap().0)
                .collect()
        };

        // Alone each gets all that it wants.
        let (tower, chunk) = (of(&islands[..1])[0], of(&islands[1..2])[0]);
        assert!(tower.passes >= 28 && chunk.passes >= 28, "{tower:?} {chunk:?}");
        assert!(!tower.rests() && !chunk.rests());
        let all = of(&islands);
        assert!(2 * all[0].passes > tower.passes && !all[0].rests(), "{:?}", all[0]);
        assert!(all[1].carries_much && all[1].rests() && all[1].passes == 2, "{:?}", all[1]);
    }

    /// Only heaps take fewer substeps, while most of their pairs creep.
    #[test]
    fn heaps_that_creep_take_fewer_substeps() {
        let of = |pairs: usize, restless: usize| Effort::of_island(pairs, restless).substeps;
        let heap = 10 * HEAP_PAIRS;
        let some = (RESTLESS * heap as f64) as usize;
        assert_eq!([of(heap, 0), of(heap, some)], [SUBSTEPS_OF_CREEPING_HEAPS; 2]);
        assert_eq!([of(heap, some + 1), of(heap, heap), of(HEAP_PAIRS, 0)], [SUBSTEPS; 3]);
        assert_eq!(
            [heap, HEAP_PAIRS].map(|pairs| Effort::of_size(pairs).meeting),
            [MEETING_IN_HEAPS, MEETING]
        );
        assert_eq!(Effort::of_island(heap, 0), Effort { substeps: of(heap, 0), ..Effort::of_size(heap) });
    }

    /// What is large gets no more than its size says, and neither does what carries little.
    #[test]
    fn effort_follows_the_load_within_the_budget() {
        assert_eq!(Effort::of_load(10, LIGHT, 1.0), None);
        assert_eq!(Effort::of_load(BUDGET as usize, 1000.0, 1.0), None);
        let of =
            |pairs: usize, load: f64| Effort::of_load(pairs, load, 1.0).unwrap_or(Effort::of_size(pairs));
        let (tower, higher, wider) = (of(10, 10.0), of(20, 20.0), of(200, 20.0));
        assert_eq!(tower.passes, 10);
        assert!(higher.passes > tower.passes && higher.stiffest > tower.stiffest);
        assert!(wider.passes < higher.passes && wider.passes > Effort::of_size(200).passes);
        assert!(f64::from(of(1, 1e9).passes) <= 2.0 * MOST_PASSES);

        // What is at its limits shrinks with its share, too.
        let shared = Effort::of_load(10, 1e9, 0.25).map_or(0, |effort| effort.passes);
        assert_eq!(4 * shared, of(10, 1e9).passes);
    }
}
