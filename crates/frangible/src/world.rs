//! The world: bodies, how they break, and the books.

use crate::fingerprint::Fnv1a;
use crate::hand::state::Hand;
use crate::report::books::{Books, Totals};
use crate::report::id_number;
use crate::scene::check::{BuildError, Checker, MOST_SPEED, MOST_SPIN};
use crate::scene::desc::{LookDesc, Method};
use crate::scene::pattern_choice::PatternChoice;
use crate::scene::strength::Strength;
use crate::step::body_path::BodyPath;
use crate::step::bonds::state::Bonds;
use crate::step::waiting::state::{Starts, Waiting};
use frangible_bodies::{
    Bodies, BodyId, Drowsiness, Frame, Motion, NewBody, StepSettings, Velocity,
};
use frangible_collision::{BirthFits, ContactCache, ImpulseCache, find_penetrations};
use frangible_dynamics::{Ledger, RecentImpacts};
use frangible_fracture::{ShatterSettings, StrengthPoints};
use frangible_geometry::{Shape, Surface};
use frangible_math::check::Check;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Bodies in motion. Built from a [`crate::scene::desc::SceneDesc`], advanced by [`crate::step`].
#[derive(Clone, Debug)]
pub struct World {
    pub(crate) bodies: Bodies,
    /// One entry for each body, in the order of `bodies`.
    pub(crate) labels: Vec<Label>,
    pub(crate) frame: u64,
    pub(crate) dt: f64,
    pub(crate) gravity: DVec3,
    pub(crate) settings: StepSettings,
    pub(crate) books: Books,
    pub(crate) ledger: Ledger,
    pub(crate) method: Method,
    /// The last frame's contact impulses.
    pub(crate) warm: ImpulseCache,
    /// Impacts that the next frame's may join to one blow.
    pub(crate) recent_impacts: RecentImpacts,
    /// Pairs of polyhedra as they were in the last frame.
    pub(crate) contact_cache: ContactCache,
    /// Overlaps of fragments at birth.
    pub(crate) fits: BirthFits,
    /// Bodies temporarily unbreakable in the running frame, with their own strength [N s].
    pub(crate) spared: Vec<(BodyId, f64)>,
    /// Pieces of pieces that were born in the running frame.
    pub(crate) born_of_pieces: usize,
    /// A text of the caller's.
    pub(crate) note: String,
    /// Bodies that the caller holds, and its deeds since the last frame.
    pub(crate) hand: Hand,
    /// The caller's [s], for the report.
    pub(crate) clock: Option<fn() -> f64>,
}

/// Engine data of a body, unused by dynamics.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Label {
    /// From the scene; a fragment has its parent's with a number.
    pub name: String,
    /// Parent of a fragment.
    pub parent: Option<BodyId>,
    /// Of islands of glued pieces, the body that they all were at first.
    pub whole: Option<BodyId>,
    /// Appearance, unused by physics.
    pub look: Option<LookDesc>,
    /// Fracture data of breakable bodies. Boxed: few bodies break, and all labels are read in each
    /// frame.
    pub breaking: Option<Box<Breaking>>,
    /// Glued pieces of a body, if any.
    pub bonds: Option<Box<Bonds>>,
    /// Given motion of a kinematic body, if any.
    pub path: Option<Box<BodyPath>>,
    /// Of a body that has not started.
    pub waiting: Option<Waiting>,
}

impl Label {
    /// True for a glued body that does not wait.
    pub(crate) fn may_lose_bonds(&self) -> bool {
        self.bonds.is_some() && self.waiting.is_none()
    }

    /// True for a body that starts when it is struck, and has not been.
    pub(crate) fn waits_for_blow(&self) -> bool {
        self.waiting.is_some_and(|waiting| waiting.starts == Starts::WhenStruck)
    }
}

/// Fracture data of a body.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Breaking {
    /// Patterns of prescored space.
    #[serde(with = "frangible_math::shared")]
    pub choice: Arc<PatternChoice>,
    /// Strength of the body.
    pub strength: Strength,
    /// Resolution of the fragments.
    pub shatter: ShatterSettings,
    /// Remaining number of consecutive breaks, including the next.
    pub generations: u32,
    /// Minimum length of breakable bodies [m].
    pub smallest: f64,
    /// Where the next break's pattern has its centre, in the shape's frame [m], if not at the blow.
    pub center: Option<DVec3>,
    /// Where it is stronger than elsewhere.
    #[serde(with = "frangible_math::shared")]
    pub strength_points: Option<Arc<StrengthPoints>>,
    /// The grid that an exact body breaks on, in the same body frame; `None` if it breaks as it is.
    #[serde(with = "frangible_math::shared")]
    pub solid: Option<Arc<Shape>>,
}

impl Breaking {
    /// The largest impulse that a body bears where it is weakest [N s].
    pub(crate) fn bears(&self, shape: &Shape, density: f64) -> f64 {
        let least = self.strength_points.as_ref().map_or(1.0, |points| points.least());
        least * self.strength.least(shape, density)
    }

    /// The largest impulse that a body bears at a point of its frame [m], if it `bears` the other
    /// where it is weakest [N s].
    pub(crate) fn bears_at(&self, shape: &Shape, density: f64, point: DVec3, bears: f64) -> f64 {
        let Some(points) = &self.strength_points else {
            return self.strength.at(shape, density, (point, bears));
        };
        let least = bears / points.least();
        let point_grid = shape.body_from_grid.inverse().point(point);
        points.factor(point_grid) * self.strength.at(shape, density, (point, least))
    }
}

impl World {
    /// Living bodies, densely, in order of birth.
    pub fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    /// Names, parents and patterns, in the order of [`World::bodies`].
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// Number of frames so far.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// [s]
    pub fn time(&self) -> f64 {
        self.frame as f64 * self.dt
    }

    /// Length of a frame [s].
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Along each axis [m/s^2].
    pub fn gravity(&self) -> DVec3 {
        self.gravity
    }

    /// Which step advances a frame.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Iteration counts and switches of the method.
    pub fn settings(&self) -> &StepSettings {
        &self.settings
    }

    /// Sets [`World::settings`]; for experiments and negative controls.
    ///
    /// # Errors
    /// If a frame could not end with them.
    pub fn set_settings(&mut self, settings: StepSettings) -> Result<(), BuildError> {
        let at = Checker::root().field("settings");
        settings.check().map_err(|rule| at.broken(&format!("{settings:?}"), rule))?;
        self.settings = settings;
        Ok(())
    }

    /// Lets reports say how long each stage took, by a clock of the caller's that counts seconds.
    /// The engine has none of its own; until it is given one all stages take 0 ms.
    pub fn set_clock(&mut self, seconds: fn() -> f64) {
        self.clock = Some(seconds);
    }

    /// A text of the caller's that goes with the world, into snapshots too; empty at first.
    pub fn note(&self) -> &str {
        &self.note
    }

    /// Sets [`World::note`].
    pub fn set_note(&mut self, note: String) {
        self.note = note;
    }

    /// Sets the velocity of a dynamic or kinematic body: `linear` of its centre of mass [m/s] and
    /// `angular` [rad/s], world frame. A kinematic body keeps it until the next call. The change of
    /// energy and momentum belongs to no step and no report.
    ///
    /// # Errors
    /// If the body is gone, static or waiting, or a number is out of range.
    pub fn set_velocity(
        &mut self,
        id: BodyId,
        linear: DVec3,
        angular: DVec3,
    ) -> Result<(), BuildError> {
        let at = Checker::root();
        let body = at.field("body");
        let linear = at.field("linear").bounded(linear.to_array(), MOST_SPEED, "m/s")?;
        let angular = at.field("angular").bounded(angular.to_array(), MOST_SPIN, "rad/s")?;
        let dense = self.living(id)?;
        if self.labels[dense].waiting.is_some() {
            return Err(body.broken("waiting", "started before"));
        }
        match self.bodies.motions[dense] {
            Motion::Static => return Err(body.broken("static", "dynamic or kinematic")),
            Motion::Kinematic { .. } => {
                self.bodies.motions[dense] = Motion::Kinematic { linear, angular }
            }
            Motion::Dynamic => {
                let orientation = self.bodies.poses[dense].orientation;
                let (shape, density) = (&self.bodies.shapes[dense], self.bodies.densities[dense]);
                self.bodies.velocities[dense] =
                    Velocity::spinning(linear, angular, orientation, shape, density);
            }
        }
        self.bodies.activities[dense].drowsiness = Drowsiness::default();
        Ok(())
    }

    /// Takes a living body out of the world, with its energy and momentum, which belong to no step
    /// and no report.
    ///
    /// # Errors
    /// If the body is gone.
    pub fn remove_body(&mut self, id: BodyId) -> Result<(), BuildError> {
        let dense = self.living(id)?;
        let gone: Vec<bool> = (0..self.bodies.len()).map(|i| i == dense).collect();
        self.remove(&gone);
        Ok(())
    }

    /// Dense index of a living body.
    pub(crate) fn living(&self, id: BodyId) -> Result<usize, BuildError> {
        let rule = "the id of a living body";
        let broken = || Checker::root().field("body").broken(&id_number(id).to_string(), rule);
        self.bodies.index_of(id).ok_or_else(broken)
    }

    /// True if a body waits for its start; see [starts](crate::BodyDesc::starts).
    pub fn is_waiting(&self, id: BodyId) -> bool {
        self.bodies.index_of(id).is_some_and(|dense| self.labels[dense].waiting.is_some())
    }

    /// Starts a body that waits, with its initial velocities, from the next step on. Its energy and
    /// momentum belong to no step and no report. False if it does not wait.
    pub fn start(&mut self, id: BodyId) -> bool {
        let waits = self.is_waiting(id);
        if let (true, Some(dense)) = (waits, self.bodies.index_of(id)) {
            self.start_at(dense);
        }
        waits
    }

    /// Mass of a living body that is dynamic, or will be once it starts [kg]; infinite for others.
    pub fn mass(&self, id: BodyId) -> Option<f64> {
        let dense = self.bodies.index_of(id)?;
        let bodies = &self.bodies;
        let waits = self.labels[dense].waiting.is_some();
        let whole = || bodies.densities[dense] * bodies.shapes[dense].volume;
        Some(if waits { whole() } else { bodies.masses[dense] })
    }

    /// True if a body slept in the last frame; see [sleep](crate::SceneDesc::sleep).
    pub fn is_asleep(&self, id: BodyId) -> bool {
        let dense = self.bodies.index_of(id);
        dense.is_some_and(|dense| self.bodies.activities[dense].drowsiness.is_asleep)
    }

    /// The closed surface of a living body in its own frame; `None` if the id is stale. Made when
    /// asked for.
    pub fn surface(&self, id: BodyId) -> Option<Surface> {
        self.bodies.index_of(id).map(|dense| self.bodies.shapes[dense].surface())
    }

    /// Kinetic and potential energy of all dynamic bodies as they are now [J].
    pub fn energy(&self) -> (f64, f64) {
        let totals = Totals::of(&self.bodies, &self.frame_constants());
        (totals.kinetic, totals.potential)
    }

    /// For each pair of bodies that overlaps now, how deep [m]: the shortest way that parts balls,
    /// half-spaces and convex polyhedra; of compounds, the deepest of their parts; of level sets,
    /// the deepest sample. Found when asked for.
    pub fn penetrations(&self) -> Vec<f64> {
        find_penetrations(&self.bodies).into_iter().map(|(_, depth)| depth).collect()
    }

    /// Adds a body behind all others.
    pub(crate) fn spawn(&mut self, mut body: NewBody, label: Label) -> BodyId {
        body.surface.glued = label.bonds.is_some();
        self.labels.push(label);
        self.bodies.spawn(body)
    }

    /// Starts a body if it waits.
    pub(crate) fn start_at(&mut self, dense: usize) {
        if let Some(waiting) = self.labels[dense].waiting.take() {
            self.bodies.make_dynamic(dense, waiting.velocity);
        }
    }

    /// Lets a body bear everything until the frame ends.
    pub(crate) fn spare(&mut self, dense: usize) {
        let bears = &mut self.bodies.surfaces[dense].strength;
        self.spared.push((self.bodies.ids[dense], std::mem::replace(bears, f64::INFINITY)));
    }

    /// The shape that a body breaks as, in its body frame.
    pub(crate) fn solid(&self, dense: usize) -> Arc<Shape> {
        let solid =
            self.labels[dense].breaking.as_ref().and_then(|breaking| breaking.solid.clone());
        solid.unwrap_or_else(|| self.bodies.shapes[dense].clone())
    }

    /// True if an impact may break a body, or its bonds.
    pub(crate) fn may_break(&self) -> bool {
        let may_break = |i| self.bodies.strength(i).is_finite() || self.labels[i].may_lose_bonds();
        (0..self.bodies.len()).any(may_break)
    }

    /// Lets the spared bodies break again.
    pub(crate) fn end_sparing(&mut self) {
        self.born_of_pieces = 0;
        for (id, bears) in std::mem::take(&mut self.spared) {
            if let Some(dense) = self.bodies.index_of(id) {
                self.bodies.surfaces[dense].strength = bears;
            }
        }
    }

    /// Removes the bodies whose entry in `gone` is true; returns the new dense index of each old
    /// one.
    pub(crate) fn remove(&mut self, gone: &[bool]) -> Vec<Option<usize>> {
        let mut dense = 0;
        self.labels.retain(|_| {
            dense += 1;
            !gone[dense - 1]
        });
        self.bodies.remove(gone)
    }

    /// Constants of the next frame, common to all stages.
    pub(crate) fn frame_constants(&self) -> Frame {
        Frame { dt: self.dt, gravity: self.gravity, settings: self.settings }
    }

    /// A fingerprint of ids, poses and velocities, bit by bit: equal states have equal hashes, on
    /// every platform.
    pub fn state_hash(&self) -> u64 {
        let mut hash = Fnv1a::default();
        hash.add(self.frame);
        for i in 0..self.bodies.len() {
            let (pose, velocity) = (&self.bodies.poses[i], &self.bodies.velocities[i]);
            hash.add(id_number(self.bodies.ids[i]));
            pose.position.to_array().into_iter().for_each(|x| hash.add(x.to_bits()));
            pose.orientation.to_array().into_iter().for_each(|x| hash.add(x.to_bits()));
            velocity.linear.to_array().into_iter().for_each(|x| hash.add(x.to_bits()));
            velocity.angular_momentum.to_array().into_iter().for_each(|x| hash.add(x.to_bits()));
        }
        hash.digest()
    }
}
