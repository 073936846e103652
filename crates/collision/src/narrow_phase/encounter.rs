//! Two bodies on their ballistic ways through a frame.

use crate::narrow_phase::samples::ContactPoint;
use crate::relative_motion::Placed;
use frangible_bodies::Bodies;
use frangible_bodies::Flight;
use frangible_bodies::Frame;
use frangible_bodies::Pair;
use glam::DVec3;

/// Steps along the ways of two through a frame to their first touch; each goes as far as their
/// distance allows [1]. With 8 of them falling heaps are the same.
pub(crate) const MOST_STEPS: u32 = 32;

/// A pair of bodies and how they fly through a frame.
pub struct Encounter<'a> {
    /// All bodies.
    pub bodies: &'a Bodies,
    /// Which of them meet.
    pub pair: Pair,
    /// Their ways.
    pub(crate) flights: [&'a Flight; 2],
    /// The frame.
    pub frame: &'a Frame,
    /// No two points of the pair move faster against each other on these ways [m/s].
    pub most_speed: f64,
    /// Nor by more than this beyond it if they are struck [m/s].
    pub(crate) faster: f64,
    /// What is this near may meet within the frame although it rests now: it may fall, or be struck
    /// [m].
    pub near: f64,
    /// How far apart two surfaces may be and still meet within the frame [m].
    pub reach: f64,
    /// How far apart they are to be looked for, at least the reach [m].
    pub search: f64,
    /// Radius of the smaller one [m].
    pub size: f64,
}

/// How far beside a sample it is looked where its own body is, relative to the smaller body [1].
/// With a tenth of it eleven shots end in the same bits.
const BESIDE: f64 = 1e-2;

/// And no further than this part of its own body's thickness [1]: a longer step goes through thin
/// discs, whose samples were left out, so that they fell through the ground.
const THROUGH: f64 = 0.25;

impl<'a> Encounter<'a> {
    /// Of a pair whose bodies fly as told.
    #[inline]
    pub fn new(bodies: &'a Bodies, pair: Pair, flights: [&'a Flight; 2], frame: &'a Frame) -> Self {
        let [first, second] = flights;
        let speed = (first.linear - second.linear).length() + first.spin_speed + second.spin_speed;
        let most_speed = speed + frame.gravity.length() * frame.dt;
        let near = frame.sag();
        let (reach, size) = (frame.dt * speed + near, first.radius.min(second.radius));
        Self {
            bodies,
            pair,
            flights,
            frame,
            most_speed,
            faster: 0.0,
            near,
            reach,
            search: reach,
            size,
        }
    }

    /// They may come so much faster against each other because they are struck [m/s].
    #[inline]
    pub fn struck(self, faster: f64) -> Self {
        let further = faster * self.frame.dt;
        let (near, reach) = (self.near + further, self.reach + further);
        Self { near, reach, search: reach, faster, ..self }
    }

    /// Its bodies where they are at the frame's start.
    #[inline]
    pub fn placed(&self) -> [Placed<'_>; 2] {
        let at = |i: usize, side: usize| Placed {
            shape: &self.bodies.shapes[i],
            pose: &self.flights[side].start,
        };
        [at(self.pair.first, 0), at(self.pair.second, 1)]
    }

    /// True if balls around the two cannot meet within the frame: a body that turns stays in its
    /// ball.
    #[inline]
    pub(crate) fn is_out_of_reach(&self) -> bool {
        let [first, second] = self.flights;
        let way = self.frame.dt * (first.linear - second.linear).length();
        let most = first.radius + second.radius + way + self.near;
        first.start.position.distance_squared(second.start.position) > most * most
    }

    /// True if any two points of the pair, near as they are, may meet so fast that it is a
    /// strike.
    #[inline]
    pub(crate) fn may_strike(&self) -> bool {
        self.most_speed + self.faster > self.frame.strike_speed()
    }

    /// Speed at which a gap `phi` [m] that closes at `closing` [m/s] along `normal` will be closed,
    /// gravity included [m/s].
    #[inline]
    pub(crate) fn surface_speed(&self, normal: DVec3, closing: f64, phi: f64) -> f64 {
        let [first, second] = self.flights;
        let acceleration = -(first.acceleration - second.acceleration).dot(normal);
        let squared = closing * closing + 2.0 * acceleration * phi;
        if phi > 0.0 && closing > 0.0 { squared.max(0.0).sqrt() } else { closing.max(0.0) }
    }

    /// True if a sample passes beside the other body's surface: the body that it is of lies on
    /// the far side. Where two edges lie on each other a distance has the normals of both sides.
    pub fn is_beside(&self, sample_of_first: bool, contact: &ContactPoint) -> bool {
        let [first, second] = self.placed();
        let (own, outward) =
            if sample_of_first { (first, contact.normal) } else { (second, -contact.normal) };
        let (low, high) = own.shape.bounds;
        let step = (BESIDE * self.size).min(THROUGH * (high - low).min_element());
        let body_from_world = own.pose.world_from_body().inverse();
        let distance =
            |point: DVec3| own.shape.distance_and_gradient(body_from_world.point(point)).0;
        distance(contact.point + step * outward) - distance(contact.point) > 0.5 * step
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::{Contactant, Motion, NewBody, Pose, StepSettings, Velocity};
    use frangible_geometry::{ClosedForm, HalfSpace, Shape};
    use glam::DQuat;
    use std::sync::Arc;

    /// A ball above the ground that may not strike it meets it no faster than what falls from as
    /// high as is near, however far above it is; one that is some times as fast does.
    #[test]
    fn what_is_slow_strikes_nothing() {
        let frame =
            Frame { dt: 1.0 / 30.0, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
        let ground = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.0 });
        let fastest = |times: f64| {
            let speed = times * (frame.strike_speed() - 9.81 * frame.dt);
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
                    contactant: Contactant::new(0.0, 0.5),
                });
            }
            let pair = Pair { first: 0, second: 1 };
            let [first, second] = Flight::of_pair(&bodies, pair, &frame);
            let encounter = Encounter::new(&bodies, pair, [&first, &second], &frame);
            let at = |part: i32| {
                encounter.surface_speed(-DVec3::Y, speed, 0.01 * f64::from(part) * encounter.reach)
            };
            (encounter.may_strike(), (0..=100).map(at).fold(0.0, f64::max) * frame.dt)
        };
        let least = 2.0 * frame.sag();
        for times in [0.0, 0.5, 0.999] {
            let (may, comes) = fastest(times);
            assert!(!may && comes <= least, "{times}: {comes} m of {least}");
        }
        let (may, comes) = fastest(3.0);
        assert!(may && comes > least, "{comes} m of {least}");
    }
}
