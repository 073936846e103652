//! Patterns from a few numbers [Su09 sec. 4.3]. The same numbers give the same pattern on every
//! machine.

pub(crate) mod bricks;
pub(crate) mod concrete;
pub(crate) mod natural;
mod nearest_sites;
pub(crate) mod parameters;
pub(crate) mod radial;
pub(crate) mod slices;
pub(crate) mod splinters;
pub(crate) mod voronoi;
