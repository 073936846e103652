//! Impulse between two touching bodies: Newton's restitution and Coulomb's friction [GBF03 sec. 5].

use frangible_bodies::{PairSurface, Velocity};
use glam::{DMat3, DVec3};

/// Jam threshold: if a sliding impulse per unit of normal impulse changes the normal velocity by
/// less than this fraction of a frictionless impulse, the contact jams, as the sliding impulse
/// would be enormous or pull.
const JAM: f64 = 1e-6;

/// Tangential velocity below this fraction of the velocity is round-off and has no direction.
const NO_DIRECTION: f64 = 1e-12;

/// Contact matrix of a body's point, `K = 1/m + r*^T I^-1 r*` [1/kg]: velocity change per impulse,
/// from the inverse inertia in the world frame [1/(kg m^2)] and the lever r from the centre of mass
/// to the point [m]. A pair's matrix is the sum over both bodies; an infinite mass adds zero.
pub fn contact_matrix(inverse_mass: f64, inverse_inertia: DMat3, lever: DVec3) -> DMat3 {
    let cross = DMat3::from_cols(
        DVec3::new(0.0, lever.z, -lever.y),
        DVec3::new(-lever.z, 0.0, lever.x),
        DVec3::new(lever.y, -lever.x, 0.0),
    );
    DMat3::from_diagonal(DVec3::splat(inverse_mass)) + cross.transpose() * inverse_inertia * cross
}

/// Impulse [kg m/s] on body a, with its opposite on body b, for a separation speed of `restitution`
/// times the approach speed and friction in Coulomb's cone.
///
/// `contact_matrix` is the pair's K [1/kg], `relative_velocity` the velocity of a's point minus b's
/// [m/s], `normal` the unit normal from b to a. Zero if the points separate or no mass is finite.
/// In ordinary sliding or sticking the energy can rise, by the model or in a split state [Su09 sec.
/// 3]: see [`crate::impulse::energy_clamp::clamp_impulse`]. In a jam (Painleve's paradox) the
/// friction is limited to no energy gain.
pub fn collision_impulse(
    contact_matrix: DMat3,
    relative_velocity: DVec3,
    normal: DVec3,
    surfaces: PairSurface,
) -> DVec3 {
    let PairSurface { restitution, friction, .. } = surfaces;

    // Skip separating points.
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

    // Stick: stop the tangential velocity completely, if the friction lies in the cone.
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

    // Jam or reversal: sliding friction would drive the bodies together, or accelerate the sliding.
    // Take the side of the cone nearest to the sticking impulse, which always changes the normal
    // velocity: from n.K j = normal_change > 0 for the sticking j, with |j_t| > mu j_n, follows
    // n.K (n + mu j_t/|j_t|) > 0.
    let on_cone = normal + (friction / sticking_friction) * sticking_tangent;
    let turned = (normal_change / normal.dot(contact_matrix * on_cone)) * on_cone;
    frictionless
        + energy_limit(contact_matrix, relative_velocity, frictionless, turned)
            * (turned - frictionless)
}

/// Fraction in [0, 1] of the way from `safe` (no energy gain) to `other` for a blend without energy
/// gain. By convexity the blend stays in the cone and keeps the restitution.
fn energy_limit(contact_matrix: DMat3, relative_velocity: DVec3, safe: DVec3, other: DVec3) -> f64 {
    // The energy change v.j + j.K j / 2 along the way is  constant + slope t + curvature t^2  [J].
    let way = other - safe;
    let answer = contact_matrix * safe;
    let constant = safe.dot(relative_velocity + 0.5 * answer).min(0.0);
    let slope = way.dot(relative_velocity + answer);
    let curvature = 0.5 * way.dot(contact_matrix * way);
    if constant + slope + curvature <= 0.0 {
        return 1.0;
    }
    // Positive root, in the form without cancellation.
    let root = (slope * slope - 4.0 * curvature * constant).sqrt();
    if slope > 0.0 { -2.0 * constant / (slope + root) } else { (root - slope) / (2.0 * curvature) }
}

/// Solves `matrix x = right` for a symmetric positive definite matrix by L D L^T factors; the
/// residual stays at rounding even for ill-conditioned matrices of thin bodies. `None` if the
/// matrix is singular to rounding.
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

/// Impulse on a body, about its centre of mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// Change of the linear momentum [kg m/s].
    pub linear: DVec3,
    /// Change of the angular momentum about the centre of mass [kg m^2/s].
    pub angular: DVec3,
}

impl Impulse {
    /// An impulse [kg m/s] at `lever` from the centre of mass [m]: `j_tau = r* j + ...`
    /// [Su09 sec. 3.2].
    pub fn at(lever: DVec3, impulse: DVec3) -> Self {
        Self { linear: impulse, angular: lever.cross(impulse) }
    }

    /// Scales both parts.
    pub fn scaled(&self, scale: f64) -> Self {
        Self { linear: scale * self.linear, angular: scale * self.angular }
    }
}

/// Velocity after an impulse. An infinite mass keeps its velocity.
pub fn apply_impulse(velocity: &Velocity, inverse_mass: f64, impulse: &Impulse) -> Velocity {
    if inverse_mass == 0.0 {
        return *velocity;
    }
    Velocity {
        linear: velocity.linear + inverse_mass * impulse.linear,
        angular_momentum: velocity.angular_momentum + impulse.angular,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::Inertia;
    use glam::DQuat;

    const UP: DVec3 = DVec3::Y;

    fn surfaces(restitution: f64, friction: f64) -> PairSurface {
        PairSurface::new(restitution, friction)
    }

    /// A solid ball of 2 kg and 0.5 m on the ground.
    fn ball_matrix() -> DMat3 {
        let inertia = Inertia::new(2.0, DVec3::splat(0.4 * 2.0 * 0.25));
        contact_matrix(inertia.inverse_mass, inertia.inverse_tensor(DQuat::IDENTITY), -0.5 * UP)
    }

    #[test]
    fn ball_that_slips_keeps_coulombs_ratio_and_ball_that_grips_stops_at_two_sevenths() {
        let velocity = DVec3::new(7.0, -3.0, 0.0);
        let slips = collision_impulse(ball_matrix(), velocity, UP, surfaces(0.5, 0.1));
        assert!((slips - 2.0 * 1.5 * 3.0 * DVec3::new(-0.1, 1.0, 0.0)).length() < 1e-14, "{slips}");
        // K across the normal is 1/m + r^2/I = 7/(2m).
        let grips = collision_impulse(ball_matrix(), velocity, UP, surfaces(0.5, 1.0));
        assert!((grips - DVec3::new(-2.0 * 7.0 * 2.0 / 7.0, 9.0, 0.0)).length() < 1e-14, "{grips}");
        let glances = collision_impulse(ball_matrix(), velocity, UP, surfaces(0.5, 0.0));
        assert!((glances - 9.0 * UP).length() < 1e-14, "{glances}");
    }

    #[test]
    fn separating_points_and_infinite_masses_get_nothing() {
        assert_eq!(
            collision_impulse(ball_matrix(), DVec3::new(1.0, 0.0, 0.0), UP, surfaces(0.5, 0.5)),
            DVec3::ZERO
        );
        assert_eq!(collision_impulse(ball_matrix(), -UP, UP, surfaces(-1.0, 0.5)), DVec3::ZERO);
        assert_eq!(collision_impulse(DMat3::ZERO, -UP, UP, surfaces(0.5, 0.5)), DVec3::ZERO);
        let wall = contact_matrix(
            0.0,
            Inertia::INFINITE.inverse_tensor(DQuat::IDENTITY),
            DVec3::new(3.0, 1.0, 2.0),
        );
        assert_eq!(wall, DMat3::ZERO);
    }

    /// A thin rod sliding on its lower end, away from its lean [Pai95]: Coulomb's sliding impulse
    /// would have to pull. Our impulse pushes, meets the restitution, stays in the cone and adds no
    /// energy.
    #[test]
    fn painleve_rod_neither_pulls_nor_gains() {
        let (mass, half_length, lean, friction) = (1.0, 0.5, 1.0f64, 3.0);
        let (sine, cosine) = libm::sincos(lean);
        let lever = half_length * DVec3::new(cosine, -sine, 0.0);
        let moment = mass * half_length * half_length / 3.0;
        let inertia = Inertia::new(mass, DVec3::new(1e-4, moment, moment));
        let matrix = contact_matrix(
            inertia.inverse_mass,
            inertia.inverse_tensor(DQuat::from_rotation_z(-lean)),
            lever,
        );

        let mut jams = 0;
        for slip in [-2.0, 2.0] {
            let velocity = DVec3::new(slip, -1.0, 0.0);
            let sliding = UP - friction * DVec3::new(slip, 0.0, 0.0).normalize();
            jams += i32::from(UP.dot(matrix * sliding) < 0.0);
            for restitution in [0.0, 0.5, 1.0] {
                let impulse =
                    collision_impulse(matrix, velocity, UP, surfaces(restitution, friction));
                let after = velocity + matrix * impulse;
                assert!((after.y - restitution).abs() < 1e-13);
                assert!(
                    (impulse - impulse.y * UP).length() <= friction * impulse.y * (1.0 + 1e-14)
                );
                let gain = impulse.dot(velocity) + 0.5 * impulse.dot(matrix * impulse);
                assert!(
                    gain <= 1e-13 || UP.dot(matrix * sliding) > 0.0,
                    "{slip} {restitution}: gains {gain}"
                );
            }
        }
        assert_eq!(jams, 1, "one of the two ways of sliding jams");
    }
}
