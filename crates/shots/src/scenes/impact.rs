//! Any mesh, hit by a ball.

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::Voronoi;
use frangible::geometry::mesh_io;
use frangible::{BodyDesc, BreakingDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc};

/// The user's own mesh.
pub(crate) const IMPACT: Shot = Shot {
    name: "impact",
    caption: "a ball breaks a mesh of your own (--mesh FILE), scaled to 2 m and set on the ground",
    frames: 120,
    takes_mesh: true,
    is_large: false,
    build: |options| impact("impact", None, 200, options),
};

/// Figure 6, with the bunny as the mesh.
pub(crate) const BUNNY: Shot = Shot {
    name: "bunny",
    caption: "a ball shatters the Stanford bunny (--mesh FILE), 70 x 60 x 45 voxels (figure 6)",
    frames: 120,
    takes_mesh: true,
    is_large: false,
    build: |options| impact("bunny", Some(BUNNY_VOXELS), 500, options),
};

/// Of figure 6: along the bunny's length, height and depth; in the order of the file's axes the
/// largest need decides.
const BUNNY_VOXELS: [usize; 3] = [70, 60, 45];

/// Length of the mesh's longest side after scaling [m]: one shot suits files in any unit.
const LONGEST_SIDE: f64 = 2.0;

/// Steel [kg/m^3].
const BALL_DENSITY: f64 = 7800.0;

/// [m]
const BALL_RADIUS: f64 = 0.25;

/// [m/s]
const SPEED: f64 = 15.0;

/// Initial distance of the ball from the mesh [m]: visible in flight, with little fall.
const RUN_UP: f64 = 2.0;

/// Strength of the mesh per mass [N s/kg]: three times gravity's impulse in a frame, to survive
/// standing.
const STRENGTH_PER_MASS: f64 = 1.0;

/// Maximum strength of the mesh [N s]: less than the impact of the ball.
const MOST_STRENGTH: f64 = 2500.0;

fn impact(
    shot: &'static str,
    voxels: Option<[usize; 3]>,
    cells: usize,
    options: &ShotOptions,
) -> Result<SceneDesc, ShotError> {
    // The mesh stands on the ground, in the middle.
    let path = options.mesh.as_ref().ok_or(ShotError::NeedsMesh(shot))?;
    let name = path.display().to_string();
    let raw = mesh_io::load(path)?;
    let raw = match options.thickness {
        Some(thickness) => raw.thickened(thickness, &name)?.mesh,
        None => raw,
    };
    let mesh = raw.cleaned(&name)?.mesh;
    let (low, high) = mesh.bounds();
    let scale = LONGEST_SIDE / (high - low).max_element();
    let (low, high) = (scale * low, scale * high);
    let middle = 0.5 * (low + high);
    let resolution = Resolution { voxels, sample_spacing: None };
    let thickness = options.thickness.map(|thickness| scale * thickness);
    let shape = ShapeDesc::Mesh { path: name, scale, thickness, sides: None, resolution };
    let pattern = PatternDesc::Voronoi(Voronoi {
        cells,
        clustering: 1.5,
        seed: options.seed,
        ..Voronoi::default()
    });
    let body =
        BodyDesc { position: [-middle.x, -low.y, -middle.z], ..BodyDesc::new("mesh", shape) };
    let mass = body.density * mesh.mass_properties().volume * scale * scale * scale;
    let strength = (STRENGTH_PER_MASS * mass).min(MOST_STRENGTH);
    let body = BodyDesc { breaking: Some(BreakingDesc::once(strength, pattern)), ..body };

    // The ball flies at the centre of its mass.
    let center = scale * mesh.mass_properties().center - middle;
    let height = (center.y + middle.y - low.y).max(BALL_RADIUS);
    let shape = ShapeDesc::Sphere { radius: BALL_RADIUS, resolution: Resolution::default() };
    let ball = BodyDesc {
        position: [0.5 * (high.x - low.x) + RUN_UP, height, center.z],
        linear_velocity: [-SPEED, 0.0, 0.0],
        density: BALL_DENSITY,
        ..BodyDesc::new("ball", shape)
    };
    let mut scene = SceneDesc::new("");
    scene.bodies = vec![BodyDesc::ground(0.0), body, ball];
    Ok(scene)
}
