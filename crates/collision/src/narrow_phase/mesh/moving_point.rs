//! A ball, or a point of a body, on its way along a mesh.
//!
//! The way is that of free flight until the first touch. From there it goes on along what was
//! touched, or bounces, and may touch more: a body needs its contacts with all of that in this
//! frame. What free flight would touch further on counts too, unless the actual way ends behind it:
//! its plane, which has no borders, would push the body back.

pub(crate) mod follow;

use crate::narrow_phase::mesh::edge_sweep::{MeshEdge, nearest_to_corner, sweep_corner};
use crate::narrow_phase::mesh::mesh_contact::{Meets, MeshContact, feature_of, side_of};
use crate::narrow_phase::mesh::mesh_motion::{BEYOND, MeshMotion};
use crate::narrow_phase::mesh::nearby::NearTriangle;
use crate::narrow_phase::mesh::triangle_sweep::{Facet, Sweep};
use crate::narrow_phase::pair_motion::PairMotion;
use frangible_geometry::{EdgeKind, Sides};
use glam::DVec3;

/// Sine of the angle by which a face of a polyhedron may dip under the plane that a corner of it
/// slides onto [1]: ramps that begin less steeply are met with the corner.
const TILT: f64 = 0.1;

/// Cosine of the largest angle between the normals of what bears a point and of what free flight,
/// which sinks into it, meets besides [1].
const ALIKE: f64 = 0.7;

/// Cosine of the least angle at an edge whose rim is not met [1].
const STEEP: f64 = 0.9;

/// Cosine between normals of the same plane, as in the solver's constraints.
const SAME_NORMAL: f64 = 1.0 - 1e-5;

/// A point of a body, with a ball around it.
pub(crate) struct MovingPoint<'a> {
    pub(crate) motion: &'a MeshMotion<'a>,
    /// In the body frame [m].
    pub(crate) anchor: DVec3,
    /// [m]
    pub(crate) radius: f64,
    /// A point inside of the body, on the straight way from which the anchor has come through what
    /// it overlaps; body frame [m].
    pub(crate) inside: Option<DVec3>,
    /// Corners of a convex body, of which the point is one, body frame [m].
    pub(crate) corners: &'a [DVec3],
    /// Part of the speed against a surface that comes back [1].
    pub(crate) bounce: f64,
    pub(crate) feature: u64,
}

/// A feature that the point meets, or comes near, on a part of its way.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    sweep: Sweep,
    /// [s]
    time: f64,
    on_mesh: DVec3,
    normal: DVec3,
    /// True for the inside of a triangle.
    of_face: bool,
}

/// A straight part of the way.
#[derive(Clone, Copy, Debug)]
struct Leg {
    way: [DVec3; 2],
    /// At both ends [s].
    times: [f64; 2],
    /// True in free flight.
    falls: bool,
}

impl MovingPoint<'_> {
    /// Appends the contacts of the point.
    pub(crate) fn contacts(&self, contacts: &mut Vec<MeshContact>) {
        let instants = &self.motion.instants;
        let at = |part: usize| instants[part].1.point(self.anchor);
        let start = self.entry(at(0));
        let legs: Vec<Leg> = (1..instants.len())
            .map(|part| Leg {
                way: [at(part - 1), at(part)],
                times: [instants[part - 1].0, instants[part].0],
                falls: true,
            })
            .collect();
        let mut flight = Vec::new();
        for (part, leg) in legs.iter().enumerate() {
            let before = flight.len();
            self.meetings(leg, (start, part == 0), &mut flight);
            if flight[before..].iter().any(|meeting| meeting.sweep.touches) {
                // Later triangles would be met on another way.
                break;
            }
        }
        let mut found: Vec<Meeting> = Vec::new();
        let end = self.follow(&legs, &flight, &mut found);
        let is_harmless = |meeting: &Meeting| {
            meeting.normal.dot(end - meeting.on_mesh) - self.radius >= -self.motion.thin
        };
        // Free flight sinks into what bears the point: what it meets there otherwise is as what
        // bears it, like a lower floor.
        let bearing = found.first().map(|first| first.normal);
        let is_alike = |meeting: &Meeting| {
            let is_level = |bearing: DVec3| bearing.dot(meeting.normal) > ALIKE;
            bearing.is_none_or(|bearing| meeting.of_face && is_level(bearing))
        };
        flight.retain(|meeting| {
            let overlaps = meeting.sweep.touches && meeting.time == 0.0;
            // Triangles that come near only at the frame's end are met in the next.
            let now = meeting.normal.dot(at(0) - meeting.on_mesh) - self.radius;
            let most = if meeting.of_face { self.beside() } else { self.motion.pair_motion.near };
            let is_due = now <= most || meeting.sweep.touches && is_alike(meeting);
            overlaps || is_due && is_harmless(meeting)
        });
        found.append(&mut flight);
        self.keep(&found, contacts);
    }

    /// Gap at the frame's start of a triangle beside the way that counts [m]: others may push a
    /// ball there.
    fn beside(&self) -> f64 {
        let PairMotion { near, reach, .. } = *self.motion.pair_motion;
        near + (reach - near).min(2.0 * self.radius)
    }

    /// Where the way from inside of the body to the point first goes into the mesh, or the point.
    fn entry(&self, point: DVec3) -> DVec3 {
        let Some(inside) = self.inside else { return point };
        let way = [self.motion.start().point(inside), point];
        let MeshMotion { mesh, thin, nearby, .. } = self.motion;
        let thin = *thin;
        let mut first = 1.0;
        nearby.visit_way(mesh, way, thin, |triangle| {
            let facet = self.facet(triangle, way[0]);
            first = facet.crossing(way, thin).map_or(first, |at| at.min(first));
        });
        way[0].lerp(way[1], first)
    }

    /// A triangle with the side that a point in front of it sees.
    fn facet(&self, triangle: &NearTriangle, seen_from: DVec3) -> Facet {
        let NearTriangle { corners, normal, .. } = *triangle;
        let is_seen = (seen_from - corners[0]).dot(normal) >= 0.0;
        let flips = self.motion.mesh.sides() == Sides::Two && !is_seen;
        Facet { corners, normal: if flips { -normal } else { normal } }
    }

    /// The side of a triangle on which the point is; `None` behind a triangle that is solid there.
    fn front(&self, triangle: &NearTriangle, start: DVec3) -> Option<Facet> {
        let MeshMotion { mesh, thin, rim, .. } = *self.motion;
        let facet = self.facet(triangle, start);
        // A corner of a resting body is a little behind the planes of triangles beside it.
        let near = if self.corners.is_empty() { thin } else { rim };
        if mesh.sides() == Sides::One {
            return (facet.height(start) >= -near).then_some(facet);
        }
        // A point in the plane itself is where its body is.
        match self.inside {
            Some(inside) if facet.height(start) <= near => {
                Some(self.facet(triangle, self.motion.start().point(inside)))
            }
            _ => Some(facet),
        }
    }

    /// True if the body lies on the outer side of a plane through the point, mesh frame.
    fn is_over(&self, normal: DVec3) -> bool {
        let normal_body = self.motion.start().rotation.conjugate() * normal;
        let is_beyond = |point: &DVec3, least: f64| {
            let lever = *point - self.anchor;
            lever.dot(normal_body) >= least * lever.length()
        };
        self.inside.is_none_or(|inside| is_beyond(&inside, 0.0))
            && self.corners.iter().all(|corner| is_beyond(corner, -TILT))
    }

    /// True for a point on the rim of a triangle, if its body lies on another triangle beyond the
    /// edge: resting, it overlaps that one a little. `carried` is where the point is without
    /// gravity: something else may carry it, like the next of two flush meshes.
    fn grazes(&self, triangle: &NearTriangle, facet: &Facet, [at, carried]: [DVec3; 2]) -> bool {
        let MeshMotion { mesh, rim, .. } = *self.motion;
        let NearTriangle { index: triangle, normal: front, .. } = *triangle;
        if self.radius > 0.0 || self.corners.is_empty() || mesh.owns_nothing(triangle) {
            return false;
        }
        let vertices = mesh.triangles()[triangle];
        let turn = facet.normal.dot(front).signum();
        (0..3).any(|corner| {
            let (from, to) = (facet.corners[corner], facet.corners[(corner + 1) % 3]);
            let along = to - from;
            let inward = turn * facet.normal.cross(along);
            let off = inward.dot(at - from).min(inward.dot(carried - from));
            if off > rim * along.length() || mesh.edge_kind(triangle, corner) == EdgeKind::Flat {
                return false;
            }
            // Only an edge that stands out has a rim.
            let bears = |other: DVec3| {
                other.dot(facet.normal) < STEEP && other.dot(inward) < 0.0 && self.is_over(other)
            };
            let end = vertices[(corner + 1) % 3];
            mesh.around(vertices[corner] as usize).iter().any(|&other| {
                let other = other as usize;
                let normal = mesh.normal(other);
                other != triangle
                    && mesh.triangles()[other].contains(&end)
                    && (bears(normal) || mesh.sides() == Sides::Two && bears(-normal))
            })
        })
    }

    /// True for a ball whose nearest point to a triangle's plane comes there past the mesh, on the
    /// way of a leg, or ahead of it, before it could act: contacts do up to a substep ahead.
    fn passes(&self, facet: &Facet, leg: &Leg) -> bool {
        let [start, end] = leg.way.map(|center| facet.height(center) - self.radius);
        let duration = (leg.times[1] - leg.times[0]).max(f64::MIN_POSITIVE);
        let ahead = (BEYOND * self.motion.pair_motion.ahead - leg.times[0]) / duration;
        if self.radius == 0.0 || start <= 0.0 || start >= ahead * (start - end) {
            return false;
        }
        let low = leg.way.map(|center| center - self.radius * facet.normal);
        !self.motion.meets_mesh([low[0], low[0].lerp(low[1], start / (start - end))])
    }

    /// True for a foot on the back of a fold in a sheet, for a ball with its centre before the other
    /// part of it.
    fn is_behind_fold(
        &self,
        (triangle, facet): (usize, &Facet),
        [center, foot]: [DVec3; 2],
    ) -> bool {
        let MeshMotion { mesh, rim, .. } = *self.motion;
        if self.radius == 0.0 || mesh.sides() == Sides::One || mesh.owns_nothing(triangle) {
            return false;
        }
        let turn = facet.normal.dot(mesh.normal(triangle)).signum();
        (0..3).any(|corner| {
            let (from, to) = (facet.corners[corner], facet.corners[(corner + 1) % 3]);
            let inward = turn * facet.normal.cross(to - from);
            let Some(next) = mesh.neighbour_normal(triangle, corner) else { return false };
            let next = -turn * next;
            inward.dot(foot - from) <= rim * (to - from).length()
                && next.dot(inward) < 0.0
                && next.dot(facet.normal) < STEEP
                && next.dot(center - from) > 0.0
        })
    }

    /// True for a foot on a sheet's triangle that another triangle hides from a ball's centre.
    fn is_hidden(&self, triangle: usize, way: [DVec3; 2]) -> bool {
        let MeshMotion { mesh, thin, rim, ref nearby, .. } = *self.motion;
        if self.radius == 0.0 || mesh.sides() == Sides::One {
            return false;
        }
        let mut is_between = false;
        nearby.visit_way(mesh, way, thin, |other| {
            let facet = self.facet(other, way[0]);
            is_between |= other.index != triangle
                && facet.height(way[1]) < -rim
                && facet.crossing(way, thin).is_some();
        });
        is_between
    }

    /// Appends what a leg meets. `start` is where the way began outside of the mesh; on the first
    /// leg the point may overlap the mesh already.
    fn meetings(&self, leg: &Leg, (start, is_first): (DVec3, bool), found: &mut Vec<Meeting>) {
        let MeshMotion { mesh, thin, pair_motion, ref nearby, .. } = *self.motion;
        let margin = self.radius + self.beside() + thin;
        let [from, to] = leg.way;
        let low = from.min(to).min(start) - margin;
        let high = from.max(to).max(start) + margin;
        let mut meet = |sweep: Sweep, on_mesh: DVec3, normal: DVec3, of_face: bool| {
            if sweep.touches || sweep.least <= self.beside() {
                let time = leg.times[0] + sweep.at * (leg.times[1] - leg.times[0]);
                found.push(Meeting { sweep, time, on_mesh, normal, of_face });
            }
        };
        nearby.visit_box(mesh, (low, high), |near| {
            let triangle = near.index;
            if let Some(facet) = self.front(near, start) {
                let slack = pair_motion.near + thin;
                let is_over = || self.is_over(facet.normal);
                let sweep = facet.sweep(leg.way, self.radius, (thin, slack), is_over);
                let is_late = |sweep: &Sweep| is_first || sweep.at > 0.0 || sweep.least >= -slack;
                let met = sweep.filter(is_late).map(|sweep| (sweep, from.lerp(to, sweep.at)));
                let foot = |at: DVec3| at - facet.height(at) * facet.normal;
                let met = met.map(|(sweep, at)| (sweep, foot(at)));
                let grazes = |&(sweep, foot): &(Sweep, DVec3)| {
                    let sag = if leg.falls {
                        self.motion.sag_on((leg.times, sweep.at))
                    } else {
                        DVec3::ZERO
                    };
                    self.grazes(near, &facet, [foot, foot - sag])
                };
                let is_hidden = |&(sweep, foot): &(Sweep, DVec3)| {
                    let center = foot + (sweep.least + self.radius) * facet.normal;
                    self.is_behind_fold((triangle, &facet), [center, foot])
                        || !sweep.touches && self.is_hidden(triangle, [center, foot])
                };
                let met = met.filter(|met| !grazes(met) && !is_hidden(met));
                if let Some((sweep, foot)) = met
                    && (sweep.touches || !self.passes(&facet, leg))
                {
                    meet(sweep, foot, facet.normal, true);
                }
            }
            if self.radius == 0.0 || mesh.owns_nothing(triangle) {
                return;
            }
            for corner in 0..3 {
                if mesh.owns_edge(triangle, corner)
                    && let Some(edge) = MeshEdge::of(mesh, triangle, corner)
                    && let Some((sweep, foot, normal)) = edge.sweep(leg.way, self.radius)
                {
                    let passed = self.grazed(&sweep, |way| edge.nearest(way, self.radius));
                    let (foot, normal) = passed.unwrap_or((foot, normal));
                    meet(sweep, foot, normal, false);
                }
                if mesh.owns_vertex(triangle, corner) {
                    let vertex = mesh.triangles()[triangle][corner] as usize;
                    if let Some((sweep, foot, normal)) =
                        sweep_corner(mesh, vertex, leg.way, self.radius)
                    {
                        let passed = self.grazed(&sweep, |way| {
                            nearest_to_corner(mesh, vertex, way, self.radius)
                        });
                        let (foot, normal) = passed.unwrap_or((foot, normal));
                        meet(sweep, foot, normal, false);
                    }
                }
            }
        });
    }

    /// Foot [m] and normal of the closest approach to an edge or a corner that free flight touches,
    /// or still comes nearer to at its end, if the ball only grazes it. Gravity is left out, as of
    /// bodies that something carries: a ball of 0.5 m that rolled from one flush sheet to the next
    /// at 8 m/s hopped 0.12 m at the border.
    fn grazed(
        &self,
        sweep: &Sweep,
        nearest: impl Fn([DVec3; 2]) -> Option<(f64, DVec3, DVec3)>,
    ) -> Option<(DVec3, DVec3)> {
        let pair_motion = self.motion.pair_motion;
        let (grazing, ahead) = (pair_motion.grazing(), pair_motion.ahead);
        let passes = !sweep.touches && sweep.at < 1.0;
        if passes || sweep.least < -grazing {
            return None;
        }
        let ahead = BEYOND * ahead;
        let mesh_from_world = self.motion.mesh_path().pose(ahead).world_from_body().inverse();
        let body = self.motion.body_path().straight().pose(ahead).world_from_body();
        let end = mesh_from_world.after(&body).point(self.anchor);
        let (least, foot, normal) = nearest([self.motion.start().point(self.anchor), end])?;
        (least > -grazing).then_some((foot, normal))
    }

    /// Appends one contact for each normal: that with the smallest gap at the frame's start.
    fn keep(&self, found: &[Meeting], contacts: &mut Vec<MeshContact>) {
        let first = contacts.len();
        for meeting in found {
            let contact = MeshContact {
                on_body: self.anchor,
                rounding: self.radius,
                on_mesh: meeting.on_mesh,
                normal: meeting.normal,
                time: meeting.time,
                feature: feature_of(Meets::PointOnFace(side_of(meeting.normal)), self.feature),
            };
            let same = contacts[first..]
                .iter_mut()
                .find(|known| known.normal.dot(contact.normal) > SAME_NORMAL);
            match same {
                Some(known) => {
                    if contact.gap_at_start(self.motion) < known.gap_at_start(self.motion) {
                        *known = contact;
                    }
                }
                None => contacts.push(contact),
            }
        }
    }
}
