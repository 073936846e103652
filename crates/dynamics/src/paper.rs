//! The paper's method [Su09], based on [GBF03], stage by stage.

pub(crate) mod collisions;
pub(crate) mod contact;
pub(crate) mod contact_graph;
pub(crate) mod displacements;
pub(crate) mod push_out;
pub(crate) mod shock_propagation;
