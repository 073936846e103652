//! One frame: a page of named stages (docs/the_step.md).

pub(crate) mod body_path;
pub(crate) mod bonds;
pub(crate) mod break_bodies;
mod closing;
mod follow_paths;
pub(crate) mod local_strength;
mod moved;
mod newmark;
pub(crate) mod quarantine;
mod stage_clock;
mod substeps;
pub(crate) mod waiting;

use crate::hand::grip::pull_held;
use crate::report::StepReport;
use crate::scene::desc::Method;
use crate::step::bonds::free_overloaded;
use crate::step::closing::Opening;
use crate::step::follow_paths::follow_paths;
use crate::step::newmark::move_by_newmark;
use crate::step::quarantine::{contain, take_out, take_out_faulty};
use crate::step::stage_clock::StageClock;
use crate::step::substeps::move_by_substeps;
use crate::step::waiting::{Contacts, start_and_advance};
use crate::world::World;
use frangible_bodies::Frame;
use frangible_math::threads;

/// Advances a world by one frame: collide and break, move by the scene's method, balance, report
/// (docs/the_step.md). n is the frame's start. Cannot fail: what goes bad is quarantined and
/// reported. Long frames can be called off by [`Cancel`](crate::Cancel), on a copy of the world.
pub fn step(world: &mut World) -> StepReport {
    // Many bodies are shared among the threads of the pool that this is called in, or of the global
    // one; the bits are the same.
    if world.bodies.len() > FEW && rayon::current_num_threads() > 1 {
        threads::in_pool(|| advance(world))
    } else {
        advance(world)
    }
}

/// Fewer bodies than this are not worth the way into the pool.
const FEW: usize = 256;

/// [`step`] on this thread, and on those of its pool if it has one.
fn advance(world: &mut World) -> StepReport {
    let frame = world.frame_constants();

    // Kinematic bodies are where their paths say, held ones are pulled, and those that wait start.
    follow_paths(world);
    pull_held(world);
    start_and_advance(world, &frame, advance_started)
}

/// [`advance`] once all have started that are known to be due; beside the report, who touched
/// whom.
fn advance_started(world: &mut World, frame: &Frame) -> (StepReport, Contacts) {
    let mut clock = StageClock::new(world.clock);

    // Overloaded bonds break [Kaw78], before the books open: what was static starts at rest.
    let freed = free_overloaded(world, frame);
    clock.lap("free_overloaded");
    let mut opening = Opening::of(world, freed, frame);

    // Break what does not bear its blows, bodies [Su09 sec. 4.2] and bonds [Kaw78] (adr/014), and
    // move: collisions, contact, positions. Fragments meet their striker in the frame that made them.
    let mut moved = match world.method {
        // Newmark's scheme with clamped impulses [SSF08], [Su09 sec. 3].
        Method::Paper | Method::PaperUncorrected => {
            move_by_newmark(world, &mut opening, frame, &mut clock)
        }
        // One detection, then substeps with soft contacts [Cat24], [Mac19] (adr/010).
        Method::FrameRate => move_by_substeps(world, &mut opening, frame, &mut clock),
    };
    world.end_sparing();

    // Bodies whose numbers went bad stay where they were, with those that they touch.
    let culprits = contain(world, &moved.before, &mut moved.accounts);

    // Balance the energy of every island: none ends with more than it had and was given (adr/009).
    let balance = opening.balance_energy(world, &mut moved, frame);
    clock.lap("balance_energy");

    // Take out bodies with bad numbers, close the books, and report.
    take_out(world, &culprits);
    moved.quarantined.extend(culprits);
    take_out_faulty(world, &mut moved.quarantined);
    let mut report = opening.close(world, &mut moved, balance, frame);
    clock.lap("report");
    report.stages = clock.laps;
    (report, Contacts { hit: moved.hit, links: moved.accounts.links })
}
