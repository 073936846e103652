//! The contact of two pieces, and how its flat parts add up.

use crate::interfaces::cross_section::{CrossSection, FlatPart};
use frangible_geometry::outer;
use frangible_math::RigidTransform;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The contact of two pieces of one break, before they move apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// How its points spread about the centroid, parent's body frame.
    #[serde(with = "frangible_math::shared")]
    pub section: Arc<CrossSection>,
}

impl Interface {
    /// In another frame.
    pub(crate) fn placed(&self, to_from_here: &RigidTransform) -> Self {
        Self {
            centroid: to_from_here.point(self.centroid),
            normal: to_from_here.direction(self.normal),
            section: Arc::new(self.section.turned(to_from_here)),
            ..*self
        }
    }

    /// As a part of a larger contact.
    pub(crate) fn flat_part(&self) -> FlatPart {
        FlatPart {
            vector: self.area * self.normal,
            centroid: self.centroid,
            section: CrossSection::clone(&self.section),
        }
    }
}

/// The flat parts of all contacts, summed up for each pair.
#[derive(Default)]
pub(crate) struct Contacts {
    of_pair: BTreeMap<(usize, usize), Sum>,
}

/// Additive part of an interface.
struct Sum {
    /// [m^2]
    area: f64,
    /// [m]
    centroid: DVec3,
    /// Normal times area, from `a` to `b` [m^2].
    vector: DVec3,
    /// About the centroid [m^4].
    second_moment: DMat3,
    /// Corners of the parts [m].
    rim: Vec<DVec3>,
}

impl Default for Sum {
    fn default() -> Self {
        Self {
            area: 0.0,
            centroid: DVec3::ZERO,
            vector: DVec3::ZERO,
            second_moment: DMat3::ZERO,
            rim: Vec::new(),
        }
    }
}

impl Contacts {
    /// Takes in a flat part, whose vector points from `a` to `b`.
    pub(crate) fn add(&mut self, (a, b): (usize, usize), part: FlatPart) {
        let FlatPart { vector, centroid, section } = part;
        let sum = self.of_pair.entry((a, b)).or_default();
        let area = vector.length();
        if area <= 0.0 {
            return;
        }
        let between = centroid - sum.centroid;
        let whole = sum.area + area;
        sum.second_moment +=
            section.second_moment + outer(between, between) * (sum.area * area / whole);
        sum.centroid += between * (area / whole);
        sum.area = whole;
        sum.vector += vector;
        sum.rim.extend(section.rim.into_iter().map(|corner| centroid + corner));
    }

    /// One for each pair. A contact that closes upon itself has no mean normal; any direction is as
    /// good there.
    pub(crate) fn into_interfaces(self) -> Vec<Interface> {
        self.of_pair
            .into_iter()
            .filter(|(_, sum)| sum.area > 0.0)
            .map(|((a, b), Sum { area, centroid, vector, second_moment, rim })| {
                let normal = vector.try_normalize().unwrap_or(DVec3::Y);
                let rim = rim.into_iter().map(|corner| corner - centroid).collect();
                let section = CrossSection { second_moment, rim }.with_convex_rim(normal);
                Interface { a, b, area, centroid, normal, section: Arc::new(section) }
            })
            .collect()
    }
}
