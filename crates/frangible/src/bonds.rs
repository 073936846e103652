//! Bodies of glued pieces: one rigid body until a blow, or what they carry, breaks bonds, and
//! islands of pieces from then on.

pub(crate) mod blows;
pub(crate) mod rehearsal;

use crate::break_bodies::{fragment_body, imbalance};
use crate::check::{BuildError, Checker};
use crate::desc::breaking::BondsDesc;
use crate::desc::{BodyDesc, MotionDesc};
use crate::patterns::build_pattern;
use crate::report::{Fracture, Imbalance, id_number};
use crate::world::{Label, World};
use blows::Blows;
use frangible_bodies::{Frame, Motion, NewBody, Pair};
use frangible_dynamics::{ContactForce, Tally};
use frangible_fracture::bonds::prescore;
use frangible_fracture::{BondStrength, Fragment, Glued, Impact, PointLoad};
use frangible_geometry::{Compound, Hull, Shape};
use frangible_math::RigidTransform;
use glam::DVec3;
use rehearsal::rehearse;

/// How long a blow lasts [s]: stiff bodies of about a metre are in touch for some thousandths of a
/// second (by Hertz's law a ball of concrete, half a metre in radius and at 5 m/s, for 2 ms). A
/// blow's impulse over this time is its force.
const IMPACT_TIME: f64 = 2e-3;

/// Carried loads are forgotten below this part of the largest force [1].
const FAINT: f64 = 1e-2;

/// The pieces that a body is glued together of.
#[derive(Clone, Debug)]
pub struct Bonds {
    glued: Glued,
    /// Loads that its contacts carried in the last frame or, where that is shorter, on the average
    /// over the time that a blow lasts; in the pieces' frame.
    carried: Vec<PointLoad>,
    /// Between the surface samples of what it breaks into [m].
    sample_spacing: f64,
}

impl Bonds {
    /// Pieces and the bonds that hold, in the frame of the shape that the scene described.
    pub fn glued(&self) -> &Glued {
        &self.glued
    }

    pub(crate) fn is_anchored(&self) -> bool {
        self.glued.is_anchored()
    }
}

/// Cuts a body into pieces and glues them together.
pub(crate) fn build_bonds(
    desc: &BondsDesc,
    body: &BodyDesc,
    shape: &Shape,
    world_from_shape: &RigidTransform,
    at: &Checker,
) -> Result<Bonds, BuildError> {
    let strength = BondStrength {
        tension: at.field("tensile_strength").positive(desc.tensile_strength, "Pa")?,
        shear: at.field("shear_strength").positive(desc.shear_strength, "Pa")?,
    };
    if body.motion != MotionDesc::Dynamic {
        return Err(at.broken(
            "on a body that is not dynamic",
            "left out, or the body dynamic: anchors hold it",
        ));
    }
    if body.breaking.is_some() {
        return Err(at.broken("on a body with 'breaking'", "left out, or 'breaking' left out"));
    }
    let mut anchors = Vec::with_capacity(desc.anchors.len());
    for (index, anchor) in desc.anchors.iter().enumerate() {
        let at = at.field(&format!("anchors[{index}]"));
        anchors.push((
            at.field("low").vector(anchor.low, "m")?,
            at.field("high").vector(anchor.high, "m")?,
        ));
    }

    // Lay the pattern on its point.
    let middle = shape.body_from_grid.inverse().point(0.5 * (shape.bounds.0 + shape.bounds.1));
    let point = desc.point.map_or(Ok(middle), |point| at.field("point").vector(point, "m"))?;
    let at_normal = at.field("normal");
    let normal = at_normal
        .vector(desc.normal, "")?
        .try_normalize()
        .ok_or_else(|| at_normal.broken("0, 0, 0", "a direction"))?;
    let impact = Impact {
        point_body: shape.body_from_grid.point(point),
        normal_body: shape.body_from_grid.direction(normal),
    };
    let pattern = match &desc.pattern {
        Some(pattern) => Some(build_pattern(pattern, &at.field("pattern"))?),
        None => None,
    };
    let hulls = prescore(shape, pattern.as_ref(), &impact).ok_or_else(|| {
        at.broken(
            "on a shape or with a pattern that is not made of convex pieces",
            "on a box, a hull or a compound, with planar cells",
        )
    })?;
    let is_anchored = |center: DVec3| {
        let world = world_from_shape.point(center);
        anchors.iter().any(|(low, high)| low.cmple(world).all() && world.cmple(*high).all())
    };
    let glued = Glued::new(hulls, is_anchored, strength);
    if !anchors.is_empty() && !glued.is_anchored() {
        return Err(at.field("anchors").broken(
            "boxes without the centre of a piece",
            "boxes that hold the centres of the pieces to be fixed",
        ));
    }
    let (low, high) = shape.bounds;
    let spacing =
        body.shape.resolution().sample_spacing.unwrap_or(0.1 * (high - low).max_element());
    Ok(Bonds { glued, carried: Vec::new(), sample_spacing: spacing })
}

/// What came free before the frame's books were opened.
#[derive(Default)]
pub(crate) struct Freed {
    pub(crate) fractures: Vec<Fracture>,
    /// The frame's blows on bonds that are still to act.
    pub(crate) blows: Blows,
}

/// A body that has lost bonds.
struct Broken {
    body: usize,
    striker: usize,
    point: DVec3,
    impulse: f64,
    borne: f64,
}

/// Breaks what its own weight and its contacts overstrain, and anchored bodies that are struck.
/// What was anchored and comes free does so at rest, before the frame's books are opened: the world
/// that it was a part of has no books.
pub(crate) fn free_overloaded(world: &mut World, frame: &Frame) -> Freed {
    let mut overloaded = Vec::new();
    for body in 0..world.bodies.len() {
        // Few are glued.
        if world.labels[body].bonds.is_none() {
            continue;
        }
        let (field, density) = (field_in_pieces(world, body, frame), world.bodies.densities[body]);
        let Some(bonds) = &mut world.labels[body].bonds else { continue };
        if !bonds.glued.give_way(&bonds.carried, field, density).broken.is_empty() {
            let point = world.bodies.poses[body].position;
            overloaded.push(Broken { body, striker: body, point, impulse: 0.0, borne: 0.0 });
        }
    }
    let mut fractures = fall_apart(world, &overloaded);
    let mut blows = rehearse(world, frame);
    fractures.extend(blows.break_anchored(world));
    Freed { fractures, blows }
}

/// Strikers and what they strike feel what bonds bore before they broke; then what moves freely
/// falls apart.
pub(crate) fn strike_bonds(
    world: &mut World,
    blows: &Blows,
    frame: &Frame,
) -> (Vec<Fracture>, Tally) {
    let mut tally = Tally::default();
    blows.act(world, frame, &mut tally);
    (blows.break_free(world), tally)
}

/// Notes what the contacts of glued bodies carry, those of each pair together: their load in the
/// next frame.
pub(crate) fn note_carried(world: &mut World, forces: &[ContactForce]) {
    // In a frame that is shorter than a blow a contact's force may be a part of one.
    let share = (world.dt / IMPACT_TIME).min(1.0);
    for bonds in world.labels.iter_mut().filter_map(|label| label.bonds.as_mut()) {
        bonds.carried.iter_mut().for_each(|load| load.force *= 1.0 - share);
        let most = bonds.carried.iter().map(|load| load.force.length()).fold(0.0, f64::max);
        bonds.carried.retain(|load| load.force.length() > FAINT * most);
    }
    for of_pair in forces.chunk_by(|a, b| a.pair == b.pair) {
        let Some(Pair { first, second }) = of_pair.first().map(|force| force.pair) else {
            continue;
        };
        for (side, i) in [first, second].into_iter().enumerate() {
            let Some(bonds) = &mut world.labels[i].bonds else { continue };
            let pieces_from_body = world.bodies.shapes[i].body_from_grid.inverse();
            let body_from_world = world.bodies.poses[i].world_from_body().inverse();
            let load = |force: &ContactForce| {
                let on_this = share * if side == 0 { force.force } else { -force.force };
                PointLoad {
                    point: pieces_from_body.point(force.points[side]),
                    force: pieces_from_body.direction(body_from_world.direction(on_this)),
                }
            };
            let loads: Vec<PointLoad> = of_pair.iter().map(load).collect();
            bonds.carried.extend(bonds.glued.spread(loads));
        }
    }
}

/// Gravity in the frame of a body's pieces [m/s^2].
fn field_in_pieces(world: &World, body: usize, frame: &Frame) -> DVec3 {
    let in_body = world.bodies.poses[body].orientation.conjugate() * frame.gravity;
    world.bodies.shapes[body].body_from_grid.inverse().direction(in_body)
}

/// Replaces bodies that have lost bonds by the islands that still hold together: where they were,
/// moving as they did. Where one island is left, nothing but its bonds has changed.
fn fall_apart(world: &mut World, broken: &[Broken]) -> Vec<Fracture> {
    let mut gone = vec![false; world.bodies.len()];
    let mut born: Vec<(NewBody, Label)> = Vec::new();
    let mut fractures = Vec::new();
    for Broken { body, striker, point, impulse, borne } in broken {
        let Some(bonds) = &world.labels[*body].bonds else { continue };
        let islands = bonds.glued.islands();
        if islands.len() < 2 {
            continue;
        }
        gone[*body] = true;
        let first = born.len();
        let islands = islands.into_iter().enumerate();
        born.extend(islands.filter_map(|(index, island)| island_body(world, *body, index, island)));
        fractures.push(Fracture {
            body: id_number(world.bodies.ids[*body]),
            striker: id_number(world.bodies.ids[*striker]),
            point: point.to_array(),
            impulse: *impulse,
            borne: *borne,
            energy: 0.0,
            wanted: None,
            fragments: vec![0; born.len() - first],
            imbalance: if world.bodies.inertias[*body].is_infinite() {
                Imbalance::default()
            } else {
                imbalance(&world.bodies, *body, born[first..].iter().map(|(body, _)| body))
            },
        });
    }
    world.remove(&gone);
    let mut born = born.into_iter();
    for fracture in &mut fractures {
        for (id, (body, label)) in fracture.fragments.iter_mut().zip(&mut born) {
            *id = id_number(world.spawn(body, label));
        }
    }
    fractures
}

/// The body that an island of pieces becomes. Every piece has a volume, so that it always becomes
/// one.
fn island_body(
    world: &World,
    parent: usize,
    index: usize,
    glued: Glued,
) -> Option<(NewBody, Label)> {
    let sample_spacing = world.labels[parent].bonds.as_ref()?.sample_spacing;
    let mut hulls: Vec<Hull> = glued.hulls().iter().map(|hull| Hull::clone(hull)).collect();
    let shape = if let (1, Some(hull)) = (hulls.len(), hulls.first()) {
        Shape::convex(hull.clone(), sample_spacing)
    } else {
        Shape::compound(Compound::new(std::mem::take(&mut hulls)), sample_spacing)
    };
    let shape = shape.ok()?;
    let is_anchored = glued.is_anchored();
    let holds = glued.can_break();
    let bonds = holds.then(|| Box::new(Bonds { glued, carried: Vec::new(), sample_spacing }));
    let label = Label {
        name: format!("{}.{index}", world.labels[parent].name),
        parent: Some(world.bodies.ids[parent]),
        look: world.labels[parent].look,
        breaking: None,
        bonds,
    };
    let mut body = fragment_body(
        &world.bodies,
        parent,
        Fragment::new(&world.bodies.shapes[parent], shape, index as u32),
        &label,
    );
    if is_anchored {
        body.motion = Motion::Static;
    }
    Some((body, label))
}
