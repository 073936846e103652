//! Friction of a batch: Coulomb's at the middle of the contact patch, twisting, and rolling.

use super::constraints::MOST_POINTS;
use super::contact_batch::ContactBatch;
use super::effective_mass::reciprocal;
use super::lane_bodies::LaneDisplacements;
use super::sides::Sides;
use frangible_math::{Instructions, Single, Single3};

impl<I: Instructions> ContactBatch<I> {
    /// Twisting and rolling friction, then Coulomb friction in two dimensions at the manifold's
    /// centre.
    #[inline(always)]
    pub(super) fn solve_friction(
        &mut self,
        sides: &mut Sides<I>,
        at: &[LaneDisplacements<I>; 2],
        total: Single<I>,
        twist_arm: Single<I>,
    ) {
        let n = self.normal;
        let tangents = [self.tangent, n.cross(self.tangent)];
        let spin = sides.of[1].angular - sides.of[0].angular;
        let most = self.friction_coefficient * twist_arm + self.spinning_friction * total;
        let mut twist_inertia = self.twist_inertia;
        if self.is_turned {
            twist_inertia = reciprocal((sides.inertia[0] * n + sides.inertia[1] * n).dot(n));
        }
        let twist = (self.twist - twist_inertia * n.dot(spin)).min(most).max(-most);
        let mut torque = n * (twist - self.twist);
        self.twist = twist;
        if let Some(rolling) = &mut self.rolling {
            let slip = [spin.dot(tangents[0]), spin.dot(tangents[1])];
            let most = rolling.coefficient * total;
            let impulse = within_cone(rolling.impulse, rolling.effective_inertia, slip, most);
            torque = torque
                + tangents[0] * (impulse[0] - rolling.impulse[0])
                + tangents[1] * (impulse[1] - rolling.impulse[1]);
            rolling.impulse = impulse;
        }
        sides.of[0].angular = sides.of[0].angular - sides.inertia[0] * torque;
        sides.of[1].angular = sides.of[1].angular + sides.inertia[1] * torque;
        // Warm-started impulses may overshoot: friction work uses the slip after the solve.
        let spin = sides.of[1].angular - sides.of[0].angular;
        self.friction_work = self.friction_work + twist * n.dot(spin);
        if let Some(rolling) = &self.rolling {
            let [along, across] = rolling.impulse;
            let torque = tangents[0] * along + tangents[1] * across;
            self.friction_work = self.friction_work + torque.dot(spin);
        }

        let centers =
            if self.is_turned { self.turned_centers(at) } else { self.with_offsets(self.centers) };
        let slip = sides.velocity_at(centers);
        let slip = [slip.dot(tangents[0]), slip.dot(tangents[1])];
        let most = self.friction_coefficient * total;
        let mut friction = within_cone(self.friction, self.tangent_mass, slip, most);
        let mut change = [friction[0] - self.friction[0], friction[1] - self.friction[1]];
        if self.is_turned {
            change = sides.rub(change, slip, tangents, centers);
            friction = [self.friction[0] + change[0], self.friction[1] + change[1]];
        }
        let change = tangents[0] * change[0] + tangents[1] * change[1];
        self.friction = friction;
        sides.push_at(centers, change);
        let force = tangents[0] * friction[0] + tangents[1] * friction[1];
        self.friction_work = self.friction_work + force.dot(sides.velocity_at(centers));
    }

    /// Friction of an impact with normal `impulses`, their `sum` and their `twist_arm`: along both
    /// tangents and about the normal, with the slip before it.
    #[inline(always)]
    pub(super) fn rub_impact(
        &self,
        sides: &mut Sides<I>,
        at: &[LaneDisplacements<I>; 2],
        (sum, impulses, twist_arm): (Single<I>, &[Single<I>; MOST_POINTS], Single<I>),
    ) -> ([Single<I>; 3], [Single<I>; 3]) {
        let (zero, n) = (Single::ZERO, self.normal);
        let turns = [sides.inertia[0] * n, sides.inertia[1] * n];
        let spin = n.dot(sides.of[1].angular - sides.of[0].angular);
        let most = self.friction_coefficient * twist_arm + self.spinning_friction * sum;
        let twist = (-(reciprocal((turns[0] + turns[1]).dot(n)) * spin)).min(most).max(-most);
        sides.of[0].angular = sides.of[0].angular - turns[0] * twist;
        sides.of[1].angular = sides.of[1].angular + turns[1] * twist;

        let centers = self.impact_centers(at, (sum, impulses));
        let tangents = [self.tangent, n.cross(self.tangent)];
        let slip = sides.velocity_at(centers);
        let slip = [slip.dot(tangents[0]), slip.dot(tangents[1])];
        let most = self.friction_coefficient * sum;
        let mass = sides.tangent_mass(tangents, centers);
        let friction = within_cone([zero; 2], mass, slip, most);
        let rubs = sum.above(zero);
        let friction = [rubs.select(friction[0], zero), rubs.select(friction[1], zero)];
        let [along, across] = sides.rub(friction, slip, tangents, centers);
        sides.push_at(centers, tangents[0] * along + tangents[1] * across);
        ([along, across, twist], [slip[0], slip[1], spin])
    }

    /// Points at which friction of an impact acts, from the bodies' centres [m]: where its normal
    /// impulse does.
    #[inline(always)]
    pub(super) fn impact_centers(
        &self,
        at: &[LaneDisplacements<I>; 2],
        (sum, impulses): (Single<I>, &[Single<I>; MOST_POINTS]),
    ) -> [Single3<I>; 2] {
        let share = reciprocal(sum);
        let mut centers = [Single3::ZERO; 2];
        for (point, &impulse) in self.points[..self.point_count].iter().zip(impulses) {
            for side in 0..2 {
                centers[side] = centers[side] + point.anchors[side] * (impulse * share);
            }
        }
        for side in 0..2 {
            let offset = self.normal * self.offsets[side];
            centers[side] = centers[side] + at[side].turn_of(centers[side]) + offset;
        }
        centers
    }

    /// Books an impact's normal impulse, and its friction along both tangents and about the normal
    /// with the slip before it.
    #[inline(always)]
    pub(super) fn book_impact(
        &mut self,
        sum: Single<I>,
        friction: [Single<I>; 3],
        slip: [Single<I>; 3],
    ) {
        self.acted = self.acted.or(sum.above(Single::ZERO));
        self.frame_impulse[0] = self.frame_impulse[0] + sum;
        for k in 0..2 {
            self.frame_impulse[k + 1] = self.frame_impulse[k + 1] + friction[k];
        }
        for k in 0..3 {
            self.friction_work = self.friction_work + friction[k] * slip[k] * Single::same(0.5);
        }
    }
}

/// Accumulated impulse that stops a two-dimensional slip, by the effective mass `[xx, yy, xy]`; or,
/// where that exceeds `most`, one of this length against the slip.
///
/// A sliding contact must be braked along its slip. The impulse that stops it points elsewhere if
/// the effective mass depends on the direction: clamped alone, it drove long boxes, thrown at 45
/// degrees to their sides, 14 degrees off their way. A step by the smaller principal mass, clamped,
/// has its fixed point where the two are parallel, and never gives energy.
#[inline(always)]
pub(super) fn within_cone<I: Instructions>(
    impulse: [Single<I>; 2],
    [xx, yy, xy]: [Single<I>; 3],
    [x, y]: [Single<I>; 2],
    most: Single<I>,
) -> [Single<I>; 2] {
    let stopping = [impulse[0] - (xx * x + xy * y), impulse[1] - (yy * y + xy * x)];
    let slides = squared(stopping).above(most * most);
    let (mean, half) = ((xx + yy) * Single::same(0.5), (xx - yy) * Single::same(0.5));
    let smaller = mean - (half * half + xy * xy).sqrt();
    let braked = clamp_to_cone([impulse[0] - smaller * x, impulse[1] - smaller * y], most);
    [slides.select(braked[0], stopping[0]), slides.select(braked[1], stopping[1])]
}

/// Clamps a vector to length `most`.
#[inline(always)]
fn clamp_to_cone<I: Instructions>([x, y]: [Single<I>; 2], most: Single<I>) -> [Single<I>; 2] {
    let squared = squared([x, y]);
    let is_over = squared.above(most * most);
    let scale = is_over.select(most / squared.sqrt(), Single::same(1.0));
    [x * scale, y * scale]
}

/// Squared length.
#[inline(always)]
fn squared<I: Instructions>([x, y]: [Single<I>; 2]) -> Single<I> {
    x * x + y * y
}
