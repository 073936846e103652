//! From a description to a world: everything is checked here, so that nothing can fail later.

use crate::World;
use crate::books::Books;
use crate::check::{BuildError, Checker};
use crate::desc::{BodyDesc, BreakingDesc, Method, MotionDesc, PatternDesc, Resolution, SceneDesc};
use crate::shapes::ShapeLibrary;
use crate::world::{Breaking, Label};
use frangible_dynamics::{Bodies, BodyId, Contactant, Motion, NewBody, PaperSettings, Pose, Velocity};
use frangible_fracture::{Pattern, Radial, ShatterSettings, Voronoi};
use frangible_geometry::{Geometry, RigidTransform, Shape};
use glam::{DQuat, DVec3};
use std::sync::Arc;

impl World {
    /// Checks a scene and builds it.
    ///
    /// # Errors
    /// The first rule that the scene breaks, with the field's path and its value; or what is wrong with a mesh file.
    pub fn build(scene: &SceneDesc) -> Result<Self, BuildError> {
        let checker = Checker::root();
        let gravity = checker.field("gravity").finite_vector(scene.gravity)?;
        let rate = checker.field("frames_per_second").positive(scene.frames_per_second, "1/s")?;
        let Method::Paper = scene.method;
        let mut world = Self {
            bodies: Bodies::default(),
            labels: Vec::new(),
            frame: 0,
            dt: 1.0 / rate,
            gravity,
            settings: PaperSettings::default(),
            books: Books::default(),
        };
        let mut library = ShapeLibrary::default();
        for (index, body) in scene.bodies.iter().enumerate() {
            let at = checker.field(&format!("bodies[{index}]"));
            let (new_body, label) = build_body(body, &at, &mut library)?;
            world.spawn(new_body, label);
        }
        Ok(world)
    }

    /// Adds a body behind all others.
    pub(crate) fn spawn(&mut self, body: NewBody, label: Label) -> BodyId {
        self.labels.push(label);
        self.bodies.spawn(body)
    }

    /// Removes the bodies whose entry in `gone` is true; returns the new dense index of each old one.
    pub(crate) fn remove(&mut self, gone: &[bool]) -> Vec<Option<usize>> {
        let mut dense = 0;
        self.labels.retain(|_| {
            dense += 1;
            !gone[dense - 1]
        });
        self.bodies.remove(gone)
    }
}

fn build_body(
    desc: &BodyDesc,
    at: &Checker,
    library: &mut ShapeLibrary,
) -> Result<(NewBody, Label), BuildError> {
    // Check the plain numbers before any work is done.
    let density = at.field("density").positive(desc.density, "kg/m^3")?;
    let friction = at.field("friction").not_negative(desc.friction)?;
    let restitution = at.field("restitution").within(desc.restitution, 0.0, 1.0)?;
    let position = at.field("position").finite_vector(desc.position)?;
    let rotation = at.field("orientation").rotation(desc.orientation)?;
    let linear = at.field("linear_velocity").finite_vector(desc.linear_velocity)?;
    let angular = at.field("angular_velocity").finite_vector(desc.angular_velocity)?;

    // Shape and breaking: what breaks must be sampled.
    let shape = library.shape(&desc.shape, desc.breaking.is_some(), &at.field("shape"))?;
    if shape.volume == 0.0 && desc.motion != MotionDesc::Static {
        return Err(at
            .field("motion")
            .broken(&format!("{:?}", desc.motion), "static for a half-space, which has no mass"));
    }
    let breaking = match &desc.breaking {
        Some(breaking) => {
            Some(build_breaking(breaking, desc.shape.resolution(), &shape, &at.field("breaking"))?)
        }
        None => None,
    };
    let strength = desc.breaking.as_ref().map_or(f64::INFINITY, |breaking| breaking.strength);

    // The pose of the centre of mass and the principal axes, from that of the shape's own frame.
    let world_from_shape = RigidTransform::new(rotation, position);
    let world_from_body = world_from_shape.after(&shape.body_from_grid.inverse());
    let pose =
        Pose { position: world_from_body.translation, orientation: world_from_body.rotation.normalize() };
    let (motion, velocity) = match desc.motion {
        MotionDesc::Dynamic => {
            (Motion::Dynamic, spinning(linear, angular, density, &shape, pose.orientation))
        }
        MotionDesc::Kinematic => (Motion::Kinematic { linear, angular }, Velocity::default()),
        MotionDesc::Static => (Motion::Static, Velocity::default()),
    };
    let contactant = Contactant { friction, restitution, strength };
    let label = Label { name: desc.name.clone(), parent: None, breaking };
    Ok((NewBody { shape, density, motion, pose, velocity, contactant }, label))
}

/// Linear velocity and angular momentum from linear and angular velocity.
fn spinning(linear: DVec3, angular: DVec3, density: f64, shape: &Shape, orientation: DQuat) -> Velocity {
    let moments = density * shape.unit_moments;
    Velocity { linear, angular_momentum: orientation * (moments * (orientation.conjugate() * angular)) }
}

fn build_breaking(
    desc: &BreakingDesc,
    resolution: &Resolution,
    shape: &Shape,
    at: &Checker,
) -> Result<Breaking, BuildError> {
    at.field("strength").positive(desc.strength, "N s")?;
    at.field("generations").at_least(desc.generations as usize, 1)?;
    let pattern = match desc.pattern {
        PatternDesc::Radial { spokes, rings, jitter, seed } => {
            Pattern::radial(&Radial { spokes, rings, jitter, seed })
        }
        PatternDesc::Voronoi { cells, clustering, seed } => {
            Pattern::voronoi(&Voronoi { cells, clustering, seed, half_extent: DVec3::ONE })
        }
    };
    let pattern = pattern.map_err(|error| at.field("pattern").pattern(&error))?;
    let Geometry::Grid(solid) = &shape.geometry else {
        return Err(at.broken("a closed form", "a body that breaks is sampled on a grid"));
    };
    // Cracks are sampled as densely as the surface was.
    let mut shatter = ShatterSettings::default();
    if let Some(spacing) = resolution.sample_spacing {
        shatter.sample_spacing_voxels = spacing / solid.level_set.grid().spacing;
    }
    Ok(Breaking { pattern: Arc::new(pattern), shatter, generations: desc.generations })
}
