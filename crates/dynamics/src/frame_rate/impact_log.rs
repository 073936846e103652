//! Impacts of breakable bodies, as the impact stage notes them lane by lane.

use super::constraints::MOST_POINTS;
use super::contact_batch::ContactBatch;
use super::solver_bodies::SolverBody;
use frangible_bodies::{Pair, Pose};
use frangible_collision::ContactPoint;
use frangible_math::{Instructions, Single};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// An impact of a pair, where static bodies count as one: the impulses along one normal in a substep.
/// Or a blow: impacts close to each other in time, where the contact is of the hardest.
#[derive(Clone, Debug)]
pub struct Impact {
    /// The two that exchange most of the impulse.
    pub pair: Pair,
    /// On the first body, world frame [N s].
    pub impulse: DVec3,
    /// Part of the impulse that acted in frames before this one [N s].
    pub earlier: DVec3,
    /// Start of its first substep, from the frame's start [s], and its number among the impacts of that
    /// substep and island group: a blow comes before what it causes.
    pub time: f64,
    /// See `time`.
    pub number: usize,
    /// Mean time of its impulses, from the frame's start [s].
    pub mean_time: f64,
    /// Where and along which normal, towards the first body, the impulse acts as it does, and the
    /// poses of both bodies then.
    pub contact: ContactPoint,
    /// See `contact`.
    pub poses: [Pose; 2],
    /// Poses of both bodies where the substep would end without the impact.
    pub poses_past: [Pose; 2],
    /// True if it acts at one point, not along an edge or on a face.
    pub is_at_point: bool,
    /// Where the impulse acts at the poses of the frame's start, world frame [m].
    pub acts_at: DVec3,
    /// Its parts, if a body of the pair is glued.
    pub parts: Vec<PointImpulse>,
}

/// Impulse at a point of a contact.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct PointImpulse {
    /// In the frames of both bodies [m].
    pub at: [DVec3; 2],
    /// On the first body, world frame [N s].
    pub impulse: DVec3,
}

impl PointImpulse {
    /// With the bodies the other way round.
    pub(crate) fn swapped(self) -> Self {
        Self { at: [self.at[1], self.at[0]], impulse: -self.impulse }
    }
}

/// Impulses in the impacts of a substep, for the lanes with breakable bodies.
#[derive(Default)]
pub(super) struct ImpactLog {
    pub(super) entries: Vec<LaneImpact>,
}

/// The impacts of a lane.
pub(super) struct LaneImpact {
    /// Index of the constraint.
    pub(super) number: u32,
    /// Both bodies before the first impact of the lane in the substep.
    pub(super) bodies: [SolverBody; 2],
    /// Impulses of the lane in the frame before it: along normal and tangents [N s].
    pub(super) before: [f64; 3],
    /// Normal impulses of the points [N s].
    pub(super) impulses: [f64; MOST_POINTS],
    /// Sum of the impulses, times when they act in the substep [N s^2].
    pub(super) time_sum: f64,
}

impl ImpactLog {
    /// Notes the normal impulses of a lane's points, before they are booked or move its bodies,
    /// which `bodies` has by solver line. They act at `time` in the substep [s].
    pub(super) fn note<I: Instructions>(
        &mut self,
        batch: &ContactBatch<I>,
        lane: usize,
        bodies: [SolverBody; 2],
        impulses: [f64; MOST_POINTS],
        time: f64,
    ) {
        let number = batch.constraints[lane];
        let time_sum = time * impulses.iter().sum::<f64>();
        let known = self.entries.iter_mut().find(|entry| entry.number == number);
        if let Some(entry) = known {
            entry.impulses.iter_mut().zip(impulses).for_each(|(sum, impulse)| *sum += impulse);
            entry.time_sum += time_sum;
        } else {
            let before = batch.frame_impulse.map(|along: Single<I>| along.get(lane));
            self.entries.push(LaneImpact { number, bodies, before, impulses, time_sum });
        }
    }
}
