//! A smooth, bounded, random, invertible displacement of space.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Value noise in three components [Perlin02]: independent random vectors at the nodes of a
/// lattice, blended between them by a polynomial of fifth degree, so that it is twice
/// differentiable. Finer octaves are added to a coarse one.
///
/// It keeps the pattern's box: a point of a wall stays in the wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Edge of the coarsest lattice's cubes, in the pattern's unit.
    pub wavelength: f64,
    /// Largest change of the displacement from one point to another, relative to the way between
    /// them: below 1, so that no two points are moved to the same place. The size of the
    /// displacement follows from it.
    pub steepness: f64,
    /// Of the random numbers.
    pub seed: u64,
}

/// Share of the steepness that each octave has, and its wavelength relative to the coarsest.
const OCTAVES: [(f64, f64); 3] = [(0.5, 1.0), (0.3, 0.5), (0.2, 0.25)];

/// Largest gradient of one component of the noise at wavelength 1, with values in [-1, 1]: half-way
/// between two nodes, where the blend has slope 15/8, and values that rise by 2 along one axis. By
/// Bessel's inequality no other values have more.
const STEEPEST: f64 = 3.75;

/// Largest slope of the window that keeps the walls, see [`Noise::displacement`].
const STEEPEST_WINDOW: f64 = 4.0;

impl Noise {
    /// Length of the longest edges of a mesh that shows the noise.
    pub(crate) fn resolution(&self) -> f64 {
        let finest = OCTAVES.iter().fold(1.0, |finest: f64, octave| finest.min(octave.1));
        0.5 * finest * self.wavelength
    }

    /// Displacement at a point of the box of `half_extent`; beyond it without the components across
    /// the nearest walls.
    pub fn displacement(&self, point: DVec3, half_extent: DVec3) -> DVec3 {
        let mut sum = DVec3::ZERO;
        let mut amplitudes = 0.0;
        for (octave, (share, relative)) in (0..).zip(OCTAVES) {
            let wavelength = relative * self.wavelength;
            let amplitude = share * wavelength / (STEEPEST * 3f64.sqrt());
            amplitudes += amplitude;
            sum += amplitude * blended(point / wavelength, self.seed.wrapping_add(octave));
        }
        // A window, 1 in the middle and 0 on the walls, holds each component back. Its slope adds
        // to the noise's.
        let place = (point / half_extent).clamp(DVec3::NEG_ONE, DVec3::ONE);
        let window = DVec3::ONE - place * place * place * place;
        let steepness = 1.0 + amplitudes * STEEPEST_WINDOW / half_extent.min_element();
        sum * window * (self.steepness / steepness)
    }

    /// No displacement is longer.
    pub(crate) fn reach(&self) -> f64 {
        let amplitudes: f64 = OCTAVES.iter().map(|(share, relative)| share * relative).sum();
        self.steepness * self.wavelength * amplitudes / STEEPEST
    }

    /// The point that is moved to `target`, by Broyden's method [Broyden65]: its displacement is a
    /// contraction, so that a step without a guess at the derivative always leads nearer.
    pub(crate) fn origin_of(&self, target: DVec3, half_extent: DVec3) -> DVec3 {
        const MOST_ROUNDS: usize = 400;
        let near = 1e-14 * half_extent.max_element();
        let beyond = |point: DVec3| point + self.displacement(point, half_extent) - target;
        // Components across walls that the target lies in stay zero.
        let mut inverse = DMat3::IDENTITY;
        let (mut point, mut off) = (target, beyond(target));
        for _ in 0..MOST_ROUNDS {
            if off.abs().max_element() <= near {
                break;
            }
            let step = -(inverse * off);
            let (next, next_off) = (point + step, beyond(point + step));
            if next_off.length_squared() > 0.5 * off.length_squared() {
                inverse = DMat3::IDENTITY;
                point -= off;
                off = beyond(point);
                continue;
            }
            let guessed = inverse * (next_off - off);
            let along = inverse.transpose() * step;
            let scale = step.dot(guessed);
            if scale != 0.0 {
                let rest = (step - guessed) / scale;
                inverse += DMat3::from_cols(rest * along.x, rest * along.y, rest * along.z);
            }
            (point, off) = (next, next_off);
        }
        point
    }
}

/// The noise of one lattice of unit cubes.
fn blended(point: DVec3, seed: u64) -> DVec3 {
    let low = point.floor();
    let place = point - low;
    let weight = place * place * place * (place * (place * 6.0 - 15.0) + 10.0);
    let corner = |x: f64, y: f64, z: f64| random_vector(low + DVec3::new(x, y, z), seed);
    let along_x = |y: f64, z: f64| corner(0.0, y, z).lerp(corner(1.0, y, z), weight.x);
    let along_y = |z: f64| along_x(0.0, z).lerp(along_x(1.0, z), weight.y);
    along_y(0.0).lerp(along_y(1.0), weight.z)
}

/// A vector in [-1, 1)^3 for a node: three thirds of its number, well mixed.
fn random_vector(node: DVec3, seed: u64) -> DVec3 {
    let mut bits = mixed(seed);
    for coordinate in node.to_array() {
        bits = mixed(bits ^ (coordinate as i64 as u64));
    }
    let third = |shift: u32| ((bits >> shift) & 0x1f_ffff) as f64 / f64::from(1 << 20) - 1.0;
    DVec3::new(third(0), third(21), third(42))
}

/// One step of SplitMix64 [SLF14].
fn mixed(state: u64) -> u64 {
    let z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// Two points are never moved apart or together by more than the steepness says, near and
        /// far.
        #[test]
        fn the_steepness_bounds_the_change(
            a in point(), way in point(), exponent in -4..1i32, steepness in 0.1..0.95f64,
            wavelength in 0.1..2.0f64, seed in 0..1000u64, z in 0.2..1.0f64,
        ) {
            let half_extent = DVec3::new(1.0, 0.7, z);
            let noise = Noise { wavelength, steepness, seed };
            let b = a + way * 10f64.powi(exponent);
            let change = noise.displacement(a, half_extent) - noise.displacement(b, half_extent);
            prop_assert!(change.length() <= steepness * a.distance(b) + 1e-15);
        }

        #[test]
        fn walls_stay_and_the_origin_is_found(p in point(), wall in 0..3usize, seed in 0..1000u64) {
            let half_extent = DVec3::new(1.0, 0.7, 0.5);
            let noise = Noise { wavelength: 0.5, steepness: 0.9, seed };
            let mut target = p * half_extent;
            target[wall] = half_extent[wall];
            let origin = noise.origin_of(target, half_extent);
            prop_assert_eq!(origin[wall], half_extent[wall]);
            prop_assert!((origin + noise.displacement(origin, half_extent)).distance(target) < 1e-13);
        }
    }

    /// It is no idle bound: among random points the displacement changes by more than a fifth of
    /// it, and its size is a few hundredths of the wavelength.
    #[test]
    fn the_noise_is_there() {
        let noise = Noise { wavelength: 0.5, steepness: 1.0, seed: 3 };
        let (mut steepest, mut largest) = (0.0f64, 0.0f64);
        for n in 0..20_000 {
            let a = 0.8 * random_vector(DVec3::splat(f64::from(n)), 1);
            let b = a + 1e-4 * random_vector(DVec3::splat(f64::from(n)), 2);
            let at_a = noise.displacement(a, DVec3::ONE);
            let change = at_a - noise.displacement(b, DVec3::ONE);
            steepest = steepest.max(change.length() / a.distance(b));
            largest = largest.max(at_a.length());
        }
        assert!(steepest > 0.2, "{steepest}");
        assert!((0.01..0.2).contains(&largest), "{largest}");
    }
}
