//! Kinematic bodies lift, turn and carry others.

use super::scenes::{GRAVITY, METHODS, cube, cuboid, energy, position, run, world};
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use frangible::{BodyDesc, BuildError, Method, MotionDesc, Resolution, ShapeDesc, World};
use glam::{DQuat, DVec3};

/// Up and down.
pub(super) const ELEVATOR: Claim = Claim {
    name: "elevator",
    says: "an elevator carries a stack of five cubes up and down at 2 m/s, and its work is the energy that they gain",
    source: "Su09 sec. 3.2",
    measure: elevator,
};

/// Round.
pub(super) const TURNTABLE: Claim = Claim {
    name: "turntable",
    says: "a cube goes round with a turntable as long as friction bears its centripetal force, and else slides off",
    source: "mechanics",
    measure: turntable,
};

/// Along.
pub(super) const CONVEYOR: Claim = Claim {
    name: "conveyor",
    says: "a conveyor belt accelerates a cube by friction until it moves along",
    source: "mechanics",
    measure: conveyor,
};

/// At 30 frames per second [s].
const DT: f64 = 1.0 / 30.0;

/// A cube of 1 m under four others may sink so far into its support [m] ([adr/023]).
///
/// [adr/023]: docs/adr/023-eight-substeps.md
const MOST_SINKING: f64 = 2e-3;

/// Of the elevator and of the belt [m/s].
const SPEED: f64 = 2.0;

/// Acceleration of the elevator [m/s^2]: a fifth of gravity, to keep the stack on it.
const ACCELERATION: f64 = 2.0;

/// The elevator's velocity at a time [m/s]: up for 4 s, down for 4 s, and back at rest where it
/// began after 8 s; its speed changes from 0 to 1 s, from 3 to 5 s and from 7 s on.
fn elevator_velocity(time: f64) -> f64 {
    let clamped = |velocity: f64| velocity.clamp(-SPEED, SPEED);
    if time < 4.0 {
        clamped((ACCELERATION * time).min(ACCELERATION * (4.0 - time)))
    } else {
        clamped((ACCELERATION * (4.0 - time)).max(ACCELERATION * (time - 8.0))).min(0.0)
    }
}

/// Largest overlap of any of the five cubes with its support [m].
fn sinking(world: &World) -> f64 {
    let height = |i: usize| position(world, i).y;
    let gap = |level: usize| height(level) - height(level - 1) - if level == 1 { 0.6 } else { 1.0 };
    largest((1..6).map(|level| -gap(level)))
}

fn elevator() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let plate = BodyDesc {
            motion: MotionDesc::Kinematic,
            position: [0.0, -0.1, 0.0],
            ..BodyDesc::new("elevator", cuboid([3.0, 0.2, 3.0]))
        };
        let cube = |level: u32| BodyDesc {
            position: [0.0, 0.5 + f64::from(level), 0.0],
            restitution: 0.0,
            ..BodyDesc::new("cube", cube(1.0))
        };
        let mut world = world(method, std::iter::once(plate).chain((0..5).map(cube)).collect())?;
        let (start, plate) = (energy(&world), world.bodies().ids[0]);
        let (mut work, mut most_work, mut raised, mut sunk) = (0.0, 0.0, 0.0, f64::NEG_INFINITY);
        for frame in 0..240 {
            // The mean velocity of the frame: what a motor that is told a position would do.
            let velocity = elevator_velocity((f64::from(frame) + 0.5) * DT);
            world.set_velocity(plate, velocity * DVec3::Y, DVec3::ZERO)?;
            work += step(&mut world).energy.work;
            sunk = largest([sunk, sinking(&world)]);
            if work > most_work {
                (most_work, raised) = (work, energy(&world) - start);
            }
        }
        let lost = (energy(&world) - start - work).abs() / most_work;
        findings.push(Finding::at_most(format!("sinking, {name}"), "m", sunk, MOST_SINKING));
        findings.push(Finding::between(
            format!("energy gained per work on the way up, {name}"),
            "1",
            raised / most_work,
            0.99,
            1.01,
        ));
        findings.push(Finding::at_most(
            format!("work not returned on the way down, {name}"),
            "1",
            lost,
            0.01,
        ));
    }
    Ok(findings)
}

/// Where the cube sits on the turntable: from the axis [m].
const SEAT: f64 = 1.2;

/// Of the turntable [m].
const TABLE_RADIUS: f64 = 2.0;

/// Maximum outward slip of the cube in ten seconds with the frame-rate method [m].
const MOST_SLIP: f64 = 0.01;

fn turntable() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let (radius, _) = ride(method, 1.2)?;
        let quantity = format!("distance after 10 s above the slip rate, {name}");
        findings.push(Finding::at_least(quantity, "m", radius, TABLE_RADIUS));

        // The paper's method takes friction against where the table moves at the frame's end.
        let (radius, lag) = ride(method, 0.8)?;
        let most = |bound: f64| if method == Method::FrameRate { bound } else { f64::INFINITY };
        let quantity = format!("slip outward in 10 s below the slip rate, {name}");
        findings.push(Finding::at_most(quantity, "m", (radius - SEAT).abs(), most(MOST_SLIP)));
        let quantity = format!("angle behind in 10 s below the slip rate, {name}");
        findings.push(Finding::at_most(quantity, "rad", lag, most(0.01)));
    }
    Ok(findings)
}

/// A cube on a disk that turns at `share` of the rate at which friction no longer bears the
/// centripetal force: its distance from the axis [m], and the angle that it is behind [rad], after
/// 10 s.
fn ride(method: Method, share: f64) -> Result<(f64, f64), BuildError> {
    let friction = 0.5;
    let rate = share * (friction * GRAVITY / SEAT).sqrt();
    let shape = ShapeDesc::Cylinder {
        radius: TABLE_RADIUS,
        height: 0.2,
        resolution: Resolution::default(),
    };
    let table = BodyDesc {
        motion: MotionDesc::Kinematic,
        position: [0.0, -0.1, 0.0],
        angular_velocity: [0.0, rate, 0.0],
        ..BodyDesc::new("turntable", shape)
    };
    let cube = BodyDesc {
        position: [SEAT, 0.15, 0.0],
        linear_velocity: [0.0, 0.0, -rate * SEAT],
        angular_velocity: [0.0, rate, 0.0],
        restitution: 0.0,
        friction,
        ..BodyDesc::new("cube", cube(0.3))
    };
    let mut world = world(method, vec![BodyDesc::ground(-0.2), table, cube])?;
    run(&mut world, 300);
    let at = DQuat::from_rotation_y(-10.0 * rate) * position(&world, 2);
    Ok((at.with_y(0.0).length(), libm::atan2(-at.z, at.x).abs()))
}

fn conveyor() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let friction = 0.4;
        let belt = BodyDesc {
            motion: MotionDesc::Kinematic,
            position: [0.0, -0.1, 0.0],
            linear_velocity: [SPEED, 0.0, 0.0],
            ..BodyDesc::new("belt", cuboid([30.0, 0.2, 2.0]))
        };
        let cube = BodyDesc {
            position: [0.0, 0.15, 0.0],
            restitution: 0.0,
            friction,
            ..BodyDesc::new("cube", cube(0.3))
        };
        let mut world = world(method, vec![belt, cube])?;
        run(&mut world, 30);
        let slipped = position(&world, 0).x - position(&world, 1).x;
        let expected = 0.5 * SPEED * SPEED / (friction * GRAVITY);
        run(&mut world, 90);
        let crept = (position(&world, 0).x - position(&world, 1).x - slipped).abs();
        findings.push(Finding::between(
            format!("slip per the analytic, {name}"),
            "1",
            slipped / expected,
            0.99,
            1.01,
        ));
        findings.push(Finding::at_most(
            format!("creep in 3 s of moving along, {name}"),
            "m",
            crept,
            1e-4,
        ));
    }
    Ok(findings)
}
