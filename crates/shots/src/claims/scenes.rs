//! Building blocks of the claims' scenes.

use super::watch::step;
use frangible::{BodyDesc, BuildError, Method, Resolution, SceneDesc, ShapeDesc, World};
use glam::DVec3;

/// Gravity of the scenes [m/s^2].
pub(super) const GRAVITY: f64 = 9.81;

/// Both methods, as they are called in findings.
pub(super) const METHODS: [(Method, &str); 2] =
    [(Method::FrameRate, "frame-rate method"), (Method::Paper, "paper's method")];

pub(super) fn cube(edge: f64) -> ShapeDesc {
    cuboid([edge; 3])
}

/// A box of three edge lengths [m].
pub(super) fn cuboid(size: [f64; 3]) -> ShapeDesc {
    ShapeDesc::Box { size, resolution: Resolution::default() }
}

pub(super) fn ball(radius: f64) -> ShapeDesc {
    ShapeDesc::Sphere { radius, resolution: Resolution::default() }
}

/// Bodies under gravity at 30 frames per second.
pub(super) fn world(method: Method, bodies: Vec<BodyDesc>) -> Result<World, BuildError> {
    World::build(&SceneDesc { method, bodies, ..SceneDesc::new("claim") })
}

/// Bodies in free space.
pub(super) fn free_world(method: Method, bodies: Vec<BodyDesc>) -> Result<World, BuildError> {
    World::build(&SceneDesc { method, bodies, gravity: [0.0; 3], ..SceneDesc::new("claim") })
}

pub(super) fn run(world: &mut World, frames: u32) {
    for _ in 0..frames {
        step(world);
    }
}

/// Of a body's centre of mass [m].
pub(super) fn position(world: &World, body: usize) -> DVec3 {
    world.bodies().poses[body].position
}

/// Kinetic and potential energy [J].
pub(super) fn energy(world: &World) -> f64 {
    let (kinetic, potential) = world.energy();
    kinetic + potential
}
