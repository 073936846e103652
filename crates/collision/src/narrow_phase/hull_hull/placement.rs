//! Hulls in a common frame.

use frangible_geometry::{HalfSpace, Hull};
use frangible_math::RigidTransform;
use glam::{DMat3, DVec3};

/// Rigid transform as a matrix, for repeated use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    pub(crate) matrix: DMat3,
    pub(crate) shift: DVec3,
}

impl Placement {
    pub(crate) fn new(to_from_from: &RigidTransform) -> Self {
        Self { matrix: to_from_from.matrix(), shift: to_from_from.translation }
    }

    pub(crate) fn inverse(&self) -> Self {
        let matrix = self.matrix.transpose();
        Self { matrix, shift: -(matrix * self.shift) }
    }

    #[inline]
    pub(crate) fn point(&self, point: DVec3) -> DVec3 {
        self.matrix * point + self.shift
    }

    #[inline]
    pub(crate) fn direction(&self, direction: DVec3) -> DVec3 {
        self.matrix * direction
    }

    #[inline]
    pub(crate) fn plane(&self, plane: HalfSpace) -> HalfSpace {
        let normal = self.matrix * plane.normal;
        HalfSpace { normal, offset: plane.offset + normal.dot(self.shift) }
    }
}

/// A hull in the common frame.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) hull: &'a Hull,
    /// `None` if the hull's own frame is the common frame.
    pub(crate) here_from_hull: Option<&'a Placement>,
}

impl View<'_> {
    #[inline]
    pub(crate) fn vertex(&self, vertex: usize) -> DVec3 {
        let point = self.hull.vertices()[vertex];
        self.here_from_hull.map_or(point, |placement| placement.point(point))
    }

    #[inline]
    pub(crate) fn plane(&self, face: usize) -> HalfSpace {
        let plane = self.hull.planes()[face];
        self.here_from_hull.map_or(plane, |placement| placement.plane(plane))
    }

    #[inline]
    pub(crate) fn direction(&self, direction: DVec3) -> DVec3 {
        self.here_from_hull.map_or(direction, |placement| placement.direction(direction))
    }

    /// End points of an edge [m].
    #[inline]
    pub(crate) fn ends(&self, edge: usize) -> [DVec3; 2] {
        let [start, end] = self.hull.edges()[edge].vertices;
        [self.vertex(start as usize), self.vertex(end as usize)]
    }

    /// A direction in the hull's own frame.
    pub(crate) fn into_hull(self, direction: DVec3) -> DVec3 {
        self.here_from_hull.map_or(direction, |placement| placement.matrix.transpose() * direction)
    }
}

/// An edge and its two face normals, in the common frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ridge {
    pub(crate) edge: usize,
    pub(crate) ends: [DVec3; 2],
    pub(crate) along: DVec3,
    pub(crate) normals: [DVec3; 2],
    /// Upper bound of the separation along the normals between both [m]; infinite if unknown.
    pub(crate) bound: f64,
}

impl Ridge {
    /// Away from the hull, between both normals: not unit. The faces of a sliver look in opposite
    /// directions, and what is left of their normals' sum is rounding; across the edge in the plane
    /// of the first face, which has the edge in its own direction, is out there.
    pub(crate) fn outward(&self) -> DVec3 {
        let [first, second] = self.normals;
        first + second + self.along.cross(first - second) / self.along.length()
    }

    /// Upper bound of the separation from another hull along the normals between both faces' [m]:
    /// by some points of that hull, relative to a point of the edge.
    pub(crate) fn most_apart(&self, points: impl Iterator<Item = DVec3>) -> f64 {
        let [first, second] = self.normals;
        // A normal is a sum of both with parts of at least 1 together, and of at most this.
        let longest = 2.0 / (first + second).length();
        let height = |point: DVec3| {
            let higher = first.dot(point).max(second.dot(point));
            if higher > 0.0 { longest * higher } else { higher }
        };
        points.map(height).fold(f64::INFINITY, f64::min)
    }
}
