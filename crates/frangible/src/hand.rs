//! What a caller does to bodies between frames: push them, hold them, cut them, break them. Work
//! and breaks are part of the next frame's report.

pub(crate) mod cut;
pub(crate) mod grip;
pub(crate) mod push;
pub(crate) mod state;
