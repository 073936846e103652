//! The contact of two pieces, and how its flat parts add up.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The contact of two pieces of one break, before they move apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interface {
    /// Number of one piece.
    pub a: usize,
    /// Number of the other, larger.
    pub b: usize,
    /// [m^2], positive.
    pub area: f64,
    /// Mean of the contact's points, parent's body frame [m].
    pub centroid: DVec3,
    /// Unit normal of the contact, from `a` to `b`; the mean over a contact that is not flat.
    /// Parent's body frame.
    pub normal: DVec3,
}

/// The flat parts of all contacts, summed up for each pair.
#[derive(Default)]
pub(crate) struct Contacts {
    of_pair: BTreeMap<(usize, usize), Sum>,
}

/// Additive part of an interface.
#[derive(Clone, Copy, Default)]
struct Sum {
    /// [m^2]
    area: f64,
    /// Area times centroid [m^3].
    moment: DVec3,
    /// Normal times area, from `a` to `b` [m^2].
    vector: DVec3,
}

impl Contacts {
    /// Takes in a flat part: its vector area [m^2] from `a` to `b`, and its centroid [m].
    pub(crate) fn add(&mut self, (a, b): (usize, usize), vector: DVec3, centroid: DVec3) {
        let sum = self.of_pair.entry((a, b)).or_default();
        let area = vector.length();
        sum.area += area;
        sum.moment += area * centroid;
        sum.vector += vector;
    }

    /// One for each pair. A contact that closes upon itself has no mean normal; any direction is as
    /// good there.
    pub(crate) fn into_interfaces(self) -> Vec<Interface> {
        self.of_pair
            .into_iter()
            .filter(|(_, sum)| sum.area > 0.0)
            .map(|((a, b), sum)| Interface {
                a,
                b,
                area: sum.area,
                centroid: sum.moment / sum.area,
                normal: sum.vector.try_normalize().unwrap_or(DVec3::Y),
            })
            .collect()
    }
}
