//! Who is solved with whom: islands of bodies that may touch do not feel each other, so some of them at a time go through all substeps
//! while their numbers are at hand; and within them, pairs that share no body act side by side.

use crate::contact_batch::Touching;
use crate::effort::Effort;
use crate::manifold::{MOST_POINTS, Manifold};
use crate::{Bodies, Frame};
use std::collections::BTreeMap;

/// Pairs that are solved together, of small islands: their numbers fit into a core's own cache.
const CLUSTER_PAIRS: usize = 512;

/// Some islands.
pub(crate) struct Cluster {
    /// Their bodies and the static and kinematic ones that they may touch, by dense index.
    pub(crate) bodies: Vec<usize>,
    /// Their pairs, rank by rank.
    pub(crate) members: Vec<Member>,
    /// Where each rank ends among them. Pairs of one rank share no body that can move: one rank after the other does what one pair after the
    /// other, in the order of the manifolds, would do.
    pub(crate) rank_ends: Vec<usize>,
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
}

/// All clusters, and whether each body is in one.
pub(crate) fn clusters(bodies: &Bodies, touching: Touching, frame: &Frame) -> (Vec<Cluster>, Vec<bool>) {
    let manifolds = touching.manifolds;
    let mut clusters = Vec::new();
    let mut is_in_one = vec![false; bodies.len()];
    let mut local = vec![NOWHERE; bodies.len()];
    let mut stiffness = vec![1.0; manifolds.len()];
    let mut add = |pairs: &[usize], effort: Effort, stiffness: &[f64]| {
        let cluster = Cluster::new(bodies, touching, (pairs, effort), stiffness, &mut local);
        cluster.bodies.iter().for_each(|&i| is_in_one[i] = true);
        clusters.push(cluster);
    };

    // What takes more goes with those that take as much.
    let mut careful: BTreeMap<u32, (Vec<usize>, Effort)> = BTreeMap::new();
    let mut pairs = Vec::new();
    let islands = islands(bodies, manifolds);
    let efforts = Effort::of_islands(bodies, manifolds, &islands, frame);
    for (number, (island, effort)) in islands.iter().zip(efforts).enumerate() {
        if let Some((effort, loads)) = effort {
            for (&at, load) in island.iter().zip(loads) {
                stiffness[at] = load.clamp(1.0, effort.stiffest);
            }
            let (alike, _) = careful.entry(effort.passes).or_insert_with(|| (Vec::new(), effort));
            alike.extend_from_slice(island);
            if alike.len() >= CLUSTER_PAIRS {
                add(&std::mem::take(alike), effort, &stiffness);
            }
            continue;
        }
        pairs.extend_from_slice(island);
        let next = islands.get(number + 1).map_or(usize::MAX, Vec::len);
        if pairs.len() >= CLUSTER_PAIRS || next >= CLUSTER_PAIRS {
            add(&pairs, Effort::of_size(pairs.len()), &stiffness);
            pairs.clear();
        }
    }
    let size = pairs.len();
    for (pairs, effort) in careful.into_values().chain([(pairs, Effort::of_size(size))]) {
        if !pairs.is_empty() {
            add(&pairs, effort, &stiffness);
        }
    }
    (clusters, is_in_one)
}

/// Not in the cluster.
const NOWHERE: u32 = u32::MAX;

impl Cluster {
    /// Of some manifolds. `local` is all [`NOWHERE`], and is so again at the end.
    fn new(
        bodies: &Bodies,
        touching: Touching,
        (pairs, effort): (&[usize], Effort),
        stiffness: &[f64],
        local: &mut [u32],
    ) -> Self {
        // Each pair is one rank behind those before it that share a body with it.
        let (mut who, mut next_rank) = (Vec::new(), Vec::<usize>::new());
        let mut ranked = Vec::with_capacity(pairs.len());
        let mut places = Places::default();
        for &manifold in pairs {
            let Manifold { pair, points } = &touching.manifolds[manifold];
            let locals = [pair.first, pair.second].map(|i| {
                if local[i] == NOWHERE {
                    local[i] = who.len() as u32;
                    who.push(i);
                    next_rank.push(0);
                }
                local[i]
            });
            let mobile = |&local: &u32| !bodies.inertias[who[local as usize]].is_infinite();
            let rank = locals.iter().filter(|local| mobile(local)).map(|&local| next_rank[local as usize]);
            let rank = rank.max().unwrap_or(0);
            locals
                .iter()
                .filter(|local| mobile(local))
                .for_each(|&local| next_rank[local as usize] = rank + 1);
            let place = places.count(rank, (points.len(), touching.carried[manifold].len()));
            ranked.push((place, Member { manifold, locals, stiffness: stiffness[manifold] }));
        }
        who.iter().for_each(|&i| local[i] = NOWHERE);

        // Side by side are those with about as many points, of which about as many carried in the last frame.
        let rank_ends = places.begin();
        let nobody = Member { manifold: 0, locals: [0; 2], stiffness: 0.0 };
        let mut members = vec![nobody; ranked.len()];
        for (place, member) in ranked {
            members[places.next(place)] = member;
        }
        Self { bodies: who, members, rank_ends, effort }
    }
}

/// Where the pairs of each rank go: those with more points first, of these those of which more carried, and the others in their order.
#[derive(Default)]
struct Places(Vec<usize>);

impl Places {
    /// Of each rank: by points, then by how many of them carried.
    const EACH: usize = (MOST_POINTS + 1) * (MOST_POINTS + 1);

    /// Makes room for a pair with some points, of which some carried.
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
        begins.chain([sum]).collect()
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
    let is_fixed = |i: usize| bodies.inertias[i].is_infinite();
    let mut parent: Vec<usize> = (0..bodies.len()).collect();
    for manifold in manifolds {
        let pair = manifold.pair;
        if !is_fixed(pair.first) && !is_fixed(pair.second) {
            let (a, b) = (root(&mut parent, pair.first), root(&mut parent, pair.second));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut islands: Vec<Vec<usize>> = Vec::new();
    let mut island_of = vec![usize::MAX; bodies.len()];
    for (index, manifold) in manifolds.iter().enumerate() {
        let pair = manifold.pair;
        let root = root(&mut parent, if is_fixed(pair.first) { pair.second } else { pair.first });
        if island_of[root] == usize::MAX {
            island_of[root] = islands.len();
            islands.push(Vec::new());
        }
        islands[island_of[root]].push(index);
    }
    islands
}

/// Who stands for a body's island: its smallest index.
fn root(parent: &mut [usize], mut of: usize) -> usize {
    while parent[of] != of {
        parent[of] = parent[parent[of]];
        of = parent[of];
    }
    of
}
