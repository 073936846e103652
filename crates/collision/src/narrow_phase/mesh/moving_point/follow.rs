//! The way of a point of a body from its first touch on: along what it touches, or as it bounces.

use crate::narrow_phase::mesh::moving_point::{Leg, Meeting, MovingPoint, SAME_NORMAL};
use glam::DVec3;

/// Number of touches after which a point goes no further in a frame: at 200 m/s and 30 Hz a ball
/// that bounces crosses a room of 2 m three times each way, and one in a pipe of 720 facets goes
/// over eighteen. With 4 touches, 8 % of such balls left the room in a second, and others came by a
/// seventh of their radius into the pipe, and came out with more energy.
const MOST_TOUCHES: usize = 16;

impl MovingPoint<'_> {
    /// Follows the way from the first touch in free flight, with what it touches in `found`. Gives
    /// its end.
    pub(super) fn follow(
        &self,
        legs: &[Leg],
        flight: &[Meeting],
        found: &mut Vec<Meeting>,
    ) -> DVec3 {
        let dt = self.motion.pair_motion.frame.dt;
        let end = legs.last().map_or(DVec3::ZERO, |leg| leg.way[1]);
        let Some(first) = earliest(flight) else { return end };
        let on_way = |time: f64| {
            let leg = legs.iter().find(|leg| time <= leg.times[1]).or(legs.last());
            leg.map_or(end, |leg| {
                let duration = (leg.times[1] - leg.times[0]).max(f64::MIN_POSITIVE);
                leg.way[0].lerp(leg.way[1], ((time - leg.times[0]) / duration).clamp(0.0, 1.0))
            })
        };
        let (mut at, mut next) = (on_way(first.time), first);
        let mut rest = end - at;
        let bounces = self.bounce > 0.0;
        for _ in 0..MOST_TOUCHES {
            found.push(next);
            // Overlap goes first.
            let lifted = next.on_mesh + (self.radius + self.motion.thin) * next.normal;
            at += (lifted - at).dot(next.normal).max(0.0) * next.normal;
            rest = self.deflected(rest, found);
            if let Some(other) = self.other_overlap(flight, found, (at, rest)) {
                next = other;
                continue;
            }
            let leg = Leg { way: [at, at + rest], times: [next.time, dt], falls: false };
            let mut ahead = Vec::new();
            self.meetings(&leg, (at, false), &mut ahead);
            ahead.retain(|meeting| {
                let is_known = |known: &Meeting| known.normal.dot(meeting.normal) > SAME_NORMAL;
                // A ball that bounces may come back.
                meeting.normal.dot(rest) < 0.0 && (bounces || !found.iter().any(is_known))
            });
            let Some(later) = earliest(&ahead) else { break };
            let duration = (dt - next.time).max(f64::MIN_POSITIVE);
            let part = ((later.time - next.time) / duration).clamp(0.0, 1.0);
            at += part * rest;
            rest *= 1.0 - part;
            next = later;
        }
        at + rest
    }

    /// Another triangle that a ball overlaps at the frame's start, and goes further into on the
    /// rest of its way: a sweep meets no triangle that it starts deep in. A ball that was deep in a
    /// floor and a wall met the ceiling at no speed.
    fn other_overlap(
        &self,
        flight: &[Meeting],
        found: &[Meeting],
        (at, rest): (DVec3, DVec3),
    ) -> Option<Meeting> {
        let is_other = |meeting: &&Meeting| {
            let is_known = |known: &Meeting| known.normal.dot(meeting.normal) > SAME_NORMAL;
            meeting.sweep.touches
                && meeting.time == 0.0
                && meeting.normal.dot(rest) < 0.0
                && (at - meeting.on_mesh).dot(meeting.normal) < self.radius
                && !found.iter().any(is_known)
        };
        let is_at_start = self.radius > 0.0 && found.iter().all(|known| known.time == 0.0);
        let others = flight.iter().filter(|_| is_at_start).filter(is_other);
        others.min_by(|a, b| a.sweep.least.total_cmp(&b.sweep.least)).copied()
    }

    /// The rest of the way after the last of some touches.
    fn deflected(&self, rest: DVec3, touches: &[Meeting]) -> DVec3 {
        let Some((last, before)) = touches.split_last() else { return rest };
        let into = rest.dot(last.normal).min(0.0);
        let along = rest - (1.0 + self.bounce) * into * last.normal;
        if self.bounce > 0.0 {
            return along;
        }
        let Some(other) = before.iter().find(|known| known.normal.dot(along) < 0.0) else {
            return along;
        };
        // In a groove only its direction is left, in a corner none.
        let crease = last.normal.cross(other.normal).normalize_or_zero();
        let in_groove = rest.dot(crease) * crease;
        let is_free = before.iter().all(|known| known.normal.dot(in_groove) >= -self.motion.thin);
        if is_free { in_groove } else { DVec3::ZERO }
    }
}

/// The touch that comes first; of those at once, the deepest.
fn earliest(meetings: &[Meeting]) -> Option<Meeting> {
    let touches = meetings.iter().filter(|meeting| meeting.sweep.touches);
    let order = |a: &&Meeting, b: &&Meeting| {
        a.time.total_cmp(&b.time).then(a.sweep.least.total_cmp(&b.sweep.least))
    };
    touches.min_by(order).copied()
}
