//! Impacts of pairs with a breakable body: what a body meets in a substep along one normal
//! [Su09 sec. 4.2].

use super::constraints::SAME_NORMAL;
use super::group::Group;
use super::impact_log::{Impact, ImpactLog, LaneImpact, PointImpulse};
use super::solver_bodies::SolverBody;
use frangible_bodies::{Bodies, Motion, Pair};
use frangible_collision::{ContactPoint, Manifold};
use frangible_math::Instructions;
use glam::DVec3;

/// The impact of a body with a partner, from the lanes of one normal.
struct Joint {
    body: usize,
    /// All static bodies are one, but for those with bonds.
    partner: Option<usize>,
    /// Towards the body, world frame.
    normal: DVec3,
    /// On the body [N s].
    impulse: DVec3,
    /// Sums of the points, times their normal impulses [N s m]: from the body's centre at the
    /// impact, and in the world frame at the frame's start.
    at_sums: [DVec3; 2],
    /// Sum of the normal impulses [N s], and of these times when they act in the substep [N s^2];
    /// and number of points with any.
    weight: f64,
    time_sum: f64,
    points: usize,
    /// The entry with the largest normal impulse, and that impulse [N s].
    largest: (usize, f64),
    /// Parts on the body, if one of the two is glued.
    parts: Vec<PointImpulse>,
}

impl<I: Instructions> Group<I> {
    /// Takes the impacts of the substep that begins at `time` [s], one for each pair and normal.
    pub(super) fn keep_impacts(
        &mut self,
        log: &mut ImpactLog,
        (bodies, manifolds): (&Bodies, &[Manifold]),
        time: f64,
    ) {
        let entries = std::mem::take(&mut log.entries);
        let mut joints: Vec<Joint> = Vec::new();
        for (at, entry) in entries.iter().enumerate() {
            self.join(&mut joints, (at, entry), (bodies, manifolds));
        }
        // In the order of their first lanes.
        for (number, joint) in joints.iter().enumerate() {
            let impact = self.impact_of(joint, &entries, (bodies, manifolds), (time, number));
            self.impacts.push(impact);
        }
    }

    /// Adds a lane to the joint impact that it belongs to.
    fn join(
        &self,
        joints: &mut Vec<Joint>,
        (at, entry): (usize, &LaneImpact),
        (bodies, manifolds): (&Bodies, &[Manifold]),
    ) {
        let weight: f64 = entry.impulses.iter().sum();
        let points = entry.impulses.iter().filter(|&&impulse| impulse > 0.0).count();
        if weight <= 0.0 {
            return;
        }
        let place = self.speculative.place(entry.number);
        let (batch, lane) = (&self.batches[place.batch()], place.lane());
        let both = self.pair_of(entry, manifolds).both();
        let is_first = entry.bodies[0].is_movable();
        let (side, other) = if is_first { (0, 1) } else { (1, 0) };
        let are_glued = both.map(|i| bodies.surfaces[i].glued);
        let is_any = matches!(bodies.motions[both[other]], Motion::Static) && !are_glued[other];
        let (body, partner) = (both[side], (!is_any).then_some(both[other]));

        // The lane's impulses are those on its second body, and its normal points there.
        let axes = batch.frame_of(lane);
        let sign = if is_first { -1.0 } else { 1.0 };
        let given = |k: usize| batch.frame_impulse[k].get(lane) - entry.before[k];
        let impulse = sign * (0..3).map(|k| given(k) * axes[k]).sum::<DVec3>();
        let normal = sign * axes[0];

        // Where its normal impulse acts.
        let turn = entry.bodies[side].turn();
        let offsets = batch.offsets.map(|offset| offset.get(lane) * axes[0]);
        let mut at_sums = [DVec3::ZERO; 2];
        let mut parts = Vec::new();
        for (point, along) in batch.points.iter().zip(entry.impulses) {
            let anchors = point.anchors.map(|anchor| anchor.get(lane));
            if along > 0.0 && are_glued.contains(&true) {
                let in_body = |k: usize| {
                    bodies.poses[both[k]].orientation.conjugate() * (anchors[k] + offsets[k])
                };
                let at = [in_body(side), in_body(other)];
                parts.push(PointImpulse { at, impulse: along / weight * impulse });
            }
            let on_surface = |k: usize| bodies.poses[both[k]].position + anchors[k] + offsets[k];
            at_sums[0] += along * (turn * anchors[side] + offsets[side]);
            at_sums[1] += along * 0.5 * (on_surface(0) + on_surface(1));
        }

        let is_along = |joint: &&mut Joint| {
            (joint.body, joint.partner) == (body, partner) && joint.normal.dot(normal) > SAME_NORMAL
        };
        if let Some(joint) = joints.iter_mut().find(is_along) {
            joint.impulse += impulse;
            joint.weight += weight;
            joint.time_sum += entry.time_sum;
            joint.points += points;
            joint.parts.extend(parts);
            joint.at_sums.iter_mut().zip(at_sums).for_each(|(sum, of_lane)| *sum += of_lane);
            if weight > joint.largest.1 {
                joint.largest = (at, weight);
            }
        } else {
            let largest = (at, weight);
            let time_sum = entry.time_sum;
            joints.push(Joint {
                body,
                partner,
                normal,
                impulse,
                at_sums,
                weight,
                time_sum,
                points,
                largest,
                parts,
            });
        }
    }

    fn pair_of(&self, entry: &LaneImpact, manifolds: &[Manifold]) -> Pair {
        manifolds[self.selections[entry.number as usize].manifold as usize].pair
    }

    fn impact_of(
        &self,
        joint: &Joint,
        entries: &[LaneImpact],
        (bodies, manifolds): (&Bodies, &[Manifold]),
        (time, number): (f64, usize),
    ) -> Impact {
        let entry = &entries[joint.largest.0];
        let pair = self.pair_of(entry, manifolds);
        let both = pair.both();
        let is_first = entry.bodies[0].is_movable();
        let pose = |side: usize, body: SolverBody| body.pose(&bodies.poses[both[side]]);
        let poses = [0, 1].map(|side| pose(side, entry.bodies[side]));
        let poses_past = [0, 1].map(|side| pose(side, entry.bodies[side].drifted(self.h as f32)));
        let (side, sign) = if is_first { (0, 1.0) } else { (1, -1.0) };
        let point = poses[side].position + joint.at_sums[0] / joint.weight;
        let parts = joint.parts.iter().map(|part| if is_first { *part } else { part.swapped() });
        Impact {
            pair,
            impulse: sign * joint.impulse,
            earlier: DVec3::ZERO,
            time,
            number,
            mean_time: time + joint.time_sum / joint.weight,
            contact: ContactPoint { point, normal: sign * joint.normal },
            poses,
            poses_past,
            is_at_point: joint.points == 1,
            acts_at: joint.at_sums[1] / joint.weight,
            parts: parts.collect(),
        }
    }
}
