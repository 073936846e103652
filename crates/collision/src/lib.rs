//! Collision detection: broad phase, narrow phase with contact manifolds, the caches of both across
//! frames, times of impact and penetrations. Detection never changes a body's motion.

mod birth_fits;
mod broad_phase;
mod contact_cache;
mod impulse_cache;
mod manifold;
mod narrow_phase;
mod penetration;
mod relative_motion;
mod time_of_impact;

pub use birth_fits::BirthFits;
pub use broad_phase::bounds::{Bounds, Ground};
pub use broad_phase::{Swept, find_pairs, find_swept_pairs};
pub use contact_cache::ContactCache;
pub use impulse_cache::{CachedImpulse, ImpulseCache, ImpulseChunk, PointImpulse};
pub use manifold::list::Manifolds;
pub use manifold::{FeatureId, Manifold, ManifoldPoint};
pub use narrow_phase::convex_shape::needs_one_look;
pub use narrow_phase::finder::{ManifoldFinder, find_manifolds};
pub use narrow_phase::fixed_neighbours::FixedNeighbours;
pub use narrow_phase::pair_motion::PairMotion;
pub use narrow_phase::samples::{
    ContactPoint, NearSamples, Penetration, contact_point, deepest, overlap,
};
pub use penetration::find_penetrations;
pub use relative_motion::{Placed, placed};
pub use time_of_impact::first_contact;

#[cfg(test)]
mod oracle;
