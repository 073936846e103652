//! A top on its tip.

use super::scenes::{GRAVITY, METHODS, world};
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle};
use frangible::{BodyDesc, BuildError, Method, Resolution, ShapeDesc, World};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// Spins at 50 rad/s.
pub(super) const TOP: Claim = Claim {
    name: "top",
    says: "a top that spins by 1.7 rad in a frame precesses for 10 s as mechanics says",
    source: "Goldstein, Classical Mechanics, sec. 5.7",
    measure: top,
};

/// Height of the cone [m].
const HEIGHT: f64 = 0.1;

/// Radius of its base, which is up [m].
const RADIUS: f64 = 0.15;

/// Edges of the base.
const EDGES: u32 = 24;

/// Of its axis, from the vertical [rad].
const TILT: f64 = 0.2;

/// Spin about its axis [rad/s]: twice the minimum for an upright top.
const SPIN: f64 = 50.0;

/// A cone with its tip in the origin. Velocities are the centre of mass's and the body's.
fn cone(method: Method, linear: DVec3, angular: DVec3) -> Result<World, BuildError> {
    let rim = (0..EDGES).map(|edge| {
        let (sine, cosine) = libm::sincos(TAU * f64::from(edge) / f64::from(EDGES));
        [RADIUS * cosine, HEIGHT, RADIUS * sine]
    });
    let points = std::iter::once([0.0; 3]).chain(rim).collect();
    let shape = ShapeDesc::Hull { points, resolution: Resolution::default() };
    let cone = BodyDesc {
        orientation: DQuat::from_rotation_z(-TILT).to_array(),
        linear_velocity: linear.to_array(),
        angular_velocity: angular.to_array(),
        friction: 1.0,
        restitution: 0.0,
        ..BodyDesc::new("top", shape)
    };
    world(method, vec![BodyDesc { friction: 1.0, ..BodyDesc::ground(0.0) }, cone])
}

/// The rate of steady precession [rad/s]: W in m g l = W (I3 w3 - I1 W cos(tilt)), I1 about the
/// tip. `arm` is l, from the tip to the centre of mass [m].
fn precession_rate(world: &World, arm: f64) -> f64 {
    let (inertia, mass) = (&world.bodies().inertias[1], world.bodies().masses[1]);
    // The cone is flat: its own axis has the largest moment.
    let about_axis = 1.0 / inertia.inverse_moments.min_element();
    let about_tip = 1.0 / inertia.inverse_moments.max_element() + mass * arm * arm;
    let (a, b) = (about_tip * libm::cos(TILT), about_axis * SPIN);
    (b - (b * b - 4.0 * a * mass * GRAVITY * arm).sqrt()) / (2.0 * a)
}

fn top() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        // Start in steady precession, without nutation.
        let at_rest = cone(method, DVec3::ZERO, DVec3::ZERO)?;
        let center = at_rest.bodies().poses[1].position;
        let rate = precession_rate(&at_rest, center.length());
        let angular = rate * DVec3::Y + (SPIN - rate * libm::cos(TILT)) * center.normalize();
        let mut world = cone(method, angular.cross(center), angular)?;

        // The angle that its centre of mass goes round.
        let kinetic = world.energy().0;
        let (mut last, mut turned) = (center.with_y(0.0), 0.0);
        for _ in 0..300 {
            step(&mut world);
            let now = world.bodies().poses[1].position.with_y(0.0);
            turned += libm::atan2(last.cross(now).y, last.dot(now));
            last = now;
        }
        let lost = (world.energy().0 / kinetic - 1.0).abs();
        let bound = |most: f64| if method == Method::FrameRate { most } else { f64::INFINITY };
        let quantity = format!("angle of precession per the analytic, {name}");
        let error = bound(0.03);
        findings.push(Finding::between(
            quantity,
            "1",
            turned / (10.0 * rate),
            1.0 - error,
            1.0 + error,
        ));
        findings.push(Finding::at_most(
            format!("energy of motion lost, {name}"),
            "1",
            lost,
            bound(0.01),
        ));
    }
    Ok(findings)
}
