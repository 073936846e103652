//! Cross-sections: how the points of a contact spread about their centroid.

use frangible_geometry::outer;
use frangible_math::RigidTransform;
use frangible_math::check::{Check, Checked, finite_vector};
use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Corners of the rim of a contact of which the area alone is known.
const ROUND_CORNERS: usize = 16;

/// What bends and twists a contact: its second moments and its rim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrossSection {
    /// Integral of `r r^T` over the contact, `r` from its centroid to its points [m^4].
    pub second_moment: DMat3,
    /// Corners of its convex hull, from its centroid [m]. The largest stress of bending is at one
    /// of them.
    pub rim: Vec<DVec3>,
}

impl Check for CrossSection {
    fn check(&self) -> Checked {
        let axes = self.second_moment.to_cols_array_2d().map(DVec3::from_array);
        axes.iter().chain(&self.rim).try_for_each(|&vector| finite_vector(vector))
    }
}

/// A flat part of a contact.
#[derive(Clone, Debug)]
pub(crate) struct FlatPart {
    /// Normal times area, from the first piece to the second [m^2].
    pub vector: DVec3,
    /// [m]
    pub centroid: DVec3,
    pub section: CrossSection,
}

impl CrossSection {
    /// Of a square of which only the area [m^2] and the normal are known, not the sides: it bends
    /// about all axes as about one along a side.
    pub fn square(area: f64, normal: DVec3) -> Self {
        let (across, along) = normal.any_orthonormal_pair();
        let plane = outer(across, across) + outer(along, along);
        let half = 0.5 * area.sqrt();
        let corner = |number: usize| {
            let angle = TAU * number as f64 / ROUND_CORNERS as f64;
            half * (libm::cos(angle) * across + libm::sin(angle) * along)
        };
        Self {
            second_moment: plane * (area * area / 12.0),
            rim: (0..ROUND_CORNERS).map(corner).collect(),
        }
    }

    /// In another frame.
    pub fn turned(&self, to_from_here: &RigidTransform) -> Self {
        let turn = DMat3::from_quat(to_from_here.rotation);
        Self {
            second_moment: turn * self.second_moment * turn.transpose(),
            rim: self.rim.iter().map(|&corner| turn * corner).collect(),
        }
    }

    /// Keeps the corners of the convex hull, seen along a normal.
    pub(crate) fn with_convex_rim(mut self, normal: DVec3) -> Self {
        let (across, along) = normal.any_orthonormal_pair();
        let plane = |point: DVec3| DVec2::new(across.dot(point), along.dot(point));
        self.rim = convex_hull(&self.rim, plane);
        self
    }
}

impl FlatPart {
    /// A convex polygon with this unit normal; `None` without area.
    pub(crate) fn of_polygon(polygon: &[DVec3], normal: DVec3) -> Option<Self> {
        let sides = polygon.iter().copied().zip(polygon.iter().copied().skip(1));
        Self::of_sides(sides.map(|(from, to)| [from, to]), normal)
    }

    /// Polygons of any form, with holes, by their directed edges around this unit normal; edges at
    /// the first corner may be left out. `None` without area.
    pub(crate) fn of_sides(
        sides: impl Iterator<Item = [DVec3; 2]> + Clone,
        normal: DVec3,
    ) -> Option<Self> {
        let [apex, _] = sides.clone().next()?;
        let (mut area, mut moment, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
        for [from, to] in sides.clone() {
            let (one, other) = (from - apex, to - apex);
            let part = 0.5 * one.cross(other).dot(normal);
            area += part;
            moment += part * (one + other) / 3.0;
            let sum = one + other;
            second += (outer(one, one) + outer(other, other) + outer(sum, sum)) * (part / 12.0);
        }
        if area <= 0.0 {
            return None;
        }
        let from_apex = moment / area;
        let centroid = apex + from_apex;
        let corners = std::iter::once(apex).chain(sides.map(|[_, to]| to));
        Some(Self {
            vector: area * normal,
            centroid,
            section: CrossSection {
                second_moment: second - outer(from_apex, from_apex) * area,
                rim: corners.map(|corner| corner - centroid).collect(),
            },
        })
    }
}

/// The farthest of many points in each of some directions, all around: along axes and diagonals.
/// Corners of rectangles are among them, however they lie; between those of a disc it lacks a few
/// percent of its radius.
#[derive(Clone)]
pub(crate) struct Farthest([[(f64, DVec3); 2]; FARTHEST.len()]);

/// One of each two opposite directions.
const FARTHEST: [DVec3; 13] = [
    DVec3::new(1.0, 0.0, 0.0),
    DVec3::new(0.0, 1.0, 0.0),
    DVec3::new(0.0, 0.0, 1.0),
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(1.0, -1.0, 0.0),
    DVec3::new(1.0, 0.0, 1.0),
    DVec3::new(1.0, 0.0, -1.0),
    DVec3::new(0.0, 1.0, 1.0),
    DVec3::new(0.0, 1.0, -1.0),
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
];

impl Default for Farthest {
    fn default() -> Self {
        let none = [(f64::INFINITY, DVec3::ZERO), (f64::NEG_INFINITY, DVec3::ZERO)];
        Self([none; FARTHEST.len()])
    }
}

impl Farthest {
    pub(crate) fn add(&mut self, point: DVec3) {
        for (direction, [low, high]) in FARTHEST.iter().zip(&mut self.0) {
            let along = direction.dot(point);
            if along < low.0 {
                *low = (along, point);
            }
            if along > high.0 {
                *high = (along, point);
            }
        }
    }

    /// From a centroid.
    pub(crate) fn rim(&self, centroid: DVec3) -> Vec<DVec3> {
        let found = self.0.iter().flatten().filter(|(along, _)| along.is_finite());
        found.map(|&(_, point)| point - centroid).collect()
    }
}

/// The corners of the convex hull of points in a plane, by monotone chains [And79].
fn convex_hull(points: &[DVec3], plane: impl Fn(DVec3) -> DVec2) -> Vec<DVec3> {
    let mut order: Vec<(DVec2, DVec3)> =
        points.iter().map(|&point| (plane(point), point)).collect();
    order.sort_by(|(a, _), (b, _)| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    order.dedup_by(|a, b| a.0 == b.0);
    if order.len() < 3 {
        return order.into_iter().map(|(_, point)| point).collect();
    }
    let mut hull: Vec<(DVec2, DVec3)> = Vec::with_capacity(order.len() + 1);
    let mut chain = |ordered: &mut dyn Iterator<Item = &(DVec2, DVec3)>| {
        let begin = hull.len();
        for &next in ordered {
            while let [.., (a, _), (b, _)] = &hull[begin..]
                && (*b - *a).perp_dot(next.0 - *a) <= 0.0
            {
                hull.pop();
            }
            hull.push(next);
        }
        // The last point begins the other chain.
        hull.pop();
    };
    chain(&mut order.iter());
    chain(&mut order.iter().rev());
    hull.into_iter().map(|(_, point)| point).collect()
}
