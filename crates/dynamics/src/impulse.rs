//! The impulse between two bodies that touch at a point: Newton's restitution and Coulomb's friction [GBF03 sec. 5].

use crate::Velocity;
use glam::{DMat3, DVec3};

/// Where Coulomb's sliding impulse per unit of normal impulse changes the normal velocity by less than this fraction of
/// what a frictionless one does, the contact jams: the sliding impulse would be enormous or pull.
const JAM: f64 = 1e-6;

/// Tangential velocity below this fraction of the velocity is round-off and has no direction.
const NO_DIRECTION: f64 = 1e-12;

/// How the velocity of a body's point answers an impulse at that point: `K = 1/m + r*^T I^-1 r*` [1/kg], from the
/// inverse inertia in the world frame [1/(kg m^2)] and the lever r from the centre of mass to the point [m]. A pair's
/// matrix is the sum over its two bodies; an infinite mass adds zero.
pub fn contact_matrix(inverse_mass: f64, inverse_inertia: DMat3, lever: DVec3) -> DMat3 {
    let cross = DMat3::from_cols(
        DVec3::new(0.0, lever.z, -lever.y),
        DVec3::new(-lever.z, 0.0, lever.x),
        DVec3::new(lever.y, -lever.x, 0.0),
    );
    DMat3::from_diagonal(DVec3::splat(inverse_mass)) + cross.transpose() * inverse_inertia * cross
}

/// The impulse [kg m/s] on body a, and its opposite on body b, that turns the approach speed `-v_n` into `restitution`
/// times itself, with friction in Coulomb's cone.
///
/// `contact_matrix` is the pair's K [1/kg], `relative_velocity` that of a's point less b's [m/s], `normal` the unit
/// normal from b to a, `restitution` in [-1, 1] (below 0 only a part of the approach is stopped). Zero if the points
/// separate or no mass is finite. The energy can still rise, by the friction model or in a split state; see
/// [`crate::clamp_impulse`].
pub fn collision_impulse(
    contact_matrix: DMat3,
    relative_velocity: DVec3,
    normal: DVec3,
    restitution: f64,
    friction: f64,
) -> DVec3 {
    // Only an approach is resisted.
    let normal_velocity = normal.dot(relative_velocity);
    let normal_change = -(1.0 + restitution) * normal_velocity;
    let normal_answer = normal.dot(contact_matrix * normal);
    if !(normal_velocity < 0.0 && normal_change > 0.0 && normal_answer > 0.0) {
        return DVec3::ZERO;
    }
    let frictionless = (normal_change / normal_answer) * normal;
    if friction == 0.0 {
        return frictionless;
    }

    // Stick: all of the tangential velocity stops, if the friction that this takes lies in the cone.
    let tangential_velocity = relative_velocity - normal_velocity * normal;
    let Some(sticking) = solve(contact_matrix, normal_change * normal - tangential_velocity) else {
        return frictionless;
    };
    let sticking_normal = normal.dot(sticking);
    let sticking_tangent = sticking - sticking_normal * normal;
    let sticking_friction = sticking_tangent.length();
    if sticking_friction <= friction * sticking_normal {
        return sticking;
    }

    // Slide: friction on the cone, against the tangential velocity.
    if tangential_velocity.length() > NO_DIRECTION * relative_velocity.length() {
        let against = -tangential_velocity.normalize();
        let on_cone = normal + friction * against;
        let sliding_answer = normal.dot(contact_matrix * on_cone);
        if sliding_answer > JAM * normal_answer && against.dot(sticking_tangent) > 0.0 {
            return (normal_change / sliding_answer) * on_cone;
        }
    }

    // Jam or reverse: sliding on cannot be, as that friction would drive the bodies together, or speed the sliding up.
    // Friction takes the side of the cone that the sticking impulse lies beyond, along which the normal velocity always
    // answers: of n.K j = normal_change > 0 for the sticking j, with |j_t| > mu j_n, follows n.K (n + mu j_t/|j_t|) > 0.
    let on_cone = normal + (friction / sticking_friction) * sticking_tangent;
    (normal_change / normal.dot(contact_matrix * on_cone)) * on_cone
}

/// Solves `matrix x = right` for a symmetric positive definite matrix by its L D L^T factors, whose residual stays at
/// rounding where thin bodies make the matrix ill-conditioned. `None` if it is singular to rounding.
fn solve(matrix: DMat3, right: DVec3) -> Option<DVec3> {
    let (m, p, q) = (matrix.x_axis, matrix.y_axis, matrix.z_axis);
    let (l_yx, l_zx) = (m.y / m.x, m.z / m.x);
    let d_y = p.y - l_yx * m.y;
    let zy = p.z - l_zx * m.y;
    let l_zy = zy / d_y;
    let d_z = q.z - l_zx * m.z - l_zy * zy;
    if !(m.x > 0.0 && d_y > 0.0 && d_z > 0.0) {
        return None;
    }
    let y = right.y - l_yx * right.x;
    let z = (right.z - l_zx * right.x - l_zy * y) / d_z;
    let y = y / d_y - l_zy * z;
    Some(DVec3::new(right.x / m.x - l_yx * y - l_zx * z, y, z))
}

/// The velocity after an impulse [kg m/s] at `lever` from the centre of mass [m] and a torque impulse [kg m^2/s]. An
/// infinite mass keeps its own.
pub fn apply_impulse(
    velocity: &Velocity,
    inverse_mass: f64,
    lever: DVec3,
    impulse: DVec3,
    torque_impulse: DVec3,
) -> Velocity {
    if inverse_mass == 0.0 {
        return *velocity;
    }
    Velocity {
        linear: velocity.linear + inverse_mass * impulse,
        angular_momentum: velocity.angular_momentum + lever.cross(impulse) + torque_impulse,
    }
}
