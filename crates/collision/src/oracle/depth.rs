//! Least overlap of two cores: over all normals of faces and across an edge of each, and where rims
//! are edges over all normals across them.
//!
//! The least overlap lies along a normal that belongs to a face of either, or to an edge of each.
//! Corners give finitely many. A rim on an edge leaves one angle free, and so does a round
//! side on any other body: these are tried in steps, and ever closer around each valley. Two rims
//! leave two angles: directions all over the sphere, denser around the axes, and a search around the
//! best of them.

use crate::oracle::body::{Arc, Around, Convex, Features};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Steps along an arc of normals, at most this wide [rad].
const STEP: f64 = 0.05;

/// Golden sections of two steps: to 1e-11 rad.
const NARROWINGS: usize = 46;

/// Edges whose arcs of normals miss each other by this angle have no common normal [rad].
const MISSES: f64 = 1e-7;

/// Directions all over the sphere, and the angles from an axis of those beside it [rad].
const ALL_OVER: usize = 300;
const BESIDE_AXIS: [f64; 7] = [1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.2, 0.35];
const ON_RING: usize = 16;

/// Of the best of these a search begins, one in each cone of this cosine.
const BEGINNINGS: usize = 10;
const ONE_VALLEY: f64 = 0.995;

/// Steps of a search on rims [rad]: each round makes them smaller, down to 1e-8. The deepest valleys
/// after a few rounds are followed to their floors.
const FIRST_STEP: f64 = 0.1;
const SMALLER: f64 = 0.3;
const ROUNDS: i32 = 14;
const FEW_ROUNDS: i32 = 4;
const DEEPEST: usize = 3;

/// Separation along the best normal [m], negative for overlap, and this normal, from the second to
/// the first.
pub(crate) fn least_overlap(first: &Convex, second: &Convex) -> (f64, DVec3) {
    let mut search = Search { bodies: [first, second], best: (f64::NEG_INFINITY, DVec3::Y) };
    for normal in first.features(None).normals {
        search.offer(-normal);
    }
    for normal in second.features(None).normals {
        search.offer(normal);
    }
    if !first.is_round() && !second.is_round() {
        search.edges();
        return search.best;
    }
    for side in 0..2 {
        if search.bodies[side].is_round() {
            search.round_side(side);
            search.rim_on_edges(side);
        }
    }
    if first.is_round() && second.is_round() {
        search.rims();
    }
    search.best
}

struct Search<'a> {
    bodies: [&'a Convex; 2],
    best: (f64, DVec3),
}

impl Search<'_> {
    fn value(&self, normal: DVec3) -> f64 {
        let [first, second] = self.bodies;
        (first.support(-normal) - second.support(normal)).dot(normal)
    }

    fn offer(&mut self, normal: DVec3) {
        self.best = better(self.best, (self.value(normal), normal));
    }

    /// Every two edges whose arcs of normals cross.
    fn edges(&mut self) {
        let [first, second] = self.bodies.map(Convex::arcs);
        for a in &first {
            for b in &second {
                let crosses = |arc: &Arc, other: DVec3| {
                    let [from, to] = arc.normals.map(|normal| normal.dot(other));
                    arc.is_full || from.min(to) <= MISSES && from.max(to) >= -MISSES
                };
                if !crosses(a, b.along) || !crosses(b, a.along) {
                    continue;
                }
                let across = a.along.cross(b.along);
                if across.length_squared() > 1e-24 {
                    let normal = across.normalize();
                    self.offer(normal);
                    self.offer(-normal);
                }
            }
        }
    }

    /// The round side of a body on all of the other one.
    fn round_side(&mut self, side: usize) {
        let (body, sign) = (self.bodies[side], if side == 0 { -1.0 } else { 1.0 });
        let normal_at = |angle: f64| sign * body.side_normal(angle);
        let best = self.best.0;
        let found = valleys(TAU, best, |angle| {
            let normal = normal_at(angle);
            let between = self.bodies[0].support(-normal) - self.bodies[1].support(normal);
            (between.dot(normal), between.length())
        });
        found.into_iter().for_each(|angle| self.offer(normal_at(angle)));
    }

    /// A rim of a body on the other one's edges, along the arcs of their normals.
    fn rim_on_edges(&mut self, side: usize) {
        let (round, sign) = (self.bodies[side], if side == 0 { 1.0 } else { -1.0 });
        for arc in self.bodies[1 - side].arcs() {
            // Outward of the edge.
            let beside = arc.along.cross(arc.normals[0]);
            let whole = arc.normals[1].dot(beside).atan2(arc.normals[1].dot(arc.normals[0]));
            let whole = if arc.is_full { TAU } else { whole };
            let at = |angle: f64| angle.cos() * arc.normals[0] + angle.sin() * beside;
            let found = valleys(whole, self.best.0, |angle| {
                let between = round.support(-at(angle)) - arc.point;
                (between.dot(at(angle)), between.length())
            });
            found.into_iter().for_each(|angle| self.offer(sign * at(angle)));
        }
    }

    /// Two rims.
    fn rims(&mut self) {
        let mut tried: Vec<(f64, DVec3)> = Vec::new();
        let mut look = |normal: DVec3| tried.push((self.value(normal), normal));
        let golden = PI * (3.0 - 5.0_f64.sqrt());
        for number in 0..ALL_OVER {
            let height = 1.0 - (2.0 * number as f64 + 1.0) / ALL_OVER as f64;
            let (sin, cos) = (golden * number as f64).sin_cos();
            let wide = (1.0 - height * height).sqrt();
            look(DVec3::new(wide * cos, height, wide * sin));
        }
        for body in self.bodies {
            for (axis, angle) in
                [1.0, -1.0].into_iter().flat_map(|sign| BESIDE_AXIS.map(|angle| (sign, angle)))
            {
                let axis = axis * body.axis();
                let (u, v) = axis.any_orthonormal_pair();
                for step in 0..ON_RING {
                    let (sin, cos) = (TAU * step as f64 / ON_RING as f64).sin_cos();
                    look(angle.cos() * axis + angle.sin() * (cos * u + sin * v));
                }
            }
        }
        tried.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut begin: Vec<(f64, DVec3)> = Vec::new();
        for here in tried {
            let is_new = begin.iter().all(|known| known.1.dot(here.1) < ONE_VALLEY);
            if begin.len() < BEGINNINGS && (is_new || begin.len() < 2) {
                begin.push(here);
            }
        }
        // Most valleys are known as such before their floors are.
        for (keep, rounds) in [(BEGINNINGS, 0..FEW_ROUNDS), (DEEPEST, FEW_ROUNDS..ROUNDS)] {
            begin.sort_by(|a, b| b.0.total_cmp(&a.0));
            begin.truncate(keep);
            for here in &mut begin {
                rounds
                    .clone()
                    .for_each(|round| self.narrow(here, FIRST_STEP * SMALLER.powi(round)));
            }
        }
        self.best = begin.into_iter().fold(self.best, better);
    }

    /// The best normal across a tangent of each rim, in steps around where a normal meets them.
    fn narrow(&self, here: &mut (f64, DVec3), step: f64) {
        let towards = here.1;
        let [first, second] = self.bodies;
        let features = [
            first.features(Some(Around { towards: -towards, step })),
            second.features(Some(Around { towards, step })),
        ];
        each_normal(&features, |normal| *here = better(*here, (self.value(normal), normal)));
    }
}

/// Angles from zero to `whole` [rad] at which a function is larger than at both neighbours, found
/// in steps and narrowed by golden sections; not those that cannot reach `best`. The function gives
/// its value [m], and its largest slope [m/rad].
fn valleys(whole: f64, best: f64, value: impl Fn(f64) -> (f64, f64)) -> Vec<f64> {
    let count = (whole / STEP).abs().ceil().max(4.0) as usize;
    let step = whole / count as f64;
    let values: Vec<(f64, f64)> = (0..=count).map(|at| value(step * at as f64)).collect();
    let mut found = Vec::new();
    for at in 0..=count {
        let here = values[at];
        let neighbours = [at.checked_sub(1), Some(at + 1).filter(|&next| next <= count)];
        let is_best = neighbours.into_iter().flatten().all(|next| values[next].0 <= here.0);
        if is_best && here.0 + step.abs() * here.1 > best {
            let middle = step * at as f64;
            found.push(middle);
            found.push(narrowed([middle - step, middle + step], &value));
        }
    }
    found
}

fn narrowed([mut from, mut to]: [f64; 2], value: &impl Fn(f64) -> (f64, f64)) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    for _ in 0..NARROWINGS {
        let [low, high] = [to - GOLDEN * (to - from), from + GOLDEN * (to - from)];
        if value(low).0 >= value(high).0 {
            to = high;
        } else {
            from = low;
        }
    }
    0.5 * (from + to)
}

pub(crate) fn better(a: (f64, DVec3), b: (f64, DVec3)) -> (f64, DVec3) {
    if b.0 > a.0 { b } else { a }
}

/// Normals from the second to the first: of faces of either, and across an edge of each.
pub(crate) fn each_normal(features: &[Features; 2], mut visit: impl FnMut(DVec3)) {
    features[0].normals.iter().for_each(|&normal| visit(-normal));
    features[1].normals.iter().for_each(|&normal| visit(normal));
    for &a in &features[0].edges {
        for &b in &features[1].edges {
            let across = a.cross(b);
            if across.length_squared() <= 1e-24 * a.length_squared() * b.length_squared() {
                continue;
            }
            let normal = across.normalize();
            visit(normal);
            visit(-normal);
        }
    }
}
