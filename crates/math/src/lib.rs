//! Arithmetic that every other crate of the engine stands on: lanes and the instruction sets that
//! they are computed with, vectors and unit quaternions over them, loops over threads that give the
//! same bits on any number of them, rigid transforms, symmetric eigenproblems, Jacobi's elliptic
//! functions and disjoint sets. All `unsafe` of the engine is in `instructions/`.

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
#[cfg(target_arch = "x86_64")]
pub use instructions::x86::{Avx2, Avx512, Sse2};
pub use instructions::{Instructions, LANES, Numbers, Singles};
pub use jacobi_elliptic::{Series, arithmetic_geometric_mean};
pub use lanes::{Blend, Lanes, Lanes3, Mask, Single, Single3, Symmetric, Three};
pub use number::Number;
pub use rigid_transform::RigidTransform;
pub use symmetric_eigen::symmetric_eigen;
pub use vector::{Turn, Vector};
#[cfg(not(target_arch = "x86_64"))]
pub use width::Only;
#[cfg(target_arch = "x86_64")]
pub use width::available;
pub use width::{Width, prefetch};
