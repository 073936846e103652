//! Contact points of a body of revolution and its partner at an instant.

use crate::narrow_phase::revolved::areas::{AreaPoint, OF_PARTNER, disc_on_area, line_on_area};
use crate::narrow_phase::revolved::closest::deepest_points;
use crate::narrow_phase::revolved::features::{
    Area, Facing, is_aligned, nearest_face, touching_edge,
};
use crate::narrow_phase::revolved::lines::{common_stretch, lines_meet};
use crate::narrow_phase::revolved::partner::Partner;
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use crate::narrow_phase::revolved::round_point::{Anchor, RimPoint, RoundPoint, fixed};
use crate::narrow_phase::revolved::separation::Separation;
use frangible_geometry::Hull;
use glam::DVec3;

/// Cosine of the angle within which a flat area faces another body: what lies over it may come down
/// on it within the frame.
const LEANS: f64 = 0.7;

/// Sine of the angle within which lines are side by side, and sides face each other.
const BESIDE: f64 = 0.17;

/// Parts of a line nearer than this are one point [1].
const ONE_POINT: f64 = 1e-6;

const SIDE: u64 = 16;
const SIDE_OF_PARTNER: u64 = 18;
const SINGLE: u64 = 20;
const BALL: u64 = 21;

/// Parts of a stretch between such balls [1].
const BALLS: u64 = 4;

/// A pair at an instant, in the partner's frame.
pub(crate) struct Instant<'a> {
    pub(crate) round: &'a PlacedRevolved,
    pub(crate) partner: &'a Partner<'a>,
    pub(crate) separation: Separation,
    /// Angular velocities of both [rad/s].
    pub(crate) angular: [DVec3; 2],
    /// [m/s^2]
    pub(crate) gravity: DVec3,
    /// Lengths that are the same for a contact [m].
    pub(crate) close: f64,
}

impl<'a> Instant<'a> {
    /// All points of an instant, also those that are still far apart.
    pub(crate) fn points(&self, points: &mut Vec<RoundPoint>) {
        let (round, normal) = (self.round, self.separation.normal);
        let mine = round.facing(-normal);
        match *self.partner {
            Partner::Plane(plane) => self.on_area(Area::Plane(plane), points),
            Partner::Hull(hull) => self.with_hull(hull, mine, points),
            Partner::Revolved(ref other) => self.with_round(other, mine, points),
        }
        // Where faces and sides have no common point, or where they miss the deepest one.
        let deepest = points.iter().map(|point| point.gap()).fold(f64::INFINITY, f64::min);
        if deepest > self.separation.gap + 2.0 * self.close {
            points.push(self.single(mine));
        }
    }

    fn with_hull(&self, hull: &Hull, mine: Facing, points: &mut Vec<RoundPoint>) {
        let (round, normal) = (self.round, self.separation.normal);
        let (face, cosine) = nearest_face(hull, normal);
        let area = Area::Face(hull, face);
        if is_aligned(cosine) {
            self.on_area(area, points);
            // A side that rolls on to a face may still have its line beside it.
            if points.is_empty() && mine == Facing::Side {
                self.side_on_edge(hull, points);
            }
            return;
        }
        match mine {
            Facing::Disc(end) => self.disc(end, area, points),
            Facing::Side => {
                let line = side_line(round, -normal);
                let edge = touching_edge(hull, normal, line[0].lerp(line[1], 0.5));
                if is_along(line, edge) || cosine < LEANS {
                    self.side_on_edge(hull, points);
                } else {
                    self.side_on_area(area, points);
                }
            }
            Facing::Rim(_) if !self.touches() => {}
            Facing::Rim(_) => match round.nearest_facing(-normal) {
                Facing::Disc(end) if round.end_normal(end).dot(-normal) > LEANS => {
                    let edge = touching_edge(hull, normal, round.support(-normal));
                    self.edge_on_disc(edge, end, points);
                }
                _ => {}
            },
        }
    }

    fn with_round(&self, other: &PlacedRevolved, mine: Facing, points: &mut Vec<RoundPoint>) {
        let (round, normal) = (self.round, self.separation.normal);
        let theirs = other.facing(normal);
        let is_flat = |facing: Facing| matches!(facing, Facing::Disc(_));
        let is_pointed = |facing: Facing| matches!(facing, Facing::Rim(_));
        if is_pointed(mine) && is_pointed(theirs) && !self.touches() {
            return;
        }
        let near = [round.nearest_facing(-normal), other.nearest_facing(normal)];
        let leans = |body: &PlacedRevolved, facing: Facing, towards: DVec3| match facing {
            Facing::Disc(end) => body.end_normal(end).dot(towards) > LEANS,
            Facing::Side | Facing::Rim(_) => body.off_side(towards) < BESIDE,
        };
        let is_one_flat = is_flat(mine) || is_flat(theirs);
        let both_lean = leans(round, near[0], -normal) && leans(other, near[1], normal);
        if !is_one_flat && !both_lean {
            return;
        }
        match near {
            [Facing::Disc(end), Facing::Disc(other_end)] => {
                self.disc(end, Area::Disc(other, other_end), points);
            }
            [Facing::Disc(end), _] => self.other_side_on_disc(other, end, points),
            [_, Facing::Disc(other_end)] => {
                self.side_on_area(Area::Disc(other, other_end), points);
            }
            _ => self.side_on_side(other, points),
        }
    }

    /// True for bodies that touch, not for such that pass each other.
    fn touches(&self) -> bool {
        self.separation.gap <= 4.0 * self.close
    }

    /// The feature nearest to facing a flat area, on the area.
    pub(crate) fn on_area(&self, area: Area, points: &mut Vec<RoundPoint>) {
        match self.round.nearest_facing(-area.plane().normal) {
            Facing::Disc(end) => self.disc(end, area, points),
            Facing::Side | Facing::Rim(_) => self.side_on_area(area, points),
        }
    }

    fn disc(&self, end: usize, area: Area, points: &mut Vec<RoundPoint>) {
        let mut found: Vec<AreaPoint> = Vec::with_capacity(8);
        let directions = [self.separation.normal, self.gravity];
        disc_on_area(self.round, end, area, directions, &mut found);
        points.extend(found.into_iter().map(|AreaPoint { on, id, is_rim, is_other_rim }| {
            let rim = match area {
                _ if is_rim => Some(RimPoint { of_round: true, end, point: on[0] }),
                Area::Disc(_, end) if is_other_rim => {
                    Some(RimPoint { of_round: false, end, point: on[1] })
                }
                _ => None,
            };
            RoundPoint { anchors: on.map(fixed), normal: self.separation.normal, id, rim }
        }));
    }

    /// The line of the side, at most two points.
    fn side_on_area(&self, area: Area, points: &mut Vec<RoundPoint>) {
        let (round, normal) = (self.round, self.separation.normal);
        let line = side_line(round, -normal);
        let Some(within) = line_on_area(line, area, normal) else { return };
        let is_one = within[1] - within[0] < ONE_POINT;
        for (which, part) in within.into_iter().enumerate().take(if is_one { 1 } else { 2 }) {
            let mine = hold_on_side(round, line, part, -normal);
            let below = area.drop(line[0].lerp(line[1], part), normal);
            points.push(RoundPoint::new([mine, fixed(below)], normal, SIDE + which as u64));
        }
    }

    /// An edge on a disc.
    fn edge_on_disc(&self, edge: [DVec3; 2], end: usize, points: &mut Vec<RoundPoint>) {
        let (area, normal) = (Area::Disc(self.round, end), self.separation.normal);
        let Some(within) = line_on_area(edge, area, normal) else { return };
        for (which, part) in within.into_iter().enumerate() {
            let theirs = edge[0].lerp(edge[1], part);
            let above = self.round.hold_fixed(area.drop(theirs, normal));
            let id = SIDE_OF_PARTNER + which as u64;
            points.push(RoundPoint::new([above, fixed(theirs)], normal, id));
        }
    }

    fn other_side_on_disc(&self, other: &PlacedRevolved, end: usize, points: &mut Vec<RoundPoint>) {
        let normal = self.separation.normal;
        let (line, area) = (side_line(other, normal), Area::Disc(self.round, end));
        let Some(within) = line_on_area(line, area, normal) else { return };
        let is_one = within[1] - within[0] < ONE_POINT;
        for (which, part) in within.into_iter().enumerate().take(if is_one { 1 } else { 2 }) {
            let theirs = hold_on_side(other, line, part, normal);
            let above = area.drop(line[0].lerp(line[1], part), normal);
            let anchors = [self.round.hold_fixed(above), theirs];
            points.push(RoundPoint::new(anchors, normal, SIDE_OF_PARTNER + which as u64));
        }
    }

    /// The side across an edge, or along it.
    fn side_on_edge(&self, hull: &Hull, points: &mut Vec<RoundPoint>) {
        let (round, normal) = (self.round, self.separation.normal);
        let line = side_line(round, -normal);
        let edge = touching_edge(hull, normal, line[0].lerp(line[1], 0.5));
        let (parts, count) = lines_meet([line, edge], normal, self.leaves([round, round]));
        for (which, [mine, theirs]) in parts.into_iter().enumerate().take(count) {
            let anchors =
                [hold_on_side(round, line, mine, -normal), fixed(edge[0].lerp(edge[1], theirs))];
            points.push(RoundPoint::new(anchors, normal, SIDE + which as u64));
        }
    }

    fn side_on_side(&self, other: &PlacedRevolved, points: &mut Vec<RoundPoint>) {
        let (round, normal) = (self.round, self.separation.normal);
        let lines = [side_line(round, -normal), side_line(other, normal)];
        let (parts, count) = lines_meet(lines, normal, self.leaves([round, other]));
        if count == 1 {
            self.balls_on_side(other, lines, points);
        }
        for (which, [mine, theirs]) in parts.into_iter().enumerate().take(count) {
            let anchors = [
                hold_on_side(round, lines[0], mine, -normal),
                hold_on_side(other, lines[1], theirs, normal),
            ];
            points.push(RoundPoint::new(anchors, normal, SIDE + which as u64));
        }
    }

    /// Where sides cross, their common point runs along them as they turn: balls along the axis, as
    /// large as the body, meet the other one.
    fn balls_on_side(
        &self,
        other: &PlacedRevolved,
        lines: [[DVec3; 2]; 2],
        points: &mut Vec<RoundPoint>,
    ) {
        let (round, normal) = (self.round, self.separation.normal);
        let Some(within) = common_stretch(lines, normal) else { return };
        for which in 0..=BALLS {
            let part = within[0] + (within[1] - within[0]) * which as f64 / BALLS as f64;
            let ball = hold_on_side(round, lines[0], part, -normal);
            let (distance, outward) = other.distance_and_gradient(ball.point);
            // At the end of a side a ball reaches beyond it.
            let touching = ball.point - (ball.rounding - round.rounding) * outward;
            let along = (touching - round.middle).dot(round.axis);
            let is_beyond = along < round.ends[0].height - self.close
                || along > round.ends[1].height + self.close;
            if is_beyond || round.off_side(-outward) > BESIDE {
                continue;
            }
            let core = ball.point - (distance + other.rounding) * outward;
            let facing = other.facing(outward);
            let theirs = if facing == Facing::Side {
                let (_, _, radius) = other.split(core - other.middle);
                other.hold_by_axis(core, radius, outward)
            } else {
                other.hold_fixed(core)
            };
            points.push(RoundPoint::new([ball, theirs], outward, BALL + which));
        }
    }

    /// How far lines may leave each other for their surfaces to part by no more than `close` [m].
    fn leaves(&self, bodies: [&PlacedRevolved; 2]) -> f64 {
        let radius =
            |body: &PlacedRevolved| body.rounding + body.ends[0].radius.max(body.ends[1].radius);
        // An edge is a line, and only the other body curves away from it.
        let radii = bodies.map(radius).into_iter().filter(|&radius| radius > 0.0);
        let least = radii.reduce(f64::min).unwrap_or(0.0);
        (2.0 * least * self.close).sqrt()
    }

    /// The point where the bodies are nearest or deepest.
    pub(crate) fn nearest(&self) -> RoundPoint {
        self.single(self.round.facing(-self.separation.normal))
    }

    /// The point furthest along the normal, on what bounds the partner there: where a side that is
    /// nearly parallel to an edge crosses it beyond both of their ends.
    pub(crate) fn furthest(&self) -> RoundPoint {
        let (round, normal) = (self.round, self.separation.normal);
        let point = round.support(-normal);
        let below = point - (round.rounding + self.separation.gap) * normal;
        RoundPoint::new([round.hold_fixed(point), fixed(below)], normal, SINGLE)
    }

    /// The closest points of separated cores, or of the edges and sides that overlap.
    fn single(&self, mine: Facing) -> RoundPoint {
        let (round, normal) = (self.round, self.separation.normal);
        let [point, point_partner] = self.separation.on.unwrap_or_else(|| {
            let on = self.deepest(mine);
            let rounding = round.rounding + self.partner.rounding();
            let gap = (on[0] - on[1]).dot(normal) - rounding;
            let misses = gap > self.separation.gap + 2.0 * self.close;
            let found = misses.then(|| deepest_points(round, self.partner, (normal, self.close)));
            found.flatten().unwrap_or(on)
        });
        let theirs = match self.partner {
            Partner::Revolved(other) => {
                let facing = other.facing(normal);
                hold_single(other, facing, point_partner, normal, self.angular[1])
            }
            Partner::Hull(_) | Partner::Plane(_) => fixed(point_partner),
        };
        let anchor = hold_single(round, mine, point, -normal, self.angular[0]);
        let id = if let Facing::Rim(end) = mine { 4 * end as u64 } else { SINGLE };
        RoundPoint::new([anchor, theirs], normal, id)
    }

    /// Where the edges or sides with the normal meet.
    fn deepest(&self, mine: Facing) -> [DVec3; 2] {
        let (round, normal) = (self.round, self.separation.normal);
        let line_of = |body: &PlacedRevolved, facing: Facing, towards: DVec3| match facing {
            Facing::Side => side_line(body, towards),
            Facing::Rim(_) | Facing::Disc(_) => [body.support(towards); 2],
        };
        let line = line_of(round, mine, -normal);
        let theirs = match self.partner {
            Partner::Revolved(other) => line_of(other, other.facing(normal), normal),
            Partner::Hull(hull) => touching_edge(hull, normal, line[0].lerp(line[1], 0.5)),
            Partner::Plane(plane) => [line[0] - plane.distance(line[0]) * plane.normal; 2],
        };
        let ([[on_mine, on_theirs], _], _) = lines_meet([line, theirs], normal, 0.0);
        let on = [line[0].lerp(line[1], on_mine), theirs[0].lerp(theirs[1], on_theirs)];
        match (mine, self.partner) {
            (Facing::Disc(end), _) => [round.nearest_on_disc(end, on[1]), on[1]],
            (_, Partner::Revolved(other)) => match other.facing(normal) {
                Facing::Disc(end) => [on[0], other.nearest_on_disc(end, on[0])],
                Facing::Side | Facing::Rim(_) => on,
            },
            _ => on,
        }
    }

    /// The same point with the rim that touches alone held as it moves.
    pub(crate) fn alone(&self, point: RoundPoint) -> RoundPoint {
        let Some(RimPoint { of_round, end, point: on_rim }) = point.rim else { return point };
        let normal = self.separation.normal;
        let [mut mine, mut theirs] = point.anchors;
        match self.partner {
            _ if of_round => {
                mine = self.round.hold_rim(on_rim, end, -normal, self.angular[0]);
            }
            Partner::Revolved(other) => {
                theirs = other.hold_rim(on_rim, end, normal, self.angular[1]);
            }
            Partner::Hull(_) | Partner::Plane(_) => {}
        }
        RoundPoint { anchors: [mine, theirs], ..point }
    }
}

/// True for lines that are nearly parallel.
fn is_along([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> bool {
    let (first, second) = (b - a, d - c);
    let both = first.length_squared() * second.length_squared();
    first.cross(second).length_squared() <= BESIDE * BESIDE * both
}

/// The line of the side that faces a direction, from the lower to the higher disc [m].
fn side_line(body: &PlacedRevolved, towards: DVec3) -> [DVec3; 2] {
    let radial = body.radial(towards);
    [body.rim(0, radial), body.rim(1, radial)]
}

fn hold_on_side(body: &PlacedRevolved, line: [DVec3; 2], part: f64, towards: DVec3) -> Anchor {
    let [low, high] = body.ends;
    let radius = low.radius + part * (high.radius - low.radius);
    body.hold_by_axis(line[0].lerp(line[1], part), radius, towards)
}

fn hold_single(
    body: &PlacedRevolved,
    facing: Facing,
    point: DVec3,
    towards: DVec3,
    angular: DVec3,
) -> Anchor {
    match facing {
        Facing::Rim(end) => body.hold_rim(point, end, towards, angular),
        // The point may belong to another normal, nearly the same.
        Facing::Side => {
            let line = side_line(body, towards);
            let [from, to] = [body.center(0), body.center(1)].map(|center| center.dot(body.axis));
            let part = ((point.dot(body.axis) - from) / (to - from)).clamp(0.0, 1.0);
            hold_on_side(body, line, part, towards)
        }
        Facing::Disc(_) => body.hold_fixed(point),
    }
}

/// True for the number of a rim point of the partner.
pub(crate) fn is_of_partner(id: u64) -> bool {
    (OF_PARTNER..SIDE).contains(&id) || id == SIDE_OF_PARTNER || id == SIDE_OF_PARTNER + 1
}
