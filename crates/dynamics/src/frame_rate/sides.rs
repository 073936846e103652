//! Velocities and inverse inertias of both sides of a batch during a visit.

use super::effective_mass::inverse_2x2;
use super::lane_bodies::LaneVelocities;
use frangible_math::{Instructions, Single, Single3, Symmetric};

/// Both bodies of eight manifolds during a visit.
pub(super) struct Sides<I> {
    pub(super) of: [LaneVelocities<I>; 2],
    pub(super) inertia: [Symmetric<Single<I>>; 2],
}

impl<I: Instructions> Sides<I> {
    /// Applies an impulse along `normal` with its moments about both centres.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        normal: Single3<I>,
        impulse: Single<I>,
        moments: [Single3<I>; 2],
    ) {
        let [a, b] = &mut self.of;
        a.linear = a.linear - normal * (a.inverse_mass * impulse);
        b.linear = b.linear + normal * (b.inverse_mass * impulse);
        a.angular = a.angular - self.inertia[0] * moments[0];
        b.angular = b.angular + self.inertia[1] * moments[1];
    }

    /// Applies an impulse at arms relative to both centres.
    #[inline(always)]
    pub(super) fn push_at(&mut self, arms: [Single3<I>; 2], impulse: Single3<I>) {
        let [a, b] = &mut self.of;
        a.linear = a.linear - impulse * a.inverse_mass;
        b.linear = b.linear + impulse * b.inverse_mass;
        a.angular = a.angular - self.inertia[0] * arms[0].cross(impulse);
        b.angular = b.angular + self.inertia[1] * arms[1].cross(impulse);
    }

    /// Twice the kinetic energy [J] of an impulse on bodies at rest, from its size and its moments.
    #[inline(always)]
    pub(super) fn work_of(&self, impulse: Single<I>, moments: [Single3<I>; 2]) -> Single<I> {
        let inverse_mass = self.of[0].inverse_mass + self.of[1].inverse_mass;
        impulse * impulse * inverse_mass
            + moments[0].dot(self.inertia[0] * moments[0])
            + moments[1].dot(self.inertia[1] * moments[1])
    }

    /// Inverse of the 2 x 2 matrix along both tangents at arms relative to both centres: xx, yy, xy
    /// [kg].
    #[inline(always)]
    pub(super) fn tangent_mass(
        &self,
        tangents: [Single3<I>; 2],
        arms: [Single3<I>; 2],
    ) -> [Single<I>; 3] {
        let inverse_mass = self.of[0].inverse_mass + self.of[1].inverse_mass;
        let mut along = [inverse_mass, inverse_mass, Single::ZERO];
        for (arm, inertia) in arms.into_iter().zip(&self.inertia) {
            let moments = [arm.cross(tangents[0]), arm.cross(tangents[1])];
            let turns = [*inertia * moments[0], *inertia * moments[1]];
            along[0] = along[0] + turns[0].dot(moments[0]);
            along[1] = along[1] + turns[1].dot(moments[1]);
            along[2] = along[2] + turns[0].dot(moments[1]);
        }
        inverse_2x2(along)
    }

    /// Scales the change of friction along both tangents to at most the change that stops the slip.
    #[inline(always)]
    pub(super) fn rub(
        &self,
        change: [Single<I>; 2],
        slip: [Single<I>; 2],
        tangents: [Single3<I>; 2],
        centers: [Single3<I>; 2],
    ) -> [Single<I>; 2] {
        let impulse = tangents[0] * change[0] + tangents[1] * change[1];
        let moments = [centers[0].cross(impulse), centers[1].cross(impulse)];
        let size = impulse.dot(impulse).sqrt();
        let lost = -(change[0] * slip[0] + change[1] * slip[1]);
        let scale = shortened(self.work_of(size, moments), lost);
        let scale = lost.above(Single::ZERO).select(scale, Single::same(1.0));
        [change[0] * scale, change[1] * scale]
    }

    /// Relative velocity at arms relative to both centres.
    #[inline(always)]
    pub(super) fn velocity_at(&self, arms: [Single3<I>; 2]) -> Single3<I> {
        let [a, b] = &self.of;
        (b.linear + b.angular.cross(arms[1])) - (a.linear + a.angular.cross(arms[0]))
    }
}

/// Scale in [0, 1] that limits the work of an impulse to the expected work.
#[inline(always)]
pub(super) fn shortened<I: Instructions>(work: Single<I>, expected: Single<I>) -> Single<I> {
    // Rounding may turn an expected work of zero negative.
    let expected = expected.max(Single::ZERO);
    work.above(expected).select(expected / work, Single::same(1.0))
}
