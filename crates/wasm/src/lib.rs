//! The WebAssembly door: one world, built from a shot. JavaScript writes the shot's name to
//! [`name_room`], calls [`build`], then [`step`] for each frame, and reads [`state_hash`].

#![allow(unsafe_code, reason = "a module's exports have names of their own")]

use frangible::World;
use frangible_shots::{Shot, ShotOptions};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// State of the module between calls.
static STATE: Mutex<State> = Mutex::new(State { name: Vec::new(), world: None });

struct State {
    /// Of the shot, in UTF-8.
    name: Vec<u8>,
    world: Option<World>,
}

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where the next shot's name goes, of so many bytes.
#[unsafe(no_mangle)]
pub extern "C" fn name_room(bytes: usize) -> *mut u8 {
    let name = &mut state().name;
    name.clear();
    name.resize(bytes, 0);
    name.as_mut_ptr()
}

/// Builds the named shot. False, and no world, if no shot has this name or it needs files.
#[unsafe(no_mangle)]
pub extern "C" fn build() -> bool {
    let mut state = state();
    state.world = world(&state.name);
    state.world.is_some()
}

fn world(name: &[u8]) -> Option<World> {
    let shot = Shot::find(std::str::from_utf8(name).ok()?).ok()?;
    World::build(&shot.scene(&ShotOptions::default()).ok()?).ok()
}

/// Advances the world by one frame, if there is one.
#[unsafe(no_mangle)]
pub extern "C" fn step() {
    if let Some(world) = &mut state().world {
        frangible::step(world);
    }
}

/// Of ids, poses and velocities, as [`World::state_hash`] gives it; 0 without a world.
#[unsafe(no_mangle)]
pub extern "C" fn state_hash() -> u64 {
    state().world.as_ref().map_or(0, World::state_hash)
}
