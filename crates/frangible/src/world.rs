//! The world: bodies, how they break, and the books.

use crate::report::books::{Books, Totals};
use crate::report::id_number;
use crate::scene::check::{BuildError, Checker, MOST_SPEED, MOST_SPIN};
use crate::scene::desc::{LookDesc, Method};
use crate::scene::fineness::Fineness;
use crate::scene::strength::Strength;
use crate::step::body_path::BodyPath;
use crate::step::bonds::state::Bonds;
use frangible_bodies::{
    Bodies, BodyId, Drowsiness, Frame, Motion, NewBody, StepSettings, Velocity,
};
use frangible_collision::{BirthFits, ContactCache, ImpulseCache, find_penetrations};
use frangible_dynamics::Ledger;
use frangible_fracture::{Fragment, Pattern, ShatterSettings, StrengthPoints};
use frangible_geometry::{Shape, Surface};
use glam::DVec3;
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
    /// Pairs of polyhedra as they were in the last frame.
    pub(crate) contact_cache: ContactCache,
    /// Overlaps of fragments at birth.
    pub(crate) fits: BirthFits,
    /// Bodies temporarily unbreakable in the running frame, with their own strength [N s].
    pub(crate) spared: Vec<(BodyId, f64)>,
    /// The caller's [s], for the report.
    pub(crate) clock: Option<fn() -> f64>,
}

/// Engine data of a body, unused by dynamics.
#[derive(Clone, Debug)]
pub struct Label {
    /// From the scene; a fragment has its parent's with a number.
    pub name: String,
    /// Parent of a fragment.
    pub parent: Option<BodyId>,
    /// Appearance, unused by physics.
    pub look: Option<LookDesc>,
    /// Fracture data of breakable bodies. Boxed: few bodies break, and all labels are read in each
    /// frame.
    pub breaking: Option<Box<Breaking>>,
    /// Glued pieces of a body, if any.
    pub bonds: Option<Box<Bonds>>,
    /// Given motion of a kinematic body, if any.
    pub path: Option<Box<BodyPath>>,
}

/// A break need not meet the number of pieces that is asked for more closely: each try costs a
/// break.
const PIECES_WITHIN: f64 = 0.1;

/// Fracture data of a body.
#[derive(Clone, Debug)]
pub struct Breaking {
    /// Patterns of prescored space: first as described, then ever coarser, for blows with less
    /// energy than all cracks need.
    pub patterns: Vec<Arc<Pattern>>,
    /// Number of pieces, if given, and the patterns to choose from.
    pub pieces: Option<(usize, Arc<Fineness>)>,
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
    pub strength_points: Option<Arc<StrengthPoints>>,
}

impl Breaking {
    /// The largest impulse that a body bears where it is weakest [N s].
    pub(crate) fn bears(&self, shape: &Shape, density: f64) -> f64 {
        let least = self.strength_points.as_ref().map_or(1.0, |points| points.least());
        least * self.strength.bears(shape, density)
    }

    /// The pattern of a step, at first as fine as described, then ever coarser, and the fragments
    /// that it makes; `None` beyond the coarsest.
    pub(crate) fn cut(
        &self,
        step: usize,
        shatter: impl Fn(&Pattern) -> Vec<Fragment>,
    ) -> Option<(Arc<Pattern>, Vec<Fragment>)> {
        let Some((pieces, fineness)) = &self.pieces else {
            return self.patterns.get(step).map(|pattern| (pattern.clone(), shatter(pattern)));
        };
        let wanted = pieces >> step.min(usize::BITS as usize - 1);
        if wanted < 2 {
            return None;
        }
        let attempt = |pattern: &Pattern| {
            let fragments = shatter(pattern);
            (fragments.len(), fragments)
        };
        let found = fineness.search(wanted, PIECES_WITHIN, attempt)?;
        Some((found.pattern, found.made))
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

    /// Iteration counts and switches of the method; for experiments and negative controls.
    pub fn settings_mut(&mut self) -> &mut StepSettings {
        &mut self.settings
    }

    /// Lets reports say how long each stage took, by a clock of the caller's that counts seconds.
    /// The engine has none of its own; until it is given one all stages take 0 ms.
    pub fn set_clock(&mut self, seconds: fn() -> f64) {
        self.clock = Some(seconds);
    }

    /// Sets the velocity of a dynamic or kinematic body: `linear` of its centre of mass [m/s] and
    /// `angular` [rad/s], world frame. A kinematic body keeps it until the next call. The change of
    /// energy and momentum belongs to no step and no report.
    ///
    /// # Errors
    /// If the body is gone or static, or a number is out of range.
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
        let dense = self
            .bodies
            .index_of(id)
            .ok_or_else(|| body.broken(&id_number(id).to_string(), "the id of a living body"))?;
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
    pub(crate) fn spawn(&mut self, body: NewBody, label: Label) -> BodyId {
        self.labels.push(label);
        self.bodies.spawn(body)
    }

    /// Lets a body bear everything until the frame ends.
    pub(crate) fn spare(&mut self, dense: usize) {
        let bears = &mut self.bodies.surfaces[dense].strength;
        self.spared.push((self.bodies.ids[dense], std::mem::replace(bears, f64::INFINITY)));
    }

    /// Lets the spared bodies break again.
    pub(crate) fn end_sparing(&mut self) {
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
        hash.0
    }
}

/// 64-bit FNV-1a [FNV]: a fixed function, unlike the standard library's hasher.
struct Fnv1a(u64);

impl Default for Fnv1a {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv1a {
    fn add(&mut self, word: u64) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
