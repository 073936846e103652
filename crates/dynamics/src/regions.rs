//! Where in a heap pairs are: halves of halves, which touch each other only through the pairs between them. No pair of one half shares a body
//! that can move with a pair of the other, so threads take a half each: nested dissection [Geo73].

use crate::Bodies;
use crate::threads;
use glam::DVec3;
use std::cmp::Ordering;
use std::ops::Range;

/// Pairs that a region has in the mean after the last halving, up to twice as many: smaller ones leave more lanes empty, larger ones leave less to share out.
const REGION_PAIRS: usize = 2048;

/// The regions of a heap: each is a node of a binary tree, by its number. 1 is the whole, 2 and 3 are its halves.
pub(crate) struct Regions {
    /// How often the whole is halved.
    depth: u32,
    /// The smallest region of each body, 0 for one that impulses do not move.
    of_body: Vec<u32>,
}

impl Regions {
    /// Of bodies, by dense index, with so many pairs: halves hold as many bodies, and are apart along the longest side of the whole.
    pub(crate) fn new(bodies: &Bodies, who: &[usize], pairs: usize) -> Self {
        let depth = (pairs / REGION_PAIRS).checked_ilog2().unwrap_or(0);
        let mut of_body = vec![0; who.len()];
        let moves = |&local: &usize| !bodies.inertias[who[local]].is_infinite();
        let place = |local: usize| Place { local, position: bodies.poses[who[local]].position, region: 0 };
        let mut places: Vec<Place> = (0..who.len()).filter(moves).map(place).collect();
        halve(&mut places, 1, depth);
        places.iter().for_each(|place| of_body[place.local] = place.region);
        Self { depth, of_body }
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        (2 << self.depth) - 1
    }

    /// Where a pair is, in the order of [`halves`]: in the smallest region that holds both of its bodies, if both can move.
    pub(crate) fn of_pair(&self, locals: [u32; 2]) -> usize {
        let [mut a, mut b] = locals.map(|local| self.of_body[local as usize]);
        if a == 0 || b == 0 {
            (a, b) = (a.max(b), a.max(b));
        }
        while a != b {
            (a, b) = (a / 2, b / 2);
        }
        // From the whole down to it: behind all of the lower half, if it is in the higher one.
        let (mut below, mut begin) = (self.depth, 0);
        for level in (0..a.checked_ilog2().unwrap_or(0)).rev() {
            below -= 1;
            if a >> level & 1 == 1 {
                begin += (2 << below) - 1;
            }
        }
        begin + (2 << below) - 2
    }
}

/// The two halves among so many regions that follow each other, of which the last one is between those: none if that is all.
pub(crate) fn halves(regions: usize) -> Option<[Range<usize>; 2]> {
    let half = regions / 2;
    (half > 0).then(|| [0..half, half..2 * half])
}

/// A body, where it is [m], and in which region.
struct Place {
    local: usize,
    position: DVec3,
    /// The smallest region that it is in.
    region: u32,
}

/// Halves a region so often.
fn halve(places: &mut [Place], region: u32, depth: u32) {
    if depth == 0 {
        places.iter_mut().for_each(|place| place.region = region);
        return;
    }
    let (least, most) = places
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(least, most), Place { position, .. }| {
            (least.min(*position), most.max(*position))
        });
    let axis = (most - least).max_position();
    let along = |a: &Place, b: &Place| -> Ordering {
        a.position[axis].total_cmp(&b.position[axis]).then(a.local.cmp(&b.local))
    };
    let (count, half) = (places.len(), places.len() / 2);
    if half > 0 {
        places.select_nth_unstable_by(half, along);
    }
    let (low, high) = places.split_at_mut(half);
    threads::join(count, || halve(low, 2 * region, depth - 1), || halve(high, 2 * region + 1, depth - 1));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Contactant, Motion, NewBody, Pose, Velocity};
    use frangible_geometry::{ClosedForm, Shape};
    use glam::DQuat;
    use std::collections::BTreeSet;
    use std::sync::Arc;

    /// A layer of balls on a ground, and who is next to whom.
    fn layer(side: u32) -> (Bodies, Vec<[u32; 2]>) {
        let mut bodies = Bodies::default();
        let mut spawn = |motion, position| {
            bodies.spawn(NewBody {
                shape: Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1)),
                density: 1.0,
                motion,
                pose: Pose { position, orientation: DQuat::IDENTITY },
                velocity: Velocity { linear: DVec3::ZERO, angular_momentum: DVec3::ZERO },
                contactant: Contactant::new(0.0, 0.5),
            });
        };
        spawn(Motion::Static, DVec3::ZERO);
        let mut pairs = Vec::new();
        for x in 0..side {
            for z in 0..side {
                spawn(Motion::Dynamic, DVec3::new(1.1 * f64::from(x), 0.0, f64::from(z)));
                let at = 1 + x * side + z;
                pairs.push([0, at]);
                pairs.extend((x > 0).then(|| [at - side, at]));
                pairs.extend((z > 0).then(|| [at - 1, at]));
            }
        }
        (bodies, pairs)
    }

    /// No pair of one half has a ball of the other; both have as many pairs to within a quarter, and few are between them.
    #[test]
    fn halves_share_nothing_that_moves() {
        fn check(pairs_of: &[Vec<[u32; 2]>], depth: u32) {
            let Some(parts) = halves(pairs_of.len()) else { return assert_eq!(depth, 0) };
            let all: Vec<Vec<[u32; 2]>> = parts.iter().map(|part| pairs_of[part.clone()].concat()).collect();
            let [low, high] = [0, 1].map(|half| {
                all[half].iter().flatten().copied().filter(|&i| i > 0).collect::<BTreeSet<u32>>()
            });
            assert!(low.is_disjoint(&high));
            let (a, b, between) = (all[0].len(), all[1].len(), pairs_of[pairs_of.len() - 1].len());
            assert!(4 * a.abs_diff(b) < a && 10 * between < a + b, "{a}, {b} and {between} between them");
            parts.into_iter().for_each(|part| check(&pairs_of[part], depth - 1));
        }
        let (bodies, pairs) = layer(64);
        let who: Vec<usize> = (0..bodies.len()).collect();
        let regions = Regions::new(&bodies, &who, pairs.len());
        assert_eq!(
            regions.count(),
            7,
            "four regions of a heap of {} pairs, and those between them",
            pairs.len()
        );
        let mut pairs_of = vec![Vec::new(); regions.count()];
        for &pair in &pairs {
            pairs_of[regions.of_pair(pair)].push(pair);
        }
        check(&pairs_of, 2);
    }

    /// What is small is one region; and there may be more regions than bodies.
    #[test]
    fn the_small_and_the_degenerate_have_regions_too() {
        let (bodies, pairs) = layer(8);
        let who: Vec<usize> = (0..bodies.len()).collect();
        let one = Regions::new(&bodies, &who, pairs.len());
        assert_eq!((one.count(), one.of_pair([0, 5]), one.of_pair([3, 4])), (1, 0, 0));
        let many = Regions::new(&bodies, &who[..2], 1 << 20);
        assert!(many.of_pair([0, 1]) < many.count());
    }
}
