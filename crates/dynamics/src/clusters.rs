//! Who is solved with whom: islands of bodies that may touch do not feel each other, so some of them at a time go through all substeps
//! while their numbers are at hand; and within them, pairs that share no body act side by side.

use crate::balance::Balance;
use crate::contact_batch::Touching;
use crate::effort::Effort;
use crate::islands::root;
use crate::kept_pairs::creeping_below;
use crate::manifold::{MOST_POINTS, Manifold};
use crate::moving::{fastest, is_calm};
use crate::pair::Pair;
use crate::regions::Regions;
use crate::sleep::Sleep;
use crate::threads;
use crate::warm_start::WarmStart;
use crate::{Bodies, Frame, Inertia, Motion};
use glam::DVec3;
use std::collections::BTreeMap;

/// Pairs that are solved together, of small islands: their numbers fit into a core's own cache.
const CLUSTER_PAIRS: usize = 512;

/// Frames, one after the other, in which a body could come to rest, after which it probably can in the next one [1]. Eight pairs side by side rest only
/// together: of those that could in one frame 3 % cannot in the next one in `pile-spread`, 17 % in figure 8's heap.
pub(crate) const SETTLED_AFTER: u8 = 4;

/// Speed from which on a body may bounce, or what it strikes, in units of what gravity gives in a frame [1].
const LIVELY: f64 = 0.5;

/// Some islands.
pub(crate) struct Cluster {
    /// Their bodies and the static and kinematic ones that they may touch, by dense index.
    pub(crate) bodies: Vec<usize>,
    /// Their pairs, region by region, rank by rank.
    pub(crate) members: Vec<Member>,
    /// Where each rank of each [region](Regions) ends among them. Pairs of one rank share no body that can move.
    pub(crate) rank_ends: Vec<Vec<usize>>,
    /// How often they act.
    pub(crate) effort: Effort,
}

/// A pair of a cluster.
#[derive(Clone, Copy)]
pub(crate) struct Member {
    /// Its place among the manifolds.
    pub(crate) manifold: usize,
    /// The places of its bodies in the cluster.
    pub(crate) locals: [u32; 2],
    /// Of its contact, in units of that of a pair that carries one body.
    pub(crate) stiffness: f64,
    /// Whether it is in a heap.
    pub(crate) is_in_heap: bool,
}

/// Which pairs are solved together.
pub(crate) struct Plan {
    /// The pairs of each cluster, by their places among the manifolds, and how often they act.
    pub(crate) clusters: Vec<(Vec<usize>, Effort)>,
    /// Of each contact, in units of that of a pair that carries one body.
    pub(crate) stiffness: Vec<f64>,
    /// Whether each body probably comes to rest in this frame; what is static always does.
    pub(crate) settled: Vec<bool>,
    /// Who is in no cluster, as it sleeps or is in balance.
    pub(crate) sleep: Sleep,
    pub(crate) balance: Balance,
}

/// Whether a body probably comes to rest in this frame, as it could in some before; what is static does.
pub(crate) fn has_settled(bodies: &Bodies, i: usize, warm: &WarmStart) -> bool {
    match bodies.motions[i] {
        Motion::Static => true,
        Motion::Kinematic { .. } => false,
        Motion::Dynamic => warm.settled_for(bodies.ids[i]) >= SETTLED_AFTER && is_calm(fastest(bodies, i)),
    }
}

/// Puts islands together: `warm` knows who has settled.
pub(crate) fn plan(bodies: &Bodies, touching: Touching, warm: &WarmStart, frame: &Frame) -> Plan {
    let Touching { manifolds, carried, .. } = touching;
    let speeds = threads::list(bodies.len(), |i| match bodies.motions[i] {
        Motion::Kinematic { linear, angular } if angular != DVec3::ZERO => {
            linear.length() + angular.length() * bodies.radii[i]
        }
        Motion::Kinematic { linear, .. } => linear.length(),
        Motion::Static | Motion::Dynamic => fastest(bodies, i),
    });
    let settled = threads::list(bodies.len(), |i| has_settled(bodies, i, warm));
    let creeping = creeping_below(frame);
    let least = LIVELY * frame.gravity.length() * frame.dt;
    let mut clusters = Vec::new();
    let mut stiffness = vec![1.0; manifolds.len()];
    let mut add = |pairs: Vec<usize>, effort: Effort| clusters.push((pairs, effort));

    // What takes more goes with those that take as much, what has settled with others that have, and what may bounce with others that may: where
    // anything does, nothing rests.
    let mut careful: BTreeMap<u32, (Vec<usize>, Effort)> = BTreeMap::new();
    let [mut settled_pairs, mut lively_pairs, mut others] = [Vec::new(), Vec::new(), Vec::new()];
    let mut islands = islands(bodies, manifolds);
    let sleep = Sleep::take_out(bodies, (manifolds, carried), &mut islands, (warm, frame));
    let balance = Balance::take_out(bodies, touching, &mut islands, (&settled, warm, frame));
    let efforts = Effort::of_islands(bodies, manifolds, &islands, frame);
    for (island, effort) in islands.iter().zip(efforts) {
        if let Some((effort, loads)) = effort {
            for (&at, load) in island.iter().zip(loads) {
                stiffness[at] = load.clamp(1.0, effort.stiffest);
            }
            let (alike, _) = careful.entry(effort.passes).or_insert_with(|| (Vec::new(), effort));
            alike.extend_from_slice(island);
            if alike.len() >= CLUSTER_PAIRS {
                add(std::mem::take(alike), effort);
            }
            continue;
        }
        if island.len() >= CLUSTER_PAIRS {
            let is_restless = |pair: Pair| speeds[pair.first] >= creeping || speeds[pair.second] >= creeping;
            let restless = island.iter().filter(|&&at| is_restless(manifolds[at].pair)).count();
            add(island.clone(), Effort::of_island(island.len(), restless));
            continue;
        }
        let any = |of: &dyn Fn(usize) -> bool| {
            island.iter().map(|&at| manifolds[at].pair).any(|pair| of(pair.first) || of(pair.second))
        };
        let alike = if !any(&|i| !settled[i]) {
            &mut settled_pairs
        } else if any(&|i| speeds[i] > least) {
            &mut lively_pairs
        } else {
            &mut others
        };
        alike.extend_from_slice(island);
        if alike.len() >= CLUSTER_PAIRS {
            add(std::mem::take(alike), Effort::of_size(CLUSTER_PAIRS));
        }
    }
    let others = [lively_pairs, others, settled_pairs].map(|pairs| {
        let effort = Effort::of_size(pairs.len());
        (pairs, effort)
    });
    for (pairs, effort) in careful.into_values().chain(others) {
        if !pairs.is_empty() {
            add(pairs, effort);
        }
    }
    Plan { clusters, stiffness, settled, sleep, balance }
}

/// Not in the cluster.
pub(crate) const NOWHERE: u32 = u32::MAX;

impl Cluster {
    /// One of a plan. `local` has room for all bodies: all are [`NOWHERE`], and are so again at the end.
    pub(crate) fn new(
        bodies: &Bodies,
        touching: Touching,
        Plan { clusters, stiffness, settled, .. }: &Plan,
        number: usize,
        local: &mut [u32],
    ) -> Self {
        let (pairs, effort) = &clusters[number];
        let (mut who, mut locals_of) = (Vec::new(), Vec::with_capacity(pairs.len()));
        for &manifold in pairs {
            let pair = touching.manifolds[manifold].pair;
            locals_of.push([pair.first, pair.second].map(|i| {
                if local[i] == NOWHERE {
                    local[i] = who.len() as u32;
                    who.push(i);
                }
                local[i]
            }));
        }
        who.iter().for_each(|&i| local[i] = NOWHERE);

        // Region by region. What has no points is only watched, behind all that has; but where impacts follow each other, it acts among the others.
        let regions = Regions::new(bodies, &who, pairs.len());
        let (mut pairs_of, mut watched) = (vec![Vec::new(); regions.count()], Vec::new());
        for (place, &locals) in locals_of.iter().enumerate() {
            let acts = effort.impacts > 1 || !touching.manifolds[pairs[place]].points.is_empty();
            if acts { &mut pairs_of[regions.of_pair(locals)] } else { &mut watched }.push(place);
        }
        let is_mobile = |&local: &usize| !bodies.inertias[who[local]].is_infinite();
        let are_settled = |&place: &usize| {
            effort.rests() && locals_of[place].iter().all(|&local| settled[who[local as usize]])
        };
        let rank_all = |next_ranks: &mut NextRanks, (of_region, ranked): &mut (Vec<usize>, Ranked)| {
            let mut places = Places::default();
            let mut members = Vec::with_capacity(of_region.len());
            // What has settled has ranks of its own, as a few that move would keep all awake that lie side by side with them.
            let (settled, others): (Vec<usize>, Vec<usize>) = of_region.drain(..).partition(are_settled);
            for alike in [settled, others] {
                let first_rank = places.ranks();
                for place in alike {
                    let (manifold, locals) = (pairs[place], locals_of[place]);
                    let mobile = locals.map(|local| local as usize).into_iter().filter(is_mobile);
                    let rank = first_rank + next_ranks.next(mobile);
                    let counts =
                        (touching.manifolds[manifold].points.len(), touching.carried[manifold].len());
                    let (stiffness, is_in_heap) = (stiffness[manifold], effort.is_for_heap());
                    let member = Member { manifold, locals, stiffness, is_in_heap };
                    members.push((places.count(rank, counts), member));
                }
                for (_, member) in &members {
                    member.locals.iter().for_each(|&local| next_ranks.clear(local as usize));
                }
            }

            // Side by side are those with about as many points, of which about as many carried in the last frame.
            ranked.ends = places.begin();
            ranked.members = vec![Member::NOBODY; members.len()];
            for (place, member) in members {
                ranked.members[places.next(place)] = member;
            }
        };
        let mut regions: Vec<(Vec<usize>, Ranked)> =
            pairs_of.into_iter().chain([watched]).map(|of_region| (of_region, Ranked::default())).collect();
        let is_one_region = regions.len() == 2;
        let room = || NextRanks::new(who.len(), is_one_region);
        threads::for_each_with(&mut regions, pairs.len(), room, rank_all);

        // What is watched is of the last region.
        let (mut members, mut rank_ends) = (Vec::with_capacity(pairs.len()), Vec::<Vec<usize>>::new());
        let last = regions.len() - 1;
        for (number, (_, ranked)) in regions.into_iter().enumerate() {
            let ends = ranked.ends.iter().map(|end| members.len() + end);
            if number < last {
                rank_ends.push(ends.collect());
            } else {
                rank_ends[last - 1].extend(ends);
            }
            members.extend(ranked.members);
        }
        Self { bodies: who, members, rank_ends, effort: *effort }
    }
}

/// The pairs of a region, rank by rank, and where each rank ends among them.
#[derive(Default)]
struct Ranked {
    members: Vec<Member>,
    ends: Vec<usize>,
}

impl Member {
    const NOBODY: Self = Self { manifold: 0, locals: [0; 2], stiffness: 0.0, is_in_heap: false };
}

/// Which ranks the next pairs of bodies can have.
struct NextRanks {
    /// Of each body, behind all that it has.
    next: Vec<usize>,
    /// Of each body, the first ranks that it has, a bit each, if they need not be behind all.
    taken: Option<Vec<u64>>,
}

impl NextRanks {
    /// In a cluster of one region one rank after the other acts in the order of the manifolds, as far as pairs share a body, of those that have settled and then of the others. In the regions
    /// of heaps, where that would take many ranks with empty lanes, pairs take the first rank that they find free.
    fn new(bodies: usize, is_one_region: bool) -> Self {
        Self { next: vec![0; bodies], taken: (!is_one_region).then(|| vec![0; bodies]) }
    }

    /// That of the next pair, of some bodies that can move.
    fn next(&mut self, bodies: impl Iterator<Item = usize> + Clone) -> usize {
        let Self { next, taken } = self;
        let mut first = 0;
        if let Some(taken) = taken {
            let free = !bodies.clone().fold(0, |all, body| all | taken[body]);
            if free != 0 {
                bodies.for_each(|body| taken[body] |= free & free.wrapping_neg());
                return free.trailing_zeros() as usize;
            }
            first = u64::BITS as usize;
        }
        let rank = bodies.clone().map(|body| next[body]).max().unwrap_or(0);
        bodies.for_each(|body| next[body] = rank + 1);
        first + rank
    }

    /// A body's pairs are in another region from now on.
    fn clear(&mut self, body: usize) {
        self.next[body] = 0;
        if let Some(taken) = &mut self.taken {
            taken[body] = 0;
        }
    }
}

/// Where the pairs of each rank go: those with more points first, of these those of which more carried, and the others in their order.
#[derive(Default)]
struct Places(Vec<usize>);

impl Places {
    /// Of each rank: by points, then by how many of them carried.
    const EACH: usize = (MOST_POINTS + 1) * (MOST_POINTS + 1);

    /// How many ranks there are.
    fn ranks(&self) -> usize {
        self.0.len() / Self::EACH
    }

    /// Makes room in a rank for a pair with some points, of which some carried.
    fn count(&mut self, rank: usize, (points, carried): (usize, usize)) -> usize {
        let less = |number: usize| MOST_POINTS - number.min(MOST_POINTS);
        let place = rank * Self::EACH + less(points) * (MOST_POINTS + 1) + less(carried);
        if place >= self.0.len() {
            self.0.resize((rank + 1) * Self::EACH, 0);
        }
        self.0[place] += 1;
        place
    }

    /// All pairs are counted. Where the ranks end.
    fn begin(&mut self) -> Vec<usize> {
        let mut sum = 0;
        for count in &mut self.0 {
            sum += std::mem::replace(count, sum);
        }
        let begins = self.0.iter().step_by(Self::EACH).skip(1).copied();
        begins.chain((sum > 0).then_some(sum)).collect()
    }

    /// Where the next one goes.
    fn next(&mut self, place: usize) -> usize {
        let next = self.0[place];
        self.0[place] += 1;
        next
    }
}

/// The manifolds of each island, both in the order of the manifolds.
fn islands(bodies: &Bodies, manifolds: &[Manifold]) -> Vec<Vec<usize>> {
    let are_fixed: Vec<bool> = bodies.inertias.iter().map(Inertia::is_infinite).collect();
    let is_fixed = |i: usize| are_fixed[i];
    let mut parent: Vec<u32> = (0..bodies.len() as u32).collect();
    for manifold in manifolds {
        let pair = manifold.pair;
        if !is_fixed(pair.first) && !is_fixed(pair.second) {
            let [a, b] = [pair.first, pair.second].map(|i| root(&mut parent, i as u32));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    // Most are small, and lists that grow cost more than counting first.
    let (mut number_of, mut sizes) = (vec![usize::MAX; bodies.len()], Vec::new());
    let mut number = |manifold: &Manifold| {
        let Pair { first, second } = manifold.pair;
        let mobile = if is_fixed(first) { second } else { first };
        let number = &mut number_of[root(&mut parent, mobile as u32) as usize];
        if *number == usize::MAX {
            *number = sizes.len();
            sizes.push(0);
        }
        sizes[*number] += 1;
        *number
    };
    let numbers: Vec<usize> = manifolds.iter().map(&mut number).collect();
    let mut islands: Vec<Vec<usize>> = sizes.into_iter().map(Vec::with_capacity).collect();
    numbers.into_iter().enumerate().for_each(|(at, number)| islands[number].push(at));
    islands
}

#[cfg(test)]
mod tests;
