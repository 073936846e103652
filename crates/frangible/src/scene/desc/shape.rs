//! Shapes, as scenes describe them.

use crate::scene::desc::defaults;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
    /// need samples get 64 voxels along their longest side, or three across their thinnest part, if
    /// that is finer and makes no more voxels than a cube has.
    #[serde(default)]
    pub voxels: Option<[usize; 3]>,
    /// Distance between surface samples [m]. Without it, two voxels, or a tenth of the longest side
    /// for shapes without a grid.
    #[serde(default)]
    pub sample_spacing: Option<f64>,
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
