//! A body of revolution on its way through a frame, seen from a mesh.

use crate::narrow_phase::hull_hull::hull_pair::PREFERENCE;
use crate::narrow_phase::mesh::mesh_contact::{Meets, MeshContact, feature_of};
use crate::narrow_phase::mesh::mesh_motion::{BEYOND, MeshMotion};
use crate::narrow_phase::mesh::triangle_sweep::Facet;
use crate::narrow_phase::revolved::contact::{THIN, TOUCH};
use crate::narrow_phase::revolved::first_touch::{Apart, Meeting};
use crate::narrow_phase::revolved::partner::Partner;
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use crate::narrow_phase::revolved::points::Instant;
use crate::narrow_phase::revolved::round_point::RoundPoint;
use crate::narrow_phase::revolved::separation::{Separation, flat_separation, quick_separation};
use frangible_geometry::{Revolved, Sides};
use frangible_math::RigidTransform;
use glam::DVec3;

/// Largest turn across its axis up to which a body's closest approach is looked for ahead [rad]:
/// beyond, it comes nearer and parts more than once, and normals of later instants touched cylinders
/// that passed 3 cm away.
const FORESEEN: f64 = 0.5;

/// A body of revolution and the motion of its pair.
#[derive(Clone, Copy)]
pub(crate) struct RoundMotion<'a> {
    pub(crate) motion: &'a MeshMotion<'a>,
    pub(crate) round: Revolved,
    /// The smaller half extent of the body [m].
    thin: f64,
    /// Lengths that are the same for a contact [m].
    pub(crate) close: f64,
    /// The body at the frame's start.
    pub(crate) start: PlacedRevolved,
    /// Part of free flight's way that what touches takes away, over the whole frame, mesh frame [m].
    held: DVec3,
    /// The straight way over the frame without gravity, as of a body that something else bears, and
    /// without what is held; mesh frame [m].
    carried: Option<DVec3>,
}

impl<'a> RoundMotion<'a> {
    pub(crate) fn new(motion: &'a MeshMotion<'a>, round: &Revolved) -> Self {
        let (low, high) = motion.body_shape().bounds;
        let thin = 0.5 * (high - low).min_element();
        let ends = [&motion.supported, &motion.instants]
            .map(|way| way.last().map_or(DVec3::ZERO, |(_, last)| last.translation));
        Self {
            motion,
            round: *round,
            thin,
            close: (PREFERENCE * motion.pair_motion.size).min(THIN * thin),
            start: PlacedRevolved::new(round, &motion.start()),
            held: ends[0] - ends[1],
            carried: None,
        }
    }

    /// `mesh_from_body` at an instant [s].
    fn pose(&self, time: f64) -> RigidTransform {
        let [body, mesh] = [self.motion.body_path(), self.motion.mesh_path()];
        let pose = if time == 0.0 {
            self.motion.start()
        } else {
            let mesh_from_world = mesh.pose(time).world_from_body().inverse();
            mesh_from_world.after(&body.pose(time).world_from_body())
        };
        let part = time / self.motion.pair_motion.frame.dt.max(f64::MIN_POSITIVE);
        let translation = match self.carried {
            Some(way) => self.motion.start().translation + part * way,
            None => pose.translation + part * self.held,
        };
        RigidTransform { translation, ..pose }
    }

    pub(crate) fn placed(&self, time: f64) -> PlacedRevolved {
        if time == 0.0 { self.start } else { PlacedRevolved::new(&self.round, &self.pose(time)) }
    }

    /// Way by gravity since the frame's start, mesh frame [m]; zero of a body that the mesh bears.
    pub(crate) fn sag(&self, time: f64) -> DVec3 {
        if self.motion.is_borne { DVec3::ZERO } else { self.motion.sag(time) }
    }

    /// First touch with a partner within the frame, or the closest approach; normals are in the
    /// mesh's frame. `None` for what comes no nearer than the speculative margin.
    pub(crate) fn touch(&self, partner: &Partner, guess: DVec3) -> Option<Apart> {
        let pair_motion = self.motion.pair_motion;
        let start = self.apart(partner, (0.0, pair_motion.reach), guess);
        if start.gap > pair_motion.reach {
            return None;
        }
        Meeting {
            at: &|time, guess| self.apart(partner, (time, f64::INFINITY), guess),
            closing: &|time, normal| self.fastest_closing(time, normal),
            dt: pair_motion.frame.dt,
            touch: TOUCH * self.thin,
            near: pair_motion.near,
        }
        .first_touch(start)
    }

    /// The way without gravity and the closest approach on it, of a body that touches a partner at
    /// `touch`, or still comes nearer then, and only grazes it.
    pub(crate) fn grazed(&self, partner: &Partner, touch: &Apart) -> Option<(Self, Apart)> {
        let pair_motion = self.motion.pair_motion;
        let grazing = pair_motion.grazing();
        let passes = touch.gap > TOUCH * self.thin && touch.parting >= 0.0;
        if passes || touch.gap <= -grazing {
            return None;
        }
        let [from, to] = [0.0, pair_motion.frame.dt].map(|time| self.pose(time).translation);
        let way = to - from - self.sag(pair_motion.frame.dt);
        let carried = Self { carried: Some(way), ..*self };
        let limits = (pair_motion.size, self.close);
        let at = |time: f64, guess: DVec3| {
            carried.seen(time, |round| flat_separation(round, partner, limits, guess))
        };
        let meeting = Meeting {
            at: &at,
            closing: &|time, normal| carried.fastest_closing(time, normal),
            dt: self.foreseen(BEYOND * pair_motion.ahead),
            touch: 0.0,
            near: pair_motion.near,
        };
        meeting.grazed(at(0.0, touch.normal), grazing).map(|nearest| (carried, nearest))
    }

    /// The part of a time ahead [s] in which the body turns by no more than [`FORESEEN`], and that of
    /// the present step at least.
    fn foreseen(&self, ahead: f64) -> f64 {
        let pair_motion = self.motion.pair_motion;
        let spins = pair_motion.paths.map(|path| path.spin_speed / path.radius);
        let most = FORESEEN / spins[0].max(spins[1]).max(f64::MIN_POSITIVE);
        ahead.min(most.max(pair_motion.frame.dt))
    }

    fn apart(&self, partner: &Partner, (time, most): (f64, f64), guess: DVec3) -> Apart {
        let limits = (self.motion.pair_motion.size, most);
        self.seen(time, |round| quick_separation(round, partner, limits, guess))
    }

    fn seen(&self, time: f64, separation: impl Fn(&PlacedRevolved) -> Separation) -> Apart {
        let round = self.placed(time);
        let Separation { gap, normal, on } = separation(&round);
        let at = on.map_or_else(|| round.support(-normal), |on| on[0]) - round.rounding * normal;
        let way = |later: f64| self.pose(later).point(self.pose(time).inverse().point(at));
        // Over a thousandth of the frame.
        let step = 1e-3 * self.motion.pair_motion.frame.dt.max(f64::MIN_POSITIVE);
        let parting = (way(time + step) - at).dot(normal) / step;
        Apart { time, gap, normal, parting }
    }

    /// Upper bound of the closing speed along a normal of any two points from an instant on [m/s].
    fn fastest_closing(&self, time: f64, normal: DVec3) -> f64 {
        let dt = self.motion.pair_motion.frame.dt;
        let [body, mesh] = [self.motion.body_path(), self.motion.mesh_path()];
        let outward = self.motion.world_direction(normal, time);
        let falling = (mesh.acceleration - body.acceleration).dot(outward);
        let most = (time * falling).max(dt * falling);
        let held = self.held.dot(normal) / dt.max(f64::MIN_POSITIVE);
        (mesh.linear - body.linear).dot(outward) + most + body.spin_speed + mesh.spin_speed - held
    }

    /// Contact points of a pair at an instant, by `of`.
    pub(crate) fn points(
        &self,
        round: &PlacedRevolved,
        partner: &Partner,
        (separation, time): (Separation, f64),
        of: impl Fn(&Instant, &mut Vec<RoundPoint>),
    ) -> Vec<RoundPoint> {
        let [body, mesh] = [self.motion.body_path(), self.motion.mesh_path()];
        let mesh_from_world = mesh.pose(time).orientation.conjugate();
        let instant = Instant {
            round,
            partner,
            separation,
            angular: [body, mesh].map(|path| mesh_from_world * path.angular),
            gravity: mesh_from_world * self.motion.pair_motion.frame.gravity,
            close: self.close,
        };
        let mut found = Vec::new();
        of(&instant, &mut found);
        if let [alone] = found[..] {
            found[0] = instant.alone(alone);
        }
        found
    }

    /// Way of an anchor in the mesh's frame from an instant [s] to the last one at which a contact of
    /// this frame acts [m]: contacts do up to a substep ahead.
    pub(crate) fn way_ahead(&self, anchor: DVec3, time: f64) -> DVec3 {
        let ahead = BEYOND * self.motion.pair_motion.ahead;
        self.pose(ahead).point(self.pose(time).inverse().point(anchor)) - anchor
    }

    /// True for a contact with surfaces that touch at its time.
    pub(crate) fn touches(&self, contact: &MeshContact) -> bool {
        let anchor = self.pose(contact.time).point(contact.on_body);
        let gap = (anchor - contact.on_mesh).dot(contact.normal) - contact.rounding;
        self.closes((gap, contact.normal), (anchor, contact.time))
    }

    /// True for surfaces that touch at an instant [s], but for what the search for it leaves; false
    /// for what passes, if only a little above.
    pub(crate) fn meet(&self, separation: &Separation, time: f64) -> bool {
        let Separation { gap, normal, .. } = *separation;
        self.closes((gap, normal), (self.placed(time).support(-normal), time))
    }

    fn closes(&self, (gap, normal): (f64, DVec3), (anchor, time): (DVec3, f64)) -> bool {
        let closes = || -self.way_ahead(anchor, time).dot(normal) >= gap;
        gap <= self.motion.thin || gap <= TOUCH * self.thin && closes()
    }

    /// False for a point that a sheet hides from the body's middle. One that lies behind its
    /// triangle has come there through a triangle, not past all of them, and in front of one no
    /// other triangle is between.
    pub(crate) fn is_seen(
        &self,
        triangle: usize,
        (round, time): (&PlacedRevolved, f64),
        point: &RoundPoint,
    ) -> bool {
        let MeshMotion { mesh, thin, rim, .. } = *self.motion;
        if mesh.sides() == Sides::One {
            return true;
        }
        let foot = point.anchors[1].point;
        let is_deep = point.gap() < -rim;
        // Free flight sinks into what may bear the body.
        let middle = round.middle - self.sag(time);
        let way = [middle, if is_deep { point.on_surfaces()[0] } else { foot }];
        let mut is_between = false;
        mesh.visit_way(way, thin, |other| {
            let (corners, mut normal) = (mesh.corners(other), mesh.normal(other));
            if normal.dot(way[0] - corners[0]) < 0.0 {
                normal = -normal;
            }
            let facet = Facet { corners, normal };
            let counts = is_deep || other != triangle && facet.height(foot) < -rim;
            is_between |= counts && facet.crossing(way, thin).is_some();
        });
        is_between == is_deep
    }

    /// True for a point that comes to its triangle's plane past the mesh, before it could act:
    /// contacts do up to a substep ahead.
    pub(crate) fn passes(&self, point: &RoundPoint, time: f64) -> bool {
        let motion = self.motion;
        let gap = point.gap();
        if gap <= motion.thin || time >= BEYOND * motion.pair_motion.ahead {
            return false;
        }
        let way = self.way_ahead(point.anchors[0].point, time);
        let closing = -way.dot(point.normal);
        let on_surface = point.on_surfaces()[0];
        closing > gap && !motion.meets_mesh([on_surface, on_surface + gap / closing * way])
    }

    /// A point as a contact; `None` for one that cannot touch within the frame.
    pub(crate) fn contact(
        &self,
        point: &RoundPoint,
        time: f64,
        (meets, number): (Meets, u64),
    ) -> Option<MeshContact> {
        let pair_motion = self.motion.pair_motion;
        let [of_round, of_mesh] = point.anchors;
        let contact = MeshContact {
            on_body: self.pose(time).inverse().point(of_round.point),
            rounding: of_round.rounding + of_mesh.rounding,
            on_mesh: of_mesh.point,
            normal: point.normal,
            time,
            feature: feature_of(meets, number),
        };
        let gap = point.gap();
        let least = gap.min(0.0) - pair_motion.grazing();
        let can_touch = gap <= pair_motion.search
            && (time == 0.0 || contact.gap_at_start(self.motion) >= least);
        can_touch.then_some(contact)
    }
}
