//! Given motion of kinematic bodies, from pose to pose.

use frangible_bodies::Pose;
use frangible_math::check::{Check, Checked, require};
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Poses of a body at frames.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BodyPath {
    /// Frames in ascending order, at least one.
    pub(crate) keys: Vec<(f64, Pose)>,
}

impl Check for BodyPath {
    fn check(&self) -> Checked {
        let is_frame = |&(frame, _): &(f64, Pose)| (0.0..=f64::from(u32::MAX)).contains(&frame);
        let in_order = self.keys.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let are_frames = !self.keys.is_empty() && self.keys.iter().all(is_frame);
        require(are_frames && in_order, "poses at ascending frames")?;
        self.keys.iter().try_for_each(|(_, pose)| pose.check())
    }
}

impl BodyPath {
    /// Pose at a frame; before the first and after the last key that of the key.
    pub(crate) fn at(&self, frame: f64) -> Pose {
        let next = self.keys.partition_point(|(key, _)| *key <= frame);
        let ends = [next.saturating_sub(1), next.min(self.keys.len() - 1)];
        let [(before, from), (after, to)] = ends.map(|key| self.keys[key]);
        if before >= after {
            return from;
        }
        let part = ((frame - before) / (after - before)).clamp(0.0, 1.0);
        Pose {
            position: from.position.lerp(to.position, part),
            orientation: from.orientation.slerp(to.orientation, part),
        }
    }

    /// Velocity of the centre of mass [m/s] and spin [rad/s] that lead from a frame to the next.
    pub(crate) fn velocity(&self, frame: f64, dt: f64) -> (DVec3, DVec3) {
        let [from, to] = [self.at(frame), self.at(frame + 1.0)];
        let turn = to.orientation * from.orientation.inverse();
        // The shorter of both ways around.
        let turn = if turn.w < 0.0 { -turn } else { turn };
        ((to.position - from.position) / dt, DQuat::to_scaled_axis(turn) / dt)
    }
}
