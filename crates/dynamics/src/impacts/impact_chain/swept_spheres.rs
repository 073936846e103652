//! Neighbour search for bodies that deviate from their ballistic paths.

use super::deviation::Deviation;
use frangible_bodies::{Bodies, Frame, Pose};
use frangible_collision::{Bounds, Ground};
use frangible_math::threads;
use glam::DVec3;

/// Bodies wider than this multiple of the mean width are few, and tested individually [1].
const WIDE: f64 = 2.0;

/// Bounding balls of all ballistic paths.
pub(super) struct SweptSpheres<'a> {
    bodies: &'a Bodies,
    ends: &'a [Pose],
    bounds: &'a [Bounds],
    frame: &'a Frame,
    /// Narrow paths sorted by strip, and the offset of each strip.
    spheres: Vec<SweptSphere>,
    begins: Vec<usize>,
    strips: Strips,
    wide: Vec<SweptSphere>,
    /// Largest deviation of any body [m].
    furthest: f64,
}

/// Strips across an axis.
struct Strips {
    axis: usize,
    /// Begin of the first strip, and width of each strip, at least the width of a narrow path [m].
    begin: f64,
    width: f64,
    count: usize,
}

impl Strips {
    /// Strip of a coordinate [m], clamped to the first and last.
    fn at(&self, place: f64) -> usize {
        (((place - self.begin) / self.width) as usize).min(self.count - 1)
    }
}

/// Bounding ball of a body's ballistic path.
#[derive(Clone, Copy)]
struct SweptSphere {
    middle: DVec3,
    radius: f64,
    i: usize,
}

impl SweptSphere {
    fn of(bodies: &Bodies, i: usize, end: &Pose, frame: &Frame) -> Self {
        let (from, to) = (bodies.poses[i].position, end.position);
        let radius = bodies.radii[i] + 0.5 * (from.distance(to) + frame.speculative_margin());
        Self { middle: 0.5 * (from + to), radius, i }
    }
}

impl<'a> SweptSpheres<'a> {
    pub(super) fn new(
        bodies: &'a Bodies,
        ends: &'a [Pose],
        bounds: &'a [Bounds],
        frame: &'a Frame,
    ) -> Self {
        let all = threads::list(bodies.len(), |i| SweptSphere::of(bodies, i, &ends[i], frame));
        let bounded = all.iter().filter(|sphere| sphere.radius.is_finite());
        let count = bounded.clone().count().max(1);
        let widest =
            WIDE * bounded.clone().map(|sphere| 2.0 * sphere.radius).sum::<f64>() / count as f64;

        // Strips along the longer horizontal extent, at most one per body.
        let (low, high) = bounded
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), sphere| {
                (low.min(sphere.middle), high.max(sphere.middle))
            });
        let axis = if high.x - low.x >= high.z - low.z { 0 } else { 2 };
        let (begin, length) = (low[axis], (high[axis] - low[axis]).max(0.0));
        let width = widest.max(length / count as f64).max(f64::MIN_POSITIVE);
        let strips = Strips { axis, begin, width, count: (length / width) as usize + 1 };

        // Counting sort into strips.
        let is_narrow = |sphere: &SweptSphere| 2.0 * sphere.radius <= widest;
        let mut begins = vec![0; strips.count + 1];
        let narrow = || all.iter().copied().filter(is_narrow);
        narrow().for_each(|sphere| begins[strips.at(sphere.middle[axis]) + 1] += 1);
        (0..strips.count).for_each(|strip| begins[strip + 1] += begins[strip]);
        let mut next = begins.clone();
        let mut spheres =
            vec![SweptSphere { middle: DVec3::ZERO, radius: 0.0, i: 0 }; begins[strips.count]];
        for sphere in narrow() {
            let next = &mut next[strips.at(sphere.middle[axis])];
            spheres[*next] = sphere;
            *next += 1;
        }
        let wide = all
            .iter()
            .copied()
            .filter(|sphere| !is_narrow(sphere) && !sphere.radius.is_nan())
            .collect();
        Self { bodies, ends, bounds, frame, spheres, begins, strips, wide, furthest: 0.0 }
    }

    /// Bodies within reach of a body and their deviations, nearest first.
    pub(super) fn reached(&mut self, i: usize, deviations: &[Deviation]) -> Vec<usize> {
        self.furthest = self.furthest.max(deviations[i].most.0);
        let Self { bodies, ends, bounds, frame, ref strips, furthest, .. } = *self;
        let bounds = |i: usize| bounds[i].grown(deviations[i].most.0);
        let of_body = bounds(i);
        let poses: &[&[Pose]] = &[&bodies.poses, ends];
        let is_above = |ground: usize| {
            Ground::of(bodies, ground, poses).is_some_and(|ground| ground.is_below(&of_body))
        };
        let is_reached = |sphere: &&SweptSphere| {
            let other = sphere.i;
            let of_other = bounds(other);
            other != i
                && of_body.overlaps(&of_other)
                && !(of_other.is_boundless() && is_above(other))
        };

        // Cull by bounding balls, enlarged by the largest deviation.
        let SweptSphere { middle, radius, .. } = SweptSphere::of(bodies, i, &ends[i], frame);
        let far = radius + deviations[i].most.0 + furthest;
        let is_near = |sphere: &&SweptSphere| {
            let most = far + sphere.radius;
            sphere.middle.distance_squared(middle) <= most * most
        };
        let (most, along) = (far + 0.5 * strips.width, middle[strips.axis]);
        let [first, last] = [along - most, along + most].map(|place| strips.at(place));
        let near = &self.spheres[self.begins[first]..self.begins[last + 1]];
        let mut reached: Vec<&SweptSphere> =
            near.iter().chain(&self.wide).filter(is_near).filter(is_reached).collect();
        let apart = |sphere: &SweptSphere| sphere.middle.distance(middle) - sphere.radius;
        reached.sort_by(|a, b| apart(a).total_cmp(&apart(b)).then(a.i.cmp(&b.i)));
        reached.into_iter().map(|sphere| sphere.i).collect()
    }
}
