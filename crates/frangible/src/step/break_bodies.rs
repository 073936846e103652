//! Where a blow becomes a break: bodies are replaced by their fragments [Su09 sec. 4.2].

use crate::report::at_rest::at_rest;
use crate::report::books::Totals;
use crate::report::{Fracture, Imbalance, id_number};
use crate::scene::desc::LookDesc;
use crate::scene::pattern_choice::{PatternChoice, Struck, counted};
use crate::world::{Breaking, Label, World};
use frangible_bodies::{
    Bodies, BodyId, Frame, Inertia, Motion, NewBody, Pair, Pose, SurfaceProperties, Velocity,
};
use frangible_dynamics::{Blow, FrameAccounts, Strike, energy_at, repay_at};
use frangible_fracture::{
    Fragment, Impact, Pattern, ShatterSettings, fragment_velocity, interfaces,
};
use glam::DVec3;
use std::sync::Arc;

/// Energy of the coarsest break, relative to what a blow has, above which finer ones are not looked
/// at: more pieces have more crack area, but for the places of the cracks.
const HOPELESS: f64 = 2.0;

/// The same of a break with plain faces in the place of rough ones, which have no less area, but
/// for what the grid makes of both.
const PLAIN: f64 = 1.1;

/// Pieces break into pieces until there are so many more in a frame; the others bear what strikes
/// them until the next one. Without a bound a disc of 30 slices that break twice again made 21,000
/// bodies in one frame, in 19 s.
const MOST_BORN_OF_PIECES: usize = 200;

/// A body in pieces that are about to take its place.
pub(crate) struct Break {
    /// By dense index.
    pub(crate) parent: usize,
    /// Of the pieces; `None` if none of them breaks.
    pub(crate) breaking: Option<Breaking>,
    /// The chosen pattern, affordable by the blow's energy.
    pub(crate) pattern: Arc<Pattern>,
    pub(crate) fragments: Vec<Fragment>,
    /// Energy spent on cracks [J].
    pub(crate) spent: f64,
    pub(crate) cause: Cause,
}

/// The blow that broke a body: see [`Fracture`].
#[derive(Clone, Copy)]
pub(crate) struct Cause {
    pub(crate) striker: BodyId,
    pub(crate) point_world: DVec3,
    pub(crate) impulse: f64,
    pub(crate) borne: f64,
}

/// Replaces broken bodies by their fragments. The borne impulse has already acted on parent and
/// striker; cracks take their energy from the remaining relative motion, and fragments continue the
/// parent's motion. Returns the fractures, and the new dense index of each old index.
pub(crate) fn break_bodies(
    world: &mut World,
    blows: &[Blow],
    accounts: &mut FrameAccounts,
) -> (Vec<Fracture>, Vec<Option<usize>>) {
    // Cut, and let the cracks take their energy: all impulses act before anybody is replaced.
    let mut gone = vec![false; world.bodies.len()];
    let mut breaks: Vec<Break> = Vec::new();
    for blow in blows {
        let Some(parent) = world.bodies.index_of(blow.body).filter(|&parent| !gone[parent]) else {
            continue;
        };
        if let Some(broken) = crack(world, blow, parent, accounts) {
            gone[parent] = true;
            breaks.push(broken);
        }
    }

    replace(world, breaks)
}

/// [`break_bodies`], and books what it does to the energy.
pub(crate) fn break_and_book(
    world: &mut World,
    blows: &[Blow],
    accounts: &mut FrameAccounts,
    frame: &Frame,
) -> (Vec<Fracture>, Vec<Option<usize>>) {
    book(world, accounts, frame, |world, accounts| break_bodies(world, blows, accounts))
}

/// Breaks bodies by impacts of which nothing has acted yet, in their order. An impact passes on what
/// the weaker body bears only if pieces come off. What came after a break of one of its bodies, or
/// after that body was turned off its way by breaking a heavier one, is left to the next pass.
pub(crate) fn break_by_strikes(
    world: &mut World,
    strikes: &[Strike],
    accounts: &mut FrameAccounts,
    frame: &Frame,
) -> Vec<Fracture> {
    book(world, accounts, frame, |world, accounts| {
        let mut is_known_until = vec![f64::INFINITY; world.bodies.len()];
        let mut gone = vec![false; world.bodies.len()];
        let mut breaks: Vec<Break> = Vec::new();
        for strike in strikes {
            let both = strike.pair.both();
            if both.into_iter().any(|i| gone[i] || strike.time > is_known_until[i]) {
                continue;
            }
            let broken = crack_by_strike(world, strike, accounts, frame);
            let inverse_mass = both.map(|i| world.bodies.inertias[i].inverse_mass);
            for (side, i) in both.into_iter().enumerate() {
                if !broken.is_empty() && inverse_mass[side] >= inverse_mass[1 - side] {
                    is_known_until[i] = is_known_until[i].min(strike.time);
                }
            }
            broken.iter().for_each(|broken| gone[broken.parent] = true);
            breaks.extend(broken);
        }
        replace(world, breaks)
    })
    .0
}

/// Cracks the bodies that an impact breaks, and passes on what is borne; or nothing.
fn crack_by_strike(
    world: &mut World,
    strike: &Strike,
    accounts: &mut FrameAccounts,
    frame: &Frame,
) -> Vec<Break> {
    let both = strike.pair.both();
    let before = both.map(|i| world.bodies.velocities[i]);
    let mut trial = FrameAccounts::default();
    strike.pass_on(&mut world.bodies, frame, &mut trial);
    let blows = strike.blows.iter().flatten();
    let cracked = blows.filter_map(|blow| {
        let parent = world.bodies.index_of(blow.body)?;
        crack(world, blow, parent, &mut trial)
    });
    let broken: Vec<Break> = cracked.collect();
    if broken.is_empty() {
        both.into_iter().zip(before).for_each(|(i, v)| world.bodies.velocities[i] = v);
    } else {
        accounts.add(trial);
    }
    broken
}

/// Breaks bodies and books the energy that no other cause has.
fn book<T>(
    world: &mut World,
    accounts: &mut FrameAccounts,
    frame: &Frame,
    breaks: impl FnOnce(&mut World, &mut FrameAccounts) -> T,
) -> T {
    let (energy, booked) = (Totals::of(&world.bodies, frame).energy(), accounts.causes.sum());
    let broken = breaks(world, accounts);
    let gained = Totals::of(&world.bodies, frame).energy() - energy;
    accounts.causes.fracture += gained - (accounts.causes.sum() - booked);
    broken
}

/// Replaces bodies by their pieces.
pub(crate) fn replace(
    world: &mut World,
    breaks: Vec<Break>,
) -> (Vec<Fracture>, Vec<Option<usize>>) {
    let mut gone = vec![false; world.bodies.len()];
    breaks.iter().for_each(|broken| gone[broken.parent] = true);

    // Fragments are born where they were in their parents.
    let mut born = Vec::new();
    let mut fractures = Vec::new();
    let mut are_rest = Vec::new();
    for mut broken in breaks {
        let first = born.len();
        let wanted = broken.breaking.as_ref().and_then(|breaking| breaking.choice.wanted());
        let counted = wanted.map(|wanted| counted(&broken.fragments, wanted));
        for (index, fragment) in std::mem::take(&mut broken.fragments).into_iter().enumerate() {
            let label = fragment_label(world, &broken, index, &fragment);
            are_rest.push(fragment.is_rest());
            born.push((fragment_body(&world.bodies, broken.parent, fragment, &label), label));
        }
        let Break { parent, spent, cause, .. } = broken;
        let pieces = || born[first..].iter().map(|(body, _)| body);
        let (rest_poses, contacts) = at_rest(&world.bodies, parent, pieces());
        fractures.push(Fracture {
            time: world.time(),
            body: id_number(world.bodies.ids[parent]),
            striker: id_number(cause.striker),
            point: cause.point_world.to_array(),
            impulse: cause.impulse,
            borne: cause.borne,
            energy: spent,
            wanted,
            counted,
            fragments: vec![0; born.len() - first],
            rest_poses,
            contacts,
            imbalance: imbalance(&world.bodies, parent, pieces()),
        });
    }

    // Parents leave, fragments enter behind all others, in order.
    let new_index = world.remove(&gone);
    let mut born = born.into_iter().zip(are_rest);
    for fracture in &mut fractures {
        for (id, ((body, label), is_rest)) in fracture.fragments.iter_mut().zip(&mut born) {
            *id = id_number(world.spawn(body, label));
            if is_rest {
                // What a blow leaves whole has borne it.
                world.spare(world.bodies.len() - 1);
            }
        }
    }
    (fractures, new_index)
}

/// Lays prescored space over a body and cuts it: as finely as the blow has energy for cracks.
/// `None` if that is not at all.
fn crack(
    world: &mut World,
    blow: &Blow,
    parent: usize,
    accounts: &mut FrameAccounts,
) -> Option<Break> {
    let breaking = Breaking::clone(world.labels[parent].breaking.as_ref()?);
    let is_piece = world.labels[parent].parent.is_some();
    if is_piece && world.born_of_pieces >= MOST_BORN_OF_PIECES {
        world.spare(parent);
        return None;
    }
    let striker = world.bodies.index_of(blow.striker)?;
    let pair = Pair { first: parent.min(striker), second: parent.max(striker) };
    let center = breaking.center.map(|at| world.bodies.shapes[parent].body_from_grid.point(at));
    let point_body = center.unwrap_or(blow.point_body);
    let impact = Impact { point_body, normal_body: blow.normal_body };
    let energy_per_area = breaking.strength.fracture_energy();
    let available = if energy_per_area > 0.0 {
        energy_at(&world.bodies, pair, blow.acts_at)
    } else {
        f64::INFINITY
    };

    let shape = world.solid(parent);
    let struck = Struck { shape: &shape, impact, settings: &breaking.shatter };
    let energy_of = |fragments: &[Fragment]| {
        if energy_per_area <= 0.0 {
            return 0.0;
        }
        energy_per_area * interfaces(fragments).iter().map(|interface| interface.area).sum::<f64>()
    };
    let (chosen, can_split) = choose_break(&breaking.choice, &struck, energy_of, available);
    if let Some(Chosen { pattern, fragments, spent }) = chosen {
        if spent > 0.0 {
            repay_at(&mut world.bodies, pair, blow.acts_at, spent, accounts);
        }
        world.born_of_pieces += if is_piece { fragments.len() } else { 0 };
        let &Blow { striker, point_world, impulse, borne, .. } = blow;
        let cause = Cause { striker, point_world, impulse, borne };
        return Some(Break { parent, breaking: Some(breaking), pattern, fragments, spent, cause });
    }
    if can_split || breaking.shatter.reach.is_some() {
        // Too little energy for this time, or nothing in reach.
        world.spare(parent);
    } else {
        // Too small to split: unbreakable from now on.
        world.bodies.surfaces[parent].strength = f64::INFINITY;
    }
    None
}

/// A break that a blow has energy for.
struct Chosen {
    pattern: Arc<Pattern>,
    fragments: Vec<Fragment>,
    /// Energy of its cracks [J].
    spent: f64,
}

/// The finest break that a blow has energy for, and true if the body could split at all.
fn choose_break(
    choice: &PatternChoice,
    struck: &Struck<'_>,
    energy_of: impl Fn(&[Fragment]) -> f64,
    available: f64,
) -> (Option<Chosen>, bool) {
    // The coarsest first: many blows have not even the energy for that.
    let coarsest = choice.steps().saturating_sub(1);
    if available.is_finite()
        && coarsest > 0
        && let Some(draft) = choice.draft(coarsest, struck)
        && draft.fragments.len() > 1
        && energy_of(&draft.fragments) > HOPELESS * available
    {
        return (None, true);
    }

    let mut can_split = false;
    for draft in (0..).map_while(|step| choice.draft(step, struck)) {
        if draft.fragments.len() < 2 {
            continue;
        }
        can_split = true;
        if draft.is_plain() && energy_of(&draft.fragments) > PLAIN * available {
            continue;
        }
        let (pattern, fragments) = choice.finish(draft, struck);
        let spent = energy_of(&fragments);
        if fragments.len() > 1 && spent <= available {
            return (Some(Chosen { pattern, fragments, spent }), true);
        }
    }
    (None, can_split)
}

/// A fragment's name, and how it breaks in turn: as the parent, but once less and not below the
/// smallest size. What a break with a reach leaves whole is the parent still.
fn fragment_label(world: &World, broken: &Break, index: usize, fragment: &Fragment) -> Label {
    let Break { parent, breaking, pattern, .. } = broken;
    let parent_label = &world.labels[*parent];
    let (low, high) = fragment.shape.bounds;
    let extent = (high - low).max_element();
    let breaking = breaking.as_ref().filter(|breaking| extent >= breaking.smallest);
    let is_joint = pattern.is_joint(fragment.cell as usize);
    Label {
        name: format!("{}.{index}", parent_label.name),
        parent: Some(world.bodies.ids[*parent]),
        whole: None,
        look: if is_joint { Some(LookDesc::Mortar) } else { parent_label.look },
        breaking: if fragment.is_rest() {
            breaking.map(|breaking| {
                Box::new(Breaking { center: None, solid: None, ..breaking.clone() })
            })
        } else {
            breaking.filter(|breaking| breaking.generations > 1).map(|breaking| {
                let generations = breaking.generations - 1;
                let shatter = ShatterSettings { reach: None, ..breaking.shatter };
                let parent = &world.bodies.shapes[*parent];
                let strength = breaking.strength.of_fragment(parent, &fragment.shape);
                let (center, solid) = (None, None);
                Box::new(Breaking {
                    generations,
                    strength,
                    shatter,
                    center,
                    solid,
                    ..breaking.clone()
                })
            })
        },
        bonds: None,
        path: None,
        waiting: None,
    }
}

/// Body of a fragment, with the parent's motion at its place.
pub(crate) fn fragment_body(
    bodies: &Bodies,
    parent: usize,
    fragment: Fragment,
    label: &Label,
) -> NewBody {
    let (pose, velocity) = (&bodies.poses[parent], &bodies.velocities[parent]);
    let world_from_fragment = pose.world_from_body().after(&fragment.parent_from_fragment);
    let pose_fragment = Pose {
        position: world_from_fragment.translation,
        orientation: world_from_fragment.rotation.normalize(),
    };

    // Angular momentum from the parent's angular velocity, at the fragment's own inertia.
    let density = bodies.densities[parent];
    let angular =
        bodies.inertias[parent].angular_velocity(pose.orientation, velocity.angular_momentum);
    let linear = fragment_velocity(velocity.linear, angular, pose.position, pose_fragment.position);
    let velocity =
        Velocity::spinning(linear, angular, pose_fragment.orientation, &fragment.shape, density);

    let strength = label
        .breaking
        .as_ref()
        .map_or(f64::INFINITY, |breaking| breaking.bears(&fragment.shape, density));
    NewBody {
        shape: Arc::new(fragment.shape),
        density,
        motion: Motion::Dynamic,
        pose: pose_fragment,
        velocity,
        surface: SurfaceProperties { strength, ..bodies.surfaces[parent] },
    }
}

/// Difference between the fragments' sums and the parent's.
pub(crate) fn imbalance<'a>(
    bodies: &Bodies,
    parent: usize,
    fragments: impl Iterator<Item = &'a NewBody>,
) -> Imbalance {
    let (pose, velocity) = (&bodies.poses[parent], &bodies.velocities[parent]);
    let mass = bodies.masses[parent];
    let spin =
        bodies.inertias[parent].rotational_energy(pose.orientation, velocity.angular_momentum);
    let (mut mass_sum, mut momentum, mut angular_momentum, mut kinetic) =
        (0.0, DVec3::ZERO, DVec3::ZERO, 0.0);
    // A body that turns in its place has no momentum of its own, but its fragments have.
    let (mut momentum_scale, mut angular_scale) = (0.0, 0.0);
    for fragment in fragments {
        let fragment_mass = fragment.density * fragment.shape.volume;
        let inertia = Inertia::of(&fragment.shape, fragment.density);
        let (at, moves) = (&fragment.pose, &fragment.velocity);
        let lever = at.position - pose.position;
        mass_sum += fragment_mass;
        let carried = fragment_mass * moves.linear;
        momentum += carried;
        angular_momentum += moves.angular_momentum + lever.cross(carried);
        momentum_scale += carried.length();
        angular_scale += moves.angular_momentum.length() + lever.length() * carried.length();
        kinetic += 0.5 * fragment_mass * moves.linear.length_squared()
            + inertia.rotational_energy(at.orientation, moves.angular_momentum);
    }
    let speed = velocity.linear.length();
    let size = (bodies.shapes[parent].bounds.1 - bodies.shapes[parent].bounds.0).length();
    momentum_scale += mass * speed;
    angular_scale += velocity.angular_momentum.length() + mass * speed * size;
    let relative = |difference: f64, scale: f64| difference / scale.max(f64::MIN_POSITIVE);
    let kinetic_before = 0.5 * mass * speed * speed + spin;
    Imbalance {
        mass: relative((mass_sum - mass).abs(), mass),
        momentum: relative((momentum - mass * velocity.linear).length(), momentum_scale),
        angular_momentum: relative(
            (angular_momentum - velocity.angular_momentum).length(),
            angular_scale,
        ),
        kinetic_energy: relative((kinetic - kinetic_before).abs(), kinetic_before),
    }
}
