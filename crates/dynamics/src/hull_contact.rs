//! Where convex polyhedra touch within a frame: separating axes, then faces clipped by faces, or edges across edges [Gregorius13].

mod axis;
mod clip;
mod nearest;
mod reduce;

use crate::detection::radius;
use crate::flight::Flight;
use crate::manifold::{ManifoldPoint, reach, surface_speed};
use crate::pair::Pair;
use crate::{Bodies, Frame, Pose};
use axis::{View, edge_axis, face_axis};
use clip::face_points;
use frangible_geometry::{Hull, RigidTransform};
use glam::DVec3;
use nearest::{between_edges, nearest_points};
pub(crate) use reduce::reduce;

/// What meets at a point of two hulls. The same features have the same name whichever hull's face is the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Feature {
    VertexOfFirst(u32),
    VertexOfSecond(u32),
    /// Of the first and of the second.
    Edges(u32, u32),
}

impl Feature {
    fn swapped(self) -> Self {
        match self {
            Self::VertexOfFirst(vertex) => Self::VertexOfSecond(vertex),
            Self::VertexOfSecond(vertex) => Self::VertexOfFirst(vertex),
            Self::Edges(a, b) => Self::Edges(b, a),
        }
    }

    /// Its key among the pair's samples; `edges` is the number of the second hull's.
    pub(crate) fn sample(self, edges: usize) -> (bool, u64) {
        const EDGES: u32 = 1 << 31;
        match self {
            Self::VertexOfFirst(vertex) => (true, vertex.into()),
            Self::VertexOfSecond(vertex) => (false, vertex.into()),
            Self::Edges(a, b) => (true, (EDGES | (a * edges as u32 + b)).into()),
        }
    }
}

/// A point on each of two hulls that face each other, in the first one's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HullPoint {
    /// On the first and on the second [m].
    pub(crate) on: [DVec3; 2],
    /// Unit, from the second hull to the first.
    pub(crate) normal: DVec3,
    /// Between them along the normal, negative if they overlap [m].
    pub(crate) gap: f64,
    pub(crate) feature: Feature,
}

/// How two hulls meet, in the first one's frame.
#[derive(Clone, Debug)]
pub(crate) struct HullContact {
    /// Unit, from the second to the first: they are apart by at least `gap` along it.
    pub(crate) normal: DVec3,
    /// [m]; negative if they overlap.
    pub(crate) gap: f64,
    pub(crate) points: Vec<HullPoint>,
}

/// How much better an axis must be than the one before it in the order of preference, relative to the size of the smaller hull: what
/// rests does not change its features for less.
pub(crate) const PREFERENCE: f64 = 5e-4;

/// How two hulls of which the smaller one is of `size` [m] meet; `None` if they are more than `most` [m] apart.
pub(crate) fn hull_contact(
    first: &Hull,
    second: &Hull,
    first_from_second: &RigidTransform,
    size: f64,
    most: f64,
) -> Option<HullContact> {
    // The best of each kind of axis.
    let (a, b) = (View::own(first), View::from_elsewhere(second, first_from_second));
    let close = PREFERENCE * size;
    let of_first = face_axis(&a, &b, most);
    if of_first.separation > most {
        return None;
    }
    let of_second = face_axis(&b, &a, most);
    if of_second.separation > most {
        return None;
    }
    // Edges that are nearest, or overlap less than the faces do, are within that distance of each other.
    let face = of_first.separation.max(of_second.separation);
    let within = most.max(-face);
    let (edges_a, edges_b) = (a.edges_in(b.bounds(within)), b.edges_in(a.bounds(within)));
    let of_edges = edge_axis(&a, &b, [&edges_a, &edges_b]);
    let gap = of_edges.map_or(face, |edges| edges.separation.max(face));
    if gap > most {
        return None;
    }

    // Edges, if they are clearly better than faces; then the first one's face, unless the second's is clearly better. A face
    // that does not lie over the other hull is none.
    let on_edges = || {
        let axis = of_edges?;
        let on = between_edges(a.ends(axis.edges[0]), b.ends(axis.edges[1]))?;
        let [edge_a, edge_b] = axis.edges.map(|edge| edge as u32);
        let (normal, gap) = (axis.normal, axis.separation);
        Some(HullPoint { on, normal, gap, feature: Feature::Edges(edge_a, edge_b) })
    };
    let on_face = |of_first_hull: bool| {
        if of_first_hull {
            face_points(&a, &b, &of_first, true, close)
        } else {
            face_points(&b, &a, &of_second, false, close)
        }
    };
    let edges_first = of_edges.is_some_and(|edges| edges.separation > face + close);
    let prefer_first = of_second.separation <= of_first.separation + close;
    if edges_first && let Some(point) = on_edges() {
        // What is over a face meets it when they turn about the edges.
        let mut points = on_face(prefer_first);
        points.retain(|point| point.gap > 0.0);
        points.push(point);
        return Some(HullContact { normal: point.normal, gap, points });
    }
    for of_first_hull in [prefer_first, !prefer_first] {
        let points = on_face(of_first_hull);
        if let Some(point) = points.first() {
            return Some(HullContact { normal: point.normal, gap, points });
        }
    }

    // What is nearest, or the edges if they overlap.
    let point = if gap > 0.0 {
        nearest_points(&a, &b, [&edges_a, &edges_b], first_from_second, most)
    } else {
        on_edges()
    }?;
    let gap = if gap > 0.0 { point.gap } else { gap };
    (gap <= most).then(|| HullContact { normal: point.normal, gap, points: vec![point] })
}

/// Nearer than this, relative to the smaller hull's size, two hulls meet where they are nearest; from further away, where they
/// first touch.
const NEAR: f64 = 0.02;

/// What counts as touching on the way, relative to the smaller hull's size.
const TOUCH: f64 = 1e-3;

/// Steps along the way to the first touch.
const MOST_STEPS: u32 = 32;

/// Two hulls on their ballistic ways through a frame.
struct Approach<'a> {
    bodies: &'a Bodies,
    pair: Pair,
    hulls: [&'a Hull; 2],
    flights: [Flight; 2],
    frame: &'a Frame,
    /// Of the smaller one [m].
    size: f64,
    /// How far apart they may be and still meet within the frame [m].
    reach: f64,
}

/// An instant of it.
struct Instant {
    time: f64,
    poses: [Pose; 2],
    contact: HullContact,
}

/// The points at which two hulls touch, or first will within the frame: at most four.
pub(crate) fn hull_points(
    bodies: &Bodies,
    pair: Pair,
    hulls: [&Hull; 2],
    frame: &Frame,
) -> Vec<ManifoldPoint> {
    let [first, second] = [pair.first, pair.second];
    let approach = Approach {
        bodies,
        pair,
        hulls,
        flights: [first, second].map(|i| Flight::of(bodies, i, frame)),
        frame,
        size: radius(&bodies.shapes[first]).min(radius(&bodies.shapes[second])),
        reach: reach(bodies, pair, frame),
    };
    let Some(mut instant) = approach.meeting() else { return Vec::new() };
    let points = std::mem::take(&mut instant.contact.points);
    let points = points.into_iter().filter(|point| approach.can_touch(&instant, point)).collect();
    let points = reduce(points, instant.contact.normal, PREFERENCE * approach.size);
    points.iter().map(|point| approach.manifold_point(&instant, point)).collect()
}

impl Approach<'_> {
    /// When they meet: at the frame's start if they are near then, else when they first touch (conservative advancement along
    /// separating axes [Mir96]). If they pass each other, when an axis that keeps them apart is found: their points hold in case
    /// that others push them. `None` if they are out of reach.
    fn meeting(&self) -> Option<Instant> {
        let mut instant = self.at(0.0)?;
        let mut enough = NEAR * self.size;
        for _ in 0..MOST_STEPS {
            let time = instant.time + instant.contact.gap / self.fastest_closing(&instant);
            let is_passing = !(instant.time..=self.frame.dt).contains(&time);
            if instant.contact.gap <= enough || is_passing {
                break;
            }
            instant = self.at(time)?;
            enough = TOUCH * self.size;
        }
        Some(instant)
    }

    fn at(&self, time: f64) -> Option<Instant> {
        let poses = [self.flights[0].pose(time), self.flights[1].pose(time)];
        let first_from_second = poses[0].world_from_body().inverse().after(&poses[1].world_from_body());
        let [first, second] = self.hulls;
        let contact = hull_contact(first, second, &first_from_second, self.size, self.reach)?;
        Some(Instant { time, poses, contact })
    }

    /// No point of the pair closes faster along the normal until the frame's end [m/s]; negative if all separate.
    fn fastest_closing(&self, instant: &Instant) -> f64 {
        let normal = instant.poses[0].orientation * instant.contact.normal;
        let towards = |flight: &Flight, i: usize, direction: DVec3| {
            let turning = flight.angular.cross(normal).length() * radius(&self.bodies.shapes[i]);
            let falling = self.frame.dt * flight.acceleration.dot(direction).max(0.0);
            let begun = instant.time * flight.acceleration.dot(direction).min(0.0);
            flight.linear.dot(direction) + begun + falling + turning
        };
        let [first, second] = &self.flights;
        towards(first, self.pair.first, -normal) + towards(second, self.pair.second, normal)
    }

    /// Speed at which the surfaces close at a point [m/s].
    fn closing(&self, instant: &Instant, point: &HullPoint) -> f64 {
        let world_from_first = instant.poses[0].world_from_body();
        let [on_first, on_second] = point.on.map(|point| world_from_first.point(point));
        let [first, second] = &self.flights;
        let velocity = first.velocity(on_first, instant.time) - second.velocity(on_second, instant.time);
        -velocity.dot(world_from_first.direction(point.normal))
    }

    /// Whether a point can touch within the frame, and comes from outside.
    fn can_touch(&self, instant: &Instant, point: &HullPoint) -> bool {
        let touch = self.manifold_point(instant, point);
        let [on_first, on_second] = touch.on_surfaces(self.bodies, self.pair);
        let is_outside = (on_first - on_second).dot(touch.normal) >= point.gap.min(0.0);
        point.gap <= self.reach && (instant.time == 0.0 || is_outside)
    }

    fn manifold_point(&self, instant: &Instant, point: &HullPoint) -> ManifoldPoint {
        let world_from_first = instant.poses[0].world_from_body();
        let second_from_world = instant.poses[1].world_from_body().inverse();
        let normal = world_from_first.direction(point.normal);
        let closing = self.closing(instant, point);
        ManifoldPoint {
            anchor_first: point.on[0],
            rounding: [0.0; 2],
            anchor_second: second_from_world.point(world_from_first.point(point.on[1])),
            normal,
            sample: point.feature.sample(self.hulls[1].edges().len()),
            approach: surface_speed(self.bodies, self.pair, normal, closing, point.gap, self.frame),
        }
    }
}

#[cfg(test)]
mod tests;
