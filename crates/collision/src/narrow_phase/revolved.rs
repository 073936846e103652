//! Contacts of bodies of revolution with each other, convex polyhedra and half-spaces.

pub(crate) mod areas;
pub(crate) mod closest;
pub(crate) mod contact;
pub(crate) mod features;
pub(crate) mod first_touch;
pub(crate) mod lines;
pub(crate) mod overlap;
pub(crate) mod partner;
pub(crate) mod placed;
pub(crate) mod points;
pub(crate) mod polytope;
pub(crate) mod round_overlap;
pub(crate) mod round_point;
pub(crate) mod search;
pub(crate) mod separation;
pub(crate) mod simplex;
