//! Kinematic bodies whose motion the scene gives.

use crate::world::World;
use frangible_bodies::{Drowsiness, Motion};

/// Puts the bodies with paths where these begin the frame, and lets them move to where these end
/// it.
pub(super) fn follow_paths(world: &mut World) {
    let frame = world.frame as f64;
    for (i, label) in world.labels.iter().enumerate() {
        let Some(path) = &label.path else { continue };
        let (linear, angular) = path.velocity(frame, world.dt);
        let motion = Motion::Kinematic { linear, angular };
        world.bodies.poses[i] = path.at(frame);
        if world.bodies.motions[i] != motion {
            world.bodies.motions[i] = motion;
            world.bodies.activities[i].drowsiness = Drowsiness::default();
        }
    }
}
