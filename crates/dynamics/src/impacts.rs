//! Impacts that break bodies, and bodies that move on because they are struck.

pub(crate) mod blows;
pub(crate) mod struck;
