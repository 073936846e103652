//! Mass properties that a body has of its own.

use crate::scene::desc::defaults;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Mass, centre of mass and inertia of a body that is not filled evenly: hollow, loaded, or stood
/// in for by a simple shape. What is left out follows from the shape and the density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassDesc {
    /// Instead of the density's [kg].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// In the shape's frame [m], at most ten times its length outside; of a round shape its
    /// own, the middle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<[f64; 3]>,
    /// Principal moments of inertia about the centre of mass, each > 0 and at most the sum of the
    /// other two [kg m^2]. Without them, those of the shape about that centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moments: Option<[f64; 3]>,
    /// Quaternion x, y, z, w that takes the axes of the moments to the shape's frame; need not be
    /// of unit length. One of a cylinder's, a capsule's and a cone's lies along its y axis.
    #[serde(default = "defaults::orientation")]
    pub axes: [f64; 4],
}
