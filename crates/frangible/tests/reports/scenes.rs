//! Bodies, runs and measurements of the reports.

use frangible::{BodyDesc, Method, MotionDesc, Resolution, SceneDesc, ShapeDesc, World};
use glam::{DQuat, DVec3};
use std::f64::consts::FRAC_PI_2;

pub(crate) const G: f64 = 9.81;
pub(crate) const NONE: Resolution = Resolution { voxels: None, sample_spacing: None };
pub(crate) const BOTH: [Method; 2] = [Method::FrameRate, Method::Paper];

/// One measurement of a report, and the least and the most that are right.
pub(crate) type Row = (&'static str, String, f64, [f64; 2]);

pub(crate) fn check(rows: &[Row]) {
    let wrong: Vec<&Row> =
        rows.iter().filter(|row| !(row.3[0]..=row.3[1]).contains(&row.2)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

pub(crate) fn about(right: f64, off: f64) -> [f64; 2] {
    [right - off, right + off]
}

pub(crate) fn cuboid(size: [f64; 3]) -> ShapeDesc {
    ShapeDesc::Box { size, resolution: NONE }
}

pub(crate) fn ball(radius: f64) -> ShapeDesc {
    ShapeDesc::Sphere { radius, resolution: NONE }
}

pub(crate) fn cylinder(radius: f64, height: f64) -> ShapeDesc {
    ShapeDesc::Cylinder { radius, height, resolution: NONE }
}

pub(crate) fn capsule(radius: f64, height: f64) -> ShapeDesc {
    ShapeDesc::Capsule { radius, height, resolution: NONE }
}

/// A dynamic body that does not bounce.
pub(crate) fn body(shape: ShapeDesc, position: [f64; 3]) -> BodyDesc {
    BodyDesc { position, restitution: 0.0, ..BodyDesc::new("body", shape) }
}

pub(crate) fn fixed(shape: ShapeDesc, position: [f64; 3]) -> BodyDesc {
    let motion = MotionDesc::Static;
    BodyDesc { position, motion, restitution: 1.0, ..BodyDesc::new("fixed", shape) }
}

/// A flat heightfield with a middle [m] and 16 cells of 1 m a side.
pub(crate) fn field(x: f64) -> BodyDesc {
    let heights = vec![vec![0.0; 17]; 17];
    fixed(ShapeDesc::Heightfield { heights, spacing: [1.0; 2], sides: None }, [x, 0.0, 0.0])
}

/// A flat sheet of two triangles, or of `cells` squares a side.
pub(crate) fn sheet(side: f64, cells: u32) -> BodyDesc {
    let at = |i: u32| side * (f64::from(i) / f64::from(cells) - 0.5);
    let positions =
        (0..=cells).flat_map(|k| (0..=cells).map(move |i| [at(i), 0.0, at(k)])).collect();
    let row = cells + 1;
    let triangles = (0..cells)
        .flat_map(|k| (0..cells).map(move |i| k * row + i))
        .flat_map(|a| [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]])
        .collect();
    let shape = ShapeDesc::Triangles {
        positions,
        triangles,
        thickness: None,
        sides: None,
        resolution: NONE,
    };
    fixed(shape, [0.0; 3])
}

pub(crate) fn lying() -> [f64; 4] {
    DQuat::from_rotation_x(FRAC_PI_2).to_array()
}

pub(crate) struct Run {
    pub(crate) method: Method,
    pub(crate) rate: f64,
    pub(crate) gravity: [f64; 3],
}

pub(crate) const DOWN: [f64; 3] = [0.0, -G, 0.0];
pub(crate) const AT_30: Run = Run { method: Method::FrameRate, rate: 30.0, gravity: DOWN };

impl Run {
    /// Steps; `see` looks at the world after each frame.
    pub(crate) fn watch(
        &self,
        bodies: Vec<BodyDesc>,
        seconds: f64,
        mut see: impl FnMut(&World),
    ) -> World {
        let scene = SceneDesc {
            bodies,
            method: self.method,
            frames_per_second: self.rate,
            gravity: self.gravity,
            ..SceneDesc::new("report")
        };
        let mut world = World::build(&scene).unwrap();
        for _ in 0..(seconds * self.rate).round() as u32 {
            frangible::step(&mut world);
            see(&world);
        }
        world
    }

    pub(crate) fn end(&self, bodies: Vec<BodyDesc>, seconds: f64) -> World {
        self.watch(bodies, seconds, |_| ())
    }
}

pub(crate) fn position(world: &World) -> DVec3 {
    world.bodies().poses[world.bodies().len() - 1].position
}

pub(crate) fn velocity(world: &World) -> DVec3 {
    world.bodies().velocities[world.bodies().len() - 1].linear
}

/// Largest speed of a body [m/s].
pub(crate) fn fastest(world: &World) -> f64 {
    world.bodies().velocities.iter().map(|v| v.linear.length()).fold(0.0, f64::max)
}

/// Deepest overlap [m].
pub(crate) fn deepest(world: &World) -> f64 {
    world.penetrations().into_iter().fold(0.0, f64::max)
}

/// Height above rest of a ball [m], by its energy.
pub(crate) fn height(world: &World, radius: f64) -> f64 {
    position(world).y - radius + velocity(world).length_squared() / (2.0 * G)
}
