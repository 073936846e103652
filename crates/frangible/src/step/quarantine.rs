//! Quarantine: a single bad body must not destroy the world.
//!
//! Values are checked at transfer points between bodies: before collision detection, to keep bad
//! values out of the solver; and before energy balancing, to keep them out of the ledger.

use crate::report::{Quarantined, id_number};
use crate::world::World;
use frangible_bodies::{Bodies, BodyId, Inertia, Pose, Velocity};
use frangible_dynamics::FrameAccounts;
use std::collections::BTreeMap;

/// Reciprocals of mass [1/kg] and moments [1/(kg m^2)] that single precision holds, with room for
/// the squares of levers and for sums.
const MOST_INVERSE: f64 = 1e30;
const LEAST_INVERSE: f64 = 1e-30;

/// True if impulses on a body can be reckoned with in single precision.
pub(crate) fn is_representable(inertia: &Inertia) -> bool {
    let holds = |inverse: f64| (LEAST_INVERSE..=MOST_INVERSE).contains(&inverse);
    holds(inertia.inverse_mass) && inertia.inverse_moments.to_array().into_iter().all(holds)
}

/// Fault of a body, if any.
fn fault(bodies: &Bodies, i: usize) -> Option<&'static str> {
    let (pose, velocity, inertia) = (&bodies.poses[i], &bodies.velocities[i], &bodies.inertias[i]);
    match () {
        () if !pose.position.is_finite() => Some("position not finite"),
        () if !pose.orientation.is_finite() => Some("orientation not finite"),
        () if !velocity.linear.is_finite() => Some("velocity not finite"),
        () if !velocity.angular_momentum.is_finite() => Some("angular momentum not finite"),
        () if !inertia.is_infinite() && !is_representable(inertia) => {
            Some("mass or inertia out of the range of single precision")
        }
        () => None,
    }
}

/// Takes out every body with a fault.
pub(crate) fn take_out_faulty(world: &mut World, quarantined: &mut Vec<Quarantined>) {
    let bodies = &world.bodies;
    let faults: Vec<Option<&str>> = (0..bodies.len()).map(|i| fault(bodies, i)).collect();
    let of_body = |(fault, id): (&Option<&'static str>, &BodyId)| {
        fault.map(|cause| Quarantined { body: id_number(*id), cause })
    };
    let found: Vec<Quarantined> = faults.iter().zip(&bodies.ids).filter_map(of_body).collect();
    if !found.is_empty() {
        world.remove(&faults.iter().map(Option::is_some).collect::<Vec<_>>());
        quarantined.extend(found);
    }
}

/// Where bodies were, and how they moved, before the solver.
pub(crate) struct Before {
    poses: Vec<Pose>,
    velocities: Vec<Velocity>,
}

impl Before {
    pub(crate) fn of(bodies: &Bodies) -> Self {
        Self { poses: bodies.poses.clone(), velocities: bodies.velocities.clone() }
    }
}

/// If numbers went bad in the solver: of all bodies that are bad together, because they touch, the
/// one that answers impulses most is the culprit, and the others stay for this frame as they were
/// before. Returns the culprits, which are to be taken out once the frame is over; they are still
/// there, as they were. The books of such a frame are void, but for the pairs that touched.
pub(crate) fn contain(
    world: &mut World,
    before: &Before,
    accounts: &mut FrameAccounts,
) -> Vec<Quarantined> {
    let bodies = &mut world.bodies;
    let faults: Vec<Option<&str>> = (0..bodies.len()).map(|i| fault(bodies, i)).collect();
    let bad: Vec<usize> = (0..bodies.len()).filter(|&i| faults[i].is_some()).collect();
    if bad.is_empty() {
        return Vec::new();
    }

    // Groups of touching bad bodies, named by their first body.
    let mut first_of: BTreeMap<usize, usize> = bad.iter().map(|&i| (i, i)).collect();
    let links: Vec<[usize; 2]> = (accounts.links.iter())
        .filter_map(|&(a, b)| Some([bodies.index_of(a)?, bodies.index_of(b)?]))
        .filter(|link| {
            link.iter().all(|&i| faults[i].is_some() && !bodies.inertias[i].is_infinite())
        })
        .collect();
    loop {
        let mut has_changed = false;
        for link in &links {
            let least = first_of[&link[0]].min(first_of[&link[1]]);
            for i in link {
                has_changed |= first_of.insert(*i, least) != Some(least);
            }
        }
        if !has_changed {
            break;
        }
    }
    let answer = |i: usize| bodies.inertias[i].inverse_moments.max_element();
    let mut culprit_of: BTreeMap<usize, usize> = BTreeMap::new();
    for (&i, &group) in &first_of {
        let culprit = culprit_of.entry(group).or_insert(i);
        if answer(i) > answer(*culprit) {
            *culprit = i;
        }
    }
    let culprits = culprit_of.values().filter_map(|&i| {
        faults[i].map(|cause| Quarantined { body: id_number(bodies.ids[i]), cause })
    });
    let culprits = culprits.collect();

    let ids: Vec<BodyId> = bad.iter().map(|&i| bodies.ids[i]).collect();
    for i in bad {
        (bodies.poses[i], bodies.velocities[i]) = (before.poses[i], before.velocities[i]);
    }
    world.warm.forget(&ids);
    let links = std::mem::take(&mut accounts.links);
    *accounts = FrameAccounts::default();
    accounts.links = links;
    culprits
}

/// Takes out bodies that are known to be bad.
pub(crate) fn take_out(world: &mut World, culprits: &[Quarantined]) {
    if !culprits.is_empty() {
        let is_culprit =
            |id: &BodyId| culprits.iter().any(|culprit| culprit.body == id_number(*id));
        let gone: Vec<bool> = world.bodies.ids.iter().map(is_culprit).collect();
        world.remove(&gone);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::desc::shape::ShapeDesc;
    use crate::scene::desc::{BodyDesc, SceneDesc};
    use crate::step;
    use glam::DVec3;

    /// A heavy cube on the ground, a light one on top of it, and another one far away.
    fn world() -> World {
        let cube = |name: &str, edge: f64, x: f64, y: f64| BodyDesc {
            position: [x, y, 0.0],
            ..BodyDesc::new(
                name,
                ShapeDesc::Box { size: [edge; 3], resolution: Default::default() },
            )
        };
        let mut scene = SceneDesc::new("quarantine");
        scene.bodies = vec![
            BodyDesc::ground(0.0),
            cube("heavy", 1.0, 0.0, 0.5),
            cube("light", 0.1, 0.0, 1.05),
        ];
        scene.bodies.push(cube("far", 1.0, 50.0, 0.5));
        World::build(&scene).unwrap()
    }

    fn names(world: &World) -> Vec<&str> {
        world.labels.iter().map(|label| label.name.as_str()).collect()
    }

    /// A body that is bad before the frame touches no other in it.
    #[test]
    fn a_bad_body_is_taken_out_before_it_meets_others() {
        let mut world = world();
        (0..5).for_each(|_| _ = step(&mut world));
        let before = world.bodies.poses[1];
        let culprit = world.bodies.ids[2];
        world.bodies.velocities[2].linear.y = f64::NAN;
        let report = step(&mut world);
        let cause = "velocity not finite";
        assert_eq!(report.quarantined, [Quarantined { body: id_number(culprit), cause }]);
        assert_eq!(names(&world), ["ground", "heavy", "far"]);
        assert!(world.bodies.poses[1].position.distance(before.position) < 1e-4);
        assert!(!serde_json::to_string(&report).unwrap().contains("null"));
    }

    /// In a group of bad bodies only the body with the strongest response to impulses is removed;
    /// the others keep their state.
    #[test]
    fn only_the_culprit_goes() {
        let mut world = world();
        let mut accounts = FrameAccounts::default();
        accounts.link(&world.bodies, frangible_bodies::Pair { first: 1, second: 2 });
        let before = Before::of(&world.bodies);
        for i in [1, 2] {
            world.bodies.velocities[i].angular_momentum = DVec3::NAN;
            world.bodies.poses[i].position = DVec3::INFINITY;
        }
        accounts.causes.contact = f64::NAN;
        let culprits = contain(&mut world, &before, &mut accounts);
        let light =
            Quarantined { body: id_number(world.bodies.ids[2]), cause: "position not finite" };
        assert_eq!(culprits, [light]);
        assert_eq!(world.bodies.poses, before.poses);
        assert_eq!((accounts.causes.contact, accounts.links.len()), (0.0, 1));
        take_out(&mut world, &culprits);
        assert_eq!(names(&world), ["ground", "heavy", "far"]);
        assert!(step(&mut world).quarantined.is_empty());
    }
}
