//! Compounds of convex polyhedra.

use crate::bvh::Bvh;
use crate::compound_surface::outer_surface;
use crate::face_polygon::{corners_of, overlap_area, polygon_area};
use crate::half_space::HalfSpace;
use crate::hull::Hull;
use crate::hull::samples::hull_samples;
use crate::mass_properties::{MassProperties, parallel_axis};
use crate::mesh::Surface;
use crate::mesh_boundary::MeshBoundary;
use frangible_math::RigidTransform;
use frangible_math::check::{Check, Checked, require};
use glam::{DMat3, DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// Convex polyhedra in one frame. Parts may touch; common faces are *glued*: the space between is
/// inside. The mass of overlaps counts twice.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "CompoundRecord")]
pub struct Compound {
    parts: Vec<Part>,
    #[serde(skip_serializing)]
    tree: Bvh,
    /// Made when it is asked for.
    #[serde(skip_serializing)]
    boundary: OnceLock<MeshBoundary>,
}

/// What a snapshot holds of a compound.
#[derive(Deserialize)]
struct CompoundRecord {
    parts: Vec<Part>,
}

impl TryFrom<CompoundRecord> for Compound {
    type Error = &'static str;

    fn try_from(CompoundRecord { parts }: CompoundRecord) -> Result<Self, &'static str> {
        require(!parts.is_empty(), "a compound of some parts")?;
        for part in &parts {
            part.hull.check()?;
            require(part.bounds == part.hull.bounds(), "the bounds of a part")?;
            require(part.glued.len() == part.hull.planes().len(), "all faces of a part")?;
        }
        let bounds: Vec<(DVec3, DVec3)> = parts.iter().map(|part| part.bounds).collect();
        Ok(Self { tree: Bvh::of_boxes(&bounds), parts, boundary: OnceLock::new() })
    }
}

impl Check for Compound {
    fn check(&self) -> Checked {
        // Its parts are checked before the tree is made of them.
        Ok(())
    }
}

/// One polyhedron of a compound.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Part {
    /// In the compound's frame.
    pub hull: Hull,
    /// Lowest and highest corner [m].
    pub bounds: (DVec3, DVec3),
    /// Per face: true if other parts cover it completely.
    pub glued: Vec<bool>,
}

/// Parts closer than this fraction of the compound's longest side touch: frame changes round
/// fragments' vertices, and decompositions come from files in single precision.
const TOUCHING: f64 = 1e-6;

/// Maximum uncovered fraction of a glued face.
const UNCOVERED: f64 = 1e-3;

/// Minimum lean of a normal towards a neighbouring part (sine of the angle) to point into the part.
const LEANING: f64 = 0.02;

impl Compound {
    /// A compound of polyhedra in one frame.
    pub fn new(hulls: Vec<Hull>) -> Self {
        let bounds: Vec<(DVec3, DVec3)> = hulls.iter().map(Hull::bounds).collect();
        let tree = Bvh::of_boxes(&bounds);
        let part = |(hull, bounds): (Hull, (DVec3, DVec3))| Part {
            glued: vec![false; hull.planes().len()],
            hull,
            bounds,
        };
        let parts = hulls.into_iter().zip(bounds).map(part).collect();
        let mut compound = Self { parts, tree, boundary: OnceLock::new() };
        let glued: Vec<Vec<bool>> =
            (0..compound.parts.len()).map(|index| compound.glued(index)).collect();
        for (part, glued) in compound.parts.iter_mut().zip(glued) {
            part.glued = glued;
        }
        compound
    }

    /// In the order in which they were given.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Lowest and highest corner of the bounding box [m].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.parts.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), part| {
            (low.min(part.bounds.0), high.max(part.bounds.1))
        })
    }

    /// The same parts in another frame.
    pub fn transformed(&self, to_from_compound: &RigidTransform) -> Self {
        let hulls: Vec<Hull> =
            self.parts.iter().map(|part| part.hull.transformed(to_from_compound)).collect();
        let bounds: Vec<(DVec3, DVec3)> = hulls.iter().map(Hull::bounds).collect();
        let tree = Bvh::of_boxes(&bounds);
        let part = |((hull, bounds), part): ((Hull, (DVec3, DVec3)), &Part)| Part {
            hull,
            bounds,
            glued: part.glued.clone(),
        };
        let parts = hulls.into_iter().zip(bounds).zip(&self.parts).map(part).collect();
        Self { parts, tree, boundary: OnceLock::new() }
    }

    /// Volume, centre and inertia at unit density: the parts' together.
    pub fn mass_properties(&self) -> MassProperties {
        let of_parts: Vec<MassProperties> =
            self.parts.iter().map(|part| part.hull.mass_properties()).collect();
        let volume: f64 = of_parts.iter().map(|part| part.volume).sum();
        let center = of_parts.iter().map(|part| part.volume * part.center).sum::<DVec3>() / volume;
        let mut inertia = DMat3::ZERO;
        for part in &of_parts {
            inertia += part.inertia + parallel_axis(part.volume, part.center - center);
        }
        MassProperties { volume, center, inertia }
    }

    /// The parts whose bounds come into the box from `low` to `high` [m], in order.
    pub fn parts_near(&self, low: DVec3, high: DVec3) -> Vec<usize> {
        let mut near = Vec::new();
        let meets = |(from, to): (DVec3, DVec3)| from.cmple(high).all() && low.cmple(to).all();
        self.tree.visit(
            |from, to| meets((from, to)),
            |index| {
                if meets(self.parts[index].bounds) {
                    near.push(index);
                }
            },
        );
        near.sort_unstable();
        near
    }

    /// The parts that come into a half-space, in order.
    pub fn parts_in(&self, half_space: &HalfSpace) -> Vec<usize> {
        let mut inside = Vec::new();
        let lowest = |low: DVec3, high: DVec3| {
            let corner = DVec3::select(half_space.normal.cmpgt(DVec3::ZERO), low, high);
            half_space.distance(corner) <= 0.0
        };
        self.tree.visit(lowest, |index| {
            let part = &self.parts[index];
            if part.hull.vertices().iter().any(|&vertex| half_space.distance(vertex) <= 0.0) {
                inside.push(index);
            }
        });
        inside.sort_unstable();
        inside
    }

    /// Signed distance [m] and its unit gradient: the least over the parts. Outside it is exact.
    /// Inside it is negative, and says how deep the point lies under those faces of a part around
    /// it that are not glued, which is its depth in the compound unless another part's face is
    /// nearer: exact for a single part, and near the surface.
    pub fn distance_and_gradient(&self, point: DVec3) -> (f64, DVec3) {
        match self.least(point, f64::INFINITY) {
            Some((_, index)) => self.parts[index].distance_and_gradient(point),
            None => (f64::INFINITY, DVec3::Y),
        }
    }

    /// Signed distance [m] alone; infinite if it is more than `most`.
    pub fn distance_up_to(&self, point: DVec3, most: f64) -> f64 {
        self.least(point, most).map_or(f64::INFINITY, |(distance, _)| distance)
    }

    /// Least distance up to `most` [m], and the first part with it.
    fn least(&self, point: DVec3, most: f64) -> Option<(f64, usize)> {
        // Skip boxes further away than the best part.
        let best = std::cell::Cell::new((most, usize::MAX));
        let away = |low: DVec3, high: DVec3| (point - point.clamp(low, high)).length();
        self.tree.visit(
            |low, high| away(low, high) <= best.get().0.max(0.0),
            |index| {
                let part = &self.parts[index];
                if away(part.bounds.0, part.bounds.1) <= best.get().0.max(0.0) {
                    let distance = part.distance_up_to(point, best.get().0);
                    if distance < best.get().0 || (distance == best.get().0 && index < best.get().1)
                    {
                        best.set((distance, index));
                    }
                }
            },
        );
        let (distance, index) = best.get();
        (index != usize::MAX).then_some((distance, index))
    }

    /// Points on the outer surface [m], about `spacing` apart.
    pub fn samples(&self, spacing: f64) -> Vec<Vec3> {
        let close = self.close();
        let mut samples = Vec::new();
        for (index, part) in self.parts.iter().enumerate() {
            for sample in hull_samples(&part.hull, spacing) {
                // Drop samples inside other parts; keep one of coincident samples.
                let point = sample.as_dvec3();
                let mut faces = part.hull.faces().zip(&part.glued);
                let is_outer =
                    faces.any(|(face, glued)| !glued && face.plane.distance(point) >= -close);
                let hidden = |other: usize| {
                    let most = if other < index { close } else { -close };
                    self.parts[other].hull.distance_and_gradient(point).0 <= most
                };
                let others = self.parts_near(point - close, point + close);
                if is_outer && !others.into_iter().any(|other| other != index && hidden(other)) {
                    samples.push(sample);
                }
            }
        }
        samples
    }

    /// The outer surface, without the faces, and parts of faces, that glue hides; where parts
    /// overlap, the surfaces of all, each closed. Of these, and what cracks made, glued faces count
    /// as interior.
    pub fn surface(&self) -> Surface {
        if let Some(surface) = self.outer_surface() {
            return surface;
        }
        let mut surface = Surface::default();
        for part in &self.parts {
            part.hull
                .add_surface(&mut surface, |face| part.glued[face] || part.hull.face(face).inner);
        }
        surface
    }

    /// The surface without what parts hide of one another; `None` where they overlap.
    fn outer_surface(&self) -> Option<Surface> {
        let hulls: Vec<&Hull> = self.parts.iter().map(|part| &part.hull).collect();
        let close = self.close();
        let beside = |index: usize| {
            let (low, high) = self.parts[index].bounds;
            self.parts_near(low - close, high + close)
        };
        outer_surface(&hulls, beside, close)
    }

    /// The triangles that separate inside from outside; `None` where parts overlap.
    pub fn outer_boundary(&self) -> Option<MeshBoundary> {
        self.outer_surface().map(|surface| MeshBoundary::of_mesh(&surface.mesh))
    }

    /// The triangles of [`Compound::surface`].
    pub(crate) fn boundary(&self) -> &MeshBoundary {
        self.boundary.get_or_init(|| MeshBoundary::of_mesh(&self.surface().mesh))
    }

    /// True if a neighbouring part covers a surface point in the direction of `normal`: the normal
    /// is then not a surface normal of the compound within `slack` [m] of the point.
    pub fn is_covered(&self, part: usize, point: DVec3, normal: DVec3, slack: f64) -> bool {
        let close = self.close();
        // A corner in which parts meet has no normal. Beside it each has its own.
        let across = normal.any_orthonormal_vector();
        let along = normal.cross(across);
        let around = |step: u32| {
            let angle = std::f64::consts::FRAC_PI_4 * f64::from(step);
            let (sin, cos) = libm::sincos(angle);
            point + slack * (cos * across + sin * along)
        };
        !self.has_normal(Some(part), point, normal, close)
            && !(0..8)
                .any(|step| self.has_normal(None, around(step), normal, close + LEANING * slack))
    }

    /// True if no part reaches further in the direction of `normal` [1] from a point that it touches
    /// to `close` [m], and one does touch it. `own` does.
    fn has_normal(&self, own: Option<usize>, point: DVec3, normal: DVec3, close: f64) -> bool {
        let near = self.parts_near(point - close, point + close);
        let mut touching = near
            .into_iter()
            .filter(|&part| Some(part) != own)
            .filter(|&part| self.parts[part].hull.distance_up_to(point, close) <= close)
            .peekable();
        let ends = |part: usize| {
            let beyond = |vertex: &DVec3| {
                let way = *vertex - point;
                normal.dot(way) > LEANING * way.length() + close
            };
            !self.parts[part].hull.vertices().iter().any(beyond)
        };
        (own.is_some() || touching.peek().is_some()) && touching.all(ends)
    }

    /// Tolerance of touching [m].
    pub(crate) fn close(&self) -> f64 {
        let (low, high) = self.bounds();
        TOUCHING * (high - low).max_element()
    }

    /// Per face of a part: true if others cover it.
    fn glued(&self, index: usize) -> Vec<bool> {
        let (part, close) = (&self.parts[index], self.close());
        let near = self.parts_near(part.bounds.0 - close, part.bounds.1 + close);
        let covered = |face: usize| {
            let corners = corners_of(&part.hull, face);
            let plane = part.hull.planes()[face];
            let faces_it = |other: &HalfSpace| {
                other.normal.dot(plane.normal) < TOUCHING - 1.0
                    && (other.offset + plane.offset).abs() <= close
            };
            let mut area = 0.0;
            for other in
                near.iter().filter(|&&other| other != index).map(|&other| &self.parts[other].hull)
            {
                let opposite =
                    (0..other.planes().len()).filter(|&at| faces_it(&other.planes()[at]));
                area += opposite
                    .map(|at| overlap_area(&corners, &corners_of(other, at), plane.normal))
                    .sum::<f64>();
            }
            area >= (1.0 - UNCOVERED) * polygon_area(&corners, plane.normal)
        };
        (0..part.hull.faces().len()).map(covered).collect()
    }
}

impl Part {
    /// Signed distance [m] and its unit gradient: inside, to the faces that are not glued.
    fn distance_and_gradient(&self, point: DVec3) -> (f64, DVec3) {
        let (distance, gradient) = self.hull.distance_and_gradient(point);
        self.under_outer_faces(point, distance).unwrap_or((distance, gradient))
    }

    /// The distance alone; what is more than `most` [m] may come out smaller, but not less than
    /// that.
    fn distance_up_to(&self, point: DVec3, most: f64) -> f64 {
        let distance = self.hull.distance_up_to(point, most);
        self.under_outer_faces(point, distance).map_or(distance, |(depth, _)| depth)
    }

    /// The highest plane of a face that is not glued over a point at `distance` [m] from the hull:
    /// how deep the point lies under it, as a negative height [m], with its normal. `None` for a
    /// point that lies outside, and if all faces are glued.
    fn under_outer_faces(&self, point: DVec3, distance: f64) -> Option<(f64, DVec3)> {
        // On a seam rounding may put it outside of both parts.
        let (low, high) = self.bounds;
        if distance > TOUCHING * (high - low).max_element() {
            return None;
        }
        let outer = self.hull.faces().zip(&self.glued).filter(|&(_, &glued)| !glued);
        outer
            .map(|(face, _)| (face.plane.distance(point), face.plane.normal))
            .fold(None, |best: Option<(f64, DVec3)>, next| {
                best.filter(|best| best.0 >= next.0).or(Some(next))
            })
            .filter(|&(height, _)| height <= 0.0)
    }
}
