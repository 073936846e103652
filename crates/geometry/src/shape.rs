//! Shapes: immutable, shared by equal bodies.

mod exact;
mod own_mass;

use crate::closed_form::ClosedForm;
use crate::closed_form_surface::closed_form_surface;
use crate::compound::Compound;
use crate::grid_solid::GridSolid;
use crate::hull::Hull;
use crate::hull::rounded::rounded_surface;
use crate::hull::samples::hull_samples;
use crate::mass_properties::NoMass;
use crate::mesh::{Surface, TriMesh};
use crate::polygonize::polygonize;
use crate::revolved::Revolved;
use crate::sample_clusters::{ClusteredSamples, LazySamples, SampleCluster};
use crate::solid::Solid;
use crate::static_mesh::StaticMesh;
use crate::surface_samples::closed_form_samples;
use crate::voxel_bounds::bounds_in_body;
use frangible_math::RigidTransform;
use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Geometry, surface samples and mass properties. The body frame has its origin at the centre of
/// mass and its axes along the principal axes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Shape {
    /// Where inside and outside are.
    pub geometry: Geometry,
    /// The frame of the grid, the closed form or the hull in the body frame.
    pub body_from_grid: RigidTransform,
    /// Lowest and highest corner in the body frame [m].
    pub bounds: (DVec3, DVec3),
    /// [m^3]; zero for a half-space and for static triangles.
    pub volume: f64,
    /// Principal moments at unit density [m^5].
    pub unit_moments: DVec3,
    /// Convex polyhedron of the shape or of its fracture, in the body frame; `None` for other
    /// shapes.
    #[serde(with = "frangible_math::shared")]
    pub hull: Option<Arc<Hull>>,
    /// Compound of convex polyhedra, in the body frame; `None` for other shapes.
    #[serde(with = "frangible_math::shared")]
    pub compound: Option<Arc<Compound>>,
    /// The ball or the cylinder that a polyhedron is a part of, in the frame of both: what its
    /// surface is drawn as.
    part_of: Option<ClosedForm>,
    /// Between samples [m]; zero if they were given.
    sample_spacing: f64,
    samples: LazySamples,
}

/// Where inside and outside are.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Geometry {
    /// A formula: exact. Breaks if it has a hull.
    ClosedForm(ClosedForm),
    /// A convex polyhedron: exact, also where it breaks.
    Hull(#[serde(with = "frangible_math::shared")] Arc<Hull>),
    /// Compound of convex polyhedra.
    Compound(#[serde(with = "frangible_math::shared")] Arc<Compound>),
    /// Samples on a grid: can break.
    Grid(Box<GridSolid>),
    /// A closed solid of any form: exact, also where it breaks. It meets others as the hull or the
    /// compound of its shape.
    Solid(#[serde(with = "frangible_math::shared")] Arc<Solid>),
    /// Triangles of what does not move by itself: no volume.
    Mesh(#[serde(with = "frangible_math::shared")] Arc<StaticMesh>),
}

/// Where a solid's centre of mass and principal axes are.
#[derive(Clone, Copy, Debug)]
pub struct BodyFrame {
    /// Into the frame of both.
    pub body_from_grid: RigidTransform,
    /// [m^3]
    pub volume: f64,
    /// Principal moments at unit density [m^5].
    pub unit_moments: DVec3,
}

impl BodyFrame {
    /// Of a solid on a grid.
    ///
    /// # Errors
    /// If the coverage sums to no volume.
    pub fn of(solid: &GridSolid) -> Result<Self, NoMass> {
        let mass = solid.mass_properties();
        let (unit_moments, body_from_grid) = mass.body_frame()?;
        Ok(Self { body_from_grid, volume: mass.volume, unit_moments })
    }
}

/// Half of the angle between axes that differ by rounding only [rad].
const ROUNDING: f64 = 1e-9;

/// Principal moments of a formula's body: those that are equal but for rounding give no axes.
fn round_moments(form: &ClosedForm, moments: DVec3) -> DVec3 {
    match form {
        ClosedForm::Sphere { .. } => DVec3::splat(moments.element_sum() / 3.0),
        ClosedForm::Cylinder { .. } | ClosedForm::Capsule { .. } | ClosedForm::Cone { .. } => {
            let across = 0.5 * (moments.x + moments.z);
            DVec3::new(across, moments.y, across)
        }
        ClosedForm::Box { .. } | ClosedForm::HalfSpace(_) => moments,
    }
}

/// Most samples along a side; see the scene's rule.
const MOST_SAMPLES_ALONG: f64 = 1e4;

impl Check for Shape {
    fn check(&self) -> Checked {
        match &self.geometry {
            Geometry::ClosedForm(form) => form.check()?,
            Geometry::Grid(solid) => solid.check()?,
            Geometry::Hull(_) => require(self.hull.is_some(), "a polyhedron in its own frame")?,
            Geometry::Compound(whole) => {
                let own = self.compound.as_ref().map(|own| own.parts().len());
                require(own == Some(whole.parts().len()), "a compound in its own frame")?;
            }
            Geometry::Solid(solid) => solid.check()?,
            Geometry::Mesh(_) => require(self.volume == 0.0, "a mesh without a volume")?,
        }
        self.body_from_grid.check()?;
        self.samples.check()?;
        let mass = [self.volume, self.unit_moments.min_element(), self.unit_moments.max_element()];
        require(mass.iter().all(|&sum| (0.0..1e60).contains(&sum)), "volume and moments")?;
        if let Some(form) = &self.part_of {
            form.check()?;
        }
        if matches!(self.geometry, Geometry::ClosedForm(ClosedForm::HalfSpace(_))) {
            return require(self.volume == 0.0, "a half-space without a volume");
        }
        let (low, high) = self.bounds;
        finite_vector(low)?;
        finite_vector(high)?;
        require(low.cmple(high).all(), "bounds in order")?;
        let least = (high - low).max_element() / MOST_SAMPLES_ALONG;
        let is_given = self.samples.are_given() || matches!(self.geometry, Geometry::Mesh(_));
        require(is_given || self.sample_spacing >= least, "samples that can be counted")?;
        require(self.sample_spacing.is_finite(), "a sample spacing")
    }
}

impl Shape {
    /// Of a ball around the centre of mass that holds the body [m]; infinite for a half-space.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.bounds.0.abs().max(self.bounds.1.abs()).length()
    }

    /// A formula: exact; only a box can break. Samples lie about `sample_spacing` [m] apart. A
    /// half-space has no volume, no samples and infinite bounds.
    pub fn closed_form(form: ClosedForm, sample_spacing: f64) -> Self {
        // The axes of all of these are principal, and their middle is the centre of mass.
        let (volume, unit_moments) = form.mass_properties().map_or((0.0, DVec3::ZERO), |mass| {
            (
                mass.volume,
                DVec3::new(mass.inertia.x_axis.x, mass.inertia.y_axis.y, mass.inertia.z_axis.z),
            )
        });
        let hull = match form {
            ClosedForm::Box { half } => Some(Arc::new(Hull::cuboid(half))),
            _ => None,
        };
        Self {
            geometry: Geometry::ClosedForm(form),
            body_from_grid: RigidTransform::IDENTITY,
            bounds: form.bounds(),
            volume,
            unit_moments,
            hull,
            compound: None,
            part_of: None,
            sample_spacing,
            samples: LazySamples::default(),
        }
    }

    /// A formula that can break, into exact polyhedra: its mass and its hull are those of a
    /// polyhedron of its volume and its centre of mass, see [`Hull::ball`], [`Hull::cylinder`],
    /// [`Hull::capsule`] and [`Hull::cone`], so that nothing changes when it does.
    ///
    /// # Errors
    /// For a half-space, which has no volume.
    pub fn breakable(form: ClosedForm, sample_spacing: f64) -> Result<Self, NoMass> {
        let hull = match form {
            ClosedForm::HalfSpace(_) => return Err(NoMass),
            ClosedForm::Box { half } => Hull::cuboid(half),
            ClosedForm::Sphere { radius } => Hull::ball(radius),
            ClosedForm::Cylinder { radius, half_height } => Hull::cylinder(radius, half_height),
            ClosedForm::Capsule { radius, half_height } => Hull::capsule(radius, half_height),
            ClosedForm::Cone { radius, height } => Hull::cone(radius, height),
        };
        let mass = hull.mass_properties();
        let moments =
            DVec3::new(mass.inertia.x_axis.x, mass.inertia.y_axis.y, mass.inertia.z_axis.z);
        Ok(Self {
            volume: mass.volume,
            unit_moments: round_moments(&form, moments),
            hull: Some(Arc::new(hull)),
            ..Self::closed_form(form, sample_spacing)
        })
    }

    /// This exact shape with the mass and the body frame of a solid that was sampled from it: it
    /// meets others exactly until it breaks on that grid, and nothing changes when it does. `None`
    /// for what is no convex body or compound, or if a formula's axes are not principal ones.
    pub fn with_mass_of(&self, solid: &Self) -> Option<Self> {
        let Self { body_from_grid, volume, unit_moments, .. } = *solid;
        let whole = Self { volume, unit_moments, samples: LazySamples::default(), ..self.clone() };
        match &self.geometry {
            // The centre of mass of the solid is that of the formula, but for rounding of the grid.
            Geometry::ClosedForm(form) => {
                let half_turn = body_from_grid.rotation.xyz().length();
                let unit_moments = round_moments(form, unit_moments);
                (half_turn < ROUNDING).then_some(Self { unit_moments, ..whole })
            }
            Geometry::Hull(hull) => {
                let hull = hull.transformed(&body_from_grid);
                let bounds = hull.bounds();
                Some(Self { body_from_grid, bounds, hull: Some(Arc::new(hull)), ..whole })
            }
            Geometry::Compound(compound) => {
                let compound = compound.transformed(&body_from_grid);
                let bounds = compound.bounds();
                let compound = Some(Arc::new(compound));
                Some(Self { body_from_grid, bounds, compound, ..whole })
            }
            Geometry::Grid(_) | Geometry::Solid(_) | Geometry::Mesh(_) => None,
        }
    }

    /// Triangles of a body that is static or kinematic: without a mass. The body frame is the
    /// mesh's own, and its samples are the vertices.
    pub fn static_mesh(mesh: StaticMesh) -> Self {
        Self {
            bounds: mesh.bounds(),
            geometry: Geometry::Mesh(Arc::new(mesh)),
            body_from_grid: RigidTransform::IDENTITY,
            volume: 0.0,
            unit_moments: DVec3::ZERO,
            hull: None,
            compound: None,
            part_of: None,
            sample_spacing: 0.0,
            samples: LazySamples::default(),
        }
    }

    /// A solid on a grid, with samples in its grid frame [m].
    ///
    /// # Errors
    /// If the coverage sums to no volume.
    pub fn from_grid_solid(solid: GridSolid, samples_grid: Vec<Vec3>) -> Result<Self, NoMass> {
        let frame = BodyFrame::of(&solid)?;
        let into_body = |sample: Vec3| frame.body_from_grid.point(sample.as_dvec3()).as_vec3();
        let samples = samples_grid.into_iter().map(into_body).collect();
        Ok(Self::from_clusters(solid, frame, ClusteredSamples::new(samples)))
    }

    /// A solid on a grid with its [`BodyFrame`], and samples in that frame.
    pub fn from_clusters(solid: GridSolid, frame: BodyFrame, surface: ClusteredSamples) -> Self {
        let BodyFrame { body_from_grid, volume, unit_moments } = frame;
        let bounds = bounds_in_body(&solid, &body_from_grid, &surface.samples);
        Self {
            geometry: Geometry::Grid(Box::new(solid)),
            body_from_grid,
            bounds,
            volume,
            unit_moments,
            hull: None,
            compound: None,
            part_of: None,
            sample_spacing: 0.0,
            samples: LazySamples::given(surface),
        }
    }

    /// Points on the surface in the body frame [m]: what is tested against other bodies' level
    /// sets. Those of a formula and of a polyhedron are made at the first call: many fragments
    /// never need any.
    pub fn samples(&self) -> &[Vec3] {
        &self.sampled().samples
    }

    /// All samples, in the same order, by neighbourhood.
    pub fn sample_clusters(&self) -> &[SampleCluster] {
        &self.sampled().clusters
    }

    fn sampled(&self) -> &ClusteredSamples {
        self.samples.get_or_make(|| {
            let spacing = self.sample_spacing;
            ClusteredSamples::new(match (&self.geometry, &self.hull, &self.compound) {
                (Geometry::ClosedForm(form), ..) => closed_form_samples(form, spacing),
                (_, Some(hull), _) => hull_samples(hull, spacing),
                (_, _, Some(compound)) => compound.samples(spacing),
                (Geometry::Mesh(mesh), ..) => {
                    mesh.positions().iter().map(|position| position.as_vec3()).collect()
                }
                _ => Vec::new(),
            })
        })
    }

    /// Sample spacing of a formula or a polyhedron [m]; zero for grids with given samples.
    pub fn sample_spacing(&self) -> f64 {
        self.sample_spacing
    }

    /// The polyhedron, in the grid frame, that this breaks as when planes cut it; `None` for what
    /// breaks on its grid or not at all.
    pub fn breaks_as(&self) -> Option<&Hull> {
        match &self.geometry {
            Geometry::Hull(hull) => Some(hull),
            // Its grid frame is the body frame.
            Geometry::ClosedForm(_) => self.hull.as_deref(),
            Geometry::Compound(_) | Geometry::Grid(_) | Geometry::Solid(_) | Geometry::Mesh(_) => {
                None
            }
        }
    }

    /// The body of revolution around the y axis of the body frame; `None` for other shapes.
    #[inline]
    pub fn revolved(&self) -> Option<Revolved> {
        // The grid frame of a formula is its body frame.
        if let Geometry::ClosedForm(form) = &self.geometry { form.revolved() } else { None }
    }

    /// Signed distance [m] and its unit gradient at a point in the body frame [m].
    pub fn distance_and_gradient(&self, point_body: DVec3) -> (f64, DVec3) {
        match (&self.geometry, &self.hull, &self.compound) {
            (Geometry::Solid(_), Some(hull), _) => return hull.distance_and_gradient(point_body),
            (Geometry::Solid(_), _, Some(compound)) => {
                return compound.distance_and_gradient(point_body);
            }
            _ => {}
        }
        let point_grid = self.body_from_grid.inverse().point(point_body);
        let (distance, gradient_grid) = match &self.geometry {
            Geometry::ClosedForm(form) => form.distance_and_gradient(point_grid),
            Geometry::Hull(hull) => hull.distance_and_gradient(point_grid),
            Geometry::Compound(compound) => compound.distance_and_gradient(point_grid),
            Geometry::Solid(solid) => solid.distance_and_gradient(point_grid),
            Geometry::Mesh(mesh) => mesh.distance_and_gradient(point_grid),
            Geometry::Grid(solid) => {
                let (distance, gradient) = solid.value_and_gradient(point_grid);
                // On a ridge the samples' gradient can vanish; any direction is as good there.
                (f64::from(distance), gradient.as_dvec3().try_normalize().unwrap_or(DVec3::Y))
            }
        };
        (distance, self.body_from_grid.direction(gradient_grid))
    }

    /// The surface in the body frame: closed, but for static triangles; empty for a half-space.
    pub fn surface(&self) -> Surface {
        let mut surface = match &self.geometry {
            Geometry::ClosedForm(form) => without_cracks(closed_form_surface(form)),
            Geometry::Hull(hull) => {
                let rounded = self.part_of.and_then(|form| rounded_surface(&form, hull));
                rounded.unwrap_or_else(|| hull.tagged_surface())
            }
            Geometry::Compound(compound) => compound.surface(),
            Geometry::Grid(solid) => polygonize(solid),
            Geometry::Solid(solid) => solid.surface(),
            Geometry::Mesh(mesh) => without_cracks(mesh.to_tri_mesh()),
        };
        for position in &mut surface.mesh.positions {
            *position = self.body_from_grid.point(*position);
        }
        surface
    }
}

/// The surface of what has never been broken.
fn without_cracks(mesh: TriMesh) -> Surface {
    let normal = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        (b - a).cross(c - a)
    };
    let normals: Vec<DVec3> = (0..mesh.triangles.len()).map(normal).collect();
    Surface::with_coordinates(mesh, vec![false; normals.len()], &normals)
}

#[cfg(test)]
mod tests;
