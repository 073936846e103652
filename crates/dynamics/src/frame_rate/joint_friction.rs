//! Friction of a joint impact: Coulomb's where the normal impulse of all of its lanes acts, and
//! twisting.

use super::constraints::MOST_POINTS;
use super::contact_batch::ContactBatch;
use super::effective_mass::inverse_2x2;
use super::friction::within_cone;
use super::joint_lanes::{FIXED, Member, inverses};
use super::solver_bodies::SolverBodies;
use frangible_math::{Instructions, Single};
use glam::DVec3;

/// A lane of a joint impact and its contact; sides as in the lane.
struct Touch<'a, I> {
    member: &'a Member,
    /// Lanes without the member's have zeros.
    sum: Single<I>,
    impulses: [Single<I>; MOST_POINTS],
    /// Largest friction [N s], and largest twist about the normal [N m s].
    most: f64,
    most_twist: f64,
    /// Where the normal impulse acts, from both bodies' centres [m].
    centers: [DVec3; 2],
    tangents: [DVec3; 2],
    /// Of the second body relative to the first: along both tangents [m/s], and spin about the
    /// lane's normal [rad/s], which is the joint impact's spin about its own.
    slip: [f64; 3],
}

/// A number in one lane, and zeros in the others.
fn in_lane<I: Instructions>(lane: usize, value: f64) -> Single<I> {
    let mut lanes = Single::ZERO;
    lanes.set(lane, value);
    lanes
}

impl<'a, I: Instructions> Touch<'a, I> {
    fn new(member: &'a Member, batches: &[ContactBatch<I>], bodies: &mut SolverBodies) -> Self {
        let (batch, lane) = (&batches[member.place.batch()], member.place.lane());
        let sum: f64 = member.impulses.iter().sum();
        let impulses = member.impulses.map(|impulse| in_lane(lane, impulse));
        let lines = &bodies.lines(batch.first_line..bodies.lines.len());
        let at = batch.displacements(lines);
        let centers = batch.impact_centers(&at, (in_lane(lane, sum), &impulses));
        let sides = batch.sides(lines);
        let slip = sides.velocity_at(centers).get(lane);
        let [normal, along, across] = batch.frame_of(lane);
        let spin = normal.dot((sides.of[1].angular - sides.of[0].angular).get(lane));
        let most = batch.friction_coefficient.get(lane);
        Self {
            member,
            sum: in_lane(lane, sum),
            impulses,
            most: most * sum,
            most_twist: most * member.twist_arm + batch.spinning_friction.get(lane) * sum,
            centers: centers.map(|center| center.get(lane)),
            tangents: [along, across],
            slip: [slip.dot(along), slip.dot(across), spin],
        }
    }

    /// Sign of vectors that act on the first body of the impact, if they act on the lane's second.
    fn sign(&self) -> f64 {
        if self.member.side == 1 { 1.0 } else { -1.0 }
    }

    fn vector(&self, [along, across, _]: [f64; 3]) -> DVec3 {
        self.sign() * (along * self.tangents[0] + across * self.tangents[1])
    }
}

/// Applies friction to the bodies of a joint impact along `normal`, and books the impact.
pub(super) fn rub_jointly<I: Instructions>(
    members: &[Member],
    (lines, normal): ([usize; 2], DVec3),
    batches: &mut [ContactBatch<I>],
    bodies: &mut SolverBodies,
) {
    let touches: Vec<Touch<I>> =
        members.iter().map(|member| Touch::new(member, batches, bodies)).collect();
    let sum_of = |touch: &Touch<I>| touch.member.impulses.iter().sum::<f64>();
    let total: f64 = touches.iter().map(sum_of).sum();
    let most: f64 = touches.iter().map(|touch| touch.most).sum();
    let most_twist: f64 = touches.iter().map(|touch| touch.most_twist).sum();
    let (mut slip, mut spin, mut arms) = (DVec3::ZERO, 0.0, [DVec3::ZERO; 2]);
    for touch in touches.iter().filter(|_| total > 0.0) {
        let share = sum_of(touch) / total;
        slip += share * touch.vector(touch.slip);
        spin += share * touch.slip[2];
        let side = touch.member.side;
        arms[0] += share * touch.centers[side];
        arms[1] += share * touch.centers[1 - side];
    }

    let inverses = inverses(lines, bodies);
    let turn: f64 = inverses.iter().map(|(_, inertia)| normal.dot(*inertia * normal)).sum();
    let twist = if turn > 0.0 { (-spin / turn).clamp(-most_twist, most_twist) } else { 0.0 };
    for ((_, inertia), arm) in inverses.iter().zip(arms) {
        slip += twist * (*inertia * normal).cross(arm);
    }

    // Coulomb's law in the common plane; each lane takes its share.
    let along = normal.any_orthonormal_vector();
    let tangents = [along, normal.cross(along)];
    let mut matrix = [0.0; 3];
    for ((mass, inertia), arm) in inverses.into_iter().zip(arms) {
        let moments = tangents.map(|tangent| arm.cross(tangent));
        for (entry, [a, b]) in matrix.iter_mut().zip([[0, 0], [1, 1], [0, 1]]) {
            let of_mass = if a == b { mass } else { 0.0 };
            *entry += of_mass + moments[a].dot(inertia * moments[b]);
        }
    }
    let mass = inverse_2x2::<I>(matrix.map(Single::splat));
    let slip = tangents.map(|tangent| Single::splat(tangent.dot(slip)));
    let friction = within_cone::<I>([Single::ZERO; 2], mass, slip, Single::splat(most));
    let friction = friction[0].get(0) * tangents[0] + friction[1].get(0) * tangents[1];

    let mut applied = DVec3::ZERO;
    for touch in &touches {
        let share = |own: f64, of: f64| if of > 0.0 { own / of } else { 0.0 };
        let sign = share(touch.most, most) * touch.sign();
        let [along, across] = touch.tangents.map(|tangent| sign * friction.dot(tangent));
        let own = [along, across, share(touch.most_twist, most_twist) * twist];
        applied += touch.vector(own);
        touch.book(&mut batches[touch.member.place.batch()], bodies, own);
    }
    for (side, &line) in lines.iter().enumerate().filter(|&(_, &line)| line != FIXED) {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let impulse = sign * applied;
        let moment = arms[side].cross(impulse) + sign * twist * normal;
        bodies.lines[line].push(impulse, moment, &bodies.inverse_inertias[line]);
    }
}

impl<I: Instructions> Touch<'_, I> {
    /// Books the impact of the lane with its friction along both tangents [N s] and about the normal
    /// [N m s].
    fn book(&self, batch: &mut ContactBatch<I>, bodies: &mut SolverBodies, friction: [f64; 3]) {
        let lane = self.member.place.lane();
        let friction = friction.map(|friction| in_lane(lane, friction));
        batch.book_impact(self.sum, friction, self.slip.map(|slip| in_lane(lane, slip)));
        if batch.has_driven() {
            let lines = &bodies.lines(batch.first_line..bodies.lines.len());
            let [along, across, twist] = friction;
            batch.note_driven_work(lines, self.impulses, [along, across], twist);
        }
    }
}
