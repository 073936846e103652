//! From a description to a world: everything is checked here, so that nothing can fail later.

use crate::hand::state::Hand;
use crate::report::books::Books;
use crate::scene::bonds::build_bonds;
use crate::scene::breaking::{
    build_breaking, check_breaking, fit_to_shape, make_to_break, shape_until_broken,
};
use crate::scene::check::{BuildError, Checker, MOST_SPEED, MOST_SPIN};
use crate::scene::desc::breaking::BondsDesc;
use crate::scene::desc::shape::{Resolution, ShapeDesc};
use crate::scene::desc::{BodyDesc, Method, MotionDesc, SceneDesc, SolverDesc};
use crate::scene::groups::{check_groups, groups_of};
use crate::scene::own_mass::with_own_mass;
use crate::scene::patterns::build_pattern;
use crate::scene::shapes::{Make, ShapeLibrary};
use crate::scene::starts::build_waiting;
use crate::step::body_path::BodyPath;
use crate::step::bonds::state::Bonds;
use crate::step::quarantine::is_representable;
use crate::world::{Breaking, Label, World};
use frangible_bodies::{
    Bodies, BodyId, CollisionClass, Inertia, Motion, NewBody, Pose, Rotation, StepSettings,
    SurfaceProperties, Velocity,
};
use frangible_collision::{BirthFits, ContactCache, ImpulseCache};
use frangible_dynamics::{Ledger, RecentImpacts};
use frangible_geometry::Shape;
use frangible_math::RigidTransform;
use glam::DVec3;
use std::sync::Arc;

impl World {
    /// Checks a scene and builds it.
    ///
    /// # Errors
    /// The first rule that the scene breaks, with the field's path and its value; or what
    /// is wrong with a mesh file.
    pub fn build(scene: &SceneDesc) -> Result<Self, BuildError> {
        let checker = Checker::root();
        let gravity = checker.field("gravity").bounded(scene.gravity, MOST_GRAVITY, "m/s^2")?;
        let rate = checker.field("frames_per_second").within(scene.frames_per_second, 1.0, 1e5)?;
        if let Some(frames) = scene.frames {
            checker.field("frames").count(frames as usize, 1, u32::MAX as usize)?;
        }
        if scene.sleep && scene.method.is_papers() {
            return Err(checker.field("sleep").broken("true", "false, with the paper's method"));
        }
        if scene.solver != SolverDesc::default() && scene.method.is_papers() {
            return Err(checker.field("solver").broken("set", "left out, with the paper's method"));
        }
        let mut world = Self {
            bodies: Bodies::default(),
            labels: Vec::new(),
            frame: 0,
            dt: 1.0 / rate,
            gravity,
            settings: settings_of(scene, &checker)?,
            books: Books::default(),
            ledger: Ledger::default(),
            method: scene.method,
            warm: ImpulseCache::default(),
            recent_impacts: RecentImpacts::default(),
            contact_cache: ContactCache::default(),
            fits: BirthFits::default(),
            spared: Vec::new(),
            born_of_pieces: 0,
            note: String::new(),
            hand: Hand::default(),
            clock: None,
        };
        let mut library = ShapeLibrary::default();
        let names: Vec<_> = scene.bodies.iter().map(|body| Some(body.name.clone())).collect();
        let groups = groups_of(scene);
        for (index, body) in scene.bodies.iter().enumerate() {
            let at = checker.field(&format!("bodies[{index}]"));
            let (new_body, label) = check_groups(body, &at, |name| groups.contains(name))
                .and_then(|()| build_body(body, (scene.method, rate), &at, &mut library))
                .map_err(|error| error.in_body(&names))?;
            world.spawn_described(body, new_body, label);
        }
        Ok(world)
    }

    /// Adds a body as a scene would hold it, behind all others. What it brings of energy and
    /// momentum belongs to no step and no report; the frames of a path are the world's.
    ///
    /// # Errors
    /// As [`World::build`].
    pub fn add_body(&mut self, body: &BodyDesc) -> Result<BodyId, BuildError> {
        let at = Checker::root().field("body");
        let method = (self.method, 1.0 / self.dt);
        check_groups(body, &at, |name| self.bodies.classes.knows(name))?;
        let (new_body, label) = build_body(body, method, &at, &mut ShapeLibrary::default())?;
        Ok(self.spawn_described(body, new_body, label))
    }

    /// Adds a built body with the groups of its description.
    fn spawn_described(&mut self, desc: &BodyDesc, mut body: NewBody, label: Label) -> BodyId {
        let classes = &mut self.bodies.classes;
        body.surface.class = classes.class_of(&desc.groups, &desc.passes_through);
        self.spawn(body, label)
    }
}

/// The substeps rely on the right phase of rotation; the paper's method has its own.
fn settings_of(scene: &SceneDesc, checker: &Checker) -> Result<StepSettings, BuildError> {
    let paper = StepSettings::default();
    match scene.method {
        Method::Paper => return Ok(paper),
        Method::PaperUncorrected => {
            let rotation = Rotation::SecondOrder { energy_fix: false };
            return Ok(StepSettings { ledger: false, impulse_clamp: false, rotation, ..paper });
        }
        Method::FrameRate => {}
    }
    let SolverDesc { quality, most_substeps, recovery_speed } = scene.solver;
    let at = checker.field("solver");
    let (least, most) = (quality.substeps(), most_substeps);
    if !most.is_power_of_two() || !(least..=1024).contains(&most) {
        let rule =
            format!("a power of two from {least}, the least number of this quality, to 1024");
        return Err(at.field("most_substeps").broken(&most.to_string(), &rule));
    }
    Ok(StepSettings {
        rotation: Rotation::Exact,
        substeps: least,
        most_substeps: most,
        recovery_speed: at.field("recovery_speed").positive(recovery_speed, "m/s")?,
        sleep: scene.sleep,
        ..paper
    })
}

/// Longest sides that a body may have [m].
const LEAST_SIZE: f64 = 1e-6;
const MOST_SIZE: f64 = 1e6;

/// Maximum gravity of a scene [m/s^2]: above it, single-precision rounding loses contacts, and
/// bodies with them.
pub(crate) const MOST_GRAVITY: f64 = 1e4;
/// Densities that a body may have [kg/m^3]: far below any gas, far above any metal.
const LEAST_DENSITY: f64 = 1e-6;
const MOST_DENSITY: f64 = 1e9;

fn check_density(density: f64, at: &Checker) -> Result<f64, BuildError> {
    if (LEAST_DENSITY..=MOST_DENSITY).contains(&density) {
        return Ok(density);
    }
    let rule = format!("between {LEAST_DENSITY:e} and {MOST_DENSITY:e} kg/m^3");
    Err(at.field("density").broken(&format!("{density:?}"), &rule))
}

/// A body must be of a size at which lengths can be reckoned with in single precision.
fn check_size(shape: &Shape, at: &Checker) -> Result<(), BuildError> {
    let (low, high) = shape.bounds;
    let longest = (high - low).max_element();
    if !(LEAST_SIZE..=MOST_SIZE).contains(&longest) {
        let rule = format!("between {LEAST_SIZE:e} and {MOST_SIZE:e} m along its longest side");
        return Err(at.field("shape").broken(&format!("{longest:e} m"), &rule));
    }
    Ok(())
}

/// A body must be of a mass and moments at which impulses can be reckoned with in single precision.
fn check_inertia(shape: &Shape, density: f64, at: &Checker) -> Result<(), BuildError> {
    let (mass, moments) = (density * shape.volume, density * shape.unit_moments);
    if !is_representable(&Inertia::new(mass, moments)) {
        let least = moments.min_element();
        let what = format!(
            "{density:?} kg/m^3, which gives {mass:.3e} kg and a moment of inertia of {least:.3e} kg m^2"
        );
        return Err(at.field("density").broken(&what, "such that both lie between 1e-30 and 1e30"));
    }
    Ok(())
}

/// Checks a description and builds its body: plain numbers, breaking and shape, pose, bonds, motion.
fn build_body(
    desc: &BodyDesc,
    (method, rate): (Method, f64),
    at: &Checker,
    library: &mut ShapeLibrary,
) -> Result<(NewBody, Label), BuildError> {
    // Check the plain numbers before any work is done.
    let density = check_density(desc.density, at)?;
    let surface = build_surface(desc, at)?;
    let position = at.field("position").vector(desc.position, "m")?;
    let rotation = at.field("orientation").rotation(desc.orientation)?;
    let world_from_shape = RigidTransform::new(rotation, position);
    let given = build_velocities(desc, at)?;

    // Breaking, and the shape that it asks for.
    let of_breaking = |breaking| build_breaking(breaking, &at.field("breaking"));
    let breaking = desc.breaking.as_ref().map(of_breaking).transpose()?;
    let make = choose_make(desc, breaking.as_ref(), method, at)?;
    let (shape, density) = build_solid(desc, make, density, at, library)?;
    check_breaking(desc, breaking.as_ref(), method, at)?;
    let mut breaking = breaking.map(|breaking| fit_to_shape(breaking, &desc.shape, &shape));
    let mut shape = shape;
    if let Some(breaking) = &mut breaking
        && let Some(whole) = shape_until_broken(desc, &shape, (at, library))?
    {
        breaking.solid = Some(std::mem::replace(&mut shape, Arc::new(whole)));
    }
    let strength =
        breaking.as_ref().map_or(f64::INFINITY, |breaking| breaking.bears(&shape, density));

    // The pose of the centre of mass and the principal axes, from that of the shape's own frame.
    let pose_of = |world_from_shape: RigidTransform| {
        let world_from_body = world_from_shape.after(&shape.body_from_grid.inverse());
        Pose {
            position: world_from_body.translation,
            orientation: world_from_body.rotation.normalize(),
        }
    };
    let path = build_path(desc, rate, at, pose_of)?;
    let pose = path.as_ref().map_or(pose_of(world_from_shape), |path| path.at(0.0));

    // Bonds, and how the body moves: anchored and waiting ones are static until something frees
    // them.
    let of_bonds = |bonds| build_bonds(bonds, desc, &shape, &world_from_shape, &at.field("bonds"));
    let bonds = desc.bonds.as_ref().map(of_bonds).transpose()?;
    let is_anchored = bonds.as_ref().is_some_and(Bonds::is_anchored);
    let [linear, angular] = given;
    let (motion, velocity) = match desc.motion {
        _ if is_anchored => (Motion::Static, Velocity::default()),
        MotionDesc::Dynamic => (
            Motion::Dynamic,
            Velocity::spinning(linear, angular, pose.orientation, &shape, density),
        ),
        MotionDesc::Kinematic => (Motion::Kinematic { linear, angular }, Velocity::default()),
        MotionDesc::Static => (Motion::Static, Velocity::default()),
    };
    let waiting = build_waiting(desc, velocity, is_anchored, method, &at.field("starts"))?;
    let motion = if waiting.is_some() { Motion::Static } else { motion };

    let surface = SurfaceProperties { strength, ..surface };
    let label = Label {
        name: desc.name.clone(),
        parent: None,
        whole: None,
        look: desc.look,
        breaking: breaking.map(Box::new),
        bonds: bonds.map(Box::new),
        path,
        waiting,
    };
    Ok((NewBody { shape, density, motion, pose, velocity, surface }, label))
}

/// Linear [m/s] and angular velocity [rad/s] of a description.
fn build_velocities(desc: &BodyDesc, at: &Checker) -> Result<[DVec3; 2], BuildError> {
    let linear = at.field("linear_velocity").bounded(desc.linear_velocity, MOST_SPEED, "m/s")?;
    let angular =
        at.field("angular_velocity").bounded(desc.angular_velocity, MOST_SPIN, "rad/s")?;
    Ok([linear, angular])
}

/// How a body's shape is made: as its breaking or its bonds need it.
fn choose_make(
    desc: &BodyDesc,
    breaking: Option<&Breaking>,
    method: Method,
    at: &Checker,
) -> Result<Make, BuildError> {
    match (breaking, &desc.bonds) {
        (Some(breaking), _) => Ok(make_to_break(desc, breaking, method)),
        (None, Some(bonds)) => make_to_glue(bonds, desc, &at.field("bonds.pattern")),
        (None, None) if is_environment(desc, method) => Ok(Make::Triangles),
        (None, None) => Ok(Make::Whole),
    }
}

/// Shape and density of a body, of a size, mass and inertia that impulses can be computed with.
fn build_solid(
    desc: &BodyDesc,
    make: Make,
    density: f64,
    at: &Checker,
    library: &mut ShapeLibrary,
) -> Result<(Arc<Shape>, f64), BuildError> {
    let shape = library.shape(&desc.shape, make, &at.field("shape"))?;
    let has_no_mass = shape.volume == 0.0 && make != Make::Triangles;
    if has_no_mass && desc.motion != MotionDesc::Static {
        return Err(at
            .field("motion")
            .broken(desc.motion.name(), "static for a half-space, which has no mass"));
    }
    if !has_no_mass {
        check_size(&shape, at)?;
    }
    let (shape, density) = with_own_mass(desc, shape, density, at)?;
    if desc.motion == MotionDesc::Dynamic {
        check_inertia(&shape, density, at)?;
    }
    Ok((shape, density))
}

/// Surface of a body that does not break.
fn build_surface(desc: &BodyDesc, at: &Checker) -> Result<SurfaceProperties, BuildError> {
    Ok(SurfaceProperties {
        friction: at.field("friction").not_negative(desc.friction)?,
        rolling_friction: at.field("rolling_friction").not_negative(desc.rolling_friction)?,
        spinning_friction: at.field("spinning_friction").not_negative(desc.spinning_friction)?,
        restitution: at.field("restitution").within(desc.restitution, 0.0, 1.0)?,
        strength: f64::INFINITY,
        glued: false,
        class: CollisionClass::default(),
    })
}

/// Path of a body, from poses of its shape's own frame.
fn build_path(
    desc: &BodyDesc,
    rate: f64,
    at: &Checker,
    pose_of: impl Fn(RigidTransform) -> Pose,
) -> Result<Option<Box<BodyPath>>, BuildError> {
    let path = at.field("path");
    if desc.path.is_empty() {
        return Ok(None);
    }
    if desc.motion != MotionDesc::Kinematic {
        return Err(path.broken("on a body that is not kinematic", "left out"));
    }
    if desc.linear_velocity != [0.0; 3] || desc.angular_velocity != [0.0; 3] {
        return Err(path.broken("beside a velocity", "without one: the path gives it"));
    }
    let mut keys: Vec<(f64, Pose)> = Vec::new();
    for (number, key) in desc.path.iter().enumerate() {
        let at = at.field(&format!("path[{number}]"));
        let frame = at.field("frame").within(key.frame, 0.0, f64::from(u32::MAX))?;
        if keys.last().is_some_and(|(last, _)| *last >= frame) {
            return Err(at.field("frame").broken(&format!("{frame}"), "after the one before"));
        }
        let position = at.field("position").vector(key.position, "m")?;
        let rotation = at.field("orientation").rotation(key.orientation)?;
        let pose = pose_of(RigidTransform::new(rotation, position));
        if let Some((last, from)) = keys.last() {
            let way = (pose.position - from.position).abs().max_element();
            at.field("position")
                .within(way * rate / (frame - last), 0.0, MOST_SPEED)
                .map_err(|_| at.broken("too far from the one before", "within 1e5 m/s of it"))?;
        }
        keys.push((frame, pose));
    }
    Ok(Some(Box::new(BodyPath { keys })))
}

/// True for a mesh that does not move by itself and is not to be sampled.
fn is_environment(desc: &BodyDesc, method: Method) -> bool {
    desc.shape.is_mesh()
        && desc.motion != MotionDesc::Dynamic
        && desc.bonds.is_none()
        && *desc.shape.resolution() == Resolution::default()
        && method == Method::FrameRate
}

/// Planar cells cut convex parts exactly; other bodies and other cells need a grid.
fn make_to_glue(
    bonds: &BondsDesc,
    desc: &BodyDesc,
    at_pattern: &Checker,
) -> Result<Make, BuildError> {
    let is_flat = match &bonds.pattern {
        Some(pattern) => build_pattern(pattern, at_pattern)?.planar().is_some(),
        None => true,
    };
    Ok(match &desc.shape {
        _ if !is_flat => Make::Voxels,
        ShapeDesc::Compound { .. } => Make::Whole,
        shape if shape.is_convex() => Make::Polyhedron,
        _ => Make::Whole,
    })
}
