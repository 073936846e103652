//! Round bodies as polyhedra of the same volume, so that they can be broken exactly.

use super::Hull;
use super::face_loops::FaceLoops;
use super::half_edges::HalfEdgeMesh;
use crate::half_space::HalfSpace;
use crate::hull::edges::plane_of;
use crate::hull::plane_clip::PlaneClipper;
use glam::DVec3;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// Parts into which a ball's polyhedron divides the edges of an icosahedron. With two there are 42
/// faces and 80 vertices, all within 4.4 % of the radius from the sphere; with three 92 and 180
/// within 1.8 %, which doubles what a break and a contact cost.
const BALL_FREQUENCY: usize = 2;

/// Sides of a cylinder's prism: within 0.6 % of the radius.
const CYLINDER_SIDES: u32 = 24;

/// Sides of a capsule's polyhedron, and where its flat ends lie, relative to the radius: within 6.2
/// % of it.
const CAPSULE_SIDES: u32 = 12;
const CAPSULE_END: f64 = 0.95;

/// Steps of Newton's method for a capsule's radius: to rounding.
const NEWTON_STEPS: usize = 6;

impl Hull {
    /// A polyhedron with the volume of a ball around the origin [m], and as much of its symmetry as
    /// a polyhedron can have: all moments are equal. Its faces are hexagons, and pentagons around
    /// the twelve corners of an icosahedron.
    pub fn ball(radius: f64) -> Self {
        // Planes that touch the unit sphere at the nodes of a geodesic net.
        let cuts: Vec<HalfSpace> = geodesic_directions()
            .into_iter()
            .map(|normal| HalfSpace { normal, offset: 1.0 })
            .collect();
        let whole = Self::cuboid(DVec3::splat(2.0));
        let touching = PlaneClipper::default().clipped(&whole, &cuts).unwrap_or(whole);
        let volume = touching.mass_properties().volume;
        touching.scaled(radius * libm::cbrt(4.0 / 3.0 * PI / volume))
    }

    /// A prism around the y axis with the volume of a cylinder [m].
    pub fn cylinder(radius: f64, half_height: f64) -> Self {
        // The circle around a polygon whose area is that of the cylinder's.
        let turn = TAU / f64::from(CYLINDER_SIDES);
        prism(radius * (turn / libm::sin(turn)).sqrt(), half_height, CYLINDER_SIDES)
    }

    /// A polyhedron around the y axis with the volume of a capsule [m]: a prism, and a ring of
    /// slanted faces and a flat end for each half ball.
    pub fn capsule(radius: f64, half_height: f64) -> Self {
        // All corners lie at one radius, the rings between the side and the ends at 45 degrees.
        let polyhedron = |radius: f64| {
            let diagonal = radius * FRAC_1_SQRT_2;
            let tip = radius * CAPSULE_END;
            let rings = [
                (radius * (1.0 - CAPSULE_END * CAPSULE_END).sqrt(), -half_height - tip),
                (diagonal, -half_height - diagonal),
                (radius, -half_height),
                (radius, half_height),
                (diagonal, half_height + diagonal),
                (radius * (1.0 - CAPSULE_END * CAPSULE_END).sqrt(), half_height + tip),
            ];
            stacked_rings(&rings, CAPSULE_SIDES)
        };
        let exact = PI * radius * radius * (2.0 * half_height + 4.0 / 3.0 * radius);
        // Newton's method for the radius of this volume.
        let mut around = radius;
        for _ in 0..NEWTON_STEPS {
            let volume = polyhedron(around).volume();
            let step = 1e-4 * radius;
            let slope = (polyhedron(around + step).volume() - volume) / step;
            around -= (volume - exact) / slope;
        }
        polyhedron(around)
    }

    /// A pyramid around the y axis with the volume of a cone [m], its centre of mass the origin.
    pub fn cone(radius: f64, height: f64) -> Self {
        let turn = TAU / f64::from(CYLINDER_SIDES);
        let around = radius * (turn / libm::sin(turn)).sqrt();
        let rings = [(around, -0.25 * height), (0.0, 0.75 * height)];
        stacked_rings(&rings, CYLINDER_SIDES)
    }

    /// Larger by a factor, all faces outer ones.
    fn scaled(self, factor: f64) -> Self {
        let plane = |plane: &HalfSpace| HalfSpace { offset: factor * plane.offset, ..*plane };
        let vertices = self.vertices.iter().map(|&vertex| factor * vertex).collect();
        Self::new(
            vertices,
            self.planes.iter().map(plane).collect(),
            self.net.all_made_by_cuts(false),
        )
    }
}

/// A regular prism around the y axis whose edges lie at a radius [m].
pub(super) fn prism(radius: f64, half_height: f64, sides: u32) -> Hull {
    let turn = TAU / f64::from(sides);
    let inner = radius * libm::cos(0.5 * turn);
    let mut vertices = Vec::with_capacity(2 * sides as usize);
    let (mut loops, mut planes) = (FaceLoops::default(), Vec::with_capacity(sides as usize + 2));
    for side in 0..sides {
        let angle = turn * f64::from(side);
        let (x, z) = (radius * libm::cos(angle), radius * libm::sin(angle));
        vertices.extend([DVec3::new(x, -half_height, z), DVec3::new(x, half_height, z)]);
        let middle = angle + 0.5 * turn;
        let normal = DVec3::new(libm::cos(middle), 0.0, libm::sin(middle));
        planes.push(HalfSpace { normal, offset: inner });
        let (low, next) = (2 * side, 2 * ((side + 1) % sides));
        loops.push(false, [low, low + 1, next + 1, next]);
    }
    for (normal, top) in [(DVec3::NEG_Y, false), (DVec3::Y, true)] {
        planes.push(HalfSpace { normal, offset: half_height });
        let around = (0..sides).map(|side| 2 * side + u32::from(top));
        if top { loops.push(false, around.rev()) } else { loops.push(false, around) }
    }
    Hull::new(vertices, planes, HalfEdgeMesh::of(&loops).unwrap_or_default())
}

/// The convex polyhedron of regular polygons around the y axis, from the lowest, each with the
/// radius of its corners and its height [m]; a radius of 0 is a point.
fn stacked_rings(rings: &[(f64, f64)], sides: u32) -> Hull {
    let turn = TAU / f64::from(sides);
    let (mut vertices, mut firsts) = (Vec::new(), Vec::new());
    for &(radius, height) in rings {
        firsts.push((vertices.len() as u32, radius > 0.0));
        let corners = if radius > 0.0 { sides } else { 1 };
        vertices.extend((0..corners).map(|side| {
            let angle = turn * f64::from(side);
            DVec3::new(radius * libm::cos(angle), height, radius * libm::sin(angle))
        }));
    }
    let corner = |ring: usize, side: u32| {
        let (first, is_wide) = firsts[ring];
        if is_wide { first + side % sides } else { first }
    };
    let (mut loops, mut planes) = (FaceLoops::default(), Vec::new());
    let mut face = |corners: &[u32]| {
        let points = corners.iter().map(|&vertex| vertices[vertex as usize]);
        if let Some(plane) = plane_of(points) {
            planes.push(plane);
            loops.push(false, corners.iter().copied());
        }
    };
    for ring in 0..rings.len() - 1 {
        for side in 0..sides {
            let mut corners = vec![
                corner(ring, side),
                corner(ring + 1, side),
                corner(ring + 1, side + 1),
                corner(ring, side + 1),
            ];
            corners.dedup();
            face(&corners);
        }
    }
    let last = rings.len() - 1;
    let around = |ring: usize| (0..sides).map(move |side| corner(ring, side));
    if firsts[0].1 {
        face(&around(0).collect::<Vec<u32>>());
    }
    if firsts[last].1 {
        face(&around(last).rev().collect::<Vec<u32>>());
    }
    Hull::new(vertices, planes, HalfEdgeMesh::of(&loops).unwrap_or_default())
}

/// The nodes of an icosahedron's faces, each divided into triangles, moved to the unit sphere.
fn geodesic_directions() -> Vec<DVec3> {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners: Vec<DVec3> = Vec::with_capacity(12);
    for axis in 0..3 {
        for (u, v) in [(1.0, golden), (-1.0, golden), (-1.0, -golden), (1.0, -golden)] {
            let mut corner = DVec3::ZERO;
            (corner[axis], corner[(axis + 1) % 3]) = (u, v);
            corners.push(corner);
        }
    }
    // Corners that share an edge are two apart.
    let beside = |a: DVec3, b: DVec3| a.distance_squared(b) < 4.1;
    let mut directions: Vec<DVec3> = Vec::new();
    for (first, &a) in corners.iter().enumerate() {
        for (second, &b) in
            corners.iter().enumerate().skip(first + 1).filter(|&(_, &b)| beside(a, b))
        {
            for &c in corners[second + 1..].iter().filter(|&&c| beside(a, c) && beside(b, c)) {
                for i in 0..=BALL_FREQUENCY {
                    for j in 0..=BALL_FREQUENCY - i {
                        let k = BALL_FREQUENCY - i - j;
                        let node = (i as f64 * a + j as f64 * b + k as f64 * c).normalize();
                        if directions.iter().all(|other| other.distance_squared(node) > 1e-6) {
                            directions.push(node);
                        }
                    }
                }
            }
        }
    }
    directions
}
