//! A scene as plain data: described first, then checked and built by [`crate::World::build`].

pub(crate) mod breaking;
pub(crate) mod defaults;
pub(crate) mod read;

use breaking::{BondsDesc, BreakingDesc};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Everything that a world starts from. SI units, y up.
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
    /// Which step.
    #[serde(default)]
    pub method: Method,
    /// Whether what has stood still for half a second sleeps until something touches it, in the frame-rate method: it takes no solving then. Off, all
    /// bodies are awake in every frame.
    #[serde(default)]
    pub sleep: bool,
    /// What the frame-rate method trades time for.
    #[serde(default)]
    pub solver: SolverDesc,
    /// How many frames `frangible run` takes, unless told otherwise; without it, three seconds' worth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub frames: Option<u32>,
    /// In the order in which they enter the world.
    pub bodies: Vec<BodyDesc>,
}

/// Which step advances a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// One detection and several substeps a frame (docs/adr/010).
    #[default]
    FrameRate,
    /// The paper's own [Su09].
    Paper,
}

/// How the frame-rate method solves contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverDesc {
    /// The least number of substeps of what touches anything.
    #[serde(default)]
    pub quality: Quality,
    /// Most substeps of an island of bodies, a power of two from the quality's least one to 1024: what is loaded or struck
    /// beyond that overlaps more.
    #[serde(default = "defaults::most_substeps")]
    pub most_substeps: u32,
    /// Speed at which overlaps close at most, above 0 [m/s].
    #[serde(default = "defaults::recovery_speed")]
    pub recovery_speed: f64,
}

/// The least number of substeps. Overlaps fall with its square, and time grows with it.
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
    /// What it is made of.
    pub shape: ShapeDesc,
    /// The cause of its motion.
    #[serde(default)]
    pub motion: MotionDesc,
    /// Of the origin of the shape's own frame (a mesh's or points' coordinates, the centre of a closed form) [m].
    #[serde(default)]
    pub position: [f64; 3],
    /// Quaternion x, y, z, w that takes the shape's frame to the world's; need not be of unit length.
    #[serde(default = "defaults::orientation")]
    pub orientation: [f64; 4],
    /// Of the centre of mass, up to 1e5 along each axis [m/s].
    #[serde(default)]
    pub linear_velocity: [f64; 3],
    /// Up to 1e4 about each axis [rad/s].
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// From 1e-6 to 1e9 [kg/m^3].
    #[serde(default = "defaults::density")]
    pub density: f64,
    /// Coulomb's coefficient; a pair has the smaller of its two.
    #[serde(default = "defaults::half")]
    pub friction: f64,
    /// Largest torque against rolling per normal force [m], in the frame-rate method; a pair has the larger of its two.
    #[serde(default)]
    pub rolling_friction: f64,
    /// Largest torque against spinning about the contact's normal per normal force [m], likewise.
    #[serde(default)]
    pub spinning_friction: f64,
    /// In [0, 1]; a pair has the smaller of its two.
    #[serde(default = "defaults::half")]
    pub restitution: f64,
    /// How it breaks, if it can.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub breaking: Option<BreakingDesc>,
    /// The glue between the pieces that it is made of, if it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bonds: Option<BondsDesc>,
    /// What it looks like in pictures and files. Physics does not see it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look: Option<LookDesc>,
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
    /// Its velocity, whatever it meets.
    Kinematic,
    /// It stays.
    Static,
}

/// A shape in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ShapeDesc {
    /// All below the plane y = 0; static only.
    HalfSpace,
    /// A ball.
    Sphere {
        /// [m]
        radius: f64,
        /// Needed if it breaks.
        #[serde(default)]
        resolution: Resolution,
    },
    /// A box.
    Box {
        /// Edge lengths [m].
        size: [f64; 3],
        /// Needed if it breaks.
        #[serde(default)]
        resolution: Resolution,
    },
    /// Around the y axis.
    Cylinder {
        /// [m]
        radius: f64,
        /// [m]
        height: f64,
        /// Needed if it breaks.
        #[serde(default)]
        resolution: Resolution,
    },
    /// The convex hull of points.
    Hull {
        /// At least four [m]; those inside of the hull of the others make no difference.
        points: Vec<[f64; 3]>,
        /// Needed if it breaks.
        #[serde(default)]
        resolution: Resolution,
    },
    /// Boxes and convex hulls that are one body: a convex decomposition. They may touch; where they overlap, their mass counts twice.
    Compound {
        /// At least one.
        parts: Vec<PartDesc>,
        /// Needed if it breaks.
        #[serde(default)]
        resolution: Resolution,
    },
    /// A mesh file: OBJ, PLY, STL or glTF.
    Mesh {
        /// Path.
        path: String,
        /// The file's unit in metres.
        #[serde(default = "defaults::one")]
        scale: f64,
        /// Open parts become plates so thick [m]; without it those that enclose nothing are left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        thickness: Option<f64>,
        /// A mesh is always sampled.
        #[serde(default)]
        resolution: Resolution,
    },
    /// A mesh that is given here.
    Triangles {
        /// Vertices [m].
        positions: Vec<[f64; 3]>,
        /// Three vertices each, counted from 0, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
        /// Open parts become plates so thick [m]; without it those that enclose nothing are left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        thickness: Option<f64>,
        /// A mesh is always sampled.
        #[serde(default)]
        resolution: Resolution,
    },
}

/// A part of a compound, in the compound's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PartDesc {
    /// A box.
    Box {
        /// Edge lengths [m].
        size: [f64; 3],
        /// Of its middle [m].
        #[serde(default)]
        position: [f64; 3],
        /// Quaternion x, y, z, w that takes the part's frame to the compound's; need not be of unit length.
        #[serde(default = "defaults::orientation")]
        orientation: [f64; 4],
    },
    /// The convex hull of points.
    Hull {
        /// At least four [m].
        points: Vec<[f64; 3]>,
        /// Of the points' origin [m].
        #[serde(default)]
        position: [f64; 3],
        /// Quaternion x, y, z, w that takes the points' frame to the compound's; need not be of unit length.
        #[serde(default = "defaults::orientation")]
        orientation: [f64; 4],
    },
}

/// How finely a shape is sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Resolution {
    /// Level-set voxels across the bounding box along x, y, z; they are cubes, so the largest need decides. Without it,
    /// closed forms stay formulas, hulls polyhedra, and what must be sampled has 64 voxels along its longest side.
    #[serde(default)]
    pub voxels: Option<[usize; 3]>,
    /// Distance between surface samples [m]. Without it, two voxels, or a tenth of the longest side of what is not on a grid.
    #[serde(default)]
    pub sample_spacing: Option<f64>,
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

impl ShapeDesc {
    /// Whether it has no dents by its kind.
    pub(crate) fn is_convex(&self) -> bool {
        match self {
            Self::HalfSpace
            | Self::Sphere { .. }
            | Self::Box { .. }
            | Self::Cylinder { .. }
            | Self::Hull { .. } => true,
            Self::Compound { .. } | Self::Mesh { .. } | Self::Triangles { .. } => false,
        }
    }

    /// How finely it is sampled.
    pub fn resolution(&self) -> &Resolution {
        const NONE: &Resolution = &Resolution { voxels: None, sample_spacing: None };
        match self {
            Self::HalfSpace => NONE,
            Self::Sphere { resolution, .. }
            | Self::Box { resolution, .. }
            | Self::Cylinder { resolution, .. }
            | Self::Hull { resolution, .. }
            | Self::Compound { resolution, .. }
            | Self::Mesh { resolution, .. }
            | Self::Triangles { resolution, .. } => resolution,
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
            density: defaults::density(),
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
            // The pair's smaller value counts, so the ground leaves restitution to what falls on it.
            restitution: 1.0,
            ..Self::new("ground", ShapeDesc::HalfSpace)
        }
    }
}
