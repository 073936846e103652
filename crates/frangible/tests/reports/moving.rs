//! What bounces, rolls and slides.

use crate::scenes::*;
use frangible::{BodyDesc, MotionDesc, World};
use glam::DQuat;
use std::f64::consts::FRAC_PI_6;

#[test]
fn balls_bounce_to_their_height_and_straight_up() {
    let mut rows = Vec::new();
    for method in BOTH {
        let run = Run { method, ..AT_30 };
        for (source, floor, radius, drop) in [
            ("bulletphysics/bullet3#1530", BodyDesc::ground(0.0), 0.1, 1.0),
            (
                "aframe-physics-system#10",
                fixed(cuboid([4.0, 1.0, 4.0]), [0.0, -0.5, 0.0]),
                0.1,
                10.0,
            ),
            // A pinball of 14 mm, of steel as of rubber.
            ("godot-jolt/godot-jolt#374", fixed(cuboid([2.0; 3]), [0.0, -1.0, 0.0]), 0.014, 0.05),
        ] {
            let start = [0.0, radius + drop, 0.0];
            let elastic = BodyDesc { restitution: 1.0, ..body(ball(radius), start) };
            let mut least = f64::INFINITY;
            let world = run.watch(vec![floor, elastic], 20.0, |world| {
                least = least.min(height(world, radius))
            });
            rows.push((
                source,
                format!("height kept, {method:?}"),
                least / drop,
                [0.9999, 1.0 + 1e-9],
            ));
            let aside = position(&world).with_y(0.0).length();
            rows.push((source, format!("aside, {method:?}"), aside, [0.0, 1e-9]));
        }
    }
    // A light ball on a heavy one: (3 - m) / (1 + m) of the speed of fall.
    let of = |radius: f64, y: f64, density: f64| BodyDesc {
        restitution: 1.0,
        density,
        ..body(ball(radius), [0.0, y, 0.0])
    };
    let pair = vec![BodyDesc::ground(0.0), of(0.2, 1.2, 1000.0), of(0.05, 1.452, 640.0)];
    let mut top = 0.0_f64;
    Run { rate: 60.0, ..AT_30 }.watch(pair, 2.2, |world| top = top.max(position(world).y - 0.45));
    rows.push(("kaplayjs/kaplay#958", "height of the light ball".into(), top, about(8.764, 0.02)));
    check(&rows);
}

#[test]
fn balls_roll_and_are_carried() {
    let mut rows = Vec::new();
    for method in BOTH {
        let slope = Run { gravity: [0.5 * G, -G * libm::cos(FRAC_PI_6), 0.0], method, ..AT_30 };
        let start = [0.0, 0.3, 0.0];
        let world = slope.end(vec![BodyDesc::ground(0.0), body(ball(0.3), start)], 3.0);
        let right = 5.0 / 7.0 * 0.5 * G * 4.5;
        rows.push((
            "gazebosim/gz-physics#7",
            format!("way down, {method:?}"),
            position(&world).x,
            about(right, 5e-3),
        ));

        let platform = BodyDesc {
            motion: MotionDesc::Kinematic,
            linear_velocity: [2.0, 0.0, 0.0],
            ..fixed(cuboid([100.0, 1.0, 10.0]), [0.0, -0.5, 0.0])
        };
        let world = Run { method, ..AT_30 }.end(vec![platform, body(ball(0.3), start)], 4.0);
        rows.push((
            "schteppe/cannon.js#327",
            format!("speed, {method:?}"),
            velocity(&world).x,
            about(4.0 / 7.0, 2e-4),
        ));
    }
    // A rolling ball does not bounce by itself.
    let rolls = BodyDesc {
        linear_velocity: [10.0, 0.0, 0.0],
        angular_velocity: [0.0, 0.0, -20.0],
        ..body(ball(0.5), [0.0, 0.5, 0.0])
    };
    let mut hop = 0.0_f64;
    AT_30.watch(vec![BodyDesc::ground(0.0), rolls], 10.0, |world| {
        hop = hop.max((position(world).y - 0.5).abs())
    });
    rows.push(("chandlerprall/GoblinPhysics#74", "bounce [m]".into(), hop, [0.0, 1e-4]));
    check(&rows);
}

#[test]
fn boxes_slide_straight_and_stop() {
    let mut rows = Vec::new();
    for method in BOTH {
        for (size, yaw) in [([0.5; 3], 30.0), ([1.0, 0.2, 0.5], 30.0), ([2.0, 0.5, 0.3], 45.0)] {
            let [source, right] = ["jrouwe/JoltPhysics#983", "6.524 m straight on"];
            let slides = BodyDesc {
                orientation: DQuat::from_rotation_y(f64::to_radians(yaw)).to_array(),
                linear_velocity: [8.0, 0.0, 0.0],
                ..body(cuboid(size), [0.0, 0.5 * size[1], 0.0])
            };
            let world = Run { method, ..AT_30 }.end(vec![BodyDesc::ground(0.0), slides], 3.0);
            let at = position(&world);
            rows.push((
                source,
                format!("{right}, {size:?}, {method:?}"),
                at.x,
                about(64.0 / G, 1e-3),
            ));
            rows.push((source, format!("aside, {size:?}, {method:?}"), at.z, about(0.0, 2e-3)));
        }
    }
    // 1 kg at a coefficient of 0.5 bears 4.9 N of 4.905.
    let pulled = Run { gravity: [4.9, -G, 0.0], ..AT_30 };
    let world = pulled
        .end(vec![BodyDesc::ground(0.0), body(cuboid([1.0, 0.5, 1.0]), [0.0, 0.25, 0.0])], 10.0);
    rows.push(("raisimTech/raisimLib#55", "creep [m]".into(), position(&world).x, [0.0, 0.01]));
    check(&rows);
}

#[test]
fn seams_are_not_felt() {
    let mut rows = Vec::new();
    let tiles: Vec<BodyDesc> =
        (0..30).map(|i| fixed(cuboid([1.0, 1.0, 4.0]), [f64::from(i) - 1.5, -0.5, 0.0])).collect();
    let upright = DQuat::IDENTITY.to_array();
    let cases = [
        ("box2d#456", tiles, 8.0, true),
        ("dimforge/rapier#182", vec![field(-8.0), field(8.0)], 6.0, false),
        ("godotengine/godot#102544", vec![sheet(32.0, 64)], 5.0, false),
    ];
    for (source, floor, speed, rolls) in cases {
        for (name, shape, orientation) in [
            ("cube", cuboid([0.5; 3]), upright),
            ("ball", ball(0.25), upright),
            ("cylinder", cylinder(0.25, 0.5), if rolls { lying() } else { upright }),
        ] {
            let is_round = name != "cube";
            let friction = if rolls && is_round { 0.5 } else { 0.0 };
            let spin = if rolls && is_round { -4.0 * speed } else { 0.0 };
            // Off the step of the frames, and with the front just above the seam as a frame begins.
            for start in [-0.25, -0.917, -1.0, -1.083] {
                let mover = BodyDesc {
                    linear_velocity: [speed, 0.0, 0.0],
                    angular_velocity: [0.0, 0.0, spin],
                    orientation,
                    friction,
                    ..body(shape.clone(), [start, 0.25, 0.13])
                };
                let mut hop = 0.0_f64;
                let bodies = floor.iter().cloned().chain([mover]).collect();
                let look = |world: &World| hop = hop.max(position(world).y - 0.25);
                let world = AT_30.watch(bodies, 0.6, look);
                let (way, right) = (position(&world).x - start, 0.6 * speed);
                let what = format!("way of a {name} from {start} [m]");
                rows.push((source, what, way, about(right, 0.01 * right)));
                rows.push((source, format!("hop of a {name} from {start} [m]"), hop, [0.0, 1e-3]));
            }
        }
    }
    // Beside a wall, nearer than gravity moves in a frame.
    for gap in [1e-4, 5e-4, 5e-3] {
        let falls = BodyDesc { restitution: 0.5, ..body(ball(0.0135), [0.0135 + gap, 0.5, 0.0]) };
        let wall = fixed(cuboid([0.2, 0.4, 0.4]), [-0.1, 0.1, 0.0]);
        let world = AT_30.end(vec![wall, falls], 0.4);
        rows.push((
            "avianphysics/avian#990",
            format!("speed aside at {gap} m"),
            velocity(&world).x,
            about(0.0, 1e-9),
        ));
    }
    check(&rows);
}
