//! Public bug reports of other engines, tried here: each with its source, what was reported there,
//! and the right value. What is not right stands in `docs/limits.md`.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod moving;
mod resting;
mod scenes;
