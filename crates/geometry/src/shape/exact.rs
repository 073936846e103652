//! Shapes of polyhedra, and of solids that meet others as polyhedra.

use super::{Geometry, Shape};
use crate::closed_form::ClosedForm;
use crate::compound::Compound;
use crate::hull::Hull;
use crate::mass_properties::{MassProperties, NoMass};
use crate::sample_clusters::LazySamples;
use crate::solid::Solid;
use std::sync::Arc;

impl Shape {
    /// A convex polyhedron: exact, also where it breaks. Samples lie about `sample_spacing` [m]
    /// apart.
    ///
    /// # Errors
    /// If it is so thin that its volume or a moment vanishes.
    pub fn convex(hull: Hull, sample_spacing: f64) -> Result<Self, NoMass> {
        let mass = hull.mass_properties();
        Self::convex_with_mass(hull, &mass, sample_spacing)
    }

    /// The same, of a polyhedron whose mass properties are known.
    ///
    /// # Errors
    /// If its volume or a moment vanishes.
    pub fn convex_with_mass(
        hull: Hull,
        mass: &MassProperties,
        sample_spacing: f64,
    ) -> Result<Self, NoMass> {
        let (unit_moments, body_from_grid) = mass.body_frame()?;
        let in_body = hull.transformed(&body_from_grid);
        Ok(Self {
            geometry: Geometry::Hull(Arc::new(hull)),
            body_from_grid,
            bounds: in_body.bounds(),
            volume: mass.volume,
            unit_moments,
            hull: Some(Arc::new(in_body)),
            compound: None,
            part_of: None,
            sample_spacing,
            samples: LazySamples::default(),
        })
    }

    /// The same, drawn as the part of a round body that it was cut out of: its parent, or what that
    /// was cut out of, in the same grid frame.
    pub fn cut_from(self, parent: &Self) -> Self {
        let part_of = match parent.geometry {
            Geometry::ClosedForm(
                form @ (ClosedForm::Sphere { .. } | ClosedForm::Cylinder { .. }),
            ) => Some(form),
            _ => parent.part_of,
        };
        Self { part_of, ..self }
    }

    /// Convex polyhedra that are one body: its mass is the sum of theirs. Samples lie about
    /// `sample_spacing` [m] apart.
    ///
    /// # Errors
    /// If they are so thin that the volume or a moment vanishes, or there are none.
    pub fn compound(compound: Compound, sample_spacing: f64) -> Result<Self, NoMass> {
        let mass = compound.mass_properties();
        Self::compound_with_mass(compound, &mass, sample_spacing)
    }

    /// The same, with mass properties of its own.
    ///
    /// # Errors
    /// If its volume or a moment vanishes.
    pub fn compound_with_mass(
        compound: Compound,
        mass: &MassProperties,
        sample_spacing: f64,
    ) -> Result<Self, NoMass> {
        let (unit_moments, body_from_grid) = mass.body_frame()?;
        let in_body = compound.transformed(&body_from_grid);
        Ok(Self {
            geometry: Geometry::Compound(Arc::new(compound)),
            body_from_grid,
            bounds: in_body.bounds(),
            volume: mass.volume,
            unit_moments,
            hull: None,
            compound: Some(Arc::new(in_body)),
            part_of: None,
            sample_spacing,
            samples: LazySamples::default(),
        })
    }

    /// A closed solid of any form, and the hulls as which it meets others, in its own frame; none
    /// for a shape that only breaks. Samples lie about `sample_spacing` [m] apart.
    ///
    /// # Errors
    /// If its volume or a moment vanishes.
    pub fn solid_with_mass(
        solid: Solid,
        mut hulls: Vec<Hull>,
        mass: &MassProperties,
        sample_spacing: f64,
    ) -> Result<Self, NoMass> {
        let (unit_moments, body_from_grid) = mass.body_frame()?;
        let (hull, compound) = match (hulls.len(), hulls.pop()) {
            (_, None) => (None, None),
            (1, Some(hull)) => (Some(Arc::new(hull.transformed(&body_from_grid))), None),
            (_, Some(last)) => {
                hulls.push(last);
                let in_body = Compound::new(hulls).transformed(&body_from_grid);
                (None, Some(Arc::new(in_body)))
            }
        };
        Ok(Self {
            bounds: solid.bounds_in(&body_from_grid),
            geometry: Geometry::Solid(Arc::new(solid)),
            body_from_grid,
            volume: mass.volume,
            unit_moments,
            hull,
            compound,
            part_of: None,
            sample_spacing,
            samples: LazySamples::default(),
        })
    }
}
