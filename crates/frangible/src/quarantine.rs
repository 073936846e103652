//! One bad body must not cost the user the world.

use crate::World;
use crate::report::id_number;

/// Takes out every body whose pose or velocity is not finite, and returns their ids.
pub(crate) fn quarantine_non_finite(world: &mut World) -> Vec<u64> {
    let bodies = &world.bodies;
    let bad: Vec<bool> = (0..bodies.len())
        .map(|i| {
            let (pose, velocity) = (&bodies.poses[i], &bodies.velocities[i]);
            let finite = pose.position.is_finite()
                && pose.orientation.is_finite()
                && velocity.linear.is_finite()
                && velocity.angular_momentum.is_finite();
            !finite
        })
        .collect();
    let ids = (0..bad.len()).filter(|&i| bad[i]).map(|i| id_number(bodies.ids[i])).collect();
    world.remove(&bad);
    ids
}
