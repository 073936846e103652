//! Points where two hulls meet, and the features that meet there.

use glam::DVec3;

/// What meets at a point of two hulls. The same features have the same name whichever hull's face
/// is the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Feature {
    VertexOfFirst(u32),
    VertexOfSecond(u32),
    /// Of the first and of the second.
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

    /// Its key among the pair's samples; `edges` is the number of the second hull's.
    pub(crate) fn sample(self, edges: usize) -> (bool, u64) {
        const EDGES: u32 = 1 << 31;
        match self {
            Self::VertexOfFirst(vertex) => (true, vertex.into()),
            Self::VertexOfSecond(vertex) => (false, vertex.into()),
            Self::Edges(a, b) => (true, (EDGES | (a * edges as u32 + b)).into()),
        }
    }
}

/// A point on each of two hulls that face each other, in the first one's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HullPoint {
    /// On the first and on the second [m].
    pub(crate) on: [DVec3; 2],
    /// Unit, from the second hull to the first.
    pub(crate) normal: DVec3,
    /// Between them along the normal, negative if they overlap [m].
    pub(crate) gap: f64,
    pub(crate) feature: Feature,
}

/// How two hulls meet, in the first one's frame; their points are in a [`Room`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct HullContact {
    /// Unit, from the second to the first: that of their points. If they are apart, they are by at
    /// least `gap` along it.
    pub(crate) normal: DVec3,
    /// Along the best axis [m]; negative if they overlap.
    pub(crate) gap: f64,
}
