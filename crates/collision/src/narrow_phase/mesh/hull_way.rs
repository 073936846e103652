//! A polyhedron on its way through a frame, seen from a mesh.

use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use frangible_geometry::Hull;
use frangible_math::RigidTransform;
use glam::{DMat3, DVec3};

/// A hull at the instants of a frame.
pub(crate) struct HullWay<'a> {
    pub(crate) motion: &'a MeshMotion<'a>,
    pub(crate) hull: &'a Hull,
    /// A point inside of it, body frame [m].
    pub(crate) inside: DVec3,
    /// Free flight, and the way along what the body touches: `None` if it touches nothing.
    pub(crate) flight: Way,
    pub(crate) supported: Option<Way>,
}

/// The hull at each instant [s] of a way.
pub(crate) struct Way {
    pub(crate) is_supported: bool,
    pub(crate) instants: Vec<Instant>,
    /// Vertices at all instants, one instant after the other, mesh frame [m].
    vertices: Vec<DVec3>,
}

/// An instant of a way.
#[derive(Clone, Copy)]
pub(crate) struct Instant {
    /// [s]
    pub(crate) time: f64,
    pub(crate) mesh_from_body: RigidTransform,
    pub(crate) body_from_mesh: RigidTransform,
    /// The rotation of `mesh_from_body`.
    pub(crate) rotation: DMat3,
}

impl Way {
    fn new(instants: &[(f64, RigidTransform)], hull: &Hull, is_supported: bool) -> Self {
        let mut way = Self {
            is_supported,
            instants: Vec::with_capacity(instants.len()),
            vertices: Vec::new(),
        };
        way.vertices.reserve(instants.len() * hull.vertices().len());
        for &(time, mesh_from_body) in instants {
            let rotation = mesh_from_body.matrix();
            let body_from_mesh = mesh_from_body.inverse();
            way.instants.push(Instant { time, mesh_from_body, body_from_mesh, rotation });
            for &vertex in hull.vertices() {
                way.vertices.push(rotation * vertex + mesh_from_body.translation);
            }
        }
        way
    }

    /// Vertices at an instant, mesh frame [m].
    pub(crate) fn vertices(&self, instant: usize) -> &[DVec3] {
        let count = self.vertices.len() / self.instants.len();
        &self.vertices[instant * count..(instant + 1) * count]
    }
}

impl<'a> HullWay<'a> {
    pub(crate) fn new(motion: &'a MeshMotion<'a>, hull: &'a Hull, inside: DVec3) -> Self {
        let supported = motion.is_borne.then(|| Way::new(&motion.supported, hull, true));
        // A body that nothing bears is as free on the way along its contacts.
        let flight = Way::new(&motion.instants, hull, !motion.is_borne);
        Self { motion, hull, inside, flight, supported }
    }

    /// Both ways, or the one, that along what the body touches first.
    pub(crate) fn ways(&self) -> impl Iterator<Item = &Way> + Clone {
        self.supported.iter().chain([&self.flight])
    }

    /// The way along what the body touches.
    pub(crate) fn supported_way(&self) -> &Way {
        self.supported.as_ref().unwrap_or(&self.flight)
    }

    /// Its last instant.
    pub(crate) fn supported_end(&self) -> Option<&Instant> {
        self.supported_way().instants.last()
    }
}
