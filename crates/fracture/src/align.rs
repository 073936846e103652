//! Aligns a pattern with a body, to break it around the point of impact [Su09 sec. 4.1].

use crate::pattern::Pattern;
use crate::pattern::region::Region;
use crate::placement::Placement;
use crate::shatter::settings::ShatterSettings;
use frangible_geometry::Shape;
use glam::{DMat3, DVec3};

/// Where a body is struck, in its own body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// The impact point [m].
    pub point_body: DVec3,
    /// The collision normal: a unit vector that points out of the struck body, towards the striker.
    pub normal_body: DVec3,
}

impl Placement {
    /// The fracture centre on the impact point, the pattern's z axis along the normal, and its box
    /// as small as encloses the body.
    ///
    /// The twist about the normal is free. The pattern's x axis follows the grid axis along which
    /// the body is longest across the normal, so that long pieces of a pattern lie along a long
    /// body, and equal blows break equally. A magnified pattern's box is larger by as much.
    pub fn new(pattern: &Pattern, impact: &Impact, struck: &Shape) -> Self {
        Self::with(pattern, impact, struck, &ShatterSettings::default())
    }

    /// The same, twisted; and for a break with a reach the box around that, if it is smaller.
    pub fn with(
        pattern: &Pattern,
        impact: &Impact,
        struck: &Shape,
        settings: &ShatterSettings,
    ) -> Self {
        let (impact_grid, corners_grid) = in_grid_frame(impact, struck);
        let mut placement = Self::twisted(pattern, &impact_grid, &corners_grid, settings.twist);
        if pattern.scale.is_none()
            && let Some(scale) = settings.reach.and_then(|reach| reach.scale(pattern))
        {
            placement.scale = placement.scale.min(scale * pattern.magnification);
        }
        placement
    }

    /// The same for a body of which only the corners of a box around it are known, in the frame of
    /// the impact: the grid frame is that one.
    pub fn around(pattern: &Pattern, impact: &Impact, corners_grid: &[DVec3; 8]) -> Self {
        Self::twisted(pattern, impact, corners_grid, 0.0)
    }

    /// The axes along which a pattern lies on a body, and the impact, in its grid frame.
    pub(crate) fn axes(impact: &Impact, struck: &Shape, twist: f64) -> (DMat3, Impact) {
        let (impact_grid, corners_grid) = in_grid_frame(impact, struck);
        (Self::axes_around(&impact_grid, &corners_grid, twist), impact_grid)
    }

    /// The same of a box around a body.
    pub(crate) fn axes_around(impact: &Impact, corners_grid: &[DVec3; 8], twist: f64) -> DMat3 {
        let z = impact.normal_body.normalize();
        let mut x = longest_axis_across(z, corners_grid);
        if twist != 0.0 {
            x = libm::cos(twist) * x + libm::sin(twist) * z.cross(x);
        }
        DMat3::from_cols(x, z.cross(x), z)
    }

    fn twisted(pattern: &Pattern, impact: &Impact, corners_grid: &[DVec3; 8], twist: f64) -> Self {
        let point_grid = impact.point_body;
        let grid_from_pattern = Self::axes_around(impact, corners_grid, twist);
        if let Some(scale) = pattern.scale {
            return Self { grid_from_pattern, scale, center_pattern: pattern.center, point_grid };
        }

        // The scale at which the farthest corner reaches the wall of the box on its side.
        let mut scale = 0.0f64;
        for &corner in corners_grid {
            let reach = grid_from_pattern.transpose() * (corner - point_grid);
            let to_upper = reach / (pattern.half_extent - pattern.center);
            let to_lower = -reach / (pattern.half_extent + pattern.center);
            scale = scale.max(to_upper.max(to_lower).max_element());
        }
        scale *= pattern.magnification;
        Self { grid_from_pattern, scale, center_pattern: pattern.center, point_grid }
    }
}

/// The regions of a planar pattern, laid onto the struck body: in its grid frame.
pub fn align_pattern(pattern: &Pattern, impact: &Impact, struck: &Shape) -> Vec<Region> {
    let placement = Placement::new(pattern, impact, struck);
    pattern.planar().unwrap_or_default().iter().map(|region| placement.region(region)).collect()
}

/// An impact and the corners of a body's box in its grid frame.
fn in_grid_frame(impact: &Impact, struck: &Shape) -> (Impact, [DVec3; 8]) {
    let grid_from_body = struck.body_from_grid.inverse();
    let impact_grid = Impact {
        point_body: grid_from_body.point(impact.point_body),
        normal_body: grid_from_body.direction(impact.normal_body),
    };
    (impact_grid, corners(struck.bounds).map(|corner| grid_from_body.point(corner)))
}

/// The eight corners of a box.
pub(crate) fn corners((low, high): (DVec3, DVec3)) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let pick = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// A unit vector across `z`: the grid axis along which the points spread farthest, seen along `z`.
fn longest_axis_across(z: DVec3, points: &[DVec3; 8]) -> DVec3 {
    let low = points.iter().fold(DVec3::INFINITY, |low, &point| low.min(point));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, &point| high.max(point));
    let extent = high - low;

    // Minimum length ratio for a later axis to replace an earlier axis: round-off must not decide
    // between equal edges.
    const CLEARLY: f64 = 1.0 + 1e-6;
    let mut longest = DVec3::ZERO;
    let mut length = 0.0;
    for axis in DVec3::AXES {
        let across = axis - z * z.dot(axis);
        let seen = extent.dot(axis) * across.length();
        if seen > CLEARLY * length {
            longest = across.normalize();
            length = seen;
        }
    }
    // `across` was normalised from a possibly short vector: take out what round-off left along z.
    (longest - z * z.dot(longest)).normalize()
}
