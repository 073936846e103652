//! Solver bodies of a batch: eight lines gathered into lanes, and stored again.

use super::solver_bodies::{SPINS, SolverBody};
use frangible_math::{Instructions, LANES, Mask, Single, Single3, Singles, Symmetric, Three};

/// Velocities of eight bodies.
#[derive(Clone, Copy)]
pub(super) struct LaneVelocities<I> {
    pub(super) linear: Single3<I>,
    pub(super) angular: Single3<I>,
    /// [1/kg]
    pub(super) inverse_mass: Single<I>,
    /// Radius of the bounding ball around the centre of mass [m].
    pub(super) radius: Single<I>,
}

/// Displacements of eight bodies since the frame's start.
#[derive(Clone, Copy)]
pub(super) struct LaneDisplacements<I> {
    pub(super) translation: Single3<I>,
    /// Vector part of the rotation's quaternion.
    pub(super) vector: Single3<I>,
    scalar: Single<I>,
}

#[inline(always)]
fn gather<I: Instructions, T>(
    lines: &[T],
    ids: &[u32; LANES],
    of: impl Fn(&T) -> Singles,
) -> [Single<I>; 8] {
    let mut rows = [Singles::ZERO; LANES];
    for lane in 0..LANES {
        rows[lane] = of(&lines[ids[lane] as usize]);
    }
    Single::transposed(rows)
}

#[inline(always)]
pub(super) fn velocities<I: Instructions>(
    lines: &[SolverBody],
    ids: &[u32; LANES],
) -> LaneVelocities<I> {
    let [x, y, z, a, b, c, inverse_mass, radius] = gather(lines, ids, |body| body.velocity);
    let (linear, angular) = (Three { x, y, z }, Three { x: a, y: b, z: c });
    LaneVelocities { linear, angular, inverse_mass, radius }
}

#[inline(always)]
pub(super) fn displacements<I: Instructions>(
    lines: &[SolverBody],
    ids: &[u32; LANES],
) -> LaneDisplacements<I> {
    let [x, y, z, a, b, c, scalar, _] = gather(lines, ids, |body| body.displacement);
    let (translation, vector) = (Three { x, y, z }, Three { x: a, y: b, z: c });
    LaneDisplacements { translation, vector, scalar }
}

#[inline(always)]
pub(super) fn inverse_inertias<I: Instructions>(
    lines: &[Singles],
    ids: &[u32; LANES],
) -> Symmetric<Single<I>> {
    let [xx, yy, zz, yz, xz, xy, _, _] = gather(lines, ids, |line| *line);
    Symmetric { diagonal: Three { x: xx, y: yy, z: zz }, off: Three { x: yz, y: xz, z: xy } }
}

impl<I: Instructions> LaneVelocities<I> {
    /// Stores the velocities in the lines `ids`.
    #[inline(always)]
    pub(super) fn store(&self, lines: &mut [SolverBody], ids: &[u32; LANES]) {
        let Self { linear: v, angular: w, inverse_mass, radius } = *self;
        let rows = Single::rows([v.x, v.y, v.z, w.x, w.y, w.z, inverse_mass, radius]);
        for lane in 0..LANES {
            lines[ids[lane] as usize].velocity = rows[lane];
        }
    }
}

impl<I: Instructions> LaneDisplacements<I> {
    /// Displacement of an arm's tip by the rotation [m].
    #[inline(always)]
    pub(super) fn turn_of(&self, arm: Single3<I>) -> Single3<I> {
        let across = self.vector.cross(arm);
        let half = across * self.scalar + self.vector.cross(across);
        half + half
    }

    /// Moves the bodies of some lanes back by the displacement of a velocity change over `time`
    /// [s].
    #[inline(always)]
    pub(super) fn retreat(
        &self,
        (lines, ids): (&mut [SolverBody], &[u32; LANES]),
        lanes: Mask,
        (linear, angular): (Single3<I>, Single3<I>),
        time: Single<I>,
    ) {
        let most = Single::same(0.5 * SPINS);
        let d = self.translation - linear * time;
        let q = self.vector - (angular * (time * Single::same(0.5))).shortened_to(most);
        let rows = Single::rows([d.x, d.y, d.z, q.x, q.y, q.z, self.scalar, Single::ZERO]);
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            let Singles(to) = &mut lines[ids[lane] as usize].displacement;
            to[..7].copy_from_slice(&rows[lane].0[..7]);
        }
    }
}
