//! Where the body is that cracks go through.

use crate::polygon;
use frangible_geometry::{ClosedForm, GridSolid, HalfSpace, Root};
use glam::DVec3;

/// Parent's surface as the limit of cracks.
pub(crate) struct Parent<'a> {
    /// The flat pieces of the parent's surface, and the box of its grid.
    pub(super) walls: Vec<HalfSpace>,
    curved: Curved<'a>,
}

/// Curved parts of the parent's surface.
enum Curved<'a> {
    Nothing,
    /// Around the origin.
    Sphere {
        radius: f64,
    },
    /// Around the y axis.
    Cylinder {
        radius: f64,
    },
    /// A sampled surface.
    Sampled(&'a GridSolid),
}

impl<'a> Parent<'a> {
    pub(crate) fn new(solid: &'a GridSolid) -> Self {
        let mut walls = solid.outline.cuts.clone();
        let of_root = match &solid.outline.root {
            Root::ClosedForm(ClosedForm::Box { half }) => {
                walls.extend(polygon::box_half_spaces(-half, *half));
                Curved::Nothing
            }
            Root::ClosedForm(ClosedForm::Cylinder { half_height, radius }) => {
                let caps = [DVec3::Y, DVec3::NEG_Y];
                walls.extend(caps.map(|normal| HalfSpace { normal, offset: *half_height }));
                Curved::Cylinder { radius: *radius }
            }
            Root::ClosedForm(ClosedForm::HalfSpace(half_space)) => {
                walls.push(*half_space);
                Curved::Nothing
            }
            Root::Hull(hull) => {
                walls.extend(hull.planes());
                Curved::Nothing
            }
            Root::ClosedForm(ClosedForm::Sphere { radius }) => Curved::Sphere { radius: *radius },
            Root::ClosedForm(ClosedForm::Capsule { .. } | ClosedForm::Cone { .. })
            | Root::Sampled(_) => Curved::Sampled(solid),
        };
        let (low, high) = solid.grid().bounds();
        walls.extend(polygon::box_half_spaces(low, high));
        // Merged slivers make a convex body non-convex.
        let curved = if solid.is_convex() { of_root } else { Curved::Sampled(solid) };
        Self { walls, curved }
    }

    /// True for a polyhedral surface.
    pub(super) fn is_flat(&self) -> bool {
        matches!(self.curved, Curved::Nothing)
    }

    /// True for planes known to miss the parent.
    pub(super) fn misses(&self, plane: &HalfSpace) -> bool {
        match self.curved {
            Curved::Sphere { radius } => plane.offset.abs() > radius,
            Curved::Cylinder { .. } | Curved::Nothing | Curved::Sampled(_) => false,
        }
    }

    /// Signed distance [m] where only samples know it.
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        match self.curved {
            Curved::Sampled(solid) => f64::from(solid.value(point)),
            Curved::Sphere { radius } => point.length() - radius,
            Curved::Cylinder { radius } => (point.x * point.x + point.z * point.z).sqrt() - radius,
            Curved::Nothing => f64::NEG_INFINITY,
        }
    }

    /// Outward normal at a point of the curved surface.
    fn normal(&self, point: DVec3) -> DVec3 {
        match self.curved {
            Curved::Sampled(solid) => solid.value_and_gradient(point).1.as_dvec3(),
            Curved::Cylinder { .. } => DVec3::new(point.x, 0.0, point.z),
            Curved::Sphere { .. } | Curved::Nothing => point,
        }
    }

    /// True if a line along `along` crosses the surface more steeply than a line along `across`.
    pub(super) fn crosses_rim(&self, point: DVec3, along: DVec3, across: DVec3) -> bool {
        let normal = self.normal(point);
        normal.dot(along).abs() >= normal.dot(across).abs()
    }

    /// The stretches of a line between two points that lie inside, as fractions of the way.
    #[inline(always)]
    pub(super) fn inside(
        &self,
        start: DVec3,
        end: DVec3,
        spacing: f64,
        stretches: &mut Vec<[f64; 2]>,
    ) {
        stretches.clear();
        let way = end - start;
        let flat = DVec3::new(1.0, 0.0, 1.0);
        match self.curved {
            Curved::Nothing => stretches.push([0.0, 1.0]),
            Curved::Sphere { radius } => stretches.extend(within_ball(start, way, radius)),
            Curved::Cylinder { radius } => {
                stretches.extend(within_ball(start * flat, way * flat, radius))
            }
            Curved::Sampled(_) => self.inside_samples(start, way, spacing, stretches),
        }
    }

    /// Inside test against samples only.
    fn inside_samples(
        &self,
        start: DVec3,
        way: DVec3,
        spacing: f64,
        stretches: &mut Vec<[f64; 2]>,
    ) {
        let steps = (way.length() / spacing).ceil().max(1.0) as usize;
        let mut last = (0.0, self.distance(start));
        let mut entry = (last.1 <= 0.0).then_some(0.0);
        for step in 1..=steps {
            let at = step as f64 / steps as f64;
            let here = (at, self.distance(start + way * at));
            if last.1 <= 0.0 && here.1 > 0.0 {
                let exit = self.bisect(start, way, [last.0, here.0]);
                stretches.extend(entry.take().map(|entry| [entry, exit]));
            } else if last.1 > 0.0 && here.1 <= 0.0 {
                entry = Some(self.bisect(start, way, [here.0, last.0]));
            }
            last = here;
        }
        stretches.extend(entry.map(|entry| [entry, 1.0]));
    }

    /// Surface crossing of a line between an inside and an outside fraction.
    fn bisect(&self, start: DVec3, way: DVec3, [mut inside, mut outside]: [f64; 2]) -> f64 {
        // From the distance between samples to a hundredth of a percent of it.
        const HALVINGS: usize = 13;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if self.distance(start + way * middle) <= 0.0 {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }
}

/// The part of a line from `start` along `way` within a ball around the origin, as fractions of the
/// way in [0, 1].
#[inline]
fn within_ball(start: DVec3, way: DVec3, radius: f64) -> Option<[f64; 2]> {
    let square = way.length_squared();
    let half = start.dot(way);
    let beyond = start.length_squared() - radius * radius;
    if square <= 1e-24 * radius * radius {
        return (beyond <= 0.0).then_some([0.0, 1.0]);
    }
    let root = (half * half - square * beyond).max(0.0).sqrt();
    let (from, to) = (((-half - root) / square).max(0.0), ((-half + root) / square).min(1.0));
    (from < to).then_some([from, to])
}
