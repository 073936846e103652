//! Sequential impulses in substeps, with soft contact and relaxation: one detection, several small steps [Cat24] [Mac19].

use crate::evolve::evolve;
use crate::manifold::{Manifold, ManifoldPoint};
use crate::pair::Pair;
use crate::{Bodies, BodyId, Frame, Motion, Tally};
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// Substeps of a frame.
const SUBSTEPS: u32 = 8;

/// Stiffness of contact: how fast an overlap closes [1/s], limited to a quarter of the substeps' rate.
const CONTACT_HERTZ: f64 = 30.0;

/// Damping of contact: overlaps close without bouncing back.
const CONTACT_DAMPING: f64 = 10.0;

/// Fastest closing of an overlap [m/s].
const PUSH_SPEED: f64 = 3.0;

/// Approach speeds below this bounce no more, in units of what gravity gives in a frame: what rests approaches so fast.
const BOUNCE: f64 = 1.0;

/// Passes over the contacts that bounce.
const BOUNCE_PASSES: u32 = 4;

/// A sample of a pair, over the frames: which bodies, whether it is the first one's, and which.
pub type SampleKey = (BodyId, BodyId, bool, u32);

/// The last substep's impulses of each contact point, before and after its drift.
pub type WarmStart = HashMap<SampleKey, [PointImpulse; 2]>;

/// What acts at one contact point [N s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointImpulse {
    /// Along the normal, not negative.
    pub normal: f64,
    /// Across it, world frame.
    pub tangent: DVec3,
}

/// A contact point while the substeps run.
struct Row {
    point: ManifoldPoint,
    pair: Pair,
    friction: f64,
    restitution: f64,
    /// Of this substep, before and after the drift.
    impulses: [PointImpulse; 2],
    touched: bool,
}

/// The two times in a substep at which contact acts.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// Overlaps begin to close.
    BeforeDrift,
    /// The closing speed is taken out again.
    AfterDrift,
}

/// A body while the substeps run.
#[derive(Clone, Copy)]
struct Moving {
    inverse_mass: f64,
    inverse_tensor: DMat3,
    linear: DVec3,
    angular: DVec3,
}

/// What the substeps did besides moving the bodies.
pub struct Solved {
    /// What static and kinematic bodies contributed.
    pub tally: Tally,
    /// Impulse and angular impulse about the world's origin that gravity gave.
    pub gravity: (DVec3, DVec3),
}

/// Moves all bodies through one frame: half kick, impulses, drift, half kick, relax in each substep.
pub fn solve(bodies: &mut Bodies, manifolds: &[Manifold], warm: &mut WarmStart, frame: &Frame) -> Solved {
    let step = Frame { dt: frame.dt / f64::from(SUBSTEPS), ..*frame };
    let mut rows = rows_of(bodies, manifolds, warm);
    let mut solved = Solved { tally: Tally::default(), gravity: (DVec3::ZERO, DVec3::ZERO) };
    for _ in 0..SUBSTEPS {
        kick(bodies, &step, &mut solved.gravity);
        contact(bodies, &mut rows, Stage::BeforeDrift, &step, &mut solved.tally);
        drift(bodies, &step);
        kick(bodies, &step, &mut solved.gravity);
        contact(bodies, &mut rows, Stage::AfterDrift, &step, &mut solved.tally);
    }
    bounce(bodies, &mut rows, frame, &mut solved.tally);

    // Keep the impulses for the next frame, and note who touched.
    warm.clear();
    for row in rows.iter().filter(|row| row.touched) {
        warm.insert(sample_key(bodies, row.pair, row.point.sample), row.impulses);
        solved.tally.link(bodies, row.pair);
    }
    solved
}

/// What a contact point is known by.
pub fn sample_key(bodies: &Bodies, pair: Pair, sample: (bool, u32)) -> SampleKey {
    (bodies.ids[pair.first], bodies.ids[pair.second], sample.0, sample.1)
}

fn rows_of(bodies: &Bodies, manifolds: &[Manifold], warm: &WarmStart) -> Vec<Row> {
    let mut rows = Vec::new();
    for manifold in manifolds {
        let pair = manifold.pair;
        let contactant = bodies.pair_contactant(pair.first, pair.second);
        for &point in &manifold.points {
            let mut impulses = warm.get(&sample_key(bodies, pair, point.sample)).copied().unwrap_or_default();
            for impulse in &mut impulses {
                impulse.tangent -= impulse.tangent.dot(point.normal) * point.normal;
            }
            let (friction, restitution) = (contactant.friction, contactant.restitution);
            rows.push(Row { point, pair, friction, restitution, impulses, touched: false });
        }
    }
    rows
}

/// Contact at one stage of a substep: what acted at this stage of the last one, then one pass over all rows.
fn contact(bodies: &mut Bodies, rows: &mut [Row], stage: Stage, step: &Frame, tally: &mut Tally) {
    let mut moving = moving_bodies(bodies);
    for row in rows.iter_mut() {
        let PointImpulse { normal, tangent } = row.impulses[stage as usize];
        apply(bodies, &mut moving, row, normal * row.point.normal + tangent, tally);
    }
    sweep(bodies, &mut moving, rows, stage, step, tally);
}

/// What came fast enough leaves with its share of the speed that it had at the surface.
fn bounce(bodies: &mut Bodies, rows: &mut [Row], frame: &Frame, tally: &mut Tally) {
    let threshold = BOUNCE * frame.gravity.length() * frame.dt;
    let mut moving = moving_bodies(bodies);
    for _ in 0..BOUNCE_PASSES {
        for row in rows.iter_mut().filter(|row| row.touched && row.point.approach > threshold) {
            let (levers, _) = levers(bodies, row);
            let normal = row.point.normal;
            let wanted = row.restitution * row.point.approach;
            let speed = relative_velocity(&moving, row.pair, levers).dot(normal);
            if speed < wanted {
                let change = (wanted - speed) / softness(&moving, row.pair, levers, normal);
                apply(bodies, &mut moving, row, change * normal, tally);
            }
        }
    }
}

/// Half a substep of gravity.
fn kick(bodies: &mut Bodies, step: &Frame, gravity: &mut (DVec3, DVec3)) {
    for i in 0..bodies.len() {
        if !bodies.inertias[i].is_infinite() {
            let gain = 0.5 * step.dt * step.gravity;
            bodies.velocities[i].linear += gain;
            gravity.0 += bodies.masses[i] * gain;
            gravity.1 += bodies.poses[i].position.cross(bodies.masses[i] * gain);
        }
    }
}

/// All bodies along their velocities for one substep.
fn drift(bodies: &mut Bodies, step: &Frame) {
    for i in 0..bodies.len() {
        bodies.poses[i] = evolve(bodies, i, &bodies.poses[i], &bodies.velocities[i], step);
    }
}

fn moving_bodies(bodies: &Bodies) -> Vec<Moving> {
    let of = |i: usize| {
        let (inertia, pose, velocity) = (&bodies.inertias[i], &bodies.poses[i], &bodies.velocities[i]);
        let inverse_tensor = inertia.inverse_tensor(pose.orientation);
        let (linear, angular) = match bodies.motions[i] {
            Motion::Static => (DVec3::ZERO, DVec3::ZERO),
            Motion::Kinematic { linear, angular } => (linear, angular),
            Motion::Dynamic => (velocity.linear, inverse_tensor * velocity.angular_momentum),
        };
        Moving { inverse_mass: inertia.inverse_mass, inverse_tensor, linear, angular }
    };
    (0..bodies.len()).map(of).collect()
}

/// Levers from the centres of mass to the middle of a row's anchors, and the gap between the anchors [m].
fn levers(bodies: &Bodies, row: &Row) -> ([DVec3; 2], f64) {
    let [on_first, on_second] = row.point.anchors_world(bodies, row.pair);
    let middle = 0.5 * (on_first + on_second);
    let Pair { first, second } = row.pair;
    let levers = [middle - bodies.poses[first].position, middle - bodies.poses[second].position];
    (levers, (on_first - on_second).dot(row.point.normal))
}

/// Velocity of the first body's material at the levers' end less the second's [m/s].
fn relative_velocity(moving: &[Moving], pair: Pair, levers: [DVec3; 2]) -> DVec3 {
    let at = |body: &Moving, lever: DVec3| body.linear + body.angular.cross(lever);
    at(&moving[pair.first], levers[0]) - at(&moving[pair.second], levers[1])
}

/// Change of the relative velocity along an axis per impulse along it [1/kg].
fn softness(moving: &[Moving], pair: Pair, levers: [DVec3; 2], axis: DVec3) -> f64 {
    let of = |body: &Moving, lever: DVec3| {
        let turn = lever.cross(axis);
        body.inverse_mass + turn.dot(body.inverse_tensor * turn)
    };
    of(&moving[pair.first], levers[0]) + of(&moving[pair.second], levers[1])
}

/// One pass over all rows. Before the drift overlaps are closed softly; after it their closing speed is taken out again.
fn sweep(
    bodies: &mut Bodies,
    moving: &mut [Moving],
    rows: &mut [Row],
    stage: Stage,
    step: &Frame,
    tally: &mut Tally,
) {
    // Soft contact: a spring and a damper that no step size makes unstable [Cat24].
    let omega = std::f64::consts::TAU * CONTACT_HERTZ.min(0.25 / step.dt);
    let a = 2.0 * CONTACT_DAMPING + step.dt * omega;
    let b = step.dt * omega * a;
    let (bias_rate, soft_mass, soft_impulse) = (omega / a, b / (1.0 + b), 1.0 / (1.0 + b));
    for row in rows {
        let (levers, gap) = levers(bodies, row);
        let normal = row.point.normal;
        let PointImpulse { normal: normal_impulse, tangent } = row.impulses[stage as usize];

        // Normal: no approach beyond the gap; an overlap closes at the soft rate.
        let speed = relative_velocity(moving, row.pair, levers).dot(normal);
        let (target, mass_scale, impulse_scale) = match stage {
            _ if gap > 0.0 => (gap / step.dt, 1.0, 0.0),
            Stage::BeforeDrift => ((bias_rate * gap).max(-PUSH_SPEED), soft_mass, soft_impulse),
            Stage::AfterDrift => (0.0, 1.0, 0.0),
        };
        let mass = 1.0 / softness(moving, row.pair, levers, normal);
        let change = -mass * mass_scale * (speed + target) - impulse_scale * normal_impulse;
        let total = (normal_impulse + change).max(0.0);
        row.impulses[stage as usize].normal = total;
        apply(bodies, moving, row, (total - normal_impulse) * normal, tally);

        // Friction: against the slip, inside Coulomb's cone.
        let slip = relative_velocity(moving, row.pair, levers);
        let slip = slip - slip.dot(normal) * normal;
        let length = slip.length();
        if length > 0.0 {
            let wanted = tangent - slip / softness(moving, row.pair, levers, slip / length);
            let most = row.friction * total;
            let held = if wanted.length() > most { wanted * (most / wanted.length()) } else { wanted };
            row.impulses[stage as usize].tangent = held;
            apply(bodies, moving, row, held - tangent, tally);
        }
    }
}

/// Applies an impulse at the middle of a row's anchors, one point for both bodies, and books what the outside gave.
fn apply(bodies: &mut Bodies, moving: &mut [Moving], row: &mut Row, impulse: DVec3, tally: &mut Tally) {
    if impulse == DVec3::ZERO {
        return;
    }
    row.touched = true;
    let [on_first, on_second] = row.point.anchors_world(bodies, row.pair);
    let middle = 0.5 * (on_first + on_second);
    tally.impulses += 1;
    for (i, other, j) in
        [(row.pair.first, row.pair.second, impulse), (row.pair.second, row.pair.first, -impulse)]
    {
        if bodies.inertias[i].is_infinite() {
            continue;
        }
        let moment = (middle - bodies.poses[i].position).cross(j);
        bodies.velocities[i].linear += moving[i].inverse_mass * j;
        bodies.velocities[i].angular_momentum += moment;
        moving[i].linear += moving[i].inverse_mass * j;
        moving[i].angular += moving[i].inverse_tensor * moment;
        if bodies.inertias[other].is_infinite() {
            tally.outside_impulse += j;
            tally.outside_angular_impulse += middle.cross(j);
            if let Motion::Kinematic { linear, angular } = bodies.motions[other] {
                let work = j.dot(linear + angular.cross(middle - bodies.poses[other].position));
                tally.kinematic_work += work;
                *tally.work.entry(bodies.ids[i]).or_insert(0.0) += work;
            }
        }
    }
}
