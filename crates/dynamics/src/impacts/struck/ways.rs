//! Whom a body may reach that strays from its ballistic way.

use super::stray::Stray;
use frangible_bodies::{Bodies, Frame, Pose};
use frangible_collision::{Bounds, Ground};
use frangible_math::threads;
use glam::DVec3;

/// Bodies wider than this, in units of the mean, are few, and looked at one by one [1].
const WIDE: f64 = 2.0;

/// Where bodies come on their ballistic ways.
pub(super) struct Ways<'a> {
    bodies: &'a Bodies,
    ends: &'a [Pose],
    bounds: &'a [Bounds],
    frame: &'a Frame,
    /// Those that are not wide, strip by strip across an axis, and where each strip begins among
    /// them.
    ways: Vec<Way>,
    begins: Vec<usize>,
    strips: Strips,
    wide: Vec<Way>,
    /// How far any of them strays from its way [m].
    furthest: f64,
}

/// Strips across an axis.
struct Strips {
    axis: usize,
    /// Where the first one begins, and how wide each is: none of what lies in them is wider [m].
    begin: f64,
    width: f64,
    count: usize,
}

impl Strips {
    /// Where a place along the axis is [m]: in the first or the last one, if it is beyond.
    fn at(&self, place: f64) -> usize {
        (((place - self.begin) / self.width) as usize).min(self.count - 1)
    }
}

/// A ball around a body's way.
#[derive(Clone, Copy)]
struct Way {
    middle: DVec3,
    radius: f64,
    i: usize,
}

impl Way {
    fn of(bodies: &Bodies, i: usize, end: &Pose, frame: &Frame) -> Self {
        let (from, to) = (bodies.poses[i].position, end.position);
        let radius = bodies.radii[i] + 0.5 * (from.distance(to) + frame.sag());
        Self { middle: 0.5 * (from + to), radius, i }
    }
}

impl<'a> Ways<'a> {
    pub(super) fn new(
        bodies: &'a Bodies,
        ends: &'a [Pose],
        bounds: &'a [Bounds],
        frame: &'a Frame,
    ) -> Self {
        let all = threads::list(bodies.len(), |i| Way::of(bodies, i, &ends[i], frame));
        let bounded = all.iter().filter(|way| way.radius.is_finite());
        let count = bounded.clone().count().max(1);
        let widest = WIDE * bounded.clone().map(|way| 2.0 * way.radius).sum::<f64>() / count as f64;

        // Along the longer side of what lies on the ground, no more strips than bodies.
        let (low, high) = bounded
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), way| {
                (low.min(way.middle), high.max(way.middle))
            });
        let axis = if high.x - low.x >= high.z - low.z { 0 } else { 2 };
        let (begin, length) = (low[axis], (high[axis] - low[axis]).max(0.0));
        let width = widest.max(length / count as f64).max(f64::MIN_POSITIVE);
        let strips = Strips { axis, begin, width, count: (length / width) as usize + 1 };

        // Into their strips, one after the other.
        let is_narrow = |way: &Way| 2.0 * way.radius <= widest;
        let mut begins = vec![0; strips.count + 1];
        let narrow = || all.iter().copied().filter(is_narrow);
        narrow().for_each(|way| begins[strips.at(way.middle[axis]) + 1] += 1);
        (0..strips.count).for_each(|strip| begins[strip + 1] += begins[strip]);
        let mut next = begins.clone();
        let mut ways = vec![Way { middle: DVec3::ZERO, radius: 0.0, i: 0 }; begins[strips.count]];
        for way in narrow() {
            let next = &mut next[strips.at(way.middle[axis])];
            ways[*next] = way;
            *next += 1;
        }
        let wide =
            all.iter().copied().filter(|way| !is_narrow(way) && !way.radius.is_nan()).collect();
        Self { bodies, ends, bounds, frame, ways, begins, strips, wide, furthest: 0.0 }
    }

    /// What a body may reach, as far as bodies stray, the nearest first.
    pub(super) fn reached(&mut self, i: usize, strays: &[Stray]) -> Vec<usize> {
        self.furthest = self.furthest.max(strays[i].most.0);
        let Self { bodies, ends, bounds, frame, ref strips, furthest, .. } = *self;
        let bounds = |i: usize| bounds[i].grown(strays[i].most.0);
        let of_body = bounds(i);
        let poses: &[&[Pose]] = &[&bodies.poses, ends];
        let is_above = |ground: usize| {
            Ground::of(bodies, ground, poses).is_some_and(|ground| ground.is_below(&of_body))
        };
        let is_reached = |way: &&Way| {
            let other = way.i;
            let of_other = bounds(other);
            other != i
                && of_body.overlaps(&of_other)
                && !(of_other.is_boundless() && is_above(other))
        };

        // Nothing whose ball is further away, as far as any strays.
        let Way { middle, radius, .. } = Way::of(bodies, i, &ends[i], frame);
        let far = radius + strays[i].most.0 + furthest;
        let is_near = |way: &&Way| {
            let most = far + way.radius;
            way.middle.distance_squared(middle) <= most * most
        };
        let (most, along) = (far + 0.5 * strips.width, middle[strips.axis]);
        let [first, last] = [along - most, along + most].map(|place| strips.at(place));
        let near = &self.ways[self.begins[first]..self.begins[last + 1]];
        let mut reached: Vec<&Way> =
            near.iter().chain(&self.wide).filter(is_near).filter(is_reached).collect();
        let apart = |way: &Way| way.middle.distance(middle) - way.radius;
        reached.sort_by(|a, b| apart(a).total_cmp(&apart(b)).then(a.i.cmp(&b.i)));
        reached.into_iter().map(|way| way.i).collect()
    }
}
