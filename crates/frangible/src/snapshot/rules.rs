//! What a world must keep so that its next frames can rely on it: the rules of scenes, and those
//! between values that a scene has not.

use crate::hand::state::{Grip, Hand};
use crate::scene::build::MOST_GRAVITY;
use crate::scene::strength::Strength;
use crate::step::bonds::state::Bonds;
use crate::world::{Breaking, Label, World};
use frangible_bodies::Motion;
use frangible_geometry::{Geometry, Shape};
use frangible_math::check::{Check, Checked, finite, finite_vector, require};

/// Frames that a float counts.
const MOST_FRAMES: u64 = 1 << 52;

impl Check for World {
    fn check(&self) -> Checked {
        require((1e-5..=1.0).contains(&self.dt), "frames of 10 microseconds to a second")?;
        require(self.gravity.abs().max_element() <= MOST_GRAVITY, "gravity of a scene")?;
        require(!self.gravity.is_nan() && self.frame < MOST_FRAMES, "a frame that counts")?;
        self.settings.check()?;
        self.bodies.check()?;
        require(self.labels.len() == self.bodies.len(), "a label for each body")?;
        for (dense, label) in self.labels.iter().enumerate() {
            check_label(label, &self.bodies.shapes[dense], self.bodies.motions[dense])?;
        }
        self.books.check()?;
        self.ledger.check()?;
        self.warm.check()?;
        self.recent_impacts.check()?;
        self.contact_cache.check()?;
        self.fits.check()?;
        require(self.spared.is_empty(), "an instant between two frames")?;
        let Hand { grips, handled } = &self.hand;
        finite(handled.work)?;
        grips.iter().try_for_each(|&Grip { point_body, target, most_force, .. }| {
            require(most_force >= 0.0 && most_force.is_finite(), "a grip with a force")?;
            finite_vector(point_body)?;
            finite_vector(target)
        })
    }
}

fn check_label(label: &Label, shape: &Shape, motion: Motion) -> Checked {
    let Label { breaking, bonds, path, waiting, .. } = label;
    if let Some(waiting) = waiting {
        waiting.velocity.check()?;
        let is_held = motion == Motion::Static && shape.volume > 0.0;
        require(is_held, "a body that waits at rest, with a volume")?;
    }
    if let Some(breaking) = breaking {
        let breaks = waiting.is_some() || motion == Motion::Dynamic;
        require(breaks, "a body that moves by itself, if it may break")?;
        check_breaking(breaking, shape)?;
    }
    if let Some(bonds) = bonds {
        let Bonds { glued, carried, sample_spacing } = &**bonds;
        glued.check()?;
        carried.iter().try_for_each(Check::check)?;
        let (low, high) = shape.bounds;
        let is_spacing = 1e4 * sample_spacing >= (high - low).max_element();
        require(is_spacing && sample_spacing.is_finite(), "samples that can be counted")?;
    }
    path.as_ref().map_or(Ok(()), |path| {
        require(matches!(motion, Motion::Kinematic { .. }), "a path of a kinematic body")?;
        path.check()
    })
}

fn check_breaking(breaking: &Breaking, shape: &Shape) -> Checked {
    let Breaking { strength, shatter, generations, smallest, center, .. } = breaking;
    match strength {
        Strength::Impulse(impulse) => require(*impulse > 0.0, "a strength")?,
        Strength::Material(material) => {
            let stiff = [material.tensile_strength, material.youngs_modulus];
            let is_stiff = stiff.iter().all(|&part| part > 0.0 && part.is_finite());
            require(is_stiff && material.weibull_modulus >= 1.0, "a material")?;
            require((0.0..1e30).contains(&material.fracture_energy), "a fracture energy")?;
        }
    }
    shatter.check()?;
    if let Geometry::Grid(solid) = &shape.geometry {
        let along = solid.grid().dims.into_iter().fold(0, usize::max);
        let is_spacing = 1e4 * shatter.sample_spacing_voxels >= along as f64;
        require(is_spacing, "samples on cracks that can be counted")?;
    }
    require(*generations <= 64, "at most 64 generations")?;
    require((0.0..1e30).contains(smallest), "a smallest size")?;
    center.map_or(Ok(()), finite_vector)
}
