//! All bodies of a world, in dense arrays grouped by what changes together.

use crate::activity::{Activity, Substeps};
use crate::body_id::BodyId;
use crate::collision_classes::{CollisionClass, CollisionClasses};
use crate::enclosures::Enclosures;
use crate::frame::MOST_SUBSTEPS;
use crate::state::{Inertia, Pose, Velocity};
use frangible_geometry::Shape;
use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Rule for the motion of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// Never moves.
    Static,
    /// Prescribed velocity, independent of contacts.
    Kinematic {
        /// [m/s]
        linear: DVec3,
        /// [rad/s]
        angular: DVec3,
    },
    /// Moves by its momentum.
    Dynamic,
}

/// Surface properties of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceProperties {
    /// Coulomb's coefficient; a pair has the smaller of its two.
    pub friction: f64,
    /// Largest torque against rolling per normal force [m]; a pair has the larger of its two.
    pub rolling_friction: f64,
    /// Largest torque against spinning about the normal per normal force [m]; a pair has the larger
    /// of its two.
    pub spinning_friction: f64,
    /// Ratio of normal speeds after and before a collision, in [0, 1]; a pair has the smaller of
    /// its two.
    pub restitution: f64,
    /// Strength: the largest impulse in one collision before the body breaks [N s]; infinite for
    /// unbreakable bodies.
    pub strength: f64,
    /// True for pieces that are glued together: impacts load their bonds.
    pub glued: bool,
    /// Whom it collides with.
    pub class: CollisionClass,
}

/// Combined surface properties of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairSurface {
    /// Ratio of normal speeds after and before; in [-1, 1], below 0 only a part of the approach is
    /// stopped.
    pub restitution: f64,
    /// Coulomb's coefficient.
    pub friction: f64,
    /// See [`SurfaceProperties::rolling_friction`]; felt by the frame-rate method.
    pub rolling_friction: f64,
    /// See [`SurfaceProperties::spinning_friction`]; felt by the frame-rate method.
    pub spinning_friction: f64,
}

impl PairSurface {
    /// Without rolling and spinning friction.
    pub fn new(restitution: f64, friction: f64) -> Self {
        Self { restitution, friction, rolling_friction: 0.0, spinning_friction: 0.0 }
    }
}

impl SurfaceProperties {
    /// Of a body that cannot break, without rolling and spinning friction.
    pub fn new(restitution: f64, friction: f64) -> Self {
        let (strength, class) = (f64::INFINITY, CollisionClass::default());
        Self {
            friction,
            rolling_friction: 0.0,
            spinning_friction: 0.0,
            restitution,
            strength,
            glued: false,
            class,
        }
    }
}

/// A body about to enter a world.
#[derive(Clone, Debug)]
pub struct NewBody {
    /// Shared, immutable.
    pub shape: Arc<Shape>,
    /// [kg/m^3]
    pub density: f64,
    /// Static, kinematic or dynamic.
    pub motion: Motion,
    /// At spawn.
    pub pose: Pose,
    /// At spawn; ignored unless dynamic.
    pub velocity: Velocity,
    /// Friction, restitution, strength.
    pub surface: SurfaceProperties,
}

/// Dense arrays, one entry for each living body, in order of birth.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Bodies {
    /// Ids of the bodies.
    pub ids: Vec<BodyId>,
    /// Where, at the time level of the stage that runs.
    pub poses: Vec<Pose>,
    /// Velocities at the time level of the running stage.
    pub velocities: Vec<Velocity>,
    /// Static, kinematic or dynamic.
    pub motions: Vec<Motion>,
    /// [kg]; infinite unless dynamic.
    pub masses: Vec<f64>,
    /// Reciprocals of mass and moments; zero unless dynamic.
    pub inertias: Vec<Inertia>,
    /// [kg/m^3]
    pub densities: Vec<f64>,
    /// Geometry, samples, mass properties.
    #[serde(with = "frangible_math::shared")]
    pub shapes: Vec<Arc<Shape>>,
    /// Radii of bounding balls around the centres of mass [m]; infinite for half-spaces.
    pub radii: Vec<f64>,
    /// Friction, restitution, strength.
    pub surfaces: Vec<SurfaceProperties>,
    /// Activity of each body in the last frames.
    pub activities: Vec<Activity>,
    /// Which of them pass through each other.
    pub classes: CollisionClasses,
    pub(crate) enclosures: Enclosures,
    slots: Slots,
}

impl Check for Bodies {
    fn check(&self) -> Checked {
        let lengths = [
            self.poses.len(),
            self.velocities.len(),
            self.motions.len(),
            self.masses.len(),
            self.inertias.len(),
            self.densities.len(),
            self.shapes.len(),
            self.radii.len(),
            self.surfaces.len(),
            self.activities.len(),
        ];
        require(lengths.iter().all(|&length| length == self.len()), "lists of one length")?;
        self.classes.check()?;
        self.slots.check(&self.ids)?;
        self.poses.iter().try_for_each(Check::check)?;
        self.velocities.iter().try_for_each(Check::check)?;
        (0..self.len()).try_for_each(|i| self.check_body(i))
    }
}

impl Bodies {
    /// Checks that the values of a body go together.
    fn check_body(&self, i: usize) -> Checked {
        let (shape, density, surface) = (&self.shapes[i], self.densities[i], &self.surfaces[i]);
        let expected = match self.motions[i] {
            Motion::Dynamic => (density * shape.volume, Inertia::of(shape, density)),
            Motion::Kinematic { linear, angular } => {
                finite_vector(linear)?;
                finite_vector(angular)?;
                (f64::INFINITY, Inertia::INFINITE)
            }
            Motion::Static => (f64::INFINITY, Inertia::INFINITE),
        };
        require((self.masses[i], self.inertias[i]) == expected, "a mass that follows")?;
        let moves = self.motions[i] == Motion::Dynamic;
        let has_mass = self.masses[i] > 0.0 && self.inertias[i].inverse_moments.is_finite();
        require(!moves || has_mass, "a body with a mass")?;
        require(density > 0.0 && density.is_finite(), "a density")?;
        require(self.radii[i] == shape.radius(), "a radius that follows")?;
        let friction = [surface.friction, surface.rolling_friction, surface.spinning_friction];
        require(friction.iter().all(|&part| part >= 0.0 && part.is_finite()), "friction")?;
        require((0.0..=1.0).contains(&surface.restitution), "a restitution")?;
        require(surface.strength > 0.0, "a strength")?;
        require(self.classes.holds(surface.class), "a class that there is")?;
        let Substeps { count, needed } = self.activities[i].substeps;
        require(count <= MOST_SUBSTEPS && needed >= 0.0, "a number of substeps")?;
        // Both are counted on from here.
        let is_early =
            self.activities[i].drowsiness.slow_for < LATE && self.ids[i].generation < LATE;
        require(is_early, "counts far from overflow")
    }
}

/// Which dense entry an id stands for.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Slots {
    generation: Vec<u32>,
    dense: Vec<Option<u32>>,
    free: Vec<u32>,
}

/// Sparse per-body values keyed by [`BodyId`]; stale generations read as absent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PerBody<T>(Vec<Option<(u32, T)>>);

/// Counts from frame to frame stay far below this.
const LATE: u32 = 1 << 31;

impl Slots {
    /// Checks that each body has its slot, and each free slot is empty and listed once.
    fn check(&self, ids: &[BodyId]) -> Checked {
        require(self.generation.len() == self.dense.len(), "a generation for each slot")?;
        for (dense, id) in ids.iter().enumerate() {
            let slot = id.index as usize;
            let is_own = self.dense.get(slot) == Some(&Some(dense as u32))
                && self.generation[slot] == id.generation;
            require(is_own, "a slot for each body")?;
        }
        require(self.dense.iter().flatten().count() == ids.len(), "no body in other slots")?;
        require(self.generation.iter().all(|&generation| generation < LATE), "young slots")?;
        let mut free = self.free.clone();
        free.sort_unstable();
        free.dedup();
        let is_empty = |&slot: &u32| self.dense.get(slot as usize) == Some(&None);
        require(free.len() == self.free.len() && free.iter().all(is_empty), "free slots, once")
    }
}

impl<T> PerBody<T> {
    /// Checks that all values keep a rule.
    ///
    /// # Errors
    /// The rule that one breaks.
    pub fn check(&self, of_value: impl Fn(&T) -> Checked) -> Checked {
        self.0.iter().flatten().try_for_each(|(_, value)| of_value(value))
    }
}

impl<T> Default for PerBody<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Copy> PerBody<T> {
    /// Value of a body, if any.
    #[inline]
    pub fn get(&self, id: BodyId) -> Option<T> {
        let (generation, value) = self.0.get(id.index as usize).copied().flatten()?;
        (generation == id.generation).then_some(value)
    }

    /// Sets or replaces the value of a body.
    #[inline]
    pub fn insert(&mut self, id: BodyId, value: T) {
        let slot = id.index as usize;
        if slot >= self.0.len() {
            self.0.resize(slot + 1, None);
        }
        self.0[slot] = Some((id.generation, value));
    }

    /// In the order of their slots.
    pub fn iter(&self) -> impl Iterator<Item = (BodyId, T)> {
        let entry = |(index, entry): (usize, &Option<(u32, T)>)| {
            entry.map(|(generation, value)| (BodyId { index: index as u32, generation }, value))
        };
        self.0.iter().enumerate().filter_map(entry)
    }
}

impl Bodies {
    /// Number of living bodies.
    #[inline]
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// True without living bodies.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Dense index of a living body.
    #[inline]
    pub fn index_of(&self, id: BodyId) -> Option<usize> {
        let slot = id.index as usize;
        let alive = self.slots.generation.get(slot) == Some(&id.generation);
        if alive { self.slots.dense[slot].map(|dense| dense as usize) } else { None }
    }

    /// Adds a body behind all others.
    pub fn spawn(&mut self, body: NewBody) -> BodyId {
        let dense = self.len() as u32;
        let index = self.slots.free.pop().unwrap_or_else(|| {
            self.slots.generation.push(0);
            self.slots.dense.push(None);
            (self.slots.generation.len() - 1) as u32
        });
        self.slots.dense[index as usize] = Some(dense);
        let id = BodyId { index, generation: self.slots.generation[index as usize] };

        let (mass, inertia) = match body.motion {
            Motion::Dynamic => {
                (body.density * body.shape.volume, Inertia::of(&body.shape, body.density))
            }
            Motion::Static | Motion::Kinematic { .. } => (f64::INFINITY, Inertia::INFINITE),
        };
        self.ids.push(id);
        self.poses.push(body.pose);
        self.velocities.push(if inertia.is_infinite() {
            Velocity::default()
        } else {
            body.velocity
        });
        self.motions.push(body.motion);
        self.masses.push(mass);
        self.inertias.push(inertia);
        self.densities.push(body.density);
        self.radii.push(body.shape.radius());
        self.shapes.push(body.shape);
        self.surfaces.push(body.surface);
        self.activities.push(Activity::default());
        id
    }

    /// Lets a body move by its momentum, at a velocity.
    pub fn make_dynamic(&mut self, i: usize, velocity: Velocity) {
        let (shape, density) = (&self.shapes[i], self.densities[i]);
        self.motions[i] = Motion::Dynamic;
        self.masses[i] = density * shape.volume;
        self.inertias[i] = Inertia::of(shape, density);
        self.velocities[i] = velocity;
        self.activities[i] = Activity::default();
    }

    /// Removes the bodies whose entry in `gone` is true; the others keep their order. Returns, for
    /// each old dense index, the new one.
    pub fn remove(&mut self, gone: &[bool]) -> Vec<Option<usize>> {
        // Free the slots; the next tenant gets a new generation.
        for (dense, id) in self.ids.iter().enumerate().filter(|&(dense, _)| gone[dense]) {
            debug_assert_eq!(self.slots.dense[id.index as usize], Some(dense as u32));
            self.slots.dense[id.index as usize] = None;
            self.slots.generation[id.index as usize] += 1;
            self.slots.free.push(id.index);
        }

        // Close the gaps in every array.
        retain(&mut self.ids, gone);
        retain(&mut self.poses, gone);
        retain(&mut self.velocities, gone);
        retain(&mut self.motions, gone);
        retain(&mut self.masses, gone);
        retain(&mut self.inertias, gone);
        retain(&mut self.densities, gone);
        retain(&mut self.shapes, gone);
        retain(&mut self.radii, gone);
        retain(&mut self.surfaces, gone);
        retain(&mut self.activities, gone);
        for (dense, id) in self.ids.iter().enumerate() {
            self.slots.dense[id.index as usize] = Some(dense as u32);
        }
        let mut next = 0;
        gone.iter()
            .map(|&is_gone| {
                (!is_gone).then(|| {
                    next += 1;
                    next - 1
                })
            })
            .collect()
    }

    /// Velocity of the material point at `lever` from the centre of mass of body `i`, at the given
    /// time levels [m/s].
    #[inline]
    pub fn point_velocity(
        &self,
        i: usize,
        pose: &Pose,
        velocity: &Velocity,
        lever: DVec3,
    ) -> DVec3 {
        match self.motions[i] {
            Motion::Static => DVec3::ZERO,
            Motion::Kinematic { linear, angular } => linear + angular.cross(lever),
            Motion::Dynamic => {
                let angular =
                    self.inertias[i].angular_velocity(pose.orientation, velocity.angular_momentum);
                velocity.linear + angular.cross(lever)
            }
        }
    }

    /// The part of an angular velocity of a body that moves its surface [rad/s]: spin of a body of
    /// revolution about its axis does not.
    #[inline]
    pub fn sweeping_spin(&self, i: usize, pose: &Pose, angular: DVec3) -> DVec3 {
        match self.shapes[i].revolved() {
            Some(_) => angular - angular.project_onto_normalized(pose.orientation * DVec3::Y),
            None => angular,
        }
    }

    /// Angular velocity of body `i` in the world frame, at the given time levels [rad/s].
    #[inline]
    pub fn spin(&self, i: usize, pose: &Pose, velocity: &Velocity) -> DVec3 {
        match self.motions[i] {
            Motion::Static => DVec3::ZERO,
            Motion::Kinematic { angular, .. } => angular,
            Motion::Dynamic => {
                self.inertias[i].angular_velocity(pose.orientation, velocity.angular_momentum)
            }
        }
    }

    /// False for bodies that pass through each other.
    #[inline]
    pub fn may_collide(&self, a: usize, b: usize) -> bool {
        self.classes.is_trivial()
            || self.classes.collide(self.surfaces[a].class, self.surfaces[b].class)
    }

    /// Strength of a body where it is weakest: the largest impulse before it breaks [N s]. Only
    /// dynamic bodies break.
    #[inline]
    pub fn strength(&self, i: usize) -> f64 {
        if self.inertias[i].is_infinite() { f64::INFINITY } else { self.surfaces[i].strength }
    }

    /// Combined surface properties of a pair.
    #[inline]
    pub fn pair_surface(&self, a: usize, b: usize) -> PairSurface {
        let (a, b) = (&self.surfaces[a], &self.surfaces[b]);
        PairSurface {
            restitution: a.restitution.min(b.restitution),
            friction: a.friction.min(b.friction),
            rolling_friction: a.rolling_friction.max(b.rolling_friction),
            spinning_friction: a.spinning_friction.max(b.spinning_friction),
        }
    }
}

fn retain<T>(values: &mut Vec<T>, gone: &[bool]) {
    let mut dense = 0;
    values.retain(|_| {
        dense += 1;
        !gone[dense - 1]
    });
}
