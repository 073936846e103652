//! Clusters of surface samples, for culling.

use frangible_math::check::{Check, Checked, finite_singles, require};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// Neighbouring samples and a ball around them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampleCluster {
    /// Index of the first sample; the others follow it.
    pub first: u32,
    /// Number of samples.
    pub count: u32,
    /// Of the ball [m].
    pub center: Vec3,
    /// Of the ball [m].
    pub radius: f32,
}

/// Samples in one cluster: a ball costs as much to test as a sample, and smaller clusters fit the
/// surface better.
const CLUSTER: usize = 16;

/// Sorts samples along a space-filling curve [Mor66] and cuts the row into clusters.
pub(crate) fn cluster_samples(samples: &mut Vec<Vec3>) -> Vec<SampleCluster> {
    // Sort by the Morton code in the samples' box; equal codes keep their order.
    let (low, high) = bounds_of(samples);
    let scale = 1023.0 / (high - low).max_element().max(f32::MIN_POSITIVE);
    let mut coded: Vec<(u32, Vec3)> =
        samples.iter().map(|&sample| (morton_code((sample - low) * scale), sample)).collect();
    coded.sort_by_key(|&(code, _)| code);
    samples.clear();
    samples.extend(coded.into_iter().map(|(_, sample)| sample));

    let chunks = samples.chunks(CLUSTER).enumerate();
    chunks.map(|(index, chunk)| SampleCluster::around((index * CLUSTER) as u32, chunk)).collect()
}

/// Lowest and highest corner of the box around some points; infinite and the wrong way round
/// without any.
pub(crate) fn bounds_of(points: &[Vec3]) -> (Vec3, Vec3) {
    // Four points at a time fill lanes.
    let (mut lows, mut highs) = ([f32::INFINITY; 12], [f32::NEG_INFINITY; 12]);
    let fours = points.chunks_exact(4);
    let rest = fours.remainder();
    for four in fours {
        let [a, b, c, d] = [four[0], four[1], four[2], four[3]];
        let all = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z];
        for n in 0..12 {
            lows[n] = if all[n] < lows[n] { all[n] } else { lows[n] };
            highs[n] = if all[n] > highs[n] { all[n] } else { highs[n] };
        }
    }
    let less = |a: f32, b: f32| if a < b { a } else { b };
    let more = |a: f32, b: f32| if a > b { a } else { b };
    let along = |n: usize| less(less(lows[n], lows[n + 3]), less(lows[n + 6], lows[n + 9]));
    let low = Vec3::new(along(0), along(1), along(2));
    let along = |n: usize| more(more(highs[n], highs[n + 3]), more(highs[n + 6], highs[n + 9]));
    let high = Vec3::new(along(0), along(1), along(2));
    rest.iter().fold((low, high), |(low, high), &point| (low.min(point), high.max(point)))
}

impl SampleCluster {
    /// The cluster of some samples, the first of which has the index `first`.
    fn around(first: u32, samples: &[Vec3]) -> Self {
        let (low, high) = bounds_of(samples);
        let center = 0.5 * (low + high);
        let square = samples.iter().fold(0.0_f32, |largest, &sample| {
            let square = sample.distance_squared(center);
            if square > largest { square } else { largest }
        });
        // The root of a square rounds: the ball holds them all.
        let radius = square.sqrt() * (1.0 + 2.0 * f32::EPSILON);
        Self { first, count: samples.len() as u32, center, radius }
    }
}

/// Samples and their clusters, collected in an order that goes from one neighbourhood to the next.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ClusteredSamples {
    /// In one frame [m].
    pub samples: Vec<Vec3>,
    /// All samples, in the same order.
    pub clusters: Vec<SampleCluster>,
}

/// Samples that were given, or that are made when somebody first asks: only the former are written
/// to a snapshot.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(from = "Option<ClusteredSamples>")]
pub(crate) struct LazySamples {
    given: Option<ClusteredSamples>,
    #[serde(skip)]
    made: OnceLock<ClusteredSamples>,
}

impl From<Option<ClusteredSamples>> for LazySamples {
    fn from(given: Option<ClusteredSamples>) -> Self {
        Self { given, made: OnceLock::new() }
    }
}

impl Check for ClusteredSamples {
    fn check(&self) -> Checked {
        self.samples.iter().try_for_each(|&sample| finite_singles(sample))?;
        self.clusters.iter().try_for_each(|cluster| {
            let end = u64::from(cluster.first) + u64::from(cluster.count);
            require(end <= self.samples.len() as u64, "clusters of samples that there are")?;
            finite_singles(cluster.center)?;
            require(cluster.radius.is_finite(), "clusters with a radius")
        })
    }
}

impl Check for LazySamples {
    fn check(&self) -> Checked {
        self.given.as_ref().map_or(Ok(()), Check::check)
    }
}

impl LazySamples {
    /// True if they need not be made.
    pub(crate) fn are_given(&self) -> bool {
        self.given.is_some()
    }

    pub(crate) fn given(samples: ClusteredSamples) -> Self {
        Some(samples).into()
    }

    /// Those given, or those that `make` makes.
    #[inline]
    pub(crate) fn get_or_make(&self, make: impl FnOnce() -> ClusteredSamples) -> &ClusteredSamples {
        match &self.given {
            Some(samples) => samples,
            None => self.made.get_or_init(make),
        }
    }
}

impl ClusteredSamples {
    /// In the order of a space-filling curve.
    pub fn new(mut samples: Vec<Vec3>) -> Self {
        let clusters = cluster_samples(&mut samples);
        Self { samples, clusters }
    }

    /// Adds one of another shape's clusters as it is: its samples and its ball, moved.
    pub fn push_cluster(&mut self, samples: impl Iterator<Item = Vec3>, center: Vec3, radius: f32) {
        let first = self.samples.len() as u32;
        self.samples.extend(samples);
        let count = self.samples.len() as u32 - first;
        // Enlarge the ball by the rounding error of moved samples.
        let radius = radius + 4.0 * f32::EPSILON * (center.length() + radius);
        self.clusters.push(SampleCluster { first, count, center, radius });
    }

    /// Clusters the samples appended since the last cluster.
    pub fn cluster_rest(&mut self) {
        let mut first = self.clusters.last().map_or(0, |last| last.first + last.count) as usize;
        while first < self.samples.len() {
            let end = (first + CLUSTER).min(self.samples.len());
            self.clusters.push(SampleCluster::around(first as u32, &self.samples[first..end]));
            first = end;
        }
    }
}

/// The bits of three coordinates in [0, 1024), interleaved.
fn morton_code(point: Vec3) -> u32 {
    spread(point.x as u32) | spread(point.y as u32) << 1 | spread(point.z as u32) << 2
}

/// Two zeros before each of the ten lowest bits.
fn spread(bits: u32) -> u32 {
    let bits = bits.min(1023);
    let bits = (bits | bits << 16) & 0x0300_00ff;
    let bits = (bits | bits << 8) & 0x0300_f00f;
    let bits = (bits | bits << 4) & 0x030c_30c3;
    (bits | bits << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Every sample is in one cluster, and in its ball.
        #[test]
        fn clusters_hold_all_samples(points in prop::collection::vec(prop::array::uniform3(-5.0..5.0f32), 0..200)) {
            let mut samples: Vec<Vec3> = points.iter().map(|&point| Vec3::from_array(point)).collect();
            let clusters = cluster_samples(&mut samples);
            let mut next = 0;
            for cluster in clusters {
                prop_assert_eq!(cluster.first, next);
                next += cluster.count;
                for sample in &samples[cluster.first as usize..next as usize] {
                    prop_assert!(sample.distance(cluster.center) <= cluster.radius);
                }
            }
            prop_assert_eq!(next as usize, points.len());
            let key = |point: &Vec3| point.to_array().map(f32::to_bits);
            let mut before: Vec<_> = points.iter().map(|&point| key(&Vec3::from_array(point))).collect();
            let mut after: Vec<_> = samples.iter().map(key).collect();
            before.sort_unstable();
            after.sort_unstable();
            prop_assert_eq!(before, after);
        }
    }

    #[test]
    fn the_curve_visits_one_octant_after_the_other() {
        assert_eq!(morton_code(Vec3::new(1.0, 0.0, 0.0)), 1);
        assert_eq!(morton_code(Vec3::new(0.0, 1.0, 0.0)), 2);
        assert_eq!(morton_code(Vec3::new(3.0, 3.0, 3.0)), 63);
        assert_eq!(morton_code(Vec3::splat(1023.0)), (1 << 30) - 1);
    }
}
