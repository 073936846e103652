//! Heavy bodies fall on light bodies.

use crate::shot::Shot;
use frangible::{BodyDesc, LookDesc, Resolution, SceneDesc, ShapeDesc};

/// Four cubes under a hundred times their mass.
pub(crate) const DEBRIS: Shot = Shot {
    name: "debris",
    caption: "a slab of a hundred times their mass comes down on four cubes of rubble at 10 m/s",
    frames: 90,
    takes_mesh: false,
    is_large: false,
    build: |_| {
        let debris = Debris { piece: Piece::Cube, size: 0.2, count: 4, ratio: 100.0, speed: 10.0 };
        Ok(debris.scene())
    },
};

/// A plate just above one piece on the ground, or above four.
#[derive(Clone, Copy)]
pub(crate) struct Debris {
    /// The piece on the ground.
    pub(crate) piece: Piece,
    /// Of a piece [m].
    pub(crate) size: f64,
    /// One piece in the middle, or one in each quarter.
    pub(crate) count: usize,
    /// Mass of the plate in units of all pieces'.
    pub(crate) ratio: f64,
    /// Of the plate, downward [m/s].
    pub(crate) speed: f64,
}

/// Shapes of pieces.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Piece {
    Cube,
    Ball,
    /// An octahedron.
    Hull,
}

/// Of the plate [m].
const PLATE: [f64; 3] = [1.0, 0.2, 1.0];

/// From the plate's middle to those of the quarters [m].
const QUARTER: f64 = 0.3;

/// Between plate and pieces at first [m].
const GAP: f64 = 0.02;

/// Of concrete [kg/m^3].
const DENSITY: f64 = 2400.0;

impl Piece {
    /// Its shape at a size [m], and its volume [m^3].
    fn shape(self, size: f64) -> (ShapeDesc, f64) {
        let (resolution, cube) = (Resolution::default(), size * size * size);
        match self {
            Self::Cube => (ShapeDesc::Box { size: [size; 3], resolution }, cube),
            Self::Ball => (
                ShapeDesc::Sphere { radius: 0.5 * size, resolution },
                std::f64::consts::PI / 6.0 * cube,
            ),
            Self::Hull => {
                let tip = |axis: usize, at: f64| {
                    let mut point = [0.0; 3];
                    point[axis] = at * size;
                    point
                };
                let points = (0..3).flat_map(|axis| [tip(axis, -0.5), tip(axis, 0.5)]).collect();
                (ShapeDesc::Hull { points, resolution }, cube / 6.0)
            }
        }
    }
}

impl Debris {
    /// Everything without restitution.
    pub(crate) fn scene(&self) -> SceneDesc {
        let mut scene = SceneDesc::new("");
        scene.bodies.push(BodyDesc::ground(0.0));
        let places: &[[f64; 2]] = match self.count {
            1 => &[[0.0, 0.0]],
            _ => &[[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]],
        };
        let (shape, volume) = self.piece.shape(self.size);
        scene.bodies.extend(places.iter().map(|[x, z]| BodyDesc {
            position: [QUARTER * x, 0.5 * self.size, QUARTER * z],
            density: DENSITY,
            restitution: 0.0,
            look: Some(LookDesc::Concrete),
            ..BodyDesc::new("piece", shape.clone())
        }));
        let mass = self.ratio * DENSITY * volume * places.len() as f64;
        scene.bodies.push(BodyDesc {
            position: [0.0, self.size + GAP + 0.5 * PLATE[1], 0.0],
            linear_velocity: [0.0, -self.speed, 0.0],
            density: mass / PLATE.iter().product::<f64>(),
            restitution: 0.0,
            look: Some(LookDesc::Concrete),
            ..BodyDesc::new(
                "slab",
                ShapeDesc::Box { size: PLATE, resolution: Resolution::default() },
            )
        });
        scene
    }
}
