//! A part of a broken body.

use frangible_geometry::Shape;
use frangible_math::RigidTransform;

/// A part of a broken body.
#[derive(Clone, Debug)]
pub struct Fragment {
    /// On its part of the parent's lattice, in the parent's grid frame.
    pub shape: Shape,
    /// The fragment's body frame in the parent's.
    pub parent_from_fragment: RigidTransform,
    /// Cell of the pattern for this fragment, or for its heaviest part.
    pub cell: u32,
}

impl Fragment {
    /// Cell of what a break with a reach leaves whole.
    pub const REST: u32 = u32::MAX;

    /// True for what a break with a reach leaves whole.
    pub fn is_rest(&self) -> bool {
        self.cell == Self::REST
    }

    /// Where it was in its parent, whose grid frame is the shape's.
    pub fn new(parent: &Shape, shape: Shape, cell: u32) -> Self {
        let parent_from_fragment = parent.body_from_grid.after(&shape.body_from_grid.inverse());
        Self { shape, parent_from_fragment, cell }
    }
}
