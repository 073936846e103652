//! Pair impulses: from a contact point to new velocities.

use crate::frame_rate::constraints::SAME_NORMAL;
use crate::impulse::collision_impulse::{
    Impulse, apply_impulse, collision_impulse, contact_matrix,
};
use crate::impulse::energy_clamp::{Clamp, ClampSide, Clamps, clamp_impulse, energy_given};
use crate::impulse::pair_turn::turn_pair;
use frangible_bodies::{Bodies, Inertia, Pair, PairSurface, Pose, Velocity};
use frangible_collision::{ContactPoint, Penetration, contact_point, placed};
use glam::{DMat3, DVec3};

/// Two bodies approaching at a point.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// Point and normal.
    pub contact: ContactPoint,
    /// From the centres of mass to the point [m].
    pub levers: [DVec3; 2],
    /// Velocity of the first body's point less that of the second's [m/s].
    pub relative_velocity: DVec3,
}

/// Depths that differ by less than this part of the smaller body's radius are those of one flat face
/// [1]: samples are in single precision.
const SAME_DEPTH: f64 = 1e-5;

/// Deepest of the penetrations with an approaching contact: point, normal and velocities at `poses`
/// and `velocities`. Samples that are equally deep along one normal act in their middle: what falls
/// flat stays flat. Consumes the penetrations.
pub(crate) fn deepest_approach(
    bodies: &Bodies,
    pair: Pair,
    penetrations: &mut Vec<Penetration>,
    poses: &[Pose],
    velocities: &[Velocity],
) -> Option<Approach> {
    let (first, second) = placed(bodies, pair, poses);
    let [a, b] = pair.both().map(|i| bodies.radii[i]);
    let same_depth = (SAME_DEPTH * a.min(b)) as f32;
    // The deepest penetration nearly always approaches: repeated minimum search is cheaper than
    // sorting.
    while let Some(deepest) =
        (0..penetrations.len()).min_by(|&a, &b| by_depth(&penetrations[a], &penetrations[b]))
    {
        let deepest = penetrations.swap_remove(deepest);
        let mut contact = contact_point(first, second, &deepest);
        let (mut sum, mut count) = (contact.point, 1.0);
        for other in penetrations.iter().filter(|other| other.phi <= deepest.phi + same_depth) {
            let ContactPoint { point, normal } = contact_point(first, second, other);
            if normal.dot(contact.normal) > SAME_NORMAL {
                (sum, count) = (sum + point, count + 1.0);
            }
        }
        contact.point = sum / count;
        let approach = approach_at(bodies, pair, contact, poses, velocities);
        if approach.relative_velocity.dot(contact.normal) < 0.0 {
            return Some(approach);
        }
    }
    None
}

/// Order by depth, deepest first; ties in sample order, for a unique order.
fn by_depth(a: &Penetration, b: &Penetration) -> std::cmp::Ordering {
    let tie = || (a.sample_of_first, a.sample).cmp(&(b.sample_of_first, b.sample));
    a.phi.total_cmp(&b.phi).then_with(tie)
}

/// Levers and relative velocity at a contact point.
pub(crate) fn approach_at(
    bodies: &Bodies,
    pair: Pair,
    contact: ContactPoint,
    poses: &[Pose],
    velocities: &[Velocity],
) -> Approach {
    let levers = [pair.first, pair.second].map(|i| contact.point - poses[i].position);
    let [first, second] = [(pair.first, levers[0]), (pair.second, levers[1])]
        .map(|(i, lever)| bodies.point_velocity(i, &poses[i], &velocities[i], lever));
    Approach { contact, levers, relative_velocity: first - second }
}

/// Impulse on the first body that stops the approach with the pair's restitution, inside Coulomb's
/// cone. `inertias` may freeze movable bodies.
pub(crate) fn impulse_for(
    pair: Pair,
    approach: &Approach,
    poses: &[Pose],
    inertias: &[Inertia],
    surfaces: PairSurface,
) -> PairImpulse {
    let k = pair_contact_matrix(pair, approach.levers, poses, inertias);
    let (relative, normal) = (approach.relative_velocity, approach.contact.normal);
    PairImpulse::new(approach, collision_impulse(k, relative, normal, surfaces))
}

/// Change of the relative velocity per impulse at the contact [1/kg].
pub(crate) fn pair_contact_matrix(
    pair: Pair,
    levers: [DVec3; 2],
    poses: &[Pose],
    inertias: &[Inertia],
) -> DMat3 {
    let of = |i: usize, lever: DVec3| {
        contact_matrix(
            inertias[i].inverse_mass,
            inertias[i].inverse_tensor(poses[i].orientation),
            lever,
        )
    };
    of(pair.first, levers[0]) + of(pair.second, levers[1])
}

/// Impulses on both bodies of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairImpulse {
    /// Impulse at the contact point on the first body, its opposite on the second [N s].
    pub at_contact: DVec3,
    /// Total impulse on each body; the linear parts are opposite.
    pub on: [Impulse; 2],
}

impl PairImpulse {
    /// From a single impulse at the contact.
    pub fn new(approach: &Approach, at_contact: DVec3) -> Self {
        let [first, second] = approach.levers;
        Self { at_contact, on: [Impulse::at(first, at_contact), Impulse::at(second, -at_contact)] }
    }

    /// Scales all parts.
    pub fn scaled(&self, scale: f64) -> Self {
        Self {
            at_contact: scale * self.at_contact,
            on: self.on.map(|impulse| impulse.scaled(scale)),
        }
    }

    /// True for a zero impulse.
    pub(crate) fn is_zero(&self) -> bool {
        self.at_contact == DVec3::ZERO
    }

    /// Adds the rigid rotation of the pair that restores angular momentum at the poses of `bodies`,
    /// after levers of another time level changed it. Applies to pairs of dynamic bodies.
    pub(crate) fn keeping_angular_momentum(mut self, bodies: &Bodies, pair: Pair) -> Self {
        let [first, second] = [pair.first, pair.second];
        if bodies.inertias[first].is_infinite() || bodies.inertias[second].is_infinite() {
            return self;
        }
        let apart = bodies.poses[first].position - bodies.poses[second].position;
        let gain = self.on[0].angular + self.on[1].angular + apart.cross(self.on[0].linear);
        for (sum, turn) in self.on.iter_mut().zip(turn_pair(bodies, pair, -gain)) {
            sum.linear += turn.linear;
            sum.angular += turn.angular;
        }
        self
    }

    /// Applies the impulse to movable bodies.
    pub fn apply(&self, pair: Pair, inertias: &[Inertia], velocities: &mut [Velocity]) {
        for (i, impulse) in [pair.first, pair.second].into_iter().zip(&self.on) {
            velocities[i] = apply_impulse(&velocities[i], inertias[i].inverse_mass, impulse);
        }
    }

    /// Largest fraction without a gain of the pair's kinetic energy in the non-split state at the
    /// poses of `bodies` and `velocities` [Su09 sec. 3.2].
    pub(crate) fn clamped_to_energy(
        &self,
        bodies: &Bodies,
        pair: Pair,
        approach: &Approach,
        velocities: &[Velocity],
        clamps: &mut Clamps,
    ) -> Self {
        let [first, second] = self.clamp_sides(bodies, pair, approach, velocities);
        let clamp = clamp_impulse(&first, &second);
        clamps.shortened += u64::from(matches!(clamp, Clamp::Scaled(_)));
        clamps.dropped += u64::from(clamp == Clamp::Blocked);
        if clamp != Clamp::Whole {
            clamps.withheld += energy_given(&first, &second).max(0.0);
        }
        self.scaled(clamp.scale())
    }

    /// Change of the pair's kinetic energy at the poses of `bodies` and `velocities`, without the
    /// work of a kinematic body [J].
    pub(crate) fn energy_given(
        &self,
        bodies: &Bodies,
        pair: Pair,
        approach: &Approach,
        velocities: &[Velocity],
    ) -> f64 {
        let [first, second] = self.clamp_sides(bodies, pair, approach, velocities);
        energy_given(&first, &second)
    }

    /// Energy change by friction: tangential impulse times the mean of the slip before and after
    /// [J].
    pub(crate) fn energy_of_friction(
        &self,
        bodies: &Bodies,
        pair: Pair,
        approach: &Approach,
        velocities: &[Velocity],
    ) -> f64 {
        let normal = approach.contact.normal;
        let tangential = self.at_contact - self.at_contact.dot(normal) * normal;
        let point_velocity = |side: usize, velocity: &Velocity| {
            let i = [pair.first, pair.second][side];
            bodies.point_velocity(i, &bodies.poses[i], velocity, approach.levers[side])
        };
        let twice_mean = |side: usize| {
            let i = [pair.first, pair.second][side];
            let after =
                apply_impulse(&velocities[i], bodies.inertias[i].inverse_mass, &self.on[side]);
            point_velocity(side, &velocities[i]) + point_velocity(side, &after)
        };
        0.5 * tangential.dot(twice_mean(0) - twice_mean(1))
    }

    fn clamp_sides(
        &self,
        bodies: &Bodies,
        pair: Pair,
        approach: &Approach,
        velocities: &[Velocity],
    ) -> [ClampSide; 2] {
        let side = |i: usize, impulse: Impulse| {
            let (inertia, pose) = (&bodies.inertias[i], &bodies.poses[i]);
            if inertia.is_infinite() {
                let lever = approach.contact.point - pose.position;
                ClampSide::Prescribed {
                    point_velocity: bodies.point_velocity(i, pose, &velocities[i], lever),
                }
            } else {
                let (orientation, velocity) = (pose.orientation, velocities[i]);
                ClampSide::Dynamic { inertia: *inertia, orientation, velocity, impulse }
            }
        };
        [side(pair.first, self.on[0]), side(pair.second, self.on[1])]
    }
}
