//! Clipping of polygons with many corners: each side of the reference face finds the corner that is
//! furthest beyond it from that of the side before. All sides together go once around the polygon.

use crate::narrow_phase::hull_hull::hull_point::Feature;
use crate::narrow_phase::hull_hull::reference_sides::Sides;
use crate::narrow_phase::hull_hull::scratch::{Corner, Side};
use glam::DVec3;

/// Clips a polygon by the sides of a face with a tolerance of `close` [m], as side after side with
/// all corners would.
pub(crate) fn clip_in_turn(
    sides: &Sides,
    close: f64,
    polygon: &mut Vec<Corner>,
    links: &mut Vec<[u32; 2]>,
) {
    let count = polygon.len() as u32;
    links.clear();
    links.extend((0..count).map(|at| [(at + count - 1) % count, (at + 1) % count]));
    let mut ring = Ring { corners: polygon, links, top: 0 };
    for (at, (start, outward)) in sides.outward().enumerate() {
        let scale = 1.0 / outward.length();
        let beyond = |point: DVec3| scale * outward.dot(point - start);
        ring.climb(&beyond);
        let is_left =
            ring.cut((Side::Reference(at), close), &beyond, |side| sides.crossing(at, side));
        if !is_left {
            polygon.clear();
            return;
        }
    }
    ring.straighten();
}

/// Directions along a ring.
const BACK: usize = 0;
const ON: usize = 1;

/// A polygon whose corners are linked.
struct Ring<'a> {
    /// Also those that are cut off.
    corners: &'a mut Vec<Corner>,
    /// Of each corner, the one before and the next.
    links: &'a mut Vec<[u32; 2]>,
    /// A corner of the polygon.
    top: u32,
}

impl Ring<'_> {
    fn step(&self, corner: u32, direction: usize) -> u32 {
        self.links[corner as usize][direction]
    }

    fn corner(&mut self, corner: u32) -> &mut Corner {
        &mut self.corners[corner as usize]
    }

    /// Goes to the corner that is furthest beyond a side.
    fn climb(&mut self, beyond: &impl Fn(DVec3) -> f64) {
        let height = |ring: &Self, corner: u32| beyond(ring.corners[corner as usize].point);
        let mut highest = height(self, self.top);
        for direction in [ON, BACK] {
            loop {
                let next = self.step(self.top, direction);
                let above = height(self, next);
                if above > highest {
                    (self.top, highest) = (next, above);
                } else {
                    break;
                }
            }
        }
    }

    /// Cuts off the corners around the top that are more than `close` [m] beyond a side; `false` if
    /// none is left.
    fn cut(
        &mut self,
        (cut, close): (Side, f64),
        beyond: &impl Fn(DVec3) -> f64,
        crossing: impl Fn(Side) -> Feature,
    ) -> bool {
        let height = |ring: &Self, corner: u32| beyond(ring.corners[corner as usize].point);
        if height(self, self.top) <= close {
            return true;
        }
        // The last corners that are out, and the first that are not, both ways.
        let (mut out, mut kept) = ([self.top; 2], [self.top; 2]);
        for direction in [BACK, ON] {
            loop {
                kept[direction] = self.step(out[direction], direction);
                if height(self, kept[direction]) <= close {
                    break;
                }
                if kept[direction] == self.top {
                    return false;
                }
                out[direction] = kept[direction];
            }
        }
        let mut chain = vec![kept[BACK]];
        for direction in [BACK, ON] {
            let [from, to] = [kept[direction], out[direction]].map(|corner| height(self, corner));
            if from >= -close {
                continue;
            }
            // The polygon's side that is cut begins at the first of both corners.
            let [kept, out] = [kept[direction], out[direction]].map(|corner| *self.corner(corner));
            let begins = if direction == BACK { kept.side } else { out.side };
            let point = if direction == BACK {
                kept.point.lerp(out.point, from / (from - to))
            } else {
                out.point.lerp(kept.point, to / (to - from))
            };
            let side = if direction == BACK { cut } else { begins };
            chain.push(self.corners.len() as u32);
            self.corners.push(Corner { point, feature: crossing(begins), side, beyond: 0.0 });
            self.links.push([0; 2]);
        }
        if height(self, kept[BACK]) >= -close {
            self.corner(kept[BACK]).side = cut;
        }
        chain.push(kept[ON]);
        for pair in chain.windows(2) {
            self.links[pair[0] as usize][ON] = pair[1];
            self.links[pair[1] as usize][BACK] = pair[0];
        }
        self.top = kept[ON];
        true
    }

    /// The polygon's corners alone, one after the other.
    fn straighten(self) {
        let Self { corners, links, top } = self;
        let first = corners.len();
        let mut at = top;
        loop {
            corners.push(corners[at as usize]);
            at = links[at as usize][ON];
            if at == top {
                break;
            }
        }
        corners.drain(..first);
    }
}
