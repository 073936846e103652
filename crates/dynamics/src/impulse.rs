//! Impulse between two touching bodies, for the paper's method and for blows.

pub(crate) mod collision_impulse;
pub(crate) mod energy_clamp;
pub(crate) mod pair_impulse;
pub(crate) mod pair_turn;
