//! Velocities of fragments.

use glam::DVec3;

/// Velocity of a fragment's centre of mass [m/s]; its angular velocity is the parent's. The
/// fragments move as the parent would have moved on, so that momentum, angular momentum and kinetic
/// energy are kept [Su09 sec. 4.2] [MMDJ01].
///
/// All in the world frame: the parent's velocity [m/s] and angular velocity [rad/s], and the two
/// centres of mass [m].
pub fn fragment_velocity(
    parent_velocity: DVec3,
    angular_velocity: DVec3,
    parent_center: DVec3,
    fragment_center: DVec3,
) -> DVec3 {
    parent_velocity + angular_velocity.cross(fragment_center - parent_center)
}
