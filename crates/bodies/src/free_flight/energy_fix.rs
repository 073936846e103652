//! The orientation near an evolved one that has the kinetic energy it should have [Su09 sec. 2].
//!
//! A step of the rotation keeps the angular momentum L and misses the kinetic energy `KE = L . I^-1
//! L / 2`. The fix rotates the body about an axis s, normal to L, until KE is right. Along that
//! circle KE is a cosine of twice the angle, so the angle has a closed form.

use crate::state::Inertia;
use glam::{DQuat, DVec3};

/// Result of the energy fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnergyFix {
    /// The energy was right already, as far as an orientation in `f64` can tell.
    WithinRounding,
    /// The energy is too small for a normal `f64` square: no correction [Su09 sec. 2.3].
    TooSlow,
    /// Rotated about L x omega, by `angle` [rad].
    Corrected {
        /// Total angle of all rounds [rad].
        angle: f64,
    },
    /// Rotated at least once in the plane of L and a principal axis [Su09 sec. 2.4].
    CorrectedByPrincipalAxis {
        /// Total angle of all rounds [rad].
        angle: f64,
        /// Number of consecutive rotations.
        rounds: u32,
    },
    /// No orientation has this energy with this angular momentum, or a number is not finite. The
    /// orientation is the one with the nearest energy that was found.
    Unresolved {
        /// `KE / KE0 - 1` of the orientation returned.
        relative_error: f64,
    },
}

/// Energies [J] whose squares are normal numbers with digits to spare: a bound of `f64`, far from
/// any physical one.
const SQUARABLE: std::ops::RangeInclusive<f64> = 1e-140..=1e140;

/// Energy errors below this many units in the last place of the orientation are left alone. Turning
/// the body by an angle d changes KE by up to `|omega||L| d`, and the orientation itself is only
/// good to a few of these.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Where `a` is below this fraction of KE the axis L x omega carries few digits, and the fallback
/// is as near.
const SMALL_SLOPE: f64 = 1e-7;

/// One round resolves nearly all; a second polishes what an ill-conditioned tensor left, or follows
/// an extremum.
const MAX_ROUNDS: u32 = 8;

/// Turns `orientation` (`world_from_body`) so that the kinetic energy of rotation is
/// `kinetic_energy_0` [J] while the angular momentum [kg m^2/s, world frame] stays as it is.
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
            return (
                orientation,
                EnergyFix::Unresolved { relative_error: energy / kinetic_energy_0 - 1.0 },
            );
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

/// A rotation about the unit vector `axis` by the angle whose tangent is `sine / cosine`; `cosine
/// >= 0`.
struct Turn {
    axis: DVec3,
    cosine: f64,
    sine: f64,
}

/// The energy on the circle that turning about an axis leads along, in the letters of
/// [Su09 sec. 2.2] [J]: `KE(eps) = KE cos^2 - a sin cos + b sin^2` [eq. 3], `c = KE - b`.
struct Circle {
    axis: DVec3,
    a: f64,
    c: f64,
}

impl BodyState {
    fn new(orientation: DQuat, angular_momentum: DVec3, inertia: &Inertia) -> Self {
        let momentum = orientation.conjugate() * angular_momentum;
        Self {
            inverse_moments: inertia.inverse_moments,
            momentum,
            omega: inertia.inverse_moments * momentum,
        }
    }

    fn energy(&self) -> f64 {
        0.5 * self.momentum.dot(self.omega)
    }

    /// `L x omega`, by which the energy changes as the body turns [Su09 eq. 1]; each component to
    /// full relative accuracy however near L is to a principal axis.
    fn momentum_cross_omega(&self) -> DVec3 {
        let (l, w) = (self.momentum, self.inverse_moments);
        DVec3::new(l.y * l.z * (w.z - w.y), l.z * l.x * (w.x - w.z), l.x * l.y * (w.y - w.x))
    }

    /// The circle about `axis`, which is normal to L; the axis is flipped so that `a = s . (L x
    /// omega) >= 0`. (The sign of y in [Su09 sec. 2.3] holds only then.)
    fn circle(&self, axis: DVec3) -> Circle {
        let signed_slope = axis.dot(self.momentum_cross_omega());
        let axis = if signed_slope < 0.0 { -axis } else { axis };
        let across = axis.cross(self.momentum);
        let b = 0.5 * across.dot(self.inverse_moments * across);
        Circle { axis, a: signed_slope.abs(), c: self.energy() - b }
    }

    /// About `s = L x omega / |L x omega|`, along which the energy changes fastest [Su09 sec. 2.4].
    /// `None` if its direction is not robust or its circle does not reach the energy sought
    /// [sec. 2.3].
    fn turn_about_best_axis(&self, excess: f64) -> Option<Turn> {
        let axis = self.momentum_cross_omega().try_normalize()?;
        let circle = self.circle(axis);
        if circle.a < SMALL_SLOPE * self.energy() {
            return None;
        }
        circle.turn_to_energy(excess)
    }

    /// About `s = L x r` with the principal axis r of the largest moment if there is too much
    /// energy and of the smallest if too little: this circle passes through the global extremum
    /// [Su09 sec. 2.4]. Where even that is out of reach, if only by rounding, turns to the
    /// extremum.
    fn turn_towards_principal_axis(&self, excess: f64) -> Turn {
        let (low, high) =
            (self.inverse_moments.min_position(), self.inverse_moments.max_position());
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
    /// The smaller of the two turns to the energy `KE0 = KE - k`; `None` if the circle does not
    /// reach it.
    ///
    /// `a x y = k - c y^2` [Su09 eq. 5] with x = cos, y = sin has the roots [eq. 6]. With a >= 0
    /// the root near zero, as [sec. 2.3] writes it, has x and y in the ratio of `a + sqrt(g)` to `2
    /// k`, and k has the sign of `k - c y^2`; so it needs no r, n, p and no sign rule.
    fn turn_to_energy(&self, k: f64) -> Option<Turn> {
        let g = self.a * self.a + 4.0 * k * (self.c - k);
        (g >= 0.0).then(|| Turn { axis: self.axis, cosine: self.a + g.sqrt(), sine: 2.0 * k })
    }

    /// To the lowest energy on the circle if `k > 0`, else to the highest: half of the way that the
    /// phase `atan2(a, c)` of the cosine in [Su09 eq. 3] has to go, by the half-angle formula that
    /// does not cancel. Nowhere if all energies are equal.
    fn turn_to_extremum(&self, k: f64) -> Turn {
        let r = (self.a * self.a + self.c * self.c).sqrt();
        if r == 0.0 {
            return Turn { axis: self.axis, cosine: 1.0, sine: 0.0 };
        }
        let sign = if k < 0.0 { -1.0 } else { 1.0 };
        let (cosine, sine) = if sign * self.c > 0.0 {
            (self.a, r + sign * self.c)
        } else {
            (r - sign * self.c, self.a)
        };
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

#[cfg(test)]
mod tests {
    use super::*;

    const MOMENTS: DVec3 = DVec3::new(1.0, 2.0, 2.5);

    /// A spread of orientations and momenta without chance.
    fn samples() -> impl Iterator<Item = (DQuat, DVec3)> {
        (1..200).map(f64::from).map(|i| {
            let orientation = DQuat::from_vec4(glam::DVec4::new(
                libm::sin(1.3 * i),
                libm::cos(2.1 * i),
                libm::sin(0.7 * i),
                0.3,
            ));
            (
                orientation.normalize(),
                DVec3::new(libm::cos(0.9 * i), libm::sin(1.7 * i), libm::cos(0.4 * i)),
            )
        })
    }

    /// dKE/d(eps) = -s . (L x omega), by central differences.
    #[test]
    fn energy_changes_with_the_orientation_as_eq_1_says() {
        let inertia = Inertia::new(1.0, MOMENTS);
        for (orientation, momentum) in samples() {
            let axis = DVec3::new(2.0, -1.0, 2.0) / 3.0;
            let energy = |angle| {
                inertia
                    .rotational_energy(DQuat::from_axis_angle(axis, angle) * orientation, momentum)
            };
            let difference = (energy(1e-5) - energy(-1e-5)) / 2e-5;
            let expected =
                -axis.dot(momentum.cross(inertia.angular_velocity(orientation, momentum)));
            assert!((difference - expected).abs() < 1e-9, "{difference} is not {expected}");
        }
    }

    /// Our ratio of sine to cosine is that of [Su09 eq. 6] and of [sec. 2.3], and satisfies [eq.
    /// 4].
    #[test]
    fn turn_agrees_with_the_printed_formulas() {
        let inertia = Inertia::new(1.0, MOMENTS);
        let mut checked = 0;
        for (orientation, momentum) in samples() {
            let state = BodyState::new(orientation, momentum, &inertia);
            let circle = state.circle(state.momentum_cross_omega().normalize());
            let (energy, a, c) = (state.energy(), circle.a, circle.c);
            for fraction in [-0.05, -0.01, 0.01, 0.05] {
                let k = fraction * energy;
                let Some(turn) = circle.turn_to_energy(k) else { continue };
                let (y, x) = libm::sincos(turn.angle());
                let b = energy - c;
                assert!(
                    (energy * x * x - a * x * y + y * y * b - (energy - k)).abs() < 1e-14,
                    "eq. 4"
                );
                checked += 1;

                // Direct use of eq. 6 with the signs of sec. 2.2: p_b = -sgn(a), p_c = 1, p_s =
                // sgn(k - c y^2).
                let (r, n) = (a.hypot(c), c - 2.0 * k);
                let q = a * (r * r - n * n).sqrt();
                let y_squared = (r * r - c * n - q) / (2.0 * r * r);
                let direct = DVec3::new(
                    (r * r + c * n + q).sqrt() / (r * 2f64.sqrt()),
                    y_squared.max(0.0).sqrt(),
                    0.0,
                );
                assert!(
                    (direct.x - x).abs() < 1e-7 && (direct.y - y.abs()).abs() < 1e-7,
                    "eq. 6: {direct} {x} {y}"
                );
                assert!((k - c * y * y) * y > 0.0, "p_s");

                // Sec. 2.3.
                let g = a * a + 4.0 * k * (c - k);
                let p = a * a + g + 2.0 * a * g.sqrt();
                assert!(
                    ((p + (c + n) * (c + n)).sqrt() / (2.0 * r) - x).abs() < 1e-14,
                    "sec. 2.3, x"
                );
                assert!(
                    (2.0 * k.abs() / (p + (c - n) * (c - n)).sqrt() - y.abs()).abs() < 1e-14,
                    "sec. 2.3, y"
                );
            }
        }
        assert!(checked > 500);
    }

    /// Nothing to correct, or nothing that could be.
    #[test]
    fn degenerate_bodies_are_left_alone() {
        let fix = |inertia: &Inertia, momentum, energy| {
            let orientation = DQuat::from_rotation_x(0.7);
            let (fixed, fix) = fix_rotational_energy(orientation, momentum, inertia, energy);
            assert!(fixed.is_normalized());
            (fixed == orientation, fix)
        };
        let momentum = DVec3::new(1.0, 2.0, 2.0);
        let sphere = Inertia::new(1.0, DVec3::splat(3.0));
        assert_eq!(fix(&sphere, momentum, 1.5), (true, EnergyFix::WithinRounding));
        assert_eq!(fix(&sphere, DVec3::ZERO, 0.0), (true, EnergyFix::WithinRounding));
        assert_eq!(fix(&Inertia::INFINITE, momentum, 0.0), (true, EnergyFix::WithinRounding));
        let top = Inertia::new(1.0, MOMENTS);
        assert_eq!(fix(&top, 1e-80 * momentum, 1e-150), (true, EnergyFix::TooSlow));
        assert!(matches!(fix(&top, momentum, f64::NAN), (true, EnergyFix::Unresolved { .. })));
        assert!(matches!(fix(&top, DVec3::NAN, 1.0), (true, EnergyFix::Unresolved { .. })));
        assert_eq!(fix(&top, DVec3::ZERO, 2.0).1, EnergyFix::Unresolved { relative_error: -1.0 });
        // A sphere has one energy only.
        let (_, EnergyFix::Unresolved { relative_error }) = fix(&sphere, momentum, 2.0) else {
            panic!("no orientation of a sphere has another energy");
        };
        assert!((relative_error + 0.25).abs() < 1e-15);
    }

    /// Other units of mass, length and time give the same orientation, to the bit where they are
    /// powers of two.
    #[test]
    fn units_do_not_matter() {
        for (orientation, momentum) in samples() {
            let fix = |moment_unit: f64, momentum_unit: f64| {
                let inertia = Inertia::new(1.0, moment_unit * MOMENTS);
                let momentum = momentum_unit * momentum;
                let energy = 0.9 * inertia.rotational_energy(orientation, momentum);
                fix_rotational_energy(orientation, momentum, &inertia, energy)
            };
            for exponent in [-60, 60] {
                let unit = f64::powi(2.0, exponent);
                assert_eq!(fix(1.0, 1.0), fix(unit, 1.0));
                assert_eq!(fix(1.0, 1.0).0, fix(1.0, unit).0);
            }
        }
    }

    /// From L on a principal axis to L on another, and to energies that no orientation has.
    #[test]
    fn extremes_are_reached_and_what_is_beyond_them_is_reported() {
        let inertia = Inertia::new(1.0, MOMENTS);
        let momentum = DVec3::new(0.0, 5.0, 0.0);
        let starts = [
            DQuat::IDENTITY,
            DQuat::from_rotation_z(1.3),
            DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
        ];
        for start in starts.into_iter().chain(samples().map(|(orientation, _)| orientation)) {
            for (moment, scale, attainable) in
                [(1.0, 1.0, true), (2.5, 1.0, true), (1.0, 1.1, false), (2.5, 0.9, false)]
            {
                let extreme = 0.5 * 25.0 / moment;
                let (fixed, fix) =
                    fix_rotational_energy(start, momentum, &inertia, scale * extreme);
                let energy = inertia.rotational_energy(fixed, momentum);
                assert!(
                    (energy / extreme - 1.0).abs() < 1e-14,
                    "{start} {moment}: {energy} is not {extreme}, {fix:?}"
                );
                assert_eq!(attainable, !matches!(fix, EnergyFix::Unresolved { .. }), "{fix:?}");
            }
        }
    }
}
