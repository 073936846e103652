//! Jacobi's elliptic functions over a short time, for any parameter m in [0, 1] without loss of
//! digits [Abramowitz & Stegun, ch. 16 to 18].

/// The series of `(rate t)^2 ns^2(rate t)`, with ns = 1/sn, in terms of `rate^2` and `m rate^2`; so
/// neither a small rate nor an m near 0 or 1 is a special case. With it the functions are, up to
/// signs, `sn^2 = (rate t)^2 / series`, `cn^2 = 1 - sn^2` and `dn^2 = 1 - m sn^2`.
#[derive(Clone, Copy, Debug)]
pub struct Series {
    coefficients: [f64; 9],
}

impl Series {
    /// Largest |rate t| at which the first term that nine terms omit is below rounding.
    pub const REACH: f64 = 0.4;
    /// The same for six terms.
    pub const SHORT_REACH: f64 = 0.15;

    /// From `rate^2` and `m rate^2`, the latter no more than the former.
    #[inline]
    pub fn new(a: f64, b: f64) -> Self {
        // rate^2 ns^2 is Weierstrass's function plus (a + b)/3, with g2 = 20 c2, g3 = 28 c3 and c_k
        // = 3 / ((2k + 1)(k - 3)) sum c_j c_{k-j} [A&S 18.5.2, 18.5.3, 18.9]. Its series converges
        // for
        // |rate t| < pi, twice as far as that of sn.
        let c2 = (a * a - a * b + b * b) * (1.0 / 15.0);
        let c3 = (a + b) * (2.0 * a - b) * (a - 2.0 * b) * (1.0 / 189.0);
        let c4 = c2 * c2 * (1.0 / 3.0);
        let c5 = c2 * c3 * (3.0 / 11.0);
        let c6 = (2.0 * c2 * c4 + c3 * c3) * (1.0 / 13.0);
        let c7 = (c2 * c5 + c3 * c4) * (1.0 / 10.0);
        let c8 = (2.0 * (c2 * c6 + c3 * c5) + c4 * c4) * (3.0 / 85.0);
        let c9 = (c2 * c7 + c3 * c6 + c4 * c5) * (1.0 / 19.0);
        Self { coefficients: [(a + b) * (1.0 / 3.0), c2, c3, c4, c5, c6, c7, c8, c9] }
    }

    /// Sum of the first `TERMS` terms.
    #[inline]
    pub fn at<const TERMS: usize>(&self, t_squared: f64) -> f64 {
        let terms = self.coefficients[..TERMS].iter().rev();
        1.0 + t_squared * terms.fold(0.0, |sum, coefficient| sum * t_squared + coefficient)
    }
}

/// Arithmetic-geometric mean of a and b, `a >= b > 0`: the quarter period is `K = pi / (2 agm(1,
/// sqrt(1 - m)))` [A&S 17.6].
#[inline]
pub fn arithmetic_geometric_mean(mut a: f64, mut b: f64) -> f64 {
    while a - b > 1e-8 * a {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    // Half of the digits agree, and each step doubles that.
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sn is sin at m = 0 and tanh at m = 1; in between it is as mpmath has it to 20 digits.
    #[test]
    fn sn_meets_its_limits_and_tabulated_values() {
        let sn = |m: f64, u: f64, rate: f64| {
            let t = u / rate;
            let series = Series::new(rate * rate, m * rate * rate);
            let sum = if u.abs() <= Series::SHORT_REACH {
                series.at::<6>(t * t)
            } else {
                series.at::<9>(t * t)
            };
            u / sum.sqrt()
        };
        for i in 0..=80 {
            let u = 0.01 * f64::from(i) - 0.4;
            for rate in [1.0, 1e-6, 30.0] {
                assert!((sn(0.0, u, rate) - libm::sin(u)).abs() <= 2e-16, "{u}");
                assert!((sn(1.0, u, rate) - libm::tanh(u)).abs() <= 2e-16, "{u}");
            }
        }
        for (m, u, expected) in SN {
            assert!((sn(m, u, 7.0) - expected).abs() <= 2e-16, "m {m}, u {u}");
        }
    }

    const SN: [(f64, f64, f64); 6] = [
        (0.1, 0.15, 0.149_382_769_723_515_3),
        (0.1, 0.4, 0.388_467_294_050_244_27),
        (0.5, 0.15, 0.149_161_436_222_347_1),
        (0.5, 0.4, 0.384_672_195_845_938_9),
        (0.9, 0.15, 0.148_940_290_658_605_06),
        (0.9, 0.4, 0.380_891_762_070_405),
    ];

    /// K(0) = pi/2, K(1/2) = Gamma(1/4)^2 / (4 sqrt(pi)) [A&S 17.3], K = ln(4 / sqrt(1 - m)) as m
    /// goes to 1.
    #[test]
    fn quarter_period_meets_its_closed_forms() {
        let lemniscate = libm::tgamma(0.25).powi(2) / (4.0 * std::f64::consts::PI.sqrt());
        for (complement, expected) in [
            (1.0_f64, std::f64::consts::FRAC_PI_2),
            (0.5, lemniscate),
            (1e-30, libm::log(4e15)),
            (1e-200, libm::log(4e100)),
        ] {
            let period =
                std::f64::consts::FRAC_PI_2 / arithmetic_geometric_mean(1.0, complement.sqrt());
            assert!(
                (period / expected - 1.0).abs() < 1e-15,
                "{complement}: {period} is not {expected}"
            );
        }
    }
}
