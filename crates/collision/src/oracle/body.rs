//! Convex bodies by their definition.

use frangible_geometry::{ClosedForm, Hull, HullEdge};
use frangible_math::RigidTransform;
use glam::DVec3;

/// Steps to either side of a normal's place on a rim that are tried around it.
const BESIDE: i32 = 3;

/// A convex body at its place.
#[derive(Clone, Debug)]
pub(crate) struct Convex {
    core: Core,
    /// [m]
    pub(crate) rounding: f64,
}

#[derive(Clone, Debug)]
enum Core {
    Points {
        points: Vec<DVec3>,
        edges: Vec<[usize; 2]>,
        /// Outward, unit.
        faces: Vec<DVec3>,
        /// Of the faces on both sides of each edge; none for a segment.
        beside: Vec<[DVec3; 2]>,
    },
    /// The hull of two discs.
    Discs { centers: [DVec3; 2], radii: [f64; 2], axis: DVec3, across: [DVec3; 2] },
}

/// Corners and points of rims [m], directions whose crosses are normals, and normals.
#[derive(Clone, Debug, Default)]
pub(crate) struct Features {
    /// Only of those around a direction.
    pub(crate) points: Vec<DVec3>,
    pub(crate) edges: Vec<DVec3>,
    pub(crate) normals: Vec<DVec3>,
}

/// An edge and the arc of its outward normals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    /// [m]
    pub(crate) point: DVec3,
    /// Unit.
    pub(crate) along: DVec3,
    /// The arc turns about the edge from the first to the second: the first face has the edge in its
    /// own direction.
    pub(crate) normals: [DVec3; 2],
    /// All around a segment.
    pub(crate) is_full: bool,
}

/// Where to look for features: around an outward unit direction, in steps of an angle [rad].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Around {
    pub(crate) towards: DVec3,
    pub(crate) step: f64,
}

impl Convex {
    pub(crate) fn of_hull(hull: &Hull, here_from_hull: &RigidTransform) -> Self {
        let points = hull.vertices().iter().map(|&vertex| here_from_hull.point(vertex)).collect();
        let edges = hull.edges().iter().map(|edge| edge.vertices.map(|v| v as usize)).collect();
        let faces: Vec<DVec3> =
            hull.planes().iter().map(|plane| here_from_hull.direction(plane.normal)).collect();
        let normals = |edge: &HullEdge| edge.faces.map(|face| faces[face as usize]);
        let beside = hull.edges().iter().map(normals).collect();
        Self { core: Core::Points { points, edges, faces, beside }, rounding: 0.0 }
    }

    pub(crate) fn of_triangle(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize();
        let core = Core::Points {
            points: corners.to_vec(),
            edges: vec![[0, 1], [1, 2], [2, 0]],
            faces: vec![normal, -normal],
            beside: vec![[normal, -normal]; 3],
        };
        Self { core, rounding: 0.0 }
    }

    /// `None` for a half-space.
    pub(crate) fn of_form(form: &ClosedForm, here_from_body: &RigidTransform) -> Option<Self> {
        let at = |height: f64| here_from_body.point(height * DVec3::Y);
        let discs = |heights: [f64; 2], radii: [f64; 2]| Core::Discs {
            centers: heights.map(at),
            radii,
            axis: here_from_body.direction(DVec3::Y),
            across: [DVec3::X, DVec3::Z].map(|across| here_from_body.direction(across)),
        };
        let points = |points: Vec<DVec3>, edges: Vec<[usize; 2]>| Core::Points {
            points,
            edges,
            faces: Vec::new(),
            beside: Vec::new(),
        };
        let (core, rounding) = match *form {
            ClosedForm::HalfSpace(_) => return None,
            ClosedForm::Sphere { radius } => (points(vec![at(0.0)], Vec::new()), radius),
            ClosedForm::Capsule { radius, half_height } => {
                (points(vec![at(-half_height), at(half_height)], vec![[0, 1]]), radius)
            }
            ClosedForm::Cylinder { radius, half_height } => {
                (discs([-half_height, half_height], [radius; 2]), 0.0)
            }
            ClosedForm::Cone { radius, height } => {
                (discs([-0.25 * height, 0.75 * height], [radius, 0.0]), 0.0)
            }
            ClosedForm::Box { half } => {
                return Some(Self::of_hull(&Hull::cuboid(half), here_from_body));
            }
        };
        Some(Self { core, rounding })
    }

    /// A point of the core furthest in a direction [m].
    pub(crate) fn support(&self, direction: DVec3) -> DVec3 {
        match &self.core {
            Core::Points { points, .. } => {
                let mut best = points[0];
                let mut reach = best.dot(direction);
                for &point in &points[1..] {
                    let here = point.dot(direction);
                    if here > reach {
                        (best, reach) = (point, here);
                    }
                }
                best
            }
            Core::Discs { centers, radii, across, .. } => {
                let [u, v] = across.map(|across| across.dot(direction));
                let length = (u * u + v * v).sqrt();
                let radial = if length > 0.0 {
                    (u * across[0] + v * across[1]) / length
                } else {
                    DVec3::ZERO
                };
                let [low, high] = [0, 1].map(|end| centers[end] + radii[end] * radial);
                if high.dot(direction) > low.dot(direction) { high } else { low }
            }
        }
    }

    /// Largest distance of a point of the core from another point [m].
    pub(crate) fn reach_from(&self, from: DVec3) -> f64 {
        match &self.core {
            Core::Points { points, .. } => {
                points.iter().map(|point| point.distance(from)).fold(0.0, f64::max)
            }
            Core::Discs { centers, radii, .. } => [0, 1]
                .map(|end| centers[end].distance(from) + radii[end])
                .into_iter()
                .fold(0.0, f64::max),
        }
    }

    /// Radius around its middle [m].
    pub(crate) fn radius(&self) -> f64 {
        self.reach_from(self.middle()) + self.rounding
    }

    /// A point inside [m].
    pub(crate) fn middle(&self) -> DVec3 {
        match &self.core {
            Core::Points { points, .. } => points.iter().sum::<DVec3>() / points.len() as f64,
            Core::Discs { centers, .. } => 0.5 * (centers[0] + centers[1]),
        }
    }

    pub(crate) fn is_round(&self) -> bool {
        matches!(self.core, Core::Discs { .. })
    }

    /// Features everywhere, or around a direction.
    pub(crate) fn features(&self, around: Option<Around>) -> Features {
        match &self.core {
            Core::Points { points, edges, faces, .. } => {
                let along = |&[a, b]: &[usize; 2]| points[b] - points[a];
                let Some(Around { towards, step }) = around else {
                    let mut features = Features { normals: faces.clone(), ..Features::default() };
                    edges.iter().for_each(|edge| push_new(&mut features.edges, along(edge)));
                    if faces.is_empty() {
                        features.normals.extend(beside(&features.edges));
                    }
                    return features;
                };
                let top = self.support(towards).dot(towards);
                let is_near = |&at: &usize| {
                    let below = top - points[at].dot(towards);
                    below <= 4.0 * step * self.reach_from(points[at])
                };
                let near = points.iter().enumerate().filter(|(at, _)| is_near(at));
                let mut features =
                    Features { points: near.map(|near| *near.1).collect(), ..Features::default() };
                for edge in edges.iter().filter(|edge| edge.iter().all(is_near)) {
                    push_new(&mut features.edges, along(edge));
                }
                features
            }
            Core::Discs { centers, radii, axis, across } => {
                let Some(Around { towards, step }) = around else {
                    return Features { normals: vec![*axis, -*axis], ..Features::default() };
                };
                let mut features = Features::default();
                let way = centers[1] - centers[0];
                if radii[0] == radii[1] {
                    features.edges.push(way);
                }
                let [u, v] = across.map(|across| across.dot(towards));
                for number in -BESIDE..=BESIDE {
                    let angle = v.atan2(u) + step * f64::from(number);
                    let (sin, cos) = angle.sin_cos();
                    let radial = cos * across[0] + sin * across[1];
                    features.normals.push(self.side_normal(angle));
                    features.edges.push(cos * across[1] - sin * across[0]);
                    if radii[0] != radii[1] {
                        features.edges.push(way + (radii[1] - radii[0]) * radial);
                    }
                    let ends = [0, 1].map(|end| centers[end] + radii[end] * radial);
                    features.points.extend(ends);
                }
                features
            }
        }
    }

    /// Unit, outward, of the side of a round body at an angle about its axis [rad].
    pub(crate) fn side_normal(&self, angle: f64) -> DVec3 {
        let Core::Discs { centers, radii, across, .. } = &self.core else { return DVec3::Y };
        let (sin, cos) = angle.sin_cos();
        let radial = cos * across[0] + sin * across[1];
        let tangent = cos * across[1] - sin * across[0];
        let line = centers[1] - centers[0] + (radii[1] - radii[0]) * radial;
        let normal = tangent.cross(line).normalize();
        normal * normal.dot(radial).signum()
    }

    /// Unit, of a round body.
    pub(crate) fn axis(&self) -> DVec3 {
        if let Core::Discs { axis, .. } = &self.core { *axis } else { DVec3::Y }
    }

    /// All edges between corners.
    pub(crate) fn arcs(&self) -> Vec<Arc> {
        let Core::Points { points, edges, beside, .. } = &self.core else { return Vec::new() };
        let arc = |(at, &[a, b]): (usize, &[usize; 2])| {
            let along = (points[b] - points[a]).try_normalize()?;
            let Some(&normals) = beside.get(at) else {
                let normals = [along.any_orthonormal_vector(); 2];
                return Some(Arc { point: points[a], along, normals, is_full: true });
            };
            Some(Arc { point: points[a], along, normals, is_full: false })
        };
        edges.iter().enumerate().filter_map(arc).collect()
    }
}

/// Normals of a segment, whose faces are none: all across it separate it from itself equally, and
/// two segments on one line overlap along it by what they have in common.
fn beside(edges: &[DVec3]) -> Vec<DVec3> {
    let of = |&edge: &DVec3| {
        let across = edge.any_orthonormal_vector();
        [across, -across, edge, -edge]
    };
    edges.iter().flat_map(of).collect()
}

/// Parallel edges are one.
fn push_new(edges: &mut Vec<DVec3>, edge: DVec3) {
    let Some(edge) = edge.try_normalize() else { return };
    if edges.iter().all(|known| known.cross(edge).length_squared() > 1e-26) {
        edges.push(edge);
    }
}
