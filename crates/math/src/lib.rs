//! Arithmetic that every other crate of the engine stands on: lanes and the instruction sets that
//! they are computed with, vectors and unit quaternions over them, loops over threads that give the
//! same bits on any number of them, rigid transforms, symmetric eigenproblems, Jacobi's elliptic
//! functions and disjoint sets. All `unsafe` of the engine is in `instructions/`.

pub mod cancel;
pub mod check;
mod disjoint_sets;
mod instructions;
mod jacobi_elliptic;
mod lanes;
mod number;
mod rigid_transform;
pub mod shared;
mod symmetric_eigen;
pub mod threads;
mod vector;
mod width;

pub use disjoint_sets::DisjointSets;
#[cfg(target_arch = "x86_64")]
pub use instructions::scalar::Scalar;
pub use instructions::{Instructions, LANES, Numbers, Singles};
pub use jacobi_elliptic::{Series, arithmetic_geometric_mean};
pub use lanes::{Blend, Lanes, Lanes3, Mask, Single, Single3, Symmetric, Three};
pub use number::Number;
pub use rigid_transform::RigidTransform;
pub use symmetric_eigen::symmetric_eigen;
pub use vector::{Turn, Vector};
pub use width::{Kernel, Width, prefetch, with_widest};
