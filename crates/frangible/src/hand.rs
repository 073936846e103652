//! A caller's deeds between frames: bodies are pushed, held, cut and broken. Work and breaks are
//! part of the next frame's report.

pub(crate) mod cut;
pub(crate) mod grip;
pub(crate) mod push;
pub(crate) mod state;
