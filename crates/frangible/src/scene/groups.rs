//! Checks of the groups that bodies are in, and of those that they pass through.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::{BodyDesc, SceneDesc};
use std::collections::BTreeSet;

/// Groups that bodies of a scene are in.
pub(super) fn groups_of(scene: &SceneDesc) -> BTreeSet<&str> {
    scene.bodies.iter().flat_map(|body| &body.groups).map(String::as_str).collect()
}

/// Checks the groups that a body names: a group that no body is in is a misspelling.
pub(super) fn check_groups(
    body: &BodyDesc,
    at: &Checker,
    has_bodies: impl Fn(&str) -> bool,
) -> Result<(), BuildError> {
    let broken = |field: &str, index: usize, name: &str, rule: &str| {
        at.field(&format!("{field}[{index}]")).broken(&format!("{name:?}"), rule)
    };
    for (index, name) in body.groups.iter().enumerate() {
        if name.is_empty() {
            return Err(broken("groups", index, name, "a name of at least one letter"));
        }
    }
    for (index, name) in body.passes_through.iter().enumerate() {
        if !has_bodies(name) && !body.groups.contains(name) {
            return Err(broken("passes_through", index, name, "a group that a body is in"));
        }
    }
    Ok(())
}
