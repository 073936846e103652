//! Contact points of two hulls, and their features.

use crate::manifold::FeatureId;
use glam::DVec3;

/// Features of a contact point. The same features have the same id for either reference hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Feature {
    VertexOfFirst(u32),
    VertexOfSecond(u32),
    /// Edges of the first and of the second hull.
    Edges(u32, u32),
}

impl Feature {
    pub(crate) fn swapped(self) -> Self {
        match self {
            Self::VertexOfFirst(vertex) => Self::VertexOfSecond(vertex),
            Self::VertexOfSecond(vertex) => Self::VertexOfFirst(vertex),
            Self::Edges(a, b) => Self::Edges(b, a),
        }
    }

    /// Feature id; `edges` is the second hull's edge count.
    pub(crate) fn id(self, edges: usize) -> FeatureId {
        const EDGES: u32 = 1 << 31;
        match self {
            Self::VertexOfFirst(vertex) => FeatureId { is_of_first: true, index: vertex.into() },
            Self::VertexOfSecond(vertex) => FeatureId { is_of_first: false, index: vertex.into() },
            Self::Edges(a, b) => {
                // Hulls of more than 46 000 edges may have pairs of the same number.
                let number = a.wrapping_mul(edges as u32).wrapping_add(b);
                FeatureId { is_of_first: true, index: (EDGES | number).into() }
            }
        }
    }
}

/// A point on each of two facing hulls, in the first hull's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HullPoint {
    /// Points on the first and on the second hull [m].
    pub(crate) on: [DVec3; 2],
    /// Unit, from the second hull to the first.
    pub(crate) normal: DVec3,
    /// Separation along the normal, negative for overlap [m].
    pub(crate) gap: f64,
    pub(crate) feature: Feature,
}

/// Contact of two hulls, in the first hull's frame; its points are in a `Scratch`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HullContact {
    /// Unit, from the second hull to the first: the normal of its points. Separated hulls are at
    /// least `gap` apart along it.
    pub(crate) normal: DVec3,
    /// Separation along the best axis [m]; negative for overlap.
    pub(crate) gap: f64,
}
