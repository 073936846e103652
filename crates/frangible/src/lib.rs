//! **Frangible**: a rigid-body destruction engine that runs at the frame rate and never makes energy.
//!
//! Describe a scene, build a world, step it:
//!
//! ```
//! use frangible::{BodyDesc, SceneDesc, ShapeDesc, World, step};
//!
//! let mut scene = SceneDesc::new("drop");
//! scene.bodies.push(BodyDesc::ground(0.0));
//! let mut ball = BodyDesc::new("ball", ShapeDesc::Sphere { radius: 0.5, resolution: Default::default() });
//! ball.position = [0.0, 2.0, 0.0];
//! scene.bodies.push(ball);
//!
//! let mut world = World::build(&scene)?;
//! for _ in 0..30 {
//!     let report = step(&mut world);
//!     println!("{:.2} s: {:.1} J", report.time, report.energy.total);
//! }
//! # Ok::<(), frangible::BuildError>(())
//! ```

mod fingerprint;
mod hand;
mod report;
mod scene;
mod snapshot;
mod step;
mod world;

pub use frangible_bodies as bodies;
pub use frangible_bodies::BodyId;
pub use frangible_collision as collision;
pub use frangible_dynamics as dynamics;
pub use frangible_fracture as fracture;
pub use frangible_geometry as geometry;
pub use frangible_math as math;
pub use frangible_math::cancel::Cancel;
pub use report::at_rest::{PieceContact, RestPose};
pub use report::{
    Causes, Energy, Fracture, Imbalance, Impulses, Momentum, Quarantined, StepReport,
    id_from_number, id_number,
};
pub use scene::check::{BuildError, nearest};
pub use scene::desc::breaking::{
    AnchorDesc, BondsDesc, BreakingDesc, MaterialDesc, MaterialName, PatternDesc, PatternFile,
    StrengthDesc,
};
pub use scene::desc::mass_properties::MassDesc;
pub use scene::desc::read::{no_json, read, schema};
pub use scene::desc::shape::{PartDesc, Resolution, ShapeDesc, SidesDesc};
pub use scene::desc::starts::{StartsDesc, StartsWhen};
pub use scene::desc::strength_points::StrengthPointDesc;
pub use scene::desc::{
    BodyDesc, KeyframeDesc, LookDesc, Method, MotionDesc, Quality, SceneDesc, SolverDesc,
};
pub use scene::fineness::{Fineness, Found};
pub use scene::pattern_choice::PatternChoice;
pub use scene::strength::Strength;
pub use scene::voxel_count::default_voxels;
pub use snapshot::SnapshotError;
pub use step::bonds::state::Bonds;
pub use step::step;
pub use step::waiting::state::{Starts, Waiting};
pub use world::{Breaking, Label, World};

/// The README's Rust is compiled and run with the doc tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
