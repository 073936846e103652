//! Torque-free rotation in closed form, at the cost of a second-order step.
//!
//! In the body frame the unit vector l along L runs around a closed curve, the polhode, as Jacobi's
//! elliptic functions of time [Landau & Lifshitz, Mechanics, sec. 37]. Where it stands on the curve
//! is known, so their addition theorem carries it on and no integral has to be inverted. All
//! constants of the curve are written as sums of terms of one sign, so near-symmetric bodies and
//! near-steady spins cost no digits.

use crate::state::Inertia;
use frangible_math::{
    Instructions, Lanes, Lanes3, Mask, Number, Series, Turn, Vector, arithmetic_geometric_mean,
};
use glam::{DQuat, DVec3};
use std::f64::consts::PI;

/// A turn [rad] that leaves a quaternion as it is.
const NO_TURN: f64 = 1e-20;

/// A turn [rad] up to which the series in time is exact to rounding: its next term, of fifth order,
/// is below 1e-16.
pub(crate) const SLOW: f64 = 1e-3;

/// Angular momentum [kg m^2/s] whose square is too small for its length to be precise.
const NO_MOMENTUM: f64 = 1e-140;

/// Rotates `orientation` (`world_from_body`) over `dt` [s], of either sign, without torque.
/// `angular_momentum` L is in the world frame [kg m^2/s]; it is an input only, and the kinetic
/// energy is kept to round-off. The error in angle is round-off times the rotation angle, unless
/// the spin is so near the intermediate axis that the motion itself magnifies it.
pub fn rotate_exact(
    orientation: DQuat,
    angular_momentum: DVec3,
    inertia: &Inertia,
    dt: f64,
) -> DQuat {
    // In units of the fastest principal axis' rate |L|/I, in which `angle` takes the place of time.
    let magnitude = angular_momentum.length();
    let fastest = inertia.inverse_moments.max_element();
    let angle = dt * fastest * magnitude;
    if angle.abs() < NO_TURN || magnitude < NO_MOMENTUM {
        return orientation;
    }
    let rates = inertia.inverse_moments * (1.0 / fastest);
    let direction_world = angular_momentum * (1.0 / magnitude);
    let direction = orientation.conjugate() * direction_world;
    if angle.abs() < SLOW {
        return rotate_slowly(orientation.into(), (direction_world, rates), angle).into();
    }

    let (axes, start) = circulation_axes(direction, rates);
    let (end, phase) = Polhode::new(start, axes.relabel(rates)).follow(start, angle);

    // L is at rest in the world, and the body turns about it: undo the tilt to l at the end, turn,
    // and redo the tilt to l at the start.
    let turn_body = axes.restore(tilt_turn_tilt(start, phase, end));
    settle((orientation * turn_body).into(), direction_world, direction, rates).into()
}

/// Rotates within an `angle` below [`SLOW`] in units of the fastest principal axis' rate, as
/// [`rotate_exact`] does. `direction_world` is that of L, `rates` are those of the principal axes,
/// relative to the fastest.
#[inline(always)]
fn rotate_slowly<V: Vector>(
    orientation: Turn<V>,
    (direction_world, rates): (V, V),
    angle: V::Number,
) -> Turn<V> {
    let direction = orientation.back().turn(direction_world);
    let turn_body = turn_slowly(direction, rates, angle);
    settle(orientation.after(turn_body), direction_world, direction, rates)
}

/// Rotates bodies side by side over `dt` [s], which is not negative, each as [`rotate_exact`] does,
/// that turn slowly: which these are. `inverse_moments` are the principal ones, of which `fastest`
/// is the largest.
#[inline(always)]
pub(crate) fn rotate_slow_ones<I: Instructions>(
    orientation: Turn<Lanes3<I>>,
    angular_momentum: Lanes3<I>,
    (inverse_moments, fastest): (Lanes3<I>, Lanes<I>),
    dt: f64,
) -> (Turn<Lanes3<I>>, Mask) {
    let one = Lanes::splat(1.0);
    let magnitude = angular_momentum.dot(angular_momentum).sqrt();
    let angle = Lanes::splat(dt) * fastest * magnitude;
    let rests = Lanes::splat(NO_TURN).above(angle).or(Lanes::splat(NO_MOMENTUM).above(magnitude));
    let direction = angular_momentum * (one / magnitude);
    let rates = inverse_moments * (one / fastest);
    let turned = rotate_slowly(orientation, (direction, rates), angle);
    let is_slow = Lanes::splat(SLOW).above(angle);
    let goes = is_slow.and(rests.not());
    let vector = goes.select(turned.vector, orientation.vector);
    (Turn { vector, scalar: goes.select(turned.scalar, orientation.scalar) }, is_slow)
}

/// The turn within `angle`, in the body frame: the logarithm of the rotation to fourth order in
/// time [Mag54].
#[inline(always)]
fn turn_slowly<V: Vector>(l: V, rates: V, angle: V::Number) -> Turn<V> {
    // Derivatives of l and of omega in the body frame, where l' = l x omega.
    let of = V::Number::of;
    let omega = rates.times(l);
    let l_1 = l.cross(omega);
    let omega_1 = rates.times(l_1);
    let l_2 = l_1.cross(omega) + l.cross(omega_1);
    let omega_2 = rates.times(l_2);
    let l_3 = l_2.cross(omega) + l_1.cross(omega_1) * of(2.0) + l.cross(omega_2);
    let omega_3 = rates.times(l_3);

    let third = omega_2 * of(1.0 / 6.0) + omega.cross(omega_1) * of(1.0 / 12.0);
    let fourth = (omega_3 + omega.cross(omega_2)) * of(1.0 / 24.0);
    Turn::by_little(
        (omega + (omega_1 * of(0.5) + (third + fourth * angle) * angle) * angle) * angle,
    )
}

/// Principal axes renamed, and some turned round, by a proper rotation.
struct Axes {
    /// Which axis of the body comes first, second, third.
    order: [usize; 3],
    signs: DVec3,
}

impl Axes {
    #[inline]
    fn relabel(&self, body: DVec3) -> DVec3 {
        let body = body.to_array();
        DVec3::new(body[self.order[0]], body[self.order[1]], body[self.order[2]])
    }

    #[inline]
    fn restore(&self, rotation: DQuat) -> DQuat {
        let mut body = [0.0, 0.0, 0.0, rotation.w];
        for (axis, value) in self.order.into_iter().zip((self.signs * rotation.xyz()).to_array()) {
            body[axis] = value;
        }
        DQuat::from_array(body)
    }
}

/// Axes in which l circulates about the third with z >= 0 and the second is the intermediate one;
/// and l in them.
#[inline]
fn circulation_axes(direction: DVec3, rates: DVec3) -> (Axes, DVec3) {
    // By rising rate; a table has no branches to mispredict.
    let (rate, l) = (rates.to_array(), direction.to_array());
    let (low, high) = match (rate[0] <= rate[1], rate[1] <= rate[2], rate[0] <= rate[2]) {
        (true, true, _) => (0, 2),
        (true, false, true) => (0, 1),
        (true, false, false) => (2, 1),
        (false, true, true) => (1, 2),
        (false, true, false) => (1, 0),
        (false, false, _) => (2, 0),
    };
    let middle = 3 - low - high;

    // The separatrix through the intermediate axis tells about which of the outer axes it
    // circulates.
    let about_high = l[high] * l[high] * (rate[high] - rate[middle])
        >= l[low] * l[low] * (rate[middle] - rate[low]);
    let order = if about_high { [low, middle, high] } else { [high, middle, low] };
    let handedness = if (middle + 3 - order[0]) % 3 == 1 { 1.0 } else { -1.0 };

    let sign = 1_f64.copysign(l[order[2]]);
    let axes = Axes { order, signs: DVec3::new(handedness, sign, sign) };
    let start = axes.signs * axes.relabel(direction);
    (axes, start)
}

/// The curve of l in [`circulation_axes`]: x, y and z go as cn, sn and dn of `sqrt(rate_squared)`
/// times time.
struct Polhode {
    rates: DVec3,
    /// Differences of the rates: first and second, second and third, first and third; all of one
    /// sign, here positive.
    differences: [f64; 3],
    /// -1 where the first rate is the lowest: time runs backwards along the curve.
    sense: f64,
    /// `l . rates l`: twice the kinetic energy.
    energy: f64,
    rate_squared: f64,
    /// `m rate_squared` and `(1 - m) rate_squared`.
    parameter: f64,
    complement: f64,
    series: Series,
}

impl Polhode {
    #[inline]
    fn new(l: DVec3, rates: DVec3) -> Self {
        let [ab, bc, ac] =
            [(rates.x - rates.y).abs(), (rates.y - rates.z).abs(), (rates.x - rates.z).abs()];
        let square = l * l;
        // |energy - rates.z| and |energy - rates.x|, without their cancellation.
        let above = square.x * ac + square.y * bc;
        let below = square.y * ab + square.z * ac;
        let (rate_squared, parameter) = (bc * below, ab * above);
        Self {
            rates,
            differences: [ab, bc, ac],
            sense: 1_f64.copysign(rates.x - rates.z),
            energy: rates.dot(square),
            rate_squared,
            parameter,
            complement: ac * (square.z * bc - square.x * ab),
            series: Series::new(rate_squared, parameter),
        }
    }

    /// Where l is after `angle`, and by which angle the body has then turned about L, beyond the
    /// tilts [rad].
    #[inline]
    fn follow(&self, l: DVec3, angle: f64) -> (DVec3, f64) {
        let advance_squared = self.rate_squared * angle * angle;
        if advance_squared <= 4.0 * Series::SHORT_REACH * Series::SHORT_REACH {
            let (end, rate) = self.part::<6, 3>(l, 0.5 * angle, &GAUSS_6);
            (end, angle * rate)
        } else if advance_squared <= PI * PI {
            self.sweep(l, angle)
        } else {
            self.follow_periods(l, angle)
        }
    }

    /// Takes whole periods out: dn has the period 2 K >= pi, over which cn and sn change sign, and
    /// each period turns as far as the other.
    fn follow_periods(&self, l: DVec3, angle: f64) -> (DVec3, f64) {
        // On the separatrix itself the period is infinite; taken as 1e-150 off it, it is some 700
        // of u.
        let rate = self.rate_squared.sqrt();
        let period = PI
            / arithmetic_geometric_mean(rate, self.complement.max(0.0).sqrt().max(1e-150 * rate));
        let periods = (angle / period).trunc();
        // Beyond 1e16 periods the remainder is rounding.
        let rest = (angle - periods * period).max(-period).min(period);
        let (end, phase) = self.sweep(l, rest);

        // From y = 0 on, the two halves of a period mirror each other.
        let [ab, bc, ac] = self.differences;
        let square = l * l;
        let origin = DVec3::new(
            (square.x + square.y * (bc / ac)).sqrt(),
            0.0,
            (square.z + square.y * (ab / ac)).sqrt(),
        );
        let (_, phase_of_half) = self.sweep(origin, 0.5 * period);
        let sign = if periods % 2.0 == 0.0 { 1.0 } else { -1.0 };
        (end * DVec3::new(sign, sign, 1.0), phase + 2.0 * periods * phase_of_half)
    }

    /// Follows in parts that the series and the quadrature bear: fewer than 1000 in a period.
    fn sweep(&self, l: DVec3, angle: f64) -> (DVec3, f64) {
        let parts = (self.rate_squared.sqrt() * angle.abs() / (2.0 * Series::REACH))
            .ceil()
            .clamp(1.0, 1000.0);
        let half = 0.5 * angle / parts;
        let (mut at, mut rates) = (l, 0.0);
        for _ in 0..parts as u32 {
            let (end, rate) = self.part::<9, 4>(at, half, &GAUSS_8);
            (at, rates) = (end, rates + rate);
        }
        (at, angle * rates / parts)
    }

    /// Where l is after twice `half`; and the mean rate at which the body turns about L in between
    /// the tilts.
    #[inline]
    fn part<const TERMS: usize, const N: usize>(
        &self,
        l: DVec3,
        half: f64,
        rule: &[(f64, f64); N],
    ) -> (DVec3, f64) {
        // The addition theorem [A&S 16.17] for l itself, with sn, cn and dn as `t / n`, `c / n` and
        // `d / n`; the amplitudes of l cancel. For so short a time nothing else does but where a
        // component changes sign.
        let [ab, bc, ac] = self.differences;
        let (t, t_squared) = (self.sense * half, half * half);
        let n_squared = self.series.at::<TERMS>(t_squared);
        let c_squared = n_squared - self.rate_squared * t_squared;
        let (n, c, d) =
            (n_squared.sqrt(), c_squared.sqrt(), (n_squared - self.parameter * t_squared).sqrt());
        let (cn, cd, dn) = (c * n, c * d, d * n);
        let (x_scale, y_scale, z_scale) = (bc * t * d, ac * t * n, ab * t * c);
        let advance = |l: DVec3| {
            let scale = 1.0 / (c_squared + ac * bc * t_squared * (l.z * l.z));
            scale
                * DVec3::new(
                    l.x * cn - x_scale * (l.y * l.z),
                    l.y * cd + y_scale * (l.x * l.z),
                    l.z * dn - z_scale * (l.x * l.y),
                )
        };
        let middle = advance(l);
        (advance(middle), self.mean_rate::<TERMS, N>(middle, t_squared, rule))
    }

    /// Mean over a time on both sides of `middle` of `(energy + rates.z z) / (1 + z)`, by Gauss's
    /// quadrature. Its poles are at least pi/2 off the real axis of u.
    #[inline]
    fn mean_rate<const TERMS: usize, const N: usize>(
        &self,
        middle: DVec3,
        half_squared: f64,
        rule: &[(f64, f64); N],
    ) -> f64 {
        let [ab, bc, ac] = self.differences;
        let odd = ab * middle.x * middle.y;
        let scale_gain = ac * bc * (middle.z * middle.z) - self.rate_squared;
        let mut mean = 0.0;
        for (node_squared, weight) in rule {
            // As in `part`, at both times +-t: z = (even -+ odd) / scale, and the mean of the two
            // rates needs odd only squared.
            let t_squared = node_squared * half_squared;
            let n_squared = self.series.at::<TERMS>(t_squared);
            let scale = n_squared + scale_gain * t_squared;
            let even = middle.z * (n_squared * (n_squared - self.parameter * t_squared)).sqrt();
            let odd_squared = odd * odd * t_squared * (n_squared - self.rate_squared * t_squared);
            let numerator = self.energy * scale + self.rates.z * even;
            let denominator = scale + even;
            mean += weight * (numerator * denominator - self.rates.z * odd_squared)
                / (denominator * denominator - odd_squared);
        }
        mean
    }
}

/// `tilt(start) R(phase) tilt(end)^-1` in the axes of [`circulation_axes`]. R turns about the third
/// axis; `tilt(l)`, along (w, x, y, z) = (1 + l.z, -l.y, l.x, 0), is the shortest rotation from
/// that axis to l. As l.z >= 0, neither is singular.
#[inline]
fn tilt_turn_tilt(start: DVec3, phase: f64, end: DVec3) -> DQuat {
    let (sine, cosine) = libm::sincos(0.5 * phase);
    let (w, v) = (1.0 + start.z, 1.0 + end.z);
    let scale = 0.5 / (w * v).sqrt();
    let (sine, cosine) = (scale * sine, scale * cosine);
    let x = start.x * sine - start.y * cosine;
    let y = start.x * cosine + start.y * sine;
    DQuat::from_xyzw(
        v * x + w * (cosine * end.y + sine * end.x),
        v * y + w * (sine * end.y - cosine * end.x),
        w * v * sine - (x * end.x + y * end.y),
        w * v * cosine + (y * end.x - x * end.y),
    )
}

/// Turns from within rounding of the energy at the start to within less, on average, and normalises
/// what nearly is so. The constants of a polhode are rounded alike in every step, which would add
/// up. `start` is the direction of L at the start, body frame.
#[inline(always)]
fn settle<V: Vector>(orientation: Turn<V>, direction_world: V, start: V, rates: V) -> Turn<V> {
    let of = V::Number::of;
    let end = orientation.back().turn(direction_world);
    // The squares change by as much together as apart, so any one rate may be taken off all of
    // them.
    let energy = rates.dot(end.times(end));
    let gain = rates.less(energy).times(end - start).dot(end + start);
    // About L x omega, where the energy changes fastest; by no more than rounding where it hardly
    // does.
    let axis = end.cross(rates.times(end));
    let half_turn = axis * (of(0.25) * gain / (axis.dot(axis) + of(1e-5) * energy * energy));
    let Turn { vector, scalar } = orientation;
    let change = half_turn * scalar + vector.cross(half_turn);
    // Next to 1 rounding is lopsided; this sum avoids it.
    let [x, y, z] = vector.components();
    let stretch = of(0.5) * ((((of(1.0) - x * x) - y * y) - z * z) - scalar * scalar);
    Turn {
        vector: vector + (vector * stretch + change),
        scalar: scalar + (scalar * stretch - vector.dot(half_turn)),
    }
}

/// Squares of the positive nodes on [-1, 1], and weights of the mean of both signs, of Gauss's
/// rules [A&S table 25.4].
const GAUSS_6: [(f64, f64); 3] = [
    (square(0.238_619_186_083_196_9), 0.467_913_934_572_691_04),
    (square(0.661_209_386_466_264_5), 0.360_761_573_048_138_6),
    (square(0.932_469_514_203_152), 0.171_324_492_379_170_35),
];
const GAUSS_8: [(f64, f64); 4] = [
    (square(0.183_434_642_495_649_8), 0.362_683_783_378_362),
    (square(0.525_532_409_916_329), 0.313_706_645_877_887_27),
    (square(0.796_666_477_413_626_7), 0.222_381_034_453_374_48),
    (square(0.960_289_856_497_536_3), 0.101_228_536_290_376_26),
];

const fn square(x: f64) -> f64 {
    x * x
}
