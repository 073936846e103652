//! The orientation near an evolved one that has the kinetic energy it should have [Su09 sec. 2].
//!
//! A step of the rotation keeps the angular momentum L and misses the kinetic energy `KE = L . I^-1 L / 2`. The fix
//! rotates the body about an axis s, normal to L, until KE is right. Along that circle KE is a cosine of twice the angle,
//! so the angle has a closed form.

use crate::Inertia;
use glam::{DQuat, DVec3};

/// What the fix did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnergyFix {
    /// The energy was right already, as far as an orientation in `f64` can tell.
    WithinRounding,
    /// The energy is so small that its square has no normal `f64`. Nothing was done [Su09 sec. 2.3].
    TooSlow,
    /// Rotated about L x omega, by `angle` [rad].
    Corrected {
        /// How far, all rounds together [rad].
        angle: f64,
    },
    /// Rotated at least once in the plane of L and a principal axis [Su09 sec. 2.4].
    CorrectedByPrincipalAxis {
        /// How far, all rounds together [rad].
        angle: f64,
        /// How many rotations in a row.
        rounds: u32,
    },
    /// No orientation has this energy with this angular momentum, or a number is not finite. The orientation is the
    /// one with the nearest energy that was found.
    Unresolved {
        /// `KE / KE0 - 1` of the orientation returned.
        relative_error: f64,
    },
}

/// Energies [J] whose squares are normal numbers with digits to spare: a bound of `f64`, far from any physical one.
const SQUARABLE: std::ops::RangeInclusive<f64> = 1e-140..=1e140;

/// Energy errors below this many units in the last place of the orientation are left alone. Turning the body by an
/// angle d changes KE by up to `|omega||L| d`, and the orientation itself is only good to a few of these.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Where `a` is below this fraction of KE the axis L x omega carries few digits, and the fallback is as near.
const SMALL_SLOPE: f64 = 1e-7;

/// One round resolves nearly all; a second polishes what an ill-conditioned tensor left, or follows an extremum.
const MAX_ROUNDS: u32 = 8;

/// Turns `orientation` (`world_from_body`) so that the kinetic energy of rotation is `kinetic_energy_0` [J] while the
/// angular momentum [kg m^2/s, world frame] stays as it is.
///
/// Works for every inertia, also when L lies along a principal axis, and in any units.
pub fn fix_rotational_energy(
    orientation: DQuat,
    angular_momentum: DVec3,
    inertia: &Inertia,
    kinetic_energy_0: f64,
) -> (DQuat, EnergyFix) {
    let mut orientation = orientation;
    let mut angle = 0.0;
    let mut rounds = 0;
    let mut by_principal_axis = false;
    loop {
        // Measure the energy error in the body frame, where the inverse inertia is diagonal.
        let state = BodyState::new(orientation, angular_momentum, inertia);
        let energy = state.energy();
        let excess = energy - kinetic_energy_0;

        // Leave alone what is right, too small to tell, or hopeless.
        if excess.abs() <= ROUNDING * state.omega.length() * state.momentum.length() {
            let fix = match (rounds, by_principal_axis) {
                (0, _) => EnergyFix::WithinRounding,
                (_, false) => EnergyFix::Corrected { angle },
                (_, true) => EnergyFix::CorrectedByPrincipalAxis { angle, rounds },
            };
            return (orientation, fix);
        }
        let largest = energy.max(kinetic_energy_0);
        if largest < *SQUARABLE.start() {
            return (orientation, EnergyFix::TooSlow);
        }
        if rounds == MAX_ROUNDS || !SQUARABLE.contains(&largest) || !excess.is_finite() {
            return (orientation, EnergyFix::Unresolved { relative_error: energy / kinetic_energy_0 - 1.0 });
        }

        // Rotate about the locally best axis, or else in the plane that holds the global extremum.
        let turn = state.turn_about_best_axis(excess).unwrap_or_else(|| {
            by_principal_axis = true;
            state.turn_towards_principal_axis(excess)
        });
        // exp(eps s) R in the world frame is R exp(eps s) in the body frame.
        orientation = (orientation * turn.rotation()).normalize();
        angle += turn.angle().abs();
        rounds += 1;
    }
}

/// A rotating body seen from its own frame.
struct BodyState {
    inverse_moments: DVec3,
    momentum: DVec3,
    omega: DVec3,
}

/// A rotation about the unit vector `axis` by the angle whose tangent is `sine / cosine`; `cosine >= 0`.
struct Turn {
    axis: DVec3,
    cosine: f64,
    sine: f64,
}

/// The energy on the circle that turning about an axis leads along, in the letters of [Su09 sec. 2.2] [J]:
/// `KE(eps) = KE cos^2 - a sin cos + b sin^2` [eq. 3], `c = KE - b`.
struct Circle {
    axis: DVec3,
    a: f64,
    c: f64,
}

impl BodyState {
    fn new(orientation: DQuat, angular_momentum: DVec3, inertia: &Inertia) -> Self {
        let momentum = orientation.conjugate() * angular_momentum;
        Self { inverse_moments: inertia.inverse_moments, momentum, omega: inertia.inverse_moments * momentum }
    }

    fn energy(&self) -> f64 {
        0.5 * self.momentum.dot(self.omega)
    }

    /// `L x omega`, each component to full relative accuracy however near L is to a principal axis.
    fn momentum_cross_omega(&self) -> DVec3 {
        let (l, w) = (self.momentum, self.inverse_moments);
        DVec3::new(l.y * l.z * (w.z - w.y), l.z * l.x * (w.x - w.z), l.x * l.y * (w.y - w.x))
    }

    /// The circle about `axis`, which is normal to L; the axis is flipped so that `a = s . (L x omega) >= 0`.
    /// (The sign of y in [Su09 sec. 2.3] holds only then.)
    fn circle(&self, axis: DVec3) -> Circle {
        let signed_slope = axis.dot(self.momentum_cross_omega());
        let axis = if signed_slope < 0.0 { -axis } else { axis };
        let across = axis.cross(self.momentum);
        let b = 0.5 * across.dot(self.inverse_moments * across);
        Circle { axis, a: signed_slope.abs(), c: self.energy() - b }
    }

    /// About `s = L x omega / |L x omega|`, along which the energy changes fastest [Su09 sec. 2.4]. `None` if its
    /// direction is not robust or its circle does not reach the energy sought [sec. 2.3].
    fn turn_about_best_axis(&self, excess: f64) -> Option<Turn> {
        let axis = self.momentum_cross_omega().try_normalize()?;
        let circle = self.circle(axis);
        if circle.a < SMALL_SLOPE * self.energy() {
            return None;
        }
        circle.turn_to_energy(excess)
    }

    /// About `s = L x r` with the principal axis r of the largest moment if there is too much energy and of the
    /// smallest if too little: this circle passes through the global extremum [Su09 sec. 2.4]. Where even that is out of
    /// reach, if only by rounding, turns to the extremum.
    fn turn_towards_principal_axis(&self, excess: f64) -> Turn {
        let (low, high) = (self.inverse_moments.min_position(), self.inverse_moments.max_position());
        let (sought, other) = if excess > 0.0 { (low, high) } else { (high, low) };
        // On the principal axis itself, any circle that leaves it will do.
        let axis = (self.momentum.cross(DVec3::AXES[sought]).try_normalize())
            .or_else(|| self.momentum.cross(DVec3::AXES[other]).try_normalize())
            .unwrap_or_else(|| self.momentum.any_orthogonal_vector().normalize_or(DVec3::X));
        let circle = self.circle(axis);
        circle.turn_to_energy(excess).unwrap_or_else(|| circle.turn_to_extremum(excess))
    }
}

impl Circle {
    /// The smaller of the two turns to the energy `KE0 = KE - k`; `None` if the circle does not reach it.
    ///
    /// With a >= 0, x and y of [Su09 sec. 2.3] are in the ratio of `a + sqrt(g)` to `2 k`, and k has the sign of
    /// `k - c y^2`; so they need no r, n, p and no sign rule.
    fn turn_to_energy(&self, k: f64) -> Option<Turn> {
        let g = self.a * self.a + 4.0 * k * (self.c - k);
        (g >= 0.0).then(|| Turn { axis: self.axis, cosine: self.a + g.sqrt(), sine: 2.0 * k })
    }

    /// To the lowest energy on the circle if `k > 0`, else to the highest: half of the way that the phase `atan2(a, c)`
    /// of the cosine in [Su09 eq. 3] has to go, by the half-angle formula that does not cancel. Nowhere if all
    /// energies are equal.
    fn turn_to_extremum(&self, k: f64) -> Turn {
        let r = (self.a * self.a + self.c * self.c).sqrt();
        if r == 0.0 {
            return Turn { axis: self.axis, cosine: 1.0, sine: 0.0 };
        }
        let sign = if k < 0.0 { -1.0 } else { 1.0 };
        let (cosine, sine) =
            if sign * self.c > 0.0 { (self.a, r + sign * self.c) } else { (r - sign * self.c, self.a) };
        Turn { axis: self.axis, cosine, sine: sign * sine }
    }
}

impl Turn {
    fn angle(&self) -> f64 {
        libm::atan2(self.sine, self.cosine)
    }

    /// By `tan(eps/2) = sin eps / (1 + cos eps)`; not normalised.
    fn rotation(&self) -> DQuat {
        let length = (self.cosine * self.cosine + self.sine * self.sine).sqrt();
        DQuat::from_vec4((self.sine * self.axis).extend(length + self.cosine))
    }
}
