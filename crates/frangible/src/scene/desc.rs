//! A scene as plain data: described first, then checked and built by [`crate::World::build`].

pub(crate) mod breaking;
pub(crate) mod defaults;
pub(crate) mod mass_properties;
pub(crate) mod read;
pub(crate) mod starts;
pub(crate) mod strength_points;

use breaking::{BondsDesc, BreakingDesc};
use mass_properties::MassDesc;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
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
    /// All within a radius of a segment of the y axis.
    Capsule {
        /// [m]
        radius: f64,
        /// Of the segment, without the round ends [m].
        height: f64,
        /// Needed if it breaks.
        #[serde(default)]
        resolution: Resolution,
    },
    /// Around the y axis, its apex up; its base lies a quarter of its height below its centre of
    /// mass, the origin.
    Cone {
        /// Of the base [m].
        radius: f64,
        /// [m]
        height: f64,
        /// Needed if it breaks.
        #[serde(default)]
        resolution: Resolution,
    },
    /// The convex hull of points.
    Hull {
        /// At least four [m]; points inside the hull of the others have no effect.
        points: Vec<[f64; 3]>,
        /// Needed if it breaks.
        #[serde(default)]
        resolution: Resolution,
    },
    /// A compound of boxes and convex hulls: a convex decomposition. Parts may touch; the mass of
    /// overlaps counts twice.
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
        /// Thickness of plates made from open parts [m]; without it open parts are left out where a
        /// mesh is sampled.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        thickness: Option<f64>,
        /// Solid sides of the triangles of a static or kinematic body.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        sides: Option<SidesDesc>,
        /// A mesh that moves or breaks is always sampled; that of a static or kinematic body is if
        /// this is given.
        #[serde(default)]
        resolution: Resolution,
    },
    /// A mesh that is given here.
    Triangles {
        /// Vertices [m].
        positions: Vec<[f64; 3]>,
        /// Three vertices each, counted from 0, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
        /// Thickness of plates made from open parts [m]; without it open parts are left out where a
        /// mesh is sampled.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        thickness: Option<f64>,
        /// Solid sides of the triangles of a static or kinematic body.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        sides: Option<SidesDesc>,
        /// A mesh that moves or breaks is always sampled; that of a static or kinematic body is if
        /// this is given.
        #[serde(default)]
        resolution: Resolution,
    },
    /// Ground from rows of heights: row k, column i stands at x = i, z = k times the spacing, the
    /// middle of the field above the origin. Static or kinematic only.
    Heightfield {
        /// At least two rows of equal lengths of at least two [m].
        heights: Vec<Vec<f64>>,
        /// Between columns along x and between rows along z [m].
        spacing: [f64; 2],
        /// Solid sides; without it one: solid below.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        sides: Option<SidesDesc>,
    },
}

/// Sides of a mesh's triangles that are solid: a static or kinematic mesh is its triangles, closed
/// or open. Without a choice, "one" for a mesh that encloses a volume and faces outward, else "two".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SidesDesc {
    /// Solid behind the triangles, which run counter-clockwise seen from the front: what gets behind
    /// one comes out again. For solids, and for rooms that face inward.
    One,
    /// A sheet: bodies stay on the side that they are on.
    Two,
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
        /// Quaternion x, y, z, w that takes the part's frame to the compound's; need not be of unit
        /// length.
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
        /// Quaternion x, y, z, w that takes the points' frame to the compound's; need not be of
        /// unit length.
        #[serde(default = "defaults::orientation")]
        orientation: [f64; 4],
    },
}

/// Sampling resolution of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Resolution {
    /// Level-set voxels across the bounding box along x, y, z; voxels are cubes, hence the largest
    /// need decides. Without it, closed forms stay formulas, hulls stay polyhedra, and shapes that
    /// need samples get 64 voxels along their longest side.
    #[serde(default)]
    pub voxels: Option<[usize; 3]>,
    /// Distance between surface samples [m]. Without it, two voxels, or a tenth of the longest side
    /// for shapes without a grid.
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
    /// True for convex kinds of shapes.
    pub(crate) fn is_convex(&self) -> bool {
        match self {
            Self::HalfSpace
            | Self::Sphere { .. }
            | Self::Box { .. }
            | Self::Cylinder { .. }
            | Self::Capsule { .. }
            | Self::Cone { .. }
            | Self::Hull { .. } => true,
            Self::Compound { .. }
            | Self::Mesh { .. }
            | Self::Triangles { .. }
            | Self::Heightfield { .. } => false,
        }
    }

    /// True for kinds of shapes that are triangles.
    pub(crate) fn is_mesh(&self) -> bool {
        matches!(self, Self::Mesh { .. } | Self::Triangles { .. } | Self::Heightfield { .. })
    }

    /// Sampling resolution.
    pub fn resolution(&self) -> &Resolution {
        const NONE: &Resolution = &Resolution { voxels: None, sample_spacing: None };
        match self {
            Self::HalfSpace | Self::Heightfield { .. } => NONE,
            Self::Sphere { resolution, .. }
            | Self::Box { resolution, .. }
            | Self::Cylinder { resolution, .. }
            | Self::Capsule { resolution, .. }
            | Self::Cone { resolution, .. }
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
