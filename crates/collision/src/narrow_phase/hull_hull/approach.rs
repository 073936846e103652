//! Time of impact of two hulls within a frame.

use crate::narrow_phase::hull_hull::hull_pair::{HullPair, PREFERENCE};
use crate::narrow_phase::hull_hull::hull_point::{HullContact, HullPoint};
use crate::narrow_phase::hull_hull::reduction::FEW_POINTS;
use crate::narrow_phase::hull_hull::reduction::reduce;
use crate::narrow_phase::hull_hull::scratch::Scratch;

use crate::manifold::ManifoldPoint;
use crate::narrow_phase::pair_motion::{MOST_STEPS, PairMotion};
use frangible_bodies::BallisticPath;
use frangible_geometry::Hull;
use frangible_math::RigidTransform;
use glam::DVec3;

/// Separation below which contact points are computed, relative to the smaller hull's size.
/// Advancement to 0.1 % takes more axis searches, and left overlaps in falling heaps no smaller.
const NEAR: f64 = 0.02;

/// Instants at which a grazing pair is looked at until it counts as a touching one [1].
const MOST_LOOKS: u32 = 8;

/// Overlap at which a point shows that a pair does more than graze, relative to the overlap of
/// grazing [1]. Most pairs that touch are known by it, at a third of the cost.
const BEYOND: f64 = 1.2;

/// Cosine between normals that count as the same [1].
const SAME_NORMAL: f64 = 0.9998;

/// Two hulls in ballistic motion through a frame.
struct Approach<'a> {
    pair_motion: &'a PairMotion<'a>,
    hulls: [&'a Hull; 2],
}

/// An instant of the approach.
#[derive(Clone, Copy)]
struct Instant<'a> {
    time: f64,
    world_from_first: RigidTransform,
    pair: HullPair<'a>,
    contact: HullContact,
    /// True if the points include all near features at the frame's start.
    lasts: bool,
}

/// Appends the contact points of two hulls at first touch within the frame: at most four. Returns
/// the separation bound of all other features at the frame's start [m], if the points belong to the
/// start.
pub(crate) fn hull_points(
    pair_motion: &PairMotion,
    hulls: [&Hull; 2],
    scratch: &mut Scratch,
    points: &mut Vec<ManifoldPoint>,
) -> Option<f64> {
    scratch.points.clear();
    let approach = Approach { pair_motion, hulls };
    let instant = match approach.meeting(scratch) {
        Ok(instant) => instant,
        Err(apart) => {
            scratch.points.clear();
            return apart;
        }
    };
    scratch.points.retain(|point| approach.can_touch(&instant, point));
    reduce(
        &mut scratch.points,
        &mut scratch.spare,
        FEW_POINTS,
        (instant.contact.normal, PREFERENCE * pair_motion.size),
    );
    points.extend(scratch.points.iter().map(|point| approach.manifold_point(&instant, point)));
    instant.lasts.then_some(pair_motion.search)
}

impl<'a> Approach<'a> {
    /// Contact instant, with the points in `scratch`: the frame's start for near hulls, else the
    /// time of approach (conservative advancement along separating axes [Mir96]). Hulls that pass
    /// within the speculative margin get the instant of a separating axis. For hulls that pass
    /// further apart the error value is their separation at the frame's start, if known.
    fn meeting(&self, scratch: &mut Scratch) -> Result<Instant<'a>, Option<f64>> {
        let PairMotion { size, search, frame, .. } = *self.pair_motion;
        let (mut time, enough) = (0.0, NEAR * size);
        let mut steps_left = MOST_STEPS;
        loop {
            // Advance by face axes as long as their separation is large.
            let poses =
                [self.pair_motion.paths[0].pose(time), self.pair_motion.paths[1].pose(time)];
            let [world_from_first, world_from_second] =
                [poses[0].world_from_body(), poses[1].world_from_body()];
            let first_from_second = world_from_first.inverse().after(&world_from_second);
            let pair = HullPair::new(self.hulls, &first_from_second, size, frame.settings.width);
            let at_start = |apart: f64| (time == 0.0).then_some(apart);
            let axes = pair.face_axes(search, scratch).map_err(at_start)?;
            let mut apart = pair.apart_by(&axes);
            let is_far = apart.gap > enough;
            if !is_far {
                apart = pair.contact(&axes, search, scratch).ok_or_else(|| at_start(search))?;
            }

            // Advance to the earliest possible time of impact.
            let [first, second] = self.pair_motion.paths;
            let normal = poses[0].orientation * apart.normal;
            let closing = fastest_closing(&[*first, *second], (time, frame.dt), normal);
            let next = time + apart.gap / closing;
            steps_left -= 1;
            let is_passing = !(time..=frame.dt).contains(&next);
            let at_end = apart.gap - closing.max(0.0) * (frame.dt - time);
            if is_far && is_passing && at_end > self.pair_motion.near {
                return Err(at_start(apart.gap));
            }
            if apart.gap <= enough || is_passing || steps_left == 0 {
                let contact =
                    if is_far { pair.contact(&axes, search, scratch) } else { Some(apart) };
                let contact = contact.ok_or_else(|| at_start(search))?;
                let touch = Instant { time, world_from_first, pair, contact, lasts: time == 0.0 };
                return Ok(self.grazing(touch, scratch));
            }
            time = next;
        }
    }

    /// Contact instant of hulls that touch at `touch`, with the points in `scratch`: their closest
    /// approach, if they overlap no deeper than grazing until the frame's end.
    fn grazing(&self, touch: Instant<'a>, scratch: &mut Scratch) -> Instant<'a> {
        let PairMotion { ahead, is_substep, .. } = *self.pair_motion;
        let grazing = self.pair_motion.grazing();
        if touch.contact.gap <= -grazing || !is_narrow(&scratch.points, grazing) {
            return touch;
        }
        let paths = self.pair_motion.paths.map(BallisticPath::straight);
        let closing = |time: f64, normal: DVec3| fastest_closing(&paths, (time, ahead), normal);
        if !is_substep {
            // Most pairs rest, or come from further away and are looked at again.
            let HullContact { gap, normal } = touch.contact;
            let closing = closing(0.0, touch.world_from_first.direction(normal));
            let gets_deeper = gap + grazing < closing * ahead;
            if touch.time > 0.0 || gap > 0.0 || !gets_deeper {
                return touch;
            }
        }
        if self.gets_deeper(&touch, &paths, scratch) {
            return touch;
        }
        // The instant with the last change of the normal, and its points.
        let of_touch = std::mem::take(&mut scratch.points);
        let (mut meeting, mut points) = (touch, of_touch.clone());
        let (mut time, mut normal, mut gap) = (touch.time, touch.normal(), touch.contact.gap);
        for _ in 0..MOST_LOOKS {
            let next = time + (gap + grazing) / closing(time, normal);
            time = if (time..ahead).contains(&next) { next } else { ahead };
            let Some(later) = self.at(&paths, time, scratch) else { break };
            if later.contact.gap <= -grazing {
                break;
            }
            (normal, gap) = (later.normal(), later.contact.gap);
            if normal.dot(meeting.normal()) < SAME_NORMAL {
                meeting = later;
                points.clone_from(&scratch.points);
            }
            if time == ahead {
                scratch.points = points;
                return meeting;
            }
        }
        scratch.points = of_touch;
        touch
    }

    /// True if hulls that touch at `touch` overlap deeper than grazing when the first of its points
    /// would.
    fn gets_deeper(
        &self,
        touch: &Instant,
        paths: &[BallisticPath; 2],
        scratch: &mut Scratch,
    ) -> bool {
        let (ahead, grazing) = (self.pair_motion.ahead, self.pair_motion.grazing());
        let time_of = |point: &HullPoint| {
            let [first, second] = [0, 1].map(|side| {
                paths[side].velocity(touch.world_from_first.point(point.on[side]), touch.time)
            });
            let closing = (second - first).dot(touch.world_from_first.direction(point.normal));
            if closing > 0.0 { (point.gap + BEYOND * grazing) / closing } else { f64::INFINITY }
        };
        let time = touch.time + scratch.points.iter().map(time_of).fold(f64::INFINITY, f64::min);
        if time > ahead {
            return false;
        }
        let of_touch = std::mem::take(&mut scratch.points);
        let gap = self.at(paths, time, scratch).map(|later| later.contact.gap);
        scratch.points = of_touch;
        gap.is_none_or(|gap| gap <= -grazing)
    }

    /// The hulls at an instant of some paths, with the points in `scratch`; `None` if they overlap
    /// deeper than grazing along all faces' axes.
    fn at(
        &self,
        paths: &[BallisticPath; 2],
        time: f64,
        scratch: &mut Scratch,
    ) -> Option<Instant<'a>> {
        let PairMotion { size, search, frame, .. } = *self.pair_motion;
        let grazing = self.pair_motion.grazing();
        let [world_from_first, world_from_second] =
            [paths[0].pose(time).world_from_body(), paths[1].pose(time).world_from_body()];
        let first_from_second = world_from_first.inverse().after(&world_from_second);
        let pair = HullPair::new(self.hulls, &first_from_second, size, frame.settings.width);
        let axes = pair.face_axes(search, scratch).ok()?;
        if pair.apart_by(&axes).gap <= -grazing {
            return None;
        }
        let contact = pair.contact(&axes, search, scratch)?;
        Some(Instant { time, world_from_first, pair, contact, lasts: time == 0.0 })
    }

    /// True for a point that can touch within the frame from a separated start.
    fn can_touch(&self, instant: &Instant, point: &HullPoint) -> bool {
        if point.gap > self.pair_motion.search {
            return false;
        }
        if instant.time == 0.0 {
            return true;
        }
        self.gap_at_start(instant, point) >= point.gap.min(0.0) - self.pair_motion.grazing()
    }

    /// Separation at the frame's start, along the point's normal [m].
    fn gap_at_start(&self, instant: &Instant, point: &HullPoint) -> f64 {
        let [first, second] = self.pair_motion.paths;
        let on_first = first.start.world_from_body().point(point.on[0]);
        let on_second = second.start.world_from_body().point(instant.on_second(point));
        (on_first - on_second).dot(instant.world_from_first.direction(point.normal))
    }

    fn manifold_point(&self, instant: &Instant, point: &HullPoint) -> ManifoldPoint {
        let [on_first, on_second] = [
            instant.world_from_first.point(point.on[0]),
            instant.world_from_first.point(point.on[1]),
        ];
        let normal = instant.world_from_first.direction(point.normal);
        let [first, second] = self.pair_motion.paths;
        let velocity =
            first.velocity(on_first, instant.time) - second.velocity(on_second, instant.time);
        ManifoldPoint {
            anchor_first: point.on[0],
            rounding: [0.0; 2],
            anchor_second: instant.on_second(point),
            normal,
            feature: point.feature.id(self.hulls[1].edges().len()),
            approach: self.pair_motion.surface_speed(normal, -velocity.dot(normal), point.gap),
            gap: self.gap_at_start(instant, point),
        }
    }
}

/// True for a contact patch that is no wider than twice `grazing` [m] in some direction. A pair
/// that only grazes has a narrow one: the overlap along the axis that it passes on. Points that are
/// further apart than the nearest one, by more than `grazing`, are of no patch.
fn is_narrow(points: &[HullPoint], grazing: f64) -> bool {
    let middle = |point: &HullPoint| 0.5 * (point.on[0] + point.on[1]);
    let least = points.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
    let mut near = points.iter().filter(|point| point.gap <= least + grazing);
    let Some(first) = near.next() else { return true };
    let (from, most) = (middle(first), 2.0 * grazing);
    let rest = near.map(|point| middle(point) - from);
    let longest = rest.clone().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let Some(along) = longest.and_then(|along| along.try_normalize()) else { return true };
    rest.into_iter().all(|arm| arm.cross(along).length_squared() <= most * most)
}

/// Upper bound of the closing speed of any two points along a normal in the world frame, from an
/// instant to another [m/s]; negative if all separate.
fn fastest_closing(
    [first, second]: &[BallisticPath; 2],
    (time, end): (f64, f64),
    normal: DVec3,
) -> f64 {
    let turning = |path: &BallisticPath| path.angular.cross(normal).length() * path.radius;
    // Common gravity cancels.
    let falling = (second.acceleration - first.acceleration).dot(normal);
    let most = (time * falling).max(end * falling);
    (second.linear - first.linear).dot(normal) + most + turning(first) + turning(second)
}

impl Instant<'_> {
    /// Unit, world frame, from the second hull to the first.
    fn normal(&self) -> DVec3 {
        self.world_from_first.direction(self.contact.normal)
    }

    /// The point on the second hull, in the second hull's frame [m].
    fn on_second(&self, point: &HullPoint) -> DVec3 {
        self.pair.second_from_first.point(point.on[1])
    }
}
