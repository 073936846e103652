//! Strength of bodies.

use crate::scene::desc::breaking::MaterialDesc;
use frangible_geometry::Shape;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A fragment bears this many times the impulse of its parent (a ratio), where strength is given as
/// an impulse: smaller pieces have fewer flaws for a crack to begin at. The paper's authors double
/// it, too.
const GROWTH_PER_BREAK: f64 = 2.0;

/// Points of a shape at which its least thickness is looked for. What is thinner than all of them
/// counts as the thinnest of them. One takes microseconds on a polyhedron.
const MOST_PLACES: usize = 32;

/// The strength of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Strength {
    /// An impulse, whatever the body's size [N s] [Su09 sec. 4.2].
    Impulse(f64),
    /// Strength from a material.
    Material(MaterialDesc),
}

impl Strength {
    /// Strength where a shape has this thickness [m]: the largest impulse in one collision [N s].
    ///
    /// A material fails if set in motion faster than sigma / (rho c), with the speed of sound c =
    /// sqrt(E / rho): the stress in a plane wave is rho c v. The strength is this speed times the
    /// mass reached by a wave after crossing the solid where it is struck: its thickness there is h,
    /// and what moves is a disc of radius h, or all of a stocky body. A thin pane therefore takes
    /// little momentum from a striker, and a thick wall much; a bottle takes as much as a pane of
    /// its wall.
    pub(crate) fn bears(&self, shape: &Shape, density: f64, thickness: f64) -> f64 {
        match self {
            Self::Impulse(impulse) => *impulse,
            Self::Material(material) => {
                let speed_of_sound = (material.youngs_modulus / density).sqrt();
                let fails_at = material.tensile_strength / (density * speed_of_sound);
                let reached = shape.volume.min(PI * thickness * thickness * thickness);
                fails_at * density * reached
            }
        }
    }

    /// Strength where the shape is thinnest [N s].
    pub(crate) fn least(&self, shape: &Shape, density: f64) -> f64 {
        match self {
            Self::Impulse(impulse) => *impulse,
            Self::Material(_) => self.bears(shape, density, shape.least_thickness(MOST_PLACES)),
        }
    }

    /// Strength at a point of the body frame [m], at least [`Strength::least`].
    pub(crate) fn at(&self, shape: &Shape, density: f64, (point, least): (DVec3, f64)) -> f64 {
        match self {
            Self::Impulse(impulse) => *impulse,
            Self::Material(_) => self.bears(shape, density, shape.thickness(point)).max(least),
        }
    }

    /// That of a fragment: by Weibull's weakest link, stress grows as the power -1/m of the volume
    /// [Wei51].
    pub(crate) fn of_fragment(&self, parent: &Shape, fragment: &Shape) -> Self {
        match *self {
            Self::Impulse(impulse) => Self::Impulse(GROWTH_PER_BREAK * impulse),
            Self::Material(material) => {
                let grows =
                    libm::pow(parent.volume / fragment.volume, 1.0 / material.weibull_modulus);
                Self::Material(MaterialDesc {
                    tensile_strength: grows * material.tensile_strength,
                    ..material
                })
            }
        }
    }

    /// Fracture energy of a crack per area [J/m^2].
    pub(crate) fn fracture_energy(&self) -> f64 {
        match self {
            Self::Impulse(_) => 0.0,
            Self::Material(material) => material.fracture_energy,
        }
    }
}
