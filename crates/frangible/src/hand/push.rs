//! Impulses of a caller.

use crate::scene::check::{BuildError, Checker, MOST_SPEED, MOST_SPIN};
use crate::world::World;
use frangible_bodies::{BodyId, Drowsiness, Motion, Velocity};
use glam::DVec3;

impl World {
    /// Gives a dynamic body an impulse [N s] at a point [m], both in the world frame; returns its
    /// work [J], which the next report counts as such.
    ///
    /// # Errors
    /// If the body is gone, not dynamic or waiting, a number is out of range, or the body would
    /// become too fast.
    pub fn apply_impulse(
        &mut self,
        id: BodyId,
        impulse: DVec3,
        point: DVec3,
    ) -> Result<f64, BuildError> {
        let at = Checker::root();
        let impulse = at.field("impulse").bounded(impulse.to_array(), MOST_IMPULSE, "N s")?;
        let point = at.field("point").vector(point.to_array(), "m")?;
        let dense = self.moved_by_hand(id)?;
        let pushed = self.pushed(dense, impulse, point);
        let spin = self.bodies.inertias[dense]
            .angular_velocity(self.bodies.poses[dense].orientation, pushed.angular_momentum);
        if pushed.linear.abs().max_element() > MOST_SPEED || spin.abs().max_element() > MOST_SPIN {
            let rule = format!("one that leaves it below {MOST_SPEED:e} m/s and {MOST_SPIN:e}/s");
            return Err(at.field("impulse").broken(&format!("{:?}", impulse.to_array()), &rule));
        }
        Ok(self.push(dense, impulse, point))
    }

    /// Dense index of a body that a hand can move.
    pub(crate) fn moved_by_hand(&self, id: BodyId) -> Result<usize, BuildError> {
        let dense = self.living(id)?;
        let body = Checker::root().field("body");
        if self.labels[dense].waiting.is_some() {
            return Err(body.broken("waiting", "started before"));
        }
        match self.bodies.motions[dense] {
            Motion::Dynamic => Ok(dense),
            Motion::Static => Err(body.broken("static", "dynamic")),
            Motion::Kinematic { .. } => Err(body.broken("kinematic", "dynamic")),
        }
    }

    /// An impulse at a point, and its work for the next report.
    pub(crate) fn push(&mut self, dense: usize, impulse: DVec3, point: DVec3) -> f64 {
        let inertia = self.bodies.inertias[dense];
        let orientation = self.bodies.poses[dense].orientation;
        let (before, after) = (self.bodies.velocities[dense], self.pushed(dense, impulse, point));
        // With the mean of the velocities before and after: exact, and small for small impulses.
        let turn = after.angular_momentum - before.angular_momentum;
        let spins = before.angular_momentum + after.angular_momentum;
        let work = 0.5 * impulse.dot(before.linear + after.linear)
            + 0.5 * turn.dot(inertia.angular_velocity(orientation, spins));
        self.bodies.velocities[dense] = after;
        self.bodies.activities[dense].drowsiness = Drowsiness::default();
        self.hand.handled.work += work;
        work
    }

    fn pushed(&self, dense: usize, impulse: DVec3, point: DVec3) -> Velocity {
        let (pose, velocity) = (&self.bodies.poses[dense], &self.bodies.velocities[dense]);
        Velocity {
            linear: velocity.linear + self.bodies.inertias[dense].inverse_mass * impulse,
            angular_momentum: velocity.angular_momentum + (point - pose.position).cross(impulse),
        }
    }
}

/// The largest impulse of a call [N s]: its square stays finite in single precision.
const MOST_IMPULSE: f64 = 1e12;
