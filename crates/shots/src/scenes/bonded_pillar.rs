//! A pillar of glued pieces stands, until a ball strikes it.

use crate::scenes::pillar::HALF;
use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::Voronoi;
use frangible::{BodyDesc, BondsDesc, LookDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc};

/// With bonds as strong as concrete.
pub(crate) const BONDED_PILLAR: Shot = Shot {
    name: "bonded-pillar",
    caption: "a pillar of glued pieces stands on its own, and comes down when a ball strikes it",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: bonded_pillar,
};

/// Cells in the cube around the pillar, of which it takes a thirty-sixth of the volume and more
/// than that of the cells.
const CELLS: usize = 1500;

/// Tensile strength of concrete [Pa], across a bond [CEB90]; about equal along it.
const STRENGTH: f64 = 3e6;

/// Of the ball [m], of steel [kg/m^3].
const RADIUS: f64 = 0.45;
const STEEL: f64 = 7850.0;

fn bonded_pillar(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let bonds = BondsDesc {
        pattern: Some(PatternDesc::Voronoi(Voronoi {
            cells: CELLS,
            seed: options.seed,
            ..Voronoi::default()
        })),
        point: None,
        normal: [0.0, 1.0, 0.0],
        tensile_strength: STRENGTH,
        shear_strength: STRENGTH,
        anchors: Vec::new(),
        strength_points: Vec::new(),
        strength_triangles: Vec::new(),
    };
    let shape = ShapeDesc::Box { size: (2.0 * HALF).to_array(), resolution: Resolution::default() };
    let pillar = BodyDesc {
        position: [0.0, HALF.y, 0.0],
        restitution: 0.1,
        bonds: Some(bonds),
        look: Some(LookDesc::Concrete),
        ..BodyDesc::new("pillar", shape)
    };
    // It flies for a second and strikes the upper half.
    let ball = BodyDesc {
        position: [-12.0, 3.6, 0.2],
        linear_velocity: [12.0, 4.9, 0.0],
        density: STEEL,
        restitution: 0.1,
        look: Some(LookDesc::Metal),
        ..BodyDesc::new(
            "ball",
            ShapeDesc::Sphere { radius: RADIUS, resolution: Resolution::default() },
        )
    };
    let mut scene = SceneDesc::new("");
    scene.bodies.extend([BodyDesc::ground(0.0), pillar, ball]);
    Ok(scene)
}
