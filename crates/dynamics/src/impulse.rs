//! The impulse between two bodies that touch at a point, of the paper's method and of blows.

pub(crate) mod collision_impulse;
pub(crate) mod energy_clamp;
pub(crate) mod pair_impulse;
pub(crate) mod pair_turn;
