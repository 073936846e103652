//! Relative ballistic motion of two bodies in a frame.

use crate::narrow_phase::fixed_neighbours::FixedNeighbours;
use crate::narrow_phase::samples::ContactPoint;
use crate::relative_motion::Placed;
use frangible_bodies::BallisticPath;
use frangible_bodies::Bodies;
use frangible_bodies::Frame;
use frangible_bodies::Pair;
use frangible_geometry::Geometry;
use glam::DVec3;

/// Maximum number of conservative-advancement steps to first touch [1]. With 8, falling heaps are
/// unchanged.
pub(crate) const MOST_STEPS: u32 = 32;

/// A pair of bodies and their ballistic motion in a frame.
pub struct PairMotion<'a> {
    /// All bodies.
    pub bodies: &'a Bodies,
    /// Dense indices of both bodies.
    pub pair: Pair,
    /// Ballistic motion of both bodies.
    pub(crate) paths: [&'a BallisticPath; 2],
    /// The frame.
    pub frame: &'a Frame,
    /// Upper bound of the relative speed of any two points [m/s].
    pub most_speed: f64,
    /// Additional relative speed after an impact with other bodies [m/s].
    pub(crate) faster: f64,
    /// Speculative margin: two resting surfaces at this separation may touch within the frame by
    /// falling or by an impact [m].
    pub near: f64,
    /// Maximum separation of two surfaces that may touch within the frame [m].
    pub reach: f64,
    /// Search distance for features, at least the reach [m].
    pub search: f64,
    /// Radius of the smaller body [m].
    pub size: f64,
    /// Time within which a pair that only grazes gets no deeper [s].
    pub(crate) ahead: f64,
    /// True from a substep on, false from the frame's start on.
    pub(crate) is_substep: bool,
    /// Dense indices of the fixed bodies that the pair's moving body may meet; none for one alone.
    pub(crate) neighbours: &'a [u32],
}

/// Overlap up to which a pair only grazes, relative to the smaller body's radius [1]: twice the
/// overlap of a resting contact. A deeper pair meets along the normal of its first touch, a grazing
/// one along the normal of its closest approach: bodies do not catch on the seams of flush tiles.
const GRAZING: f64 = 4e-3;

/// Upper bound of this overlap, relative to the thinner body's thickness [1]: thin panes meet edge
/// to edge.
const GRAZED_THICKNESS: f64 = 0.05;

/// Test distance beside a sample in its own body, relative to the smaller body [1]. With a tenth of
/// it eleven shots end in the same bits.
const BESIDE: f64 = 1e-2;

/// Upper bound of the test distance, relative to the body's own thickness [1]: longer steps cross
/// thin discs. Their samples were then left out, and the discs fell through the ground.
const THROUGH: f64 = 0.25;

/// Change of the distance to a surface along a step and back, relative to the step, up to which it
/// is flat there [1].
const FLAT: f64 = 0.1;

/// Cosine from which on two normals are the same [1]: 26 degrees, for samples of curved surfaces.
const ALONG: f64 = 0.9;

impl<'a> PairMotion<'a> {
    /// A pair with the given ballistic motion.
    #[inline]
    pub fn new(
        bodies: &'a Bodies,
        pair: Pair,
        paths: [&'a BallisticPath; 2],
        frame: &'a Frame,
    ) -> Self {
        let [first, second] = paths;
        let speed = (first.linear - second.linear).length() + first.spin_speed + second.spin_speed;
        let most_speed = speed + frame.gravity.length() * frame.dt;
        let near = frame.speculative_margin();
        let (reach, size) = (frame.dt * speed + near, first.radius.min(second.radius));
        Self {
            bodies,
            pair,
            paths,
            frame,
            most_speed,
            faster: 0.0,
            near,
            reach,
            search: reach,
            size,
            ahead: frame.dt,
            is_substep: false,
            neighbours: &[],
        }
    }

    /// A pair in straight motion through a `substep`; the frame ends after the time `ahead` [s],
    /// and has the speculative margin `near` [m].
    pub fn of_substep(
        bodies: &'a Bodies,
        pair: Pair,
        paths: [&'a BallisticPath; 2],
        substep: &'a Frame,
        (ahead, near): (f64, f64),
    ) -> Self {
        let pair_motion = Self::new(bodies, pair, paths, substep);
        let way = pair_motion.reach - pair_motion.near;
        let reach = ahead / substep.dt * way + near;
        Self { near, reach, search: reach, ahead, is_substep: true, ..pair_motion }
    }

    /// Adds relative speed after an impact with other bodies [m/s].
    #[inline]
    pub fn with_speed_gain(self, faster: f64) -> Self {
        let further = faster * self.frame.dt;
        let (near, reach) = (self.near + further, self.reach + further);
        Self { near, reach, search: reach, faster, ..self }
    }

    /// With the fixed bodies that the pair's moving body may meet.
    #[inline]
    pub fn among(self, neighbours: &'a FixedNeighbours) -> Self {
        Self { neighbours: neighbours.of_pair(self.pair), ..self }
    }

    /// Both bodies at the frame's start.
    #[inline]
    pub fn placed(&self) -> [Placed<'_>; 2] {
        let at = |i: usize, side: usize| Placed {
            shape: &self.bodies.shapes[i],
            pose: &self.paths[side].start,
        };
        [at(self.pair.first, 0), at(self.pair.second, 1)]
    }

    /// Overlap up to which a pair only grazes [m].
    pub(crate) fn grazing(&self) -> f64 {
        (GRAZING * self.size).min(GRAZED_THICKNESS * thickness(self.bodies, self.pair))
    }

    /// True if the bounding balls cannot meet within the frame; rotation stays within the ball.
    #[inline]
    pub(crate) fn is_out_of_reach(&self) -> bool {
        let [first, second] = self.paths;
        let way = self.frame.dt * (first.linear - second.linear).length();
        let most = first.radius + second.radius + way + self.near;
        first.start.position.distance_squared(second.start.position) > most * most
    }

    /// True if any two points of the pair may meet fast enough for an impact.
    #[inline]
    pub(crate) fn may_impact(&self) -> bool {
        self.most_speed + self.faster > self.frame.impact_speed()
    }

    /// Closing speed after a separation `phi` [m] has closed, from a present speed `closing` [m/s]
    /// along `normal`, with gravity [m/s].
    #[inline]
    pub(crate) fn surface_speed(&self, normal: DVec3, closing: f64, phi: f64) -> f64 {
        let [first, second] = self.paths;
        let acceleration = -(first.acceleration - second.acceleration).dot(normal);
        let squared = closing * closing + 2.0 * acceleration * phi;
        if phi > 0.0 && closing > 0.0 { squared.max(0.0).sqrt() } else { closing.max(0.0) }
    }

    /// The contact of a sample at a signed distance `phi` [m], as the surface of its own body allows.
    /// Two flat places touch along their common normal alone, and a flat place meets an edge along
    /// its own: a rim that slides over a floor does not catch on the floor's samples. `None` if the
    /// two cannot touch there.
    pub fn seen_from_own(
        &self,
        sample_of_first: bool,
        contact: ContactPoint,
        phi: f64,
    ) -> Option<(ContactPoint, f64)> {
        let [first, second] = self.placed();
        let (own, other, sign) =
            if sample_of_first { (first, second, 1.0) } else { (second, first, -1.0) };
        let (point, outward) = (contact.point, sign * contact.normal);
        let (low, high) = own.shape.bounds;
        let step = (BESIDE * self.size).min(THROUGH * (high - low).min_element());
        let (here, own_normal) = distance_and_normal(own, point);
        let [inside, outside] = [1.0, -1.0]
            .map(|side| (distance_and_normal(own, point + side * step * outward).0 - here) / step);
        // On coincident edges the distance has the normals of both sides.
        if inside > 0.5 {
            return None;
        }
        // Samples deeper than by grazing come out the nearest way.
        if phi < -self.grazing() || (inside + outside).abs() > FLAT || outside > ALONG {
            return Some((contact, phi));
        }
        let along = own_normal.reject_from_normalized(outward).normalize_or_zero();
        let beside = [1.0, -1.0].map(|side| point + side * (step + phi.abs()) * along);
        let turns_away = |at: DVec3| distance_and_normal(other, at).1.dot(outward) < ALONG;
        // On a grid, edges are round: a place that seems flat may be one.
        let is_exact = !matches!(own.shape.geometry, Geometry::Grid(_));
        let is_edge = beside.into_iter().any(turns_away);
        if outside < 0.5 || is_exact && !is_edge {
            return None;
        }
        if !is_edge {
            return Some((contact, phi));
        }
        Some((ContactPoint { point, normal: -sign * own_normal }, outside * phi))
    }
}

/// Signed distance of a point to a body [m], and its gradient; world frame.
fn distance_and_normal(body: Placed, point: DVec3) -> (f64, DVec3) {
    let world_from_body = body.pose.world_from_body();
    let (distance, gradient) =
        body.shape.distance_and_gradient(world_from_body.inverse().point(point));
    (distance, world_from_body.direction(gradient))
}

/// Least extent of the thinner body [m]. Triangles have none that counts: bodies stay on their side.
fn thickness(bodies: &Bodies, pair: Pair) -> f64 {
    let of = |i: usize| {
        if matches!(bodies.shapes[i].geometry, Geometry::Mesh(_)) {
            return f64::INFINITY;
        }
        let (low, high) = bodies.shapes[i].bounds;
        (high - low).min_element()
    };
    of(pair.first).min(of(pair.second))
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::{Motion, NewBody, Pose, StepSettings, SurfaceProperties, Velocity};
    use frangible_geometry::{ClosedForm, HalfSpace, Shape};
    use glam::DQuat;
    use std::sync::Arc;

    /// A ball too slow for an impact reaches the ground no faster than by falling through the
    /// speculative margin, at any height; a ball several times faster exceeds it.
    #[test]
    fn what_is_slow_strikes_nothing() {
        let frame =
            Frame { dt: 1.0 / 30.0, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
        let ground = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.0 });
        let fastest = |times: f64| {
            let speed = times * (frame.impact_speed() - 9.81 * frame.dt);
            let mut bodies = Bodies::default();
            for (form, motion) in
                [(ground, Motion::Static), (ClosedForm::Sphere { radius: 0.5 }, Motion::Dynamic)]
            {
                bodies.spawn(NewBody {
                    shape: Arc::new(Shape::closed_form(form, 0.1)),
                    density: 1.0,
                    motion,
                    pose: Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY },
                    velocity: Velocity { linear: -speed * DVec3::Y, ..Velocity::default() },
                    surface: SurfaceProperties::new(0.0, 0.5),
                });
            }
            let pair = Pair { first: 0, second: 1 };
            let [first, second] = BallisticPath::of_pair(&bodies, pair, &frame);
            let pair_motion = PairMotion::new(&bodies, pair, [&first, &second], &frame);
            let at = |part: i32| {
                pair_motion.surface_speed(
                    -DVec3::Y,
                    speed,
                    0.01 * f64::from(part) * pair_motion.reach,
                )
            };
            (pair_motion.may_impact(), (0..=100).map(at).fold(0.0, f64::max) * frame.dt)
        };
        let least = 2.0 * frame.speculative_margin();
        for times in [0.0, 0.5, 0.999] {
            let (may, comes) = fastest(times);
            assert!(!may && comes <= least, "{times}: {comes} m of {least}");
        }
        let (may, comes) = fastest(3.0);
        assert!(may && comes > least, "{comes} m of {least}");
    }
}
