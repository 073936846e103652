//! Walls of loose bricks: an untouched wall, and a wall hit by a ball.

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::{BodyDesc, Resolution, SceneDesc, ShapeDesc};

/// A wall without mortar, and its projectile.
pub(crate) const BRICKS: Shot = Shot {
    name: "bricks",
    caption: "a ball flies into a wall of 1000 loose bricks",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: struck,
};

/// The same without the ball.
pub(crate) const STILL: Shot = Shot {
    name: "bricks-still",
    caption: "a wall of 1000 loose bricks stands",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |_| Ok(WALL.scene()),
};

/// A wall in running bond: every other course is shifted by half a brick.
#[derive(Clone, Copy)]
pub(crate) struct Wall {
    /// Of a brick [m].
    pub(crate) brick: [f64; 3],
    /// Number of courses.
    pub(crate) courses: usize,
    /// Bricks in each course.
    pub(crate) count: usize,
    /// True for half bricks at the ends of shifted courses. Without, the ends overhang.
    pub(crate) closed: bool,
}

/// Of the shots.
pub(crate) const WALL: Wall =
    Wall { brick: [0.25, 0.065, 0.12], courses: 25, count: 40, closed: false };

/// Of the ball [m], and its speed [m/s].
const BALL: [f64; 2] = [0.3, 15.0];

/// From the aim of one seed to that of the next, along the wall [m].
const AIMS: f64 = 0.1;

impl Wall {
    /// The wall on the ground.
    pub(crate) fn scene(&self) -> SceneDesc {
        let mut scene = SceneDesc::new("");
        scene.bodies.push(BodyDesc::ground(0.0));
        for course in 0..self.courses {
            self.lay(course, &mut scene);
        }
        scene
    }

    /// Adds a course.
    fn lay(&self, course: usize, scene: &mut SceneDesc) {
        let [length, height, thickness] = self.brick;
        let half = 0.5 * (self.count as f64 - 1.0);
        let shift = 0.5 * (course % 2) as f64;
        let mut brick = |along: f64, part: f64| {
            let size = [part * length, height, thickness];
            let shape = ShapeDesc::Box { size, resolution: Resolution::default() };
            scene.bodies.push(BodyDesc {
                position: [along * length, (course as f64 + 0.5) * height, 0.0],
                density: 1900.0,
                friction: 0.6,
                ..BodyDesc::new("brick", shape)
            });
        };
        let whole = if self.closed && course % 2 == 1 { self.count - 1 } else { self.count };
        for place in 0..whole {
            brick(place as f64 - half + shift, 1.0);
        }
        if whole < self.count {
            for end in [-half - 0.25, half + 0.25] {
                brick(end, 0.5);
            }
        }
    }
}

fn struck(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let mut scene = WALL.scene();
    let [radius, speed] = BALL;
    let height = WALL.courses as f64 * WALL.brick[1];
    scene.bodies.push(BodyDesc {
        position: [AIMS * options.seed as f64, 0.6 * height, 1.0 + radius],
        linear_velocity: [0.0, 0.0, -speed],
        density: 2600.0,
        ..BodyDesc::new("ball", ShapeDesc::Sphere { radius, resolution: Resolution::default() })
    });
    Ok(scene)
}
