//! Contact constraints of eight manifolds side by side, in single precision.

use super::constraints::{Constraint, MOST_POINTS};
use super::effective_mass::{inverse_2x2, reciprocal};
use super::lane_bodies::{
    LaneDisplacements, LaneVelocities, displacements, inverse_inertias, velocities,
};
use super::sides::Sides;
use super::solver_bodies::Lines;
use frangible_math::{Instructions, LANES, Mask, Single, Single3, Symmetric};
use glam::DVec3;

/// Storage index of entry (i, j) of the symmetric 4 x 4 matrix K.
pub(super) const ENTRY: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]];

/// One point of each of eight manifolds.
#[derive(Clone, Copy)]
pub(super) struct PointLanes<I> {
    /// From the bodies' centres at the frame's start, world frame [m].
    pub(super) anchors: [Single3<I>; 2],
    /// At the frame's start [m].
    pub(super) separation: Single<I>,
    /// Accumulated normal impulse of the substep [N s].
    pub(super) impulse: Single<I>,
    /// Along the normal [kg].
    pub(super) effective_mass: Single<I>,
    /// Distance from the manifold's centre, at which friction resists twisting [m].
    pub(super) radius: Single<I>,
}

/// Rolling friction; present if any lane has a nonzero coefficient.
pub(super) struct RollingLanes<I> {
    /// Torque per normal force [m].
    pub(super) coefficient: Single<I>,
    /// Inverse of the 2 x 2 matrix about the tangents: xx, yy, xy [kg m^2].
    pub(super) effective_inertia: [Single<I>; 3],
    /// About both tangents [N m s].
    pub(super) impulse: [Single<I>; 2],
}

/// Eight manifolds, up to four points each, one normal per manifold. No two lanes share a movable
/// body.
pub(super) struct ContactBatch<I> {
    /// First solver line of the slab.
    pub(super) first_line: usize,
    /// Solver lines of the first and second bodies, relative to `first_line`.
    pub(super) ids: [[u32; LANES]; 2],
    /// Constraint index of each lane; `u32::MAX` for empty lanes.
    pub(super) constraints: [u32; LANES],
    /// Largest point count of all lanes.
    pub(super) point_count: usize,
    pub(super) points: [PointLanes<I>; MOST_POINTS],
    /// World frame, from the first body to the second.
    pub(super) normal: Single3<I>,
    pub(super) tangent: Single3<I>,
    /// Means of the anchors, from the bodies' centres [m]: friction acts there.
    pub(super) centers: [Single3<I>; 2],
    /// Distances from `centers` along the normal to the middle between the surfaces [m].
    pub(super) offsets: [Single<I>; 2],
    /// The matrix K of the points: velocity at i per impulse at j [1/kg].
    pub(super) k: [Single<I>; 10],
    /// Inverse of the 2 x 2 matrix along the tangents: xx, yy, xy [kg].
    pub(super) tangent_mass: [Single<I>; 3],
    /// About the normal [kg m^2].
    pub(super) twist_inertia: Single<I>,
    /// Accumulated impulses of friction along both tangents [N s] and about the normal [N m s].
    pub(super) friction: [Single<I>; 2],
    pub(super) twist: Single<I>,
    pub(super) friction_coefficient: Single<I>,
    pub(super) spinning_friction: Single<I>,
    pub(super) rolling: Option<Box<RollingLanes<I>>>,
    pub(super) restitution: Single<I>,
    /// Lanes whose impacts may be solved together with those of other lanes.
    pub(super) companions: Mask,
    /// Lanes with a body that may break: their impacts are noted.
    pub(super) breakable: Mask,
    /// Lanes whose impacts are solved as such: those with restitution, with companions, or with a
    /// body that may break. Others are stopped by the soft sweep.
    pub(super) bounces: Mask,
    /// Relative gravity along the normal [m/s^2].
    pub(super) gravity: Single<I>,
    /// Sums over the frame: impulses along normal and tangents [N s].
    pub(super) frame_impulse: [Single<I>; 3],
    /// Work of closing overlaps, of friction, and of kinematic bodies in the frame [J].
    pub(super) recovery: Single<I>,
    pub(super) friction_work: Single<I>,
    pub(super) driven_work: Single<I>,
    /// Lanes with a kinematic body, by side.
    pub(super) is_driven: [Mask; 2],
    /// Lanes with a nonzero impulse in this frame.
    pub(super) acted: Mask,
    /// Lanes that may not act before they are detected again, lanes that ask for it, and lanes that
    /// were in this substep, without a contact.
    pub(super) unconfirmed: Mask,
    pub(super) asks: Mask,
    pub(super) passes: Mask,
    /// True if arms turned with their bodies in the last visit.
    pub(super) is_turned: bool,
    /// True if all accumulated impulses are zero: warm starting has no effect.
    pub(super) is_quiet: bool,
    /// True if bodies have turned so far that K must be recomputed before the next solve.
    pub(super) is_stale: bool,
    /// True if any lane may approach faster than the bounce threshold.
    pub(super) may_bounce: bool,
}

impl<I: Instructions> ContactBatch<I> {
    /// Empty lanes: both sides are the slab's first line, which is fixed.
    pub(super) fn empty(first_line: usize) -> Self {
        let (zero, zero3) = (Single::ZERO, Single3::ZERO);
        let point = PointLanes {
            anchors: [zero3; 2],
            separation: Single::same(f32::MAX.sqrt()),
            impulse: zero,
            effective_mass: zero,
            radius: zero,
        };
        Self {
            first_line,
            ids: [[0; LANES]; 2],
            constraints: [u32::MAX; LANES],
            point_count: 0,
            points: [point; MOST_POINTS],
            normal: zero3,
            tangent: zero3,
            centers: [zero3; 2],
            offsets: [zero; 2],
            k: [zero; 10],
            tangent_mass: [zero; 3],
            twist_inertia: zero,
            friction: [zero; 2],
            twist: zero,
            friction_coefficient: zero,
            spinning_friction: zero,
            rolling: None,
            restitution: zero,
            companions: Mask::NONE,
            breakable: Mask::NONE,
            bounces: Mask::NONE,
            gravity: zero,
            frame_impulse: [zero; 3],
            recovery: zero,
            friction_work: zero,
            driven_work: zero,
            is_driven: [Mask::NONE; 2],
            acted: Mask::NONE,
            unconfirmed: Mask::NONE,
            asks: Mask::NONE,
            passes: Mask::NONE,
            is_turned: false,
            is_quiet: true,
            is_stale: true,
            may_bounce: true,
        }
    }

    /// Packs a constraint into a lane.
    pub(super) fn fill(&mut self, lane: usize, (number, constraint): (u32, &Constraint)) {
        self.constraints[lane] = number;
        self.is_quiet &= !constraint.carries();
        self.point_count = self.point_count.max(constraint.points.len());
        for side in 0..2 {
            self.ids[side][lane] = constraint.lines[side] - self.first_line as u32;
            self.centers[side].set(lane, constraint.centers[side]);
            self.offsets[side].set(lane, constraint.offsets[side]);
            self.is_driven[side].set(lane, constraint.is_driven[side]);
        }
        for (lanes, point) in self.points.iter_mut().zip(&constraint.points) {
            for side in 0..2 {
                lanes.anchors[side].set(lane, point.anchors[side]);
            }
            lanes.separation.set(lane, point.separation);
            lanes.impulse.set(lane, point.impulse);
            lanes.radius.set(lane, point.radius);
        }
        self.normal.set(lane, constraint.normal);
        self.tangent.set(lane, constraint.tangent);
        for k in 0..2 {
            self.friction[k].set(lane, constraint.friction_impulse[k]);
        }
        self.twist.set(lane, constraint.twist_impulse);
        let surface = &constraint.surface;
        self.friction_coefficient.set(lane, surface.friction);
        self.spinning_friction.set(lane, surface.spinning_friction);
        self.restitution.set(lane, surface.restitution.max(0.0));
        let may_break = self.breakable.get(lane);
        let has_impacts = surface.restitution > 0.0 || self.companions.get(lane) || may_break;
        self.bounces.set(lane, has_impacts);
        if surface.rolling_friction > 0.0 {
            let zero = Single::ZERO;
            let none = RollingLanes {
                coefficient: zero,
                effective_inertia: [zero; 3],
                impulse: [zero; 2],
            };
            let rolling = self.rolling.get_or_insert_with(|| Box::new(none));
            rolling.coefficient.set(lane, surface.rolling_friction);
            for k in 0..2 {
                rolling.impulse[k].set(lane, constraint.rolling_impulse[k]);
            }
        }
        self.gravity.set(lane, constraint.gravity);
    }

    /// Packs another constraint into a lane without impulses.
    pub(super) fn refill(&mut self, lane: usize, (number, constraint): (u32, &Constraint)) {
        let empty = Self::empty(self.first_line);
        for (lanes, none) in self.points.iter_mut().zip(&empty.points) {
            for side in 0..2 {
                lanes.anchors[side].set(lane, none.anchors[side].get(lane));
            }
            lanes.separation.set(lane, none.separation.get(lane));
        }
        self.fill(lane, (number, constraint));
        self.unconfirmed.set(lane, false);
        self.is_stale = true;
        self.may_bounce = true;
    }

    /// True if a lane's points press on each other.
    pub(super) fn presses(&self, lane: usize) -> bool {
        self.points[..self.point_count].iter().any(|point| point.impulse.get(lane) > 0.0)
    }

    /// Impulse of a lane in the frame, on the second body, world frame [N s].
    pub(super) fn impulse_of_frame(&self, lane: usize) -> DVec3 {
        let axes = self.frame_of(lane);
        (0..3).map(|k| self.frame_impulse[k].get(lane) * axes[k]).sum()
    }

    /// Removes and returns the impulse of a lane in the frame.
    pub(super) fn take_frame_impulse(&mut self, lane: usize) -> DVec3 {
        let impulse = self.impulse_of_frame(lane);
        for along in &mut self.frame_impulse {
            along.set(lane, 0.0);
        }
        impulse
    }

    /// Removes and returns the lanes that ask to act.
    pub(super) fn take_asking(&mut self) -> impl Iterator<Item = usize> + use<I> {
        let asks = std::mem::replace(&mut self.asks, Mask::NONE);
        (0..LANES).filter(move |&lane| asks.get(lane))
    }

    /// Computes K and the effective masses of friction at the current poses.
    #[inline(always)]
    pub(super) fn prepare(&mut self, lines: &Lines) {
        self.is_stale = false;
        let at = self.displacements(lines);
        let sides = self.sides(lines);
        let Sides { of, inertia } = &sides;
        let inverse_mass = of[0].inverse_mass + of[1].inverse_mass;
        let n = self.normal;
        let mut arms = [[Single3::ZERO; 2]; MOST_POINTS];
        for (arms, point) in arms.iter_mut().zip(&self.points[..self.point_count]) {
            for side in 0..2 {
                let anchor = point.anchors[side];
                arms[side] = (anchor + at[side].turn_of(anchor)).cross(n);
            }
        }
        for i in 0..self.point_count {
            let turns = [inertia[0] * arms[i][0], inertia[1] * arms[i][1]];
            for j in i..self.point_count {
                self.k[ENTRY[i][j]] =
                    inverse_mass + turns[0].dot(arms[j][0]) + turns[1].dot(arms[j][1]);
            }
            self.points[i].effective_mass = reciprocal(self.k[ENTRY[i][i]]);
        }

        let tangents = [self.tangent, n.cross(self.tangent)];
        let centers = self.turned_centers(&at);
        self.tangent_mass = sides.tangent_mass(tangents, centers);
        let mut about = [Single::ZERO; 3];
        let mut twist = Single::ZERO;
        for side in 0..2 {
            let turns = [inertia[side] * tangents[0], inertia[side] * tangents[1]];
            about[0] = about[0] + turns[0].dot(tangents[0]);
            about[1] = about[1] + turns[1].dot(tangents[1]);
            about[2] = about[2] + turns[0].dot(tangents[1]);
            twist = twist + (inertia[side] * n).dot(n);
        }
        self.twist_inertia = reciprocal(twist);
        if let Some(rolling) = &mut self.rolling {
            rolling.effective_inertia = inverse_2x2(about);
        }
    }

    #[inline(always)]
    pub(super) fn velocities(&self, lines: &Lines) -> [LaneVelocities<I>; 2] {
        [velocities(lines.bodies, &self.ids[0]), velocities(lines.bodies, &self.ids[1])]
    }

    #[inline(always)]
    pub(super) fn displacements(&self, lines: &Lines) -> [LaneDisplacements<I>; 2] {
        [displacements(lines.bodies, &self.ids[0]), displacements(lines.bodies, &self.ids[1])]
    }

    #[inline(always)]
    pub(super) fn inverse_inertias(&self, lines: &Lines) -> [Symmetric<Single<I>>; 2] {
        let of = lines.inverse_inertias;
        [inverse_inertias(of, &self.ids[0]), inverse_inertias(of, &self.ids[1])]
    }

    /// Current points of friction, from the bodies' centres [m].
    #[inline(always)]
    pub(super) fn turned_centers(&self, at: &[LaneDisplacements<I>; 2]) -> [Single3<I>; 2] {
        let mut centers = self.centers;
        for side in 0..2 {
            let offset = self.normal * self.offsets[side];
            centers[side] = centers[side] + at[side].turn_of(centers[side]) + offset;
        }
        centers
    }

    /// Normal impulses of a lane's points in the last substep [N s].
    pub(super) fn normal_impulses(&self, lane: usize) -> [f64; MOST_POINTS] {
        let mut impulses = [0.0; MOST_POINTS];
        for (impulse, point) in impulses.iter_mut().zip(&self.points) {
            *impulse = point.impulse.get(lane);
        }
        impulses
    }

    /// Normal and both tangents of a lane.
    pub(super) fn frame_of(&self, lane: usize) -> [DVec3; 3] {
        let (normal, tangent) = (self.normal.get(lane), self.tangent.get(lane));
        [normal, tangent, normal.cross(tangent)]
    }
}

impl<I> ContactBatch<I> {
    /// Solver lines of the first and the second body of a lane.
    #[inline(always)]
    pub(super) fn lines_of(&self, lane: usize) -> [usize; 2] {
        [self.first_line + self.ids[0][lane] as usize, self.first_line + self.ids[1][lane] as usize]
    }

    /// Solver lines of the first and of the second bodies.
    #[inline(always)]
    pub(super) fn lines(&self) -> [[usize; LANES]; 2] {
        self.ids.map(|of_side| of_side.map(|id| self.first_line + id as usize))
    }
}
