//! Balls roll, slide and spin on the ground.

use super::scenes::{GRAVITY, METHODS, ball, run, world};
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use frangible::{BodyDesc, BuildError, Method, World};
use glam::{DQuat, DVec3};

/// Coulomb's friction on a ball.
pub(super) const ROLLING: Claim = Claim {
    name: "rolling",
    says: "a ball rolls down a slope at 5/7 of a slider's acceleration, and one that slides rolls at last at 5/7 of its speed",
    source: "mechanics",
    measure: rolling,
};

/// Friction by torque.
pub(super) const ROLLING_FRICTION: Claim = Claim {
    name: "rolling-friction",
    says: "rolling and spinning friction, if wanted, stop a ball after the distance and the angle that their torques make",
    source: "mechanics",
    measure: rolling_friction,
};

/// Of the balls [m].
pub(super) const RADIUS: f64 = 0.5;

/// A ball on level ground.
pub(super) fn ball_on_ground(
    method: Method,
    linear: DVec3,
    angular: DVec3,
) -> Result<World, BuildError> {
    let ball = BodyDesc {
        position: [0.0, RADIUS, 0.0],
        linear_velocity: linear.to_array(),
        angular_velocity: angular.to_array(),
        ..BodyDesc::new("ball", ball(RADIUS))
    };
    world(method, vec![BodyDesc::ground(0.0), ball])
}

fn rolling() -> Result<Vec<Finding>, Obstacle> {
    let slope = 10_f64.to_radians();
    let tilt = DQuat::from_rotation_z(-slope);
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let (low, high) = (0.99, 1.01);

        // Down the slope for two seconds from rest.
        let start = tilt * DVec3::new(0.0, RADIUS, 0.0);
        let rolls = BodyDesc { position: start.to_array(), ..BodyDesc::new("ball", ball(RADIUS)) };
        let ground = BodyDesc { orientation: tilt.to_array(), ..BodyDesc::ground(0.0) };
        let mut world = world(method, vec![ground, rolls])?;
        run(&mut world, 60);
        let rolled = (world.bodies().poses[1].position - start).dot(tilt * DVec3::X);
        let expected = 5.0 / 7.0 * GRAVITY * libm::sin(slope) * 0.5 * 2.0 * 2.0;
        findings.push(Finding::between(
            format!("distance rolled down 10 degrees per the analytic, {name}"),
            "1",
            rolled / expected,
            low,
            high,
        ));

        // Thrown along without spin.
        let mut world = ball_on_ground(method, 3.5 * DVec3::X, DVec3::ZERO)?;
        run(&mut world, 60);
        let speed = world.bodies().velocities[1].linear.x;
        let quantity = format!("speed of a ball that slid first per the analytic, {name}");
        findings.push(Finding::between(quantity, "1", speed / 2.5, low, high));
        findings.push(Finding::at_most(
            format!("deviation of that ball, {name}"),
            "m",
            largest([
                world.bodies().poses[1].position.z.abs(),
                (world.bodies().poses[1].position.y - RADIUS).abs(),
            ]),
            1e-3,
        ));
    }
    Ok(findings)
}

/// Largest torques per normal force in that claim [m].
const TORQUE_ARM: f64 = 0.01;

fn rolling_friction() -> Result<Vec<Finding>, Obstacle> {
    let ball = |linear: DVec3, angular: DVec3| -> Result<World, BuildError> {
        let ball = BodyDesc {
            position: [0.0, RADIUS, 0.0],
            linear_velocity: linear.to_array(),
            angular_velocity: angular.to_array(),
            rolling_friction: TORQUE_ARM,
            spinning_friction: TORQUE_ARM,
            ..BodyDesc::new("ball", ball(RADIUS))
        };
        world(Method::FrameRate, vec![BodyDesc::ground(0.0), ball])
    };

    // While it rolls, the torque brakes 7/5 of its mass: v^2 / 2 a.
    let speed = 1.0;
    let mut world = ball(speed * DVec3::X, -speed / RADIUS * DVec3::Z)?;
    run(&mut world, 600);
    let brake = 5.0 / 7.0 * GRAVITY * TORQUE_ARM / RADIUS;
    let rolled = world.bodies().poses[1].position.x / (0.5 * speed * speed / brake);

    // While it spins on the spot, 2/5 of its mass: after 2 s of constant braking.
    let spin = 20.0;
    let mut world = ball(DVec3::ZERO, spin * DVec3::Y)?;
    run(&mut world, 60);
    let momentum = world.bodies().velocities[1].angular_momentum.y;
    let per_mass = momentum / (0.4 * world.bodies().masses[1] * RADIUS * RADIUS);
    let slowed = (spin - per_mass) / (2.0 * GRAVITY * TORQUE_ARM / (0.4 * RADIUS * RADIUS));
    Ok(vec![
        Finding::between(
            "distance rolled per the analytic, frame-rate method",
            "1",
            rolled,
            0.98,
            1.02,
        ),
        Finding::between(
            "loss of spin per the analytic, frame-rate method",
            "1",
            slowed,
            0.98,
            1.02,
        ),
    ])
}
