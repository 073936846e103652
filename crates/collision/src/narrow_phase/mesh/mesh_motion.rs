//! Motion of a body in the frame of a mesh.

use crate::narrow_phase::mesh::nearby::{NearTriangle, Nearby};
use crate::narrow_phase::mesh::triangle_sweep::Facet;
use crate::narrow_phase::pair_motion::PairMotion;
use frangible_bodies::{BallisticPath, Pair};
use frangible_geometry::{Shape, StaticMesh};
use frangible_math::RigidTransform;
use glam::DVec3;

/// Largest turn of a straight part of a path [rad]: points at the body's radius then leave the arc
/// by less than a thousandth of it.
const MOST_TURN: f64 = 0.1;

/// Most straight parts of a frame.
const MOST_PARTS: usize = 16;

/// Width of what counts as one plane or one line, relative to the body's size [1].
const THIN: f64 = 1e-5;

/// Width of the rim of a face, relative to the body's size [1]: twice the overlap of a resting
/// contact (`RESTING_DEPTH` of the solver). What meets a face only there slides over its edge.
/// Without it a box that slides from one closed box of a mesh to the next stops at the seam; with
/// 2.5e-3 a cylinder of 4 cm that slides along its axis does.
const RIM: f64 = 4e-3;

/// Time within which a body may pass an edge, relative to the rest of the frame [1]: contacts act
/// up to a substep ahead, and a frame has two at least.
pub(crate) const BEYOND: f64 = 1.5;

/// A body's motion through a frame, seen from a mesh.
pub(crate) struct MeshMotion<'a> {
    pub(crate) pair_motion: &'a PairMotion<'a>,
    pub(crate) mesh: &'a StaticMesh,
    pub(crate) mesh_is_first: bool,
    /// Instants of the frame [s] and `mesh_from_body` at each, ballistic.
    pub(crate) instants: Vec<(f64, RigidTransform)>,
    /// The same of what is held up: without the part of the motion that goes into what the body
    /// touches at the frame's start.
    pub(crate) supported: Vec<(f64, RigidTransform)>,
    /// True if anything of the mesh holds the body up.
    pub(crate) is_borne: bool,
    /// Transforms to the world at the frame's start, of the body and the mesh.
    pub(crate) starts: [RigidTransform; 2],
    /// Lengths within this are equal [m].
    pub(crate) thin: f64,
    /// Width of the rims of faces [m].
    pub(crate) rim: f64,
    /// True if the body is known to belong in front of all of the mesh.
    pub(crate) is_enclosed: bool,
    /// Triangles near the body.
    pub(crate) nearby: Nearby,
}

impl<'a> MeshMotion<'a> {
    pub(crate) fn new(
        pair_motion: &'a PairMotion<'a>,
        mesh: &'a StaticMesh,
        mesh_is_first: bool,
    ) -> Self {
        let dt = pair_motion.frame.dt;
        let Pair { first, second } = pair_motion.pair;
        let (sheet, body) = if mesh_is_first { (first, second) } else { (second, first) };
        let is_enclosed = mesh.is_closed_sheet() && pair_motion.bodies.is_enclosed(sheet, body);
        let mesh = pair_motion.bodies.seen_by(mesh, sheet, body);
        let turn = |path: &BallisticPath| path.angular.length() * dt;
        let turn = turn(pair_motion.paths[0]) + turn(pair_motion.paths[1]);
        let parts = ((turn / MOST_TURN) as usize + 1).min(MOST_PARTS);
        let mut motion = Self {
            pair_motion,
            mesh,
            mesh_is_first,
            instants: Vec::new(),
            supported: Vec::new(),
            is_borne: false,
            starts: pair_motion.paths.map(|path| path.start.world_from_body()),
            thin: THIN * pair_motion.size,
            rim: RIM * pair_motion.size,
            is_enclosed,
            nearby: Nearby::default(),
        };
        if mesh_is_first {
            motion.starts.swap(0, 1);
        }
        motion.instants = (0..=parts)
            .map(|part| dt * part as f64 / parts as f64)
            .map(|time| {
                let [body, mesh] = [motion.body_path(), motion.mesh_path()];
                let mesh_from_world = mesh.pose(time).world_from_body().inverse();
                (time, mesh_from_world.after(&body.pose(time).world_from_body()))
            })
            .collect();
        motion.supported = motion.instants.clone();
        motion
    }

    /// Takes the part of the motion away that goes against a normal of what supports the body.
    pub(crate) fn support(&mut self, normal: DVec3) {
        let (Some(start), Some(end)) = (self.supported.first(), self.supported.last()) else {
            return;
        };
        let (from, duration) = (start.1.translation, end.0.max(f64::MIN_POSITIVE));
        let into = (end.1.translation - from).dot(normal).min(0.0);
        self.is_borne = true;
        for (time, mesh_from_body) in &mut self.supported {
            mesh_from_body.translation -= into * (*time / duration) * normal;
        }
    }

    /// Offset to add to a point of the mesh in the body frame [m] on a straight part of free flight
    /// between two instants [s], to see it from the same flight without gravity, as of a body that
    /// something else carries.
    pub(crate) fn without_sag(
        &self,
        part: ([f64; 2], f64),
        mesh_from_body: &RigidTransform,
    ) -> DVec3 {
        mesh_from_body.rotation.conjugate() * self.sag_on(part)
    }

    /// Way of the body by gravity since the frame's start, mesh frame [m].
    pub(crate) fn sag(&self, time: f64) -> DVec3 {
        self.sag_on(([time; 2], 0.0))
    }

    /// Way of the body by gravity since the frame's start, at a fraction of a straight part of free
    /// flight between two instants [s], mesh frame [m].
    pub(crate) fn sag_on(&self, ([begin, end], at): ([f64; 2], f64)) -> DVec3 {
        let squared = begin * begin + at * (end * end - begin * begin);
        let sag = 0.5 * squared * self.body_path().acceleration;
        self.mesh_path().start.orientation.conjugate() * sag
    }

    pub(crate) fn body_path(&self) -> &BallisticPath {
        self.pair_motion.paths[usize::from(self.mesh_is_first)]
    }

    /// Shape of the body that meets the mesh.
    pub(crate) fn body_shape(&self) -> &Shape {
        let Pair { first, second } = self.pair_motion.pair;
        &self.pair_motion.bodies.shapes[if self.mesh_is_first { second } else { first }]
    }

    pub(crate) fn mesh_path(&self) -> &BallisticPath {
        self.pair_motion.paths[usize::from(!self.mesh_is_first)]
    }

    /// `mesh_from_body` at the frame's start.
    pub(crate) fn start(&self) -> RigidTransform {
        self.instants[0].1
    }

    /// True if a straight way meets a triangle, or ends at one.
    pub(crate) fn meets_mesh(&self, way: [DVec3; 2]) -> bool {
        let Self { mesh, thin, ref nearby, .. } = *self;
        let way = [way[0], way[1] + thin * (way[1] - way[0]).normalize_or_zero()];
        let mut meets = false;
        nearby.visit_way(mesh, way, thin, |&NearTriangle { corners, normal, .. }| {
            let crosses = |normal| Facet { corners, normal }.crossing(way, thin).is_some();
            meets |= crosses(normal) || crosses(-normal);
        });
        meets
    }

    /// A direction in the mesh's frame at an instant [s], in the world.
    pub(crate) fn world_direction(&self, direction: DVec3, time: f64) -> DVec3 {
        let mesh = self.mesh_path();
        // Most meshes do not turn, and a pose takes a sine and a cosine.
        let still = mesh.angular == DVec3::ZERO;
        let orientation = if still { mesh.start.orientation } else { mesh.pose(time).orientation };
        orientation * direction
    }

    /// Lowest and highest corner around a body's bounds on its way, mesh frame [m], grown by the
    /// speculative margin.
    pub(crate) fn swept_bounds(&self, (low, high): (DVec3, DVec3)) -> (DVec3, DVec3) {
        let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
        let mut swept = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (_, mesh_from_body) in &self.instants {
            let (at, matrix) = (mesh_from_body.point(center), mesh_from_body.matrix());
            let reach = half.x * matrix.x_axis.abs()
                + half.y * matrix.y_axis.abs()
                + half.z * matrix.z_axis.abs();
            swept = (swept.0.min(at - reach), swept.1.max(at + reach));
        }
        let margin = self.pair_motion.near + self.thin;
        (swept.0 - margin, swept.1 + margin)
    }
}
