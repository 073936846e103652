//! Free motion of bodies without contacts.

pub(crate) mod ballistic_path;
pub(crate) mod energy_fix;
pub(crate) mod evolve;
pub(crate) mod exact_rotation;
pub(crate) mod rotation;
