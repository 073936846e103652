//! Impacts that make one blow: what a pair exchanges along one normal within some milliseconds, in
//! whichever substeps and frames. One edge of a face that slams down lands before the other.
//! Earlier impacts count less and less, so that no blow hangs on which side of a limit one lies.

use crate::frame_rate::constraints::SAME_NORMAL;
use crate::frame_rate::impact_log::{Impact, PointImpulse};
use frangible_bodies::{Bodies, BodyId, Motion};
use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Impacts no farther apart act as one [s]: two substeps of a frame of 1/24 s are 5 ms apart.
const AS_ONE: f64 = 0.005;

/// An impact is forgotten after this time [s]. With windows of a substep a wall that fell on its
/// face bore blows of 1 at 1000 Hz and of 1.33 at 60.
const MEMORY: f64 = 0.02;

/// Impacts of the last milliseconds before a frame.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RecentImpacts {
    of_pairs: Vec<Recent>,
}

/// An impact before the frame's start.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Recent {
    bodies: Meeting,
    /// Towards the body, world frame.
    normal: DVec3,
    /// On the body, world frame [N s].
    impulse: DVec3,
    /// From the frame's start, negative [s].
    time: f64,
    is_at_point: bool,
    /// On the body first.
    parts: Vec<PointImpulse>,
}

/// A body and what it meets; all static bodies are one, but for those with bonds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
struct Meeting {
    body: BodyId,
    partner: Option<BodyId>,
}

impl Check for RecentImpacts {
    fn check(&self) -> Checked {
        self.of_pairs.iter().try_for_each(|recent| {
            require((-MEMORY..=0.0).contains(&recent.time), "impacts just before the frame")?;
            finite_vector(recent.normal)?;
            for PointImpulse { at: [first, second], impulse } in &recent.parts {
                [first, second, impulse].into_iter().try_for_each(|v| finite_vector(*v))?;
            }
            finite_vector(recent.impulse)
        })
    }
}

impl Recent {
    /// An impact of a frame, as seen from its start.
    fn of(bodies: &Bodies, impact: &Impact) -> Self {
        let both = impact.pair.both();
        let side = usize::from(bodies.inertias[both[0]].is_infinite());
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let parts = impact.parts.iter();
        let (body, other) = (both[side], both[1 - side]);
        let is_any =
            matches!(bodies.motions[other], Motion::Static) && !bodies.surfaces[other].glued;
        Self {
            bodies: Meeting {
                body: bodies.ids[body],
                partner: (!is_any).then(|| bodies.ids[other]),
            },
            normal: sign * impact.contact.normal,
            impulse: sign * impact.impulse,
            time: impact.mean_time,
            is_at_point: impact.is_at_point,
            parts: parts.map(|part| if side == 0 { *part } else { part.swapped() }).collect(),
        }
    }

    /// Share of its impulse that counts in a blow which a later impact ends [1].
    fn share_in(&self, later: &Self) -> f64 {
        let is_along = self.bodies == later.bodies && self.normal.dot(later.normal) > SAME_NORMAL;
        let remembered = (MEMORY - (later.time - self.time)) / (MEMORY - AS_ONE);
        if is_along { remembered.clamp(0.0, 1.0) } else { 0.0 }
    }
}

impl RecentImpacts {
    /// Largest blow of each pair along each normal, from the impacts of a frame of `dt` [s] and
    /// these before it; and the impacts before the next frame. `bodies` are those of the frame's
    /// start.
    pub fn blows(
        &self,
        bodies: &Bodies,
        impacts: Vec<Impact>,
        dt: f64,
    ) -> (Vec<Impact>, RecentImpacts) {
        let seen = |impact: Impact| (Recent::of(bodies, &impact), impact);
        let mut seen: Vec<(Recent, Impact)> = impacts.into_iter().map(seen).collect();
        seen.sort_by(|(a, at_a), (b, at_b)| {
            let by_time = a.time.total_cmp(&b.time).then(at_a.number.cmp(&at_b.number));
            a.bodies.cmp(&b.bodies).then(by_time)
        });
        let mut blows = Vec::new();
        for of_pair in seen.chunk_by(|(a, _), (b, _)| a.bodies == b.bodies) {
            let before = |recent: &&Recent| recent.bodies == of_pair[0].0.bodies;
            let before: Vec<&Recent> = self.of_pairs.iter().filter(before).collect();
            largest_blows(&before, of_pair, &mut blows);
        }

        let lasts = |recent: &Recent| dt - recent.time <= MEMORY;
        let of_frame = seen.into_iter().map(|(recent, _)| recent);
        let recent = self.of_pairs.iter().cloned().chain(of_frame).filter(lasts);
        let of_pairs = recent.map(|recent| Recent { time: recent.time - dt, ..recent }).collect();
        (blows, RecentImpacts { of_pairs })
    }

    /// Leaves out bodies that are gone.
    pub fn keep(&mut self, bodies: &Bodies) {
        let is_there = |id: BodyId| bodies.index_of(id).is_some();
        self.of_pairs.retain(|Recent { bodies: Meeting { body, partner }, .. }| {
            is_there(*body) && partner.is_none_or(is_there)
        });
    }
}

/// Adds the largest blow along each normal of a pair with impacts `before` a frame and in it, in
/// order.
fn largest_blows(before: &[&Recent], of_frame: &[(Recent, Impact)], blows: &mut Vec<Impact>) {
    let mut largest: Vec<Impact> = Vec::new();
    for (at, (last, _)) in of_frame.iter().enumerate() {
        let of_blow = before.iter().map(|&recent| (recent.share_in(last), recent));
        let of_blow: Vec<(f64, &Recent)> = of_blow.filter(|&(share, _)| share > 0.0).collect();
        let seen = of_frame[..=at].iter().map(|seen| (seen.0.share_in(last), seen));
        let seen: Vec<(f64, &(Recent, Impact))> = seen.filter(|&(share, _)| share > 0.0).collect();
        let size =
            |&&(share, (_, impact)): &&(f64, &(Recent, Impact))| share * impact.impulse.length();
        let Some((_, (_, hardest))) = seen.iter().max_by(|a, b| size(a).total_cmp(&size(b))) else {
            continue;
        };
        let is_first = last.normal.dot(hardest.contact.normal) > 0.0;
        let sign = if is_first { 1.0 } else { -1.0 };
        let earlier =
            sign * of_blow.iter().map(|&(share, recent)| share * recent.impulse).sum::<DVec3>();
        let in_frame = seen.iter().map(|&(share, (recent, _))| (share, recent));
        let impulse = in_frame.clone().map(|(share, recent)| share * recent.impulse).sum::<DVec3>();
        let part = |share: f64, part: &PointImpulse| {
            let part = PointImpulse { impulse: share * part.impulse, ..*part };
            if is_first { part } else { part.swapped() }
        };
        let all = of_blow.iter().copied().chain(in_frame);
        let parts =
            all.flat_map(|(share, recent)| recent.parts.iter().map(move |of| part(share, of)));
        let blow = Impact {
            impulse: earlier + sign * impulse,
            earlier,
            time: seen[0].1.1.time,
            number: seen[0].1.1.number,
            is_at_point: seen.iter().all(|(_, (recent, _))| recent.is_at_point)
                && of_blow.iter().all(|(_, recent)| recent.is_at_point),
            parts: parts.collect(),
            ..hardest.clone()
        };
        let normal = blow.contact.normal;
        match largest.iter_mut().find(|known| known.contact.normal.dot(normal) > SAME_NORMAL) {
            Some(known) if known.impulse.length() >= blow.impulse.length() => {}
            Some(known) => *known = blow,
            None => largest.push(blow),
        }
    }
    blows.extend(largest);
}
