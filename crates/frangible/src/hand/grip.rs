//! A hand that holds a point of a body: a damped spring of bounded force to where it points.

use crate::hand::state::Grip;
use crate::scene::check::{BuildError, Checker};
use crate::world::World;
use frangible_bodies::BodyId;
use glam::{DMat3, DVec3};

/// Time in which the distance to the hand falls to a third [s]: a piece that is drawn aside by a
/// metre is within two centimetres of the hand after a quarter of a second, as fast as eyes follow; at
/// a third of it, one frame of 1/30 s closes four fifths of the way.
const FOLLOWS_IN: f64 = 0.06;

impl World {
    /// Holds a dynamic body by a point of its own frame, and pulls that to a `target` in the world
    /// frame [m] with at most so much force [N], frame after frame, its weight included. The work
    /// is that of the reports. Holding a body again moves the hand. A body that breaks slips out.
    ///
    /// # Errors
    /// If the body is gone, not dynamic or waiting, or a number is out of range.
    pub fn hold(
        &mut self,
        id: BodyId,
        point_body: DVec3,
        target: DVec3,
        most_force: f64,
    ) -> Result<(), BuildError> {
        let at = Checker::root();
        let grip = Grip {
            body: id,
            point_body: at.field("point").vector(point_body.to_array(), "m")?,
            target: at.field("target").vector(target.to_array(), "m")?,
            most_force: at.field("force").positive(most_force, "N")?,
        };
        self.moved_by_hand(id)?;
        let grips = &mut self.hand.grips;
        match grips.iter_mut().find(|grip| grip.body == id) {
            Some(held) => *held = grip,
            None => grips.push(grip),
        }
        Ok(())
    }

    /// Lets go of a body; false if it is not held.
    pub fn let_go(&mut self, id: BodyId) -> bool {
        let count = self.hand.grips.len();
        self.hand.grips.retain(|grip| grip.body != id);
        self.hand.grips.len() < count
    }
}

/// Pulls what is held, for a frame.
pub(crate) fn pull_held(world: &mut World) {
    // A broken body is held no more.
    let mut grips = std::mem::take(&mut world.hand.grips);
    grips.retain(|grip| world.moved_by_hand(grip.body).is_ok());
    for grip in &grips {
        let Some(dense) = world.bodies.index_of(grip.body) else { continue };
        let (point, impulse) = pull(world, dense, grip);
        world.push(dense, impulse, point);
    }
    world.hand.grips = grips;
}

/// The held point, and the impulse that lets it move a part of the way to the target in the frame,
/// gravity included.
fn pull(world: &World, dense: usize, grip: &Grip) -> (DVec3, DVec3) {
    let (pose, velocity) = (&world.bodies.poses[dense], &world.bodies.velocities[dense]);
    let inertia = &world.bodies.inertias[dense];
    let arm = pose.orientation * grip.point_body;
    let point = pose.position + arm;
    let share = 1.0 - libm::exp(-world.dt / FOLLOWS_IN);
    let wanted = (grip.target - point) * (share / world.dt);
    let spin = inertia.angular_velocity(pose.orientation, velocity.angular_momentum);
    // On the average over the frame.
    let given = velocity.linear + spin.cross(arm) + 0.5 * world.dt * world.gravity;

    // By how much an impulse changes the velocity of the point.
    let across = DMat3::from_cols(arm.cross(DVec3::X), arm.cross(DVec3::Y), arm.cross(DVec3::Z));
    let yields = DMat3::from_diagonal(DVec3::splat(inertia.inverse_mass))
        + across.transpose() * inertia.inverse_tensor(pose.orientation) * across;
    let impulse = yields.inverse() * (wanted - given);
    (point, impulse.clamp_length_max(grip.most_force * world.dt))
}
