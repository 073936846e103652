//! Bodies that a caller cuts along a plane, or breaks without a blow.

use crate::report::{Fracture, id_from_number};
use crate::scene::check::{BuildError, Checker};
use crate::scene::pattern_choice::Struck;
use crate::step::bonds::fall_apart::{Broken, fall_apart};
use crate::step::break_bodies::{Break, Cause, replace};
use crate::world::{Breaking, Label, World};
use frangible_bodies::{BodyId, Motion};
use frangible_fracture::{
    Fragment, Impact, Interface, Pattern, RigidPiece, ShatterSettings, Smallest, shatter,
};
use frangible_geometry::{Geometry, Shape};
use glam::DVec3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The fastest that pieces may be sent apart [m/s].
const MOST_BURST: f64 = 1e3;

impl World {
    /// Cuts a body along a plane through a point [m], across a normal of any length, both in the
    /// world frame; returns its pieces, or nothing if the plane does not part it. They have its
    /// mass, move as it moved, and break as it would have. The energy of cracks is not counted. Of
    /// a glued body the bonds give way whose pieces lie on both sides. The next report tells of the
    /// break, with the body as its own striker.
    ///
    /// # Errors
    /// If the body is gone, waiting or cannot be cut, or a number is out of range.
    pub fn cut(
        &mut self,
        id: BodyId,
        point: DVec3,
        normal: DVec3,
    ) -> Result<Vec<BodyId>, BuildError> {
        let at = Checker::root();
        let point = at.field("point").vector(point.to_array(), "m")?;
        let normal = direction(normal, &at.field("normal"))?;
        let dense = self.parted_by_hand(id)?;
        let world_from_body = self.bodies.poses[dense].world_from_body();
        let body_from_world = world_from_body.inverse();
        let impact = Impact {
            point_body: body_from_world.point(point),
            normal_body: body_from_world.direction(normal),
        };
        if self.labels[dense].bonds.is_some() {
            let pieces_from_body = self.bodies.shapes[dense].body_from_grid.inverse();
            let through = pieces_from_body.point(impact.point_body);
            let across = pieces_from_body.direction(impact.normal_body);
            let is_above = |piece: &RigidPiece| across.dot(piece.center - through) > 0.0;
            let parts = |bond: &Interface, pieces: &[RigidPiece]| {
                is_above(&pieces[bond.a]) != is_above(&pieces[bond.b])
            };
            return Ok(self.part_glued(dense, point, parts));
        }
        let shape = self.solid(dense);
        // A body that can break no more is cut all the same.
        let breaking = self.labels[dense].breaking.as_deref().cloned();
        let settings = match &breaking {
            Some(Breaking { shatter, .. }) => {
                ShatterSettings { reach: None, twist: 0.0, ..*shatter }
            }
            None => ShatterSettings { smallest: Smallest::of_first(&shape), ..Default::default() },
        };
        let pattern = Pattern::halves();
        let fragments = shatter(&shape, &pattern, &impact, &settings);
        if fragments.is_empty() {
            return Err(uncut(&shape));
        }
        // Its pieces break as often as it would have: a cut is no break.
        let breaking =
            breaking.map(|breaking| Breaking { generations: breaking.generations + 1, ..breaking });
        Ok(self.part(dense, point, (Arc::new(pattern), fragments), breaking))
    }

    /// Breaks a breakable body by its pattern, as a blow at a point of its surface would [m, world
    /// frame], and sends the pieces apart from its centre of mass, the farthest with `speed` [m/s]:
    /// neither momentum nor angular momentum changes, and the work is part of the next report.
    /// Returns the pieces; nothing if it is too small to break. A glued body loses all bonds.
    ///
    /// # Errors
    /// If the body is gone, waiting or unbreakable, or a number is out of range.
    pub fn burst(
        &mut self,
        id: BodyId,
        point: DVec3,
        speed: f64,
    ) -> Result<Vec<BodyId>, BuildError> {
        let at = Checker::root();
        let point = at.field("point").vector(point.to_array(), "m")?;
        let speed = at.field("speed").within(speed, 0.0, MOST_BURST)?;
        let dense = self.parted_by_hand(id)?;
        let center = self.bodies.poses[dense].position;
        let pieces = if self.labels[dense].bonds.is_some() {
            self.part_glued(dense, point, |_, _| true)
        } else {
            let label = &self.labels[dense];
            let breaking = label.breaking.as_deref().cloned().ok_or_else(|| unbroken(label))?;
            let shape = self.solid(dense);
            let point_body = self.bodies.poses[dense].world_from_body().inverse().point(point);
            let (_, normal_body) = shape.distance_and_gradient(point_body);
            let middle = breaking.center.map(|at| shape.body_from_grid.point(at));
            let impact = Impact { point_body: middle.unwrap_or(point_body), normal_body };
            let struck = Struck { shape: &shape, impact, settings: &breaking.shatter };
            let choice = breaking.choice.clone();
            match choice.draft(0, &struck).map(|draft| choice.finish(draft, &struck)) {
                Some(broken) => self.part(dense, point, broken, Some(breaking)),
                None => Vec::new(),
            }
        };
        self.send_apart(&pieces, center, speed);
        Ok(pieces)
    }

    /// Dense index of a body that is no static shape.
    fn parted_by_hand(&self, id: BodyId) -> Result<usize, BuildError> {
        let dense = self.living(id)?;
        let Label { bonds, waiting, .. } = &self.labels[dense];
        let is_anchored = bonds.is_some() && self.bodies.motions[dense] == Motion::Static;
        if is_anchored && waiting.is_none() {
            return Ok(dense);
        }
        self.moved_by_hand(id)
    }

    /// Replaces a body by its pieces, if they are several.
    fn part(
        &mut self,
        parent: usize,
        point_world: DVec3,
        (pattern, fragments): (Arc<Pattern>, Vec<Fragment>),
        breaking: Option<Breaking>,
    ) -> Vec<BodyId> {
        if fragments.len() < 2 {
            return Vec::new();
        }
        let striker = self.bodies.ids[parent];
        let cause = Cause { striker, point_world, impulse: 0.0, borne: 0.0 };
        let broken = Break { parent, breaking, pattern, fragments, spent: 0.0, cause };
        let (fractures, _) = replace(self, vec![broken]);
        self.end_sparing();
        self.report_later(fractures)
    }

    /// Breaks bonds of a glued body.
    fn part_glued(
        &mut self,
        body: usize,
        point: DVec3,
        gives_way: impl Fn(&Interface, &[RigidPiece]) -> bool,
    ) -> Vec<BodyId> {
        let Some(bonds) = &mut self.labels[body].bonds else { return Vec::new() };
        let glued = &mut bonds.glued;
        let lost = glued.bonds().iter().filter(|bond| gives_way(bond, glued.pieces()));
        let names: BTreeSet<[u32; 2]> = lost.map(|bond| glued.name_of(bond)).collect();
        glued.cut(&names);
        let broken = Broken { body, striker: body, point, impulse: 0.0, borne: 0.0 };
        let (fractures, _) = fall_apart(self, &[broken]);
        self.report_later(fractures)
    }

    /// Keeps breaks for the next report, and lets go of what is gone; returns the pieces.
    fn report_later(&mut self, fractures: Vec<Fracture>) -> Vec<BodyId> {
        let pieces = fractures.iter().flat_map(|fracture| &fracture.fragments);
        let ids = pieces.map(|&id| id_from_number(id)).collect();
        self.hand.handled.fractures.extend(fractures);
        let bodies = &self.bodies;
        self.hand.grips.retain(|grip| bodies.index_of(grip.body).is_some());
        ids
    }

    /// Adds to pieces velocities away from the centre of all, in proportion to their distance.
    fn send_apart(&mut self, pieces: &[BodyId], center: DVec3, speed: f64) {
        let at = |id: &BodyId| {
            let dense = self.bodies.index_of(*id)?;
            let is_free = !self.bodies.inertias[dense].is_infinite();
            is_free.then(|| (dense, self.bodies.poses[dense].position))
        };
        let places: Vec<(usize, DVec3)> = pieces.iter().filter_map(at).collect();
        let farthest = places.iter().map(|(_, place)| place.distance(center)).fold(0.0, f64::max);
        if farthest == 0.0 || speed == 0.0 {
            return;
        }
        for (dense, place) in places {
            let impulse = self.bodies.masses[dense] * (place - center) * (speed / farthest);
            self.push(dense, impulse, place);
        }
    }
}

fn direction(normal: DVec3, at: &Checker) -> Result<DVec3, BuildError> {
    let bounded = at.vector(normal.to_array(), "of any unit")?;
    let length = bounded.length();
    if length > 1e-9 {
        return Ok(bounded / length);
    }
    Err(at.broken(&format!("{:?}", normal.to_array()), "longer than 0"))
}

fn unbroken(label: &Label) -> BuildError {
    let (what, rule) = match label.parent {
        None => ("unbreakable", "breakable"),
        Some(_) => (
            "a piece that breaks no further",
            "breakable: raise `generations` of its `breaking`, or cut it",
        ),
    };
    Checker::root().field("body").broken(what, rule)
}

fn uncut(shape: &Shape) -> BuildError {
    let kind = match shape.geometry {
        Geometry::Compound(_) => "a compound",
        _ => "round and unbreakable",
    };
    Checker::root().field("body").broken(kind, "a polyhedron, breakable or of voxels, to be cut")
}
