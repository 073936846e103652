//! The solver of the frame-rate method: one detection, then substeps of soft contact and
//! relaxation over batches of eight manifolds [Cat24] [Mac19].
//!
//! Single precision within the frame, relative to its start; double precision at its end.

mod confirmation;
pub(crate) mod constraints;
mod contact_batch;
pub(crate) mod contact_forces;
mod containment;
mod effective_mass;
pub(crate) mod finish;
mod friction;
mod group;
pub(crate) mod impact_log;
mod impacts_of_pairs;
mod joint_friction;
mod joint_impacts;
mod joint_lanes;
mod kernels;
mod lane_bodies;
mod meeting;
mod outline;
mod restitution;
mod sides;
mod slabs;
mod sleep;
mod solver_bodies;
mod solver_islands;
mod speculative_contacts;
mod substep;
#[cfg(test)]
mod tests;
mod timeline;
mod touching;

use crate::energy::frame_accounts::FrameAccounts;
use containment::contain;
use finish::{FrameStart, Solved, close_islands, fall};
use frangible_bodies::{Activity, Bodies, Frame, Motion, Substeps, evolve};
use frangible_collision::{FixedNeighbours, ImpulseCache, ImpulseChunk, Manifold};
#[cfg(test)]
use frangible_math::Scalar;
#[cfg(not(test))]
use frangible_math::with_widest;
use frangible_math::{Instructions, Kernel, threads};
use glam::DVec3;
use group::Group;
use slabs::NOWHERE;
use solver_islands::{Bundle, IslandGroups};
use std::collections::BTreeMap;

/// Advances all bodies by one frame and replaces the impulse cache `warm`. Contacts are manifolds,
/// and what stands beside the fixed bodies in them.
pub fn solve(
    bodies: &mut Bodies,
    contacts: (&[Manifold], &FixedNeighbours),
    warm: &mut ImpulseCache,
    frame: &Frame,
) -> Solved {
    #[cfg(not(test))]
    {
        with_widest(frame.settings.width, Solve { bodies, contacts, warm, frame })
    }
    // Unit tests compile a single width, which saves most of their compile time; the scene tests
    // compare the bits of all widths.
    #[cfg(test)]
    {
        Solve { bodies, contacts, warm, frame }.compute::<Scalar>()
    }
}

/// [`solve`] for one instruction set.
struct Solve<'a> {
    bodies: &'a mut Bodies,
    contacts: (&'a [Manifold<'a>], &'a FixedNeighbours),
    warm: &'a mut ImpulseCache,
    frame: &'a Frame,
}

impl Kernel for Solve<'_> {
    type Output = Solved;

    fn compute<I: Instructions>(self) -> Solved {
        let Self { bodies, contacts: (manifolds, neighbours), warm, frame } = self;
        let start = FrameStart::of(bodies);
        let carried = warm.of_manifolds(bodies, manifolds);
        let islands = IslandGroups::new(bodies, manifolds, &carried, frame);

        let mut solved = Solved {
            accounts: FrameAccounts::default(),
            gravity: (DVec3::ZERO, DVec3::ZERO),
            short_of_substeps: islands.short_of_substeps,
            short_of_impacts: 0,
            confirmed: BTreeMap::new(),
            impacts: Vec::new(),
        };
        let mut parts: Vec<ImpulseChunk> = Vec::new();
        let of_bundle = |lines: &mut Vec<u32>, Bundle { substeps, members }: Bundle| {
            let input = (manifolds, &carried[..]);
            let mut group = Group::<I>::new(bodies, input, (&members, substeps), lines, frame);
            group.run(bodies, (manifolds, neighbours), frame);
            group
        };
        let room = || vec![NOWHERE; bodies.len()];
        let groups = threads::map_with(islands.bundles, manifolds.len(), room, of_bundle);
        for group in groups {
            solved.short_of_impacts += usize::from(group.is_short());
            parts.push(group.write_back(bodies, manifolds, frame, &mut solved));
        }
        let from = (start.poses(), &islands.substeps[..]);
        contain(bodies, manifolds, from, frame, &mut solved.accounts);
        close_islands(bodies, &start, &islands.substeps, frame, &mut solved);
        let are_asleep = islands.sleep.hold(bodies, manifolds, &mut solved.accounts);
        fly(bodies, (&islands.substeps, &are_asleep), frame, &mut solved);
        parts.push(islands.sleep.carried(manifolds, &carried));
        *warm = ImpulseCache::of_parts(bodies, manifolds.len(), parts);
        let drowsiness = islands.sleep.drowsiness(bodies, frame, &are_asleep);
        for (i, substeps) in islands.substeps.into_iter().enumerate() {
            let drowsiness = drowsiness.get(i).copied().unwrap_or_default();
            bodies.activities[i] = Activity { substeps, drowsiness };
        }
        solved
    }
}

/// Integrates kinematic bodies, and dynamic bodies without contacts.
fn fly(
    bodies: &mut Bodies,
    (substeps, are_asleep): (&[Substeps], &[bool]),
    frame: &Frame,
    solved: &mut Solved,
) {
    for i in 0..bodies.len() {
        match bodies.motions[i] {
            Motion::Static => {}
            Motion::Kinematic { .. } => {
                let velocity = bodies.velocities[i];
                bodies.poses[i] = evolve(bodies, i, &bodies.poses[i], &velocity, frame);
            }
            Motion::Dynamic if substeps[i].count > 0 || are_asleep[i] => {}
            Motion::Dynamic => {
                let weight = frame.dt * bodies.masses[i] * frame.gravity;
                let from = bodies.poses[i].position;
                fall(bodies, i, frame);
                let middle = 0.5 * (from + bodies.poses[i].position);
                solved.gravity.0 += weight;
                solved.gravity.1 += middle.cross(weight);
            }
        }
    }
}
