//! Sequential impulses in substeps, with soft contact and relaxation: one detection, several small steps [Cat24] [Mac19].

use crate::contact_rows::{Patch, Row, Solver, moving_bodies};
use crate::evolve::evolve;
use crate::manifold::Manifold;
use crate::tally::Cause;
use crate::warm_start::{PointImpulse, WarmStart, sample_key};
use crate::{Bodies, Frame, PairContactant, Tally};
use glam::DVec3;

/// Substeps of a frame: with four, stacks of ten drift by centimetres.
pub(crate) const SUBSTEPS: u32 = 8;

/// Natural frequency of soft contact at up to four points [Hz], limited to a quarter of the substeps' rate. More points share its
/// stiffness. At 30 an elevator's stack sinks by more than a millimetre, at 60 stacks sway.
const CONTACT_HERTZ: f64 = 42.0;

/// Damping ratio of soft contact [1]: ten times critical, so that overlaps close without bouncing back [Cat24].
const CONTACT_DAMPING: f64 = 10.0;

/// Fastest closing of an overlap [m/s]: a tenth of a metre in a frame, so that deep overlaps part gently [Cat24].
const PUSH_SPEED: f64 = 3.0;

/// Approach speeds below this bounce no more, in units of what gravity gives in a frame: what rests approaches so fast.
const BOUNCE: f64 = 1.0;

/// Passes to and fro over the points of one pair that meet fast: a cube that lands flat keeps 1e-3 of the turn that one pass gives it.
const TOGETHER_PASSES: u32 = 8;

/// Passes over the points that meet fast in a substep, to stop them and to let them bounce.
const MEETING_PASSES: u32 = 4;

/// The two times in a substep at which contact acts.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// Overlaps begin to close.
    BeforeDrift,
    /// The closing speed is taken out again.
    AfterDrift,
}

/// What the substeps did besides moving the bodies.
pub struct Solved {
    /// What static and kinematic bodies contributed, and where energy went.
    pub tally: Tally,
    /// Impulse and angular impulse about the world's origin that gravity gave.
    pub gravity: (DVec3, DVec3),
}

/// Moves all bodies through one frame: half kick, impulses, drift, half kick, relax, bounce in each substep.
pub fn solve(bodies: &mut Bodies, manifolds: &[Manifold], warm: &mut WarmStart, frame: &Frame) -> Solved {
    let step = Frame { dt: frame.dt / f64::from(SUBSTEPS), ..*frame };
    let mut patches: Vec<Patch> =
        manifolds.iter().map(|manifold| Patch::new(bodies, manifold, warm)).collect();
    let mut solved = Solved { tally: Tally::default(), gravity: (DVec3::ZERO, DVec3::ZERO) };
    for done in 0..SUBSTEPS {
        let rest = Frame { dt: f64::from(SUBSTEPS - done) * step.dt, ..*frame };
        patches.iter_mut().for_each(|patch| patch.refresh(bodies, &rest));
        kick(bodies, &step, &mut solved.gravity);
        meet(bodies, &mut patches, frame, &step);
        contact(bodies, &mut patches, Stage::BeforeDrift, &step, &mut solved.tally);
        drift(bodies, &step);
        rows_of(&mut patches).for_each(|row| row.follow(bodies));
        kick(bodies, &step, &mut solved.gravity);
        contact(bodies, &mut patches, Stage::AfterDrift, &step, &mut solved.tally);
        bounce(bodies, &mut patches, &step, &mut solved.tally);
    }

    // Keep the impulses for the next frame; note who touched, and who owes energy.
    warm.clear();
    for patch in &patches {
        let touched = patch.rows.iter().filter(|row| row.touched);
        warm.extend(touched.map(|row| (sample_key(bodies, patch.pair, row.point.sample), row.impulses)));
        if patch.touched || patch.rows.iter().any(|row| row.touched) {
            solved.tally.link(bodies, patch.pair);
        }
        solved.tally.debts.extend(patch.debt(bodies));
    }
    solved
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

/// All rows, in the order of the pairs.
fn rows_of(patches: &mut [Patch]) -> impl DoubleEndedIterator<Item = &mut Row> {
    patches.iter_mut().flat_map(|patch| &mut patch.rows)
}

/// Rows whose gap closes in this substep: at which speed, and whether they will bounce. What has come apart can meet again; so can what
/// touches and is struck.
fn meet(bodies: &Bodies, patches: &mut [Patch], frame: &Frame, step: &Frame) {
    let moving = moving_bodies(bodies, step, true);
    let threshold = BOUNCE * frame.gravity.length() * frame.dt;
    for row in rows_of(patches) {
        let closing = -row.relative_velocity(&moving).dot(row.point.normal);
        if row.arm.gap > closing.max(threshold) * step.dt {
            row.met_at = None;
        }
        if row.arm.gap > closing * step.dt || (row.met_at.is_some() && closing <= threshold) {
            continue;
        }
        // The speed at the surface: from that before the kick, with gravity along the rest of the gap.
        let falls = |i: usize| if bodies.inertias[i].is_infinite() { DVec3::ZERO } else { frame.gravity };
        let acceleration = -(falls(row.pair.first) - falls(row.pair.second)).dot(row.point.normal);
        let start = closing - 0.5 * step.dt * acceleration;
        let squared = start * start + 2.0 * acceleration * row.arm.gap.max(0.0);
        let speed = if closing > 0.0 { squared.max(0.0).sqrt() } else { 0.0 };
        row.met_at = Some(speed);
        row.bounces = speed > threshold;
    }
}

/// Contact at one stage of a substep: what acted at this stage of the last one, then a pass over all rows to and one fro, so that none
/// always has the last word and stacks do not lean.
fn contact(bodies: &mut Bodies, patches: &mut [Patch], stage: Stage, step: &Frame, tally: &mut Tally) {
    let moving = moving_bodies(bodies, step, stage == Stage::BeforeDrift);
    let before = moving.clone();
    let on = &mut Solver { bodies, moving, tally };
    for row in rows_of(patches) {
        // What no longer meets has nothing to go on from.
        let closing = -row.relative_velocity(&before).dot(row.point.normal);
        if row.arm.gap > closing.max(0.0) * step.dt {
            row.impulses[stage as usize] = Default::default();
        }
        let PointImpulse { normal, tangent, twist } = row.impulses[stage as usize];
        let cause = row.cause();
        row.apply(on, normal * row.point.normal, cause);
        row.apply(on, tangent, Cause::Friction);
        row.twist(on, twist);
    }

    // What has not met yet is stopped before the next drift, where it meets. What meets now has no impulses to start from, and takes
    // more passes, its normals first: a face that lands flat does not slip.
    let beat = Beat { stage, dt: step.dt };
    let acts = |row: &&mut Row| stage == Stage::BeforeDrift || row.met_at.is_some();
    patches.iter_mut().for_each(|patch| act_together(patch, |row| stop_normal(on, row, beat)));
    rows_of(patches).filter(acts).for_each(|row| sweep(on, row, beat));
    rows_of(patches).rev().filter(acts).for_each(|row| sweep(on, row, beat));
    for _ in 1..MEETING_PASSES {
        for patch in patches.iter_mut() {
            act_together(patch, |row| stop_normal(on, row, beat));
            patch.rows.iter_mut().filter(|row| row.bounces).for_each(|row| sweep(on, row, beat));
        }
    }

    // What closes an overlap does work, as a wedge between the two would.
    for row in rows_of(patches).filter(acts) {
        let work = row.impulses[stage as usize].normal * target_speed(row, beat).max(0.0);
        on.tally.causes.add(Cause::Projection, work);
        on.tally.causes.add(row.cause(), -work);
    }
}

/// Lets the points of a patch that meet fast act together: to and fro until what one does to the others has settled. A face that
/// lands flat must not turn by the order of its corners.
fn act_together(patch: &mut Patch, mut act: impl FnMut(&mut Row)) {
    if patch.rows.iter().filter(|row| row.bounces).count() < 2 {
        return;
    }
    for _ in 0..TOGETHER_PASSES {
        patch.rows.iter_mut().filter(|row| row.bounces).for_each(&mut act);
        patch.rows.iter_mut().rev().filter(|row| row.bounces).for_each(&mut act);
    }
}

fn stop_normal(on: &mut Solver, row: &mut Row, beat: Beat) {
    let mut impulse = row.impulses[beat.stage as usize];
    stop_approach(on, row, &mut impulse, beat);
    row.impulses[beat.stage as usize] = impulse;
}

/// One pass of a row: normal, friction, rolling.
fn sweep(on: &mut Solver, row: &mut Row, beat: Beat) {
    let mut impulse = row.impulses[beat.stage as usize];
    stop_approach(on, row, &mut impulse, beat);
    stop_slip(on, row, &mut impulse);
    stop_roll(on, row, &mut impulse);
    row.impulses[beat.stage as usize] = impulse;
}

/// When rows act.
#[derive(Clone, Copy)]
struct Beat {
    stage: Stage,
    /// Of the substep [s].
    dt: f64,
}

/// How a row's normal impulse answers: soft contact is a spring and a damper that no step size makes unstable [Cat24].
struct Softness {
    /// Closing speed of an overlap per depth [1/s].
    rate: f64,
    /// Of what a rigid point would add to its impulse [1].
    mass_scale: f64,
    /// Of the impulse so far, that it takes back [1].
    impulse_scale: f64,
}

impl Softness {
    /// Of a point that has this share of the contact's stiffness.
    fn new(share: f64, dt: f64) -> Self {
        let hertz = share.sqrt() * CONTACT_HERTZ;
        let omega = std::f64::consts::TAU * hertz.min(0.25 / dt);
        let a = 2.0 * CONTACT_DAMPING + dt * omega;
        let b = dt * omega * a;
        Self { rate: omega / a, mass_scale: b / (1.0 + b), impulse_scale: 1.0 / (1.0 + b) }
    }
}

/// Normal: no approach beyond the gap; before the drift an overlap begins to close at the soft rate.
fn stop_approach(on: &mut Solver, row: &mut Row, impulse: &mut PointImpulse, beat: Beat) {
    let soft = Softness::new(row.share, beat.dt);
    let normal = row.point.normal;
    let speed = row.relative_velocity(&on.moving).dot(normal);
    let target = target_speed(row, beat);
    let (mass_scale, impulse_scale) =
        if overlaps_soften(row, beat) { (soft.mass_scale, soft.impulse_scale) } else { (1.0, 0.0) };
    let mass = 1.0 / row.answer_along(&on.moving, normal);
    let change = mass * mass_scale * (target - speed) - impulse_scale * impulse.normal;
    let total = (impulse.normal + change).max(0.0);
    let cause = row.cause();
    row.apply(on, (total - impulse.normal) * normal, cause);
    impulse.normal = total;
}

/// Before the drift, what overlaps is soft.
fn overlaps_soften(row: &Row, beat: Beat) -> bool {
    beat.stage == Stage::BeforeDrift && row.arm.gap <= 0.0
}

/// Speed at which a row's surfaces are to separate [m/s]; negative if they may approach.
fn target_speed(row: &Row, beat: Beat) -> f64 {
    if row.arm.gap > 0.0 {
        -row.arm.gap / beat.dt
    } else if overlaps_soften(row, beat) {
        (-Softness::new(row.share, beat.dt).rate * row.arm.gap).min(PUSH_SPEED)
    } else {
        0.0
    }
}

/// Friction: against the slip, inside Coulomb's cone.
fn stop_slip(on: &mut Solver, row: &mut Row, impulse: &mut PointImpulse) {
    let normal = row.point.normal;
    let velocity = row.relative_velocity(&on.moving);
    let slip = velocity - velocity.dot(normal) * normal;
    let length = slip.length();
    let stop = if length > 0.0 { slip / row.answer_along(&on.moving, slip / length) } else { DVec3::ZERO };
    let held = (impulse.tangent - stop).clamp_length_max(row.surfaces.friction * impulse.normal);
    row.apply(on, held - impulse.tangent, Cause::Friction);
    impulse.tangent = held;
}

/// Rolling and spinning friction: against the relative spin, no more than their lengths times the normal impulse.
fn stop_roll(on: &mut Solver, row: &mut Row, impulse: &mut PointImpulse) {
    let PairContactant { rolling_friction: rolling, spinning_friction: spinning, .. } = row.surfaces;
    if rolling == 0.0 && spinning == 0.0 {
        return;
    }
    let normal = row.point.normal;
    let spin = row.relative_spin(&on.moving);
    let about = spin.dot(normal) * normal;
    let held = |part: DVec3, before: DVec3, most: f64| {
        let length = part.length();
        if length == 0.0 {
            return before.clamp_length_max(most);
        }
        (before - part / row.answer_about(&on.moving, part / length)).clamp_length_max(most)
    };
    let twist_about = impulse.twist.dot(normal) * normal;
    let next = held(about, twist_about, spinning * impulse.normal)
        + held(spin - about, impulse.twist - twist_about, rolling * impulse.normal);
    row.twist(on, next - impulse.twist);
    impulse.twist = next;
}

/// What met fast enough leaves with its share of the speed at which it met; what stopped it is no guide to the next substep.
fn bounce(bodies: &mut Bodies, patches: &mut [Patch], step: &Frame, tally: &mut Tally) {
    if !rows_of(patches).any(|row| row.bounces) {
        return;
    }
    let moving = moving_bodies(bodies, step, false);
    let on = &mut Solver { bodies, moving, tally };
    rows_of(patches).filter(|row| row.bounces).for_each(|row| row.impulses = Default::default());
    for _ in 0..MEETING_PASSES {
        for patch in patches.iter_mut() {
            act_together(patch, |row| bounce_row(on, row));
            for row in patch.rows.iter_mut().filter(|row| row.bounces) {
                bounce_row(on, row);
                let mut impulse = row.impulses[Stage::AfterDrift as usize];
                stop_slip(on, row, &mut impulse);
                row.impulses[Stage::AfterDrift as usize] = impulse;
            }
        }
    }
    for row in rows_of(patches).filter(|row| row.bounces) {
        row.bounces = false;
        row.impulses = Default::default();
    }
}

/// Normal: leaves with its share of the speed at which it met.
fn bounce_row(on: &mut Solver, row: &mut Row) {
    let normal = row.point.normal;
    let wanted = row.surfaces.restitution * row.met_at.unwrap_or(0.0);
    let speed = row.relative_velocity(&on.moving).dot(normal);
    let before = row.impulses[Stage::AfterDrift as usize].normal;
    let total = (before + (wanted - speed) / row.answer_along(&on.moving, normal)).max(0.0);
    row.apply(on, (total - before) * normal, Cause::Collision);
    row.impulses[Stage::AfterDrift as usize].normal = total;
}
