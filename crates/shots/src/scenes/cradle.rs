//! Steel balls in a row, struck by others: as many leave as came, as in Newton's cradle.

use crate::shot::Shot;
use frangible::{BodyDesc, LookDesc, Resolution, SceneDesc, ShapeDesc};

/// Two balls strike five.
pub(crate) const CRADLE: Shot = Shot {
    name: "cradle",
    caption: "two steel balls strike five in a row, and two leave at its end",
    frames: 45,
    takes_mesh: false,
    is_large: false,
    build: |_| Ok(cradle(STRIKERS, 1.0)),
};

/// Number of balls in the row before impact.
pub(crate) const ROW: usize = 5;

/// In the shot.
const STRIKERS: usize = 2;

/// Of the balls [m].
pub(crate) const RADIUS: f64 = 0.1;

/// Speed of the strikers [m/s].
pub(crate) const SPEED: f64 = 2.0;

/// Between these and the row [m].
const WAY: f64 = 0.5;

/// Of steel [kg/m^3].
const DENSITY: f64 = 7800.0;

/// A smooth one that lies at a place along the row [m], and its speed [m/s].
fn ball(place: f64, speed: f64, restitution: f64) -> BodyDesc {
    BodyDesc {
        position: [place, RADIUS, 0.0],
        linear_velocity: [speed, 0.0, 0.0],
        density: DENSITY,
        friction: 0.0,
        restitution,
        look: Some(LookDesc::Metal),
        ..BodyDesc::new(
            "ball",
            ShapeDesc::Sphere { radius: RADIUS, resolution: Resolution::default() },
        )
    }
}

/// Balls `gap` apart [m] in free space, of which the first one moves [m/s].
pub(crate) fn row(count: usize, gap: f64, speed: f64) -> SceneDesc {
    let at = |number: usize| {
        let comes = if number == 0 { speed } else { 0.0 };
        ball((2.0 * RADIUS + gap) * number as f64, comes, 1.0)
    };
    SceneDesc { bodies: (0..count).map(at).collect(), gravity: [0.0; 3], ..SceneDesc::new("") }
}

/// Touching balls on smooth ground, hit along their row by `strikers` more.
pub(crate) fn cradle(strikers: usize, restitution: f64) -> SceneDesc {
    let ball = |place: f64, speed: f64| ball(place, speed, restitution);
    let mut scene = SceneDesc::new("");
    scene.bodies.push(BodyDesc::ground(0.0));
    let strikes = |number: usize| ball(-WAY - 2.0 * RADIUS * (strikers - number) as f64, SPEED);
    scene.bodies.extend((0..strikers).map(strikes));
    scene.bodies.extend((0..ROW).map(|number| ball(2.0 * RADIUS * number as f64, 0.0)));
    scene
}
