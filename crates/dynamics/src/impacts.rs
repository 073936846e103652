//! Impacts above a body's strength, and chains of impacts within a frame.

pub(crate) mod blows;
pub(crate) mod impact_chain;
pub(crate) mod recent_impacts;
