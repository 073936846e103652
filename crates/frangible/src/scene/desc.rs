//! A scene as plain data: described first, then checked and built by [`crate::World::build`].

pub(crate) mod breaking;
pub(crate) mod defaults;
pub(crate) mod mass_properties;
pub(crate) mod read;
pub(crate) mod shape;
pub(crate) mod starts;
pub(crate) mod strength_points;

use breaking::{BondsDesc, BreakingDesc};
use mass_properties::MassDesc;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shape::ShapeDesc;
use starts::StartsDesc;

/// Initial state of a world. SI units, y up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneDesc {
    /// For reports and files.
    #[serde(default)]
    pub name: String,
    /// Up to 1e4 along each axis [m/s^2].
    #[serde(default = "defaults::gravity")]
    pub gravity: [f64; 3],
    /// One step each; from 1 to 1e5.
    #[serde(default = "defaults::frames_per_second")]
    pub frames_per_second: f64,
    /// Method of the step.
    #[serde(default)]
    pub method: Method,
    /// Let islands sleep in the frame-rate method: bodies at rest for half a second sleep until the
    /// next contact, and need no solving. Off, all bodies are awake in every frame.
    #[serde(default)]
    pub sleep: bool,
    /// Trade-offs between accuracy and time of the frame-rate method.
    #[serde(default)]
    pub solver: SolverDesc,
    /// Default number of frames of `frangible run`; without it, three seconds' worth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub frames: Option<u32>,
    /// In the order in which they enter the world.
    pub bodies: Vec<BodyDesc>,
}

/// Method that advances a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// One detection and several substeps a frame (docs/adr/010).
    #[default]
    FrameRate,
    /// The paper's own [Su09].
    Paper,
    /// The paper's without its energy conservation, which figure 1 compares with [Su09 fig. 1]: it
    /// makes energy.
    PaperUncorrected,
}

impl Method {
    /// True for the paper's method, with and without its energy conservation.
    pub(crate) fn is_papers(self) -> bool {
        matches!(self, Self::Paper | Self::PaperUncorrected)
    }
}

/// Contact solver of the frame-rate method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverDesc {
    /// Minimum number of substeps of bodies in contact.
    #[serde(default)]
    pub quality: Quality,
    /// Maximum number of substeps of an island of bodies, a power of two from the quality's minimum
    /// to 1024. Loads and impacts beyond overlap further.
    #[serde(default = "defaults::most_substeps")]
    pub most_substeps: u32,
    /// Maximum speed of penetration recovery, above 0 [m/s].
    #[serde(default = "defaults::recovery_speed")]
    pub recovery_speed: f64,
}

/// Minimum number of substeps; islands that bear, press or turn more take more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Quality {
    /// 2.
    Draft,
    /// 4.
    Game,
    /// 8.
    #[default]
    Default,
    /// 16.
    Film,
}

impl Quality {
    pub(crate) fn substeps(self) -> u32 {
        match self {
            Self::Draft => 2,
            Self::Game => 4,
            Self::Default => 8,
            Self::Film => 16,
        }
    }
}

impl Default for SolverDesc {
    fn default() -> Self {
        Self {
            quality: Quality::default(),
            most_substeps: defaults::most_substeps(),
            recovery_speed: defaults::recovery_speed(),
        }
    }
}

/// One body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyDesc {
    /// For people; need not be unique.
    #[serde(default)]
    pub name: String,
    /// Shape of the body.
    pub shape: ShapeDesc,
    /// The cause of its motion.
    #[serde(default)]
    pub motion: MotionDesc,
    /// Of the origin of the shape's own frame (a mesh's or points' coordinates, the centre of a
    /// closed form) [m].
    #[serde(default)]
    pub position: [f64; 3],
    /// Quaternion x, y, z, w that takes the shape's frame to the world's; need not be of unit
    /// length.
    #[serde(default = "defaults::orientation")]
    pub orientation: [f64; 4],
    /// Of the centre of mass, up to 1e5 along each axis [m/s].
    #[serde(default)]
    pub linear_velocity: [f64; 3],
    /// Up to 1e4 about each axis [rad/s].
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// Poses of a kinematic body at frames, in ascending order: it is there exactly at the end of
    /// each frame. In between its centre of mass moves straight and it turns evenly; before the
    /// first and after the last it stands still. Instead of `position`, `orientation` and
    /// velocities.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub path: Vec<KeyframeDesc>,
    /// When a dynamic body begins to move; without it, at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub starts: Option<StartsDesc>,
    /// From 1e-6 to 1e9 [kg/m^3].
    #[serde(default = "defaults::density")]
    pub density: f64,
    /// Of a body that is not filled evenly; a dynamic one that neither breaks nor is glued.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_properties: Option<MassDesc>,
    /// Names of the groups that it is in, for `passes_through` of others; its pieces are too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<String>,
    /// Groups whose bodies it does not collide with, nor they with it; its pieces do not either.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passes_through: Vec<String>,
    /// Coulomb's coefficient; a pair has the smaller of its two.
    #[serde(default = "defaults::half")]
    pub friction: f64,
    /// Largest torque against rolling per normal force [m], in the frame-rate method; a pair has
    /// the larger of its two.
    #[serde(default)]
    pub rolling_friction: f64,
    /// Largest torque against spinning about the contact's normal per normal force [m], likewise.
    #[serde(default)]
    pub spinning_friction: f64,
    /// In [0, 1]; a pair has the smaller of its two.
    #[serde(default = "defaults::half")]
    pub restitution: f64,
    /// Fracture of the body, if breakable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub breaking: Option<BreakingDesc>,
    /// Glue between the pieces of a glued body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bonds: Option<BondsDesc>,
    /// Appearance in pictures and files; no effect on physics.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look: Option<LookDesc>,
}

/// Pose of a body at a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyframeDesc {
    /// 0 is the start; may lie between whole frames.
    pub frame: f64,
    /// As that of the body [m].
    pub position: [f64; 3],
    /// As that of the body.
    #[serde(default = "defaults::orientation")]
    pub orientation: [f64; 4],
}

/// The look of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LookDesc {
    /// Clear, green at the edges.
    Glass,
    /// Grey, with gravel inside.
    Concrete,
    /// Fired clay.
    Brick,
    /// Between bricks; pieces of a joint look like it whatever their parent does.
    Mortar,
    /// Bricks with mortar between them: joints, and what cracks lay bare, look like mortar.
    Masonry,
    /// Softwood.
    Wood,
    /// Limestone.
    Stone,
    /// Steel.
    Metal,
}

impl LookDesc {
    /// As it is written in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Glass => "glass",
            Self::Concrete => "concrete",
            Self::Brick => "brick",
            Self::Mortar => "mortar",
            Self::Masonry => "masonry",
            Self::Wood => "wood",
            Self::Stone => "stone",
            Self::Metal => "metal",
        }
    }
}

/// The cause of a body's motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MotionDesc {
    /// Its momentum.
    #[default]
    Dynamic,
    /// Prescribed velocity, independent of contacts.
    Kinematic,
    /// It stays.
    Static,
}

impl MotionDesc {
    /// As it is written in a file.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Dynamic => "dynamic",
            Self::Kinematic => "kinematic",
            Self::Static => "static",
        }
    }
}

impl SceneDesc {
    /// An empty scene with the defaults.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            gravity: defaults::gravity(),
            frames_per_second: defaults::frames_per_second(),
            method: Method::default(),
            sleep: false,
            solver: SolverDesc::default(),
            frames: None,
            bodies: Vec::new(),
        }
    }
}

impl BodyDesc {
    /// A dynamic body at rest in the origin, with the defaults.
    pub fn new(name: &str, shape: ShapeDesc) -> Self {
        Self {
            name: name.into(),
            shape,
            motion: MotionDesc::default(),
            position: [0.0; 3],
            orientation: defaults::orientation(),
            linear_velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            path: Vec::new(),
            starts: None,
            density: defaults::density(),
            mass_properties: None,
            groups: Vec::new(),
            passes_through: Vec::new(),
            friction: defaults::half(),
            rolling_friction: 0.0,
            spinning_friction: 0.0,
            restitution: defaults::half(),
            breaking: None,
            bonds: None,
            look: None,
        }
    }

    /// The ground: everything below y = `height` [m].
    pub fn ground(height: f64) -> Self {
        Self {
            motion: MotionDesc::Static,
            position: [0.0, height, 0.0],
            // The pair's smaller value counts, so the ground leaves restitution to what falls on
            // it.
            restitution: 1.0,
            ..Self::new("ground", ShapeDesc::HalfSpace)
        }
    }
}
