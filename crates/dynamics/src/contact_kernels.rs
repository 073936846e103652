//! What one row does to its bodies: each kernel acts in the lanes that it is told, and returns the energy that they gave.

use crate::contact_batch::Softness;
use crate::contact_rows::{Beat, Row, RowImpulse, Stage};
use crate::lanes::{Instructions, Lanes, Lanes3, Mask};
use crate::moving::Side;

/// Normal: no approach beyond the gap; before the drift an overlap begins to close at the soft rate; what bounces leaves with its share
/// of the speed at which it met. Returns the energy given [J].
#[inline(always)]
pub(crate) fn stop_approach<I: Instructions>(
    row: &mut Row<I>,
    sides: &mut [Side<I>; 2],
    soft: &Softness<I>,
    restitution: Lanes<I>,
    (beat, acts): (&Beat, Mask),
) -> Lanes<I> {
    let softens = row.softens(beat);
    let mass_scale = softens.select(soft.mass_scale, Lanes::splat(1.0));
    let impulse_scale = softens.select(soft.impulse_scale, Lanes::ZERO);
    let target = if beat.stage == Stage::Bounce {
        restitution * row.has_met.select(row.met_at, Lanes::ZERO)
    } else {
        row.target_speed(soft.rate, beat)
    };
    let speed = row.relative_velocity(sides).dot(row.normal);
    let before = row.impulses[beat.stage.at()].normal;
    let change = row.mass * mass_scale * (target - speed) - impulse_scale * before;
    let total = acts.select((before + change).max(Lanes::ZERO), before);
    let change = total - before;
    if !change.differs_from_zero().any() {
        return Lanes::ZERO;
    }
    row.push(sides, row.normal * change);
    row.impulses[beat.stage.at()].normal = total;
    let kick = kick_of(sides, beat).dot(row.normal);
    change * (speed + Lanes::splat(0.5) * row.answer * change - kick)
}

/// Friction: against the slip, inside Coulomb's cone. Returns the energy given [J].
#[inline(always)]
pub(crate) fn stop_slip<I: Instructions>(
    row: &mut Row<I>,
    sides: &mut [Side<I>; 2],
    friction: Lanes<I>,
    (beat, acts): (&Beat, Mask),
) -> Lanes<I> {
    // What carries nothing, and has carried nothing, does not rub.
    let RowImpulse { normal, tangent, .. } = row.impulses[beat.stage.at()];
    if !normal.differs_from_zero().or(tangent.dot(tangent).above(Lanes::ZERO)).any() {
        return Lanes::ZERO;
    }
    let velocity = row.relative_velocity(sides);
    let slip = velocity - row.normal * velocity.dot(row.normal);
    let answer = sides[0].answer(row.levers[0], slip) + sides[1].answer(row.levers[1], slip);
    let slips = answer.above(Lanes::ZERO);
    let stop = slip * slips.select(slip.dot(slip) / answer, Lanes::ZERO);
    let held = acts.select3((tangent - stop).shortened_to(friction * normal), tangent);
    let change = held - tangent;
    let kick = kick_of(sides, beat);
    row.push(sides, change);
    row.impulses[beat.stage.at()].tangent = held;
    let mean = (velocity + row.relative_velocity(sides)) * Lanes::splat(0.5) - kick;
    change.dot(mean)
}

/// Rolling and spinning friction: against the relative spin, no more than their lengths times the normal impulse. Returns the energy
/// given [J].
#[inline(always)]
pub(crate) fn stop_roll<I: Instructions>(
    row: &mut Row<I>,
    sides: &mut [Side<I>; 2],
    ([rolling, spinning], driven): (&[Lanes<I>; 2], Lanes3<I>),
    (beat, acts): (&Beat, Mask),
) -> Lanes<I> {
    let normal = row.normal;
    let spin = sides[0].angular - sides[1].angular + driven;
    let about = normal * spin.dot(normal);
    let RowImpulse { normal: load, twist, .. } = row.impulses[beat.stage.at()];
    let twist_about = normal * twist.dot(normal);
    let next = held(sides, about, twist_about, *spinning * load)
        + held(sides, spin - about, twist - twist_about, *rolling * load);
    let next = acts.select3(next, twist);
    row.impulses[beat.stage.at()].twist = next;
    turn(sides, driven, next - twist)
}

/// The angular impulse that takes a part of the relative spin out, no longer than `most` in all.
#[inline(always)]
fn held<I: Instructions>(
    sides: &[Side<I>; 2],
    spin: Lanes3<I>,
    before: Lanes3<I>,
    most: Lanes<I>,
) -> Lanes3<I> {
    let answer = spin.dot(sides[0].inverse_tensor * spin + sides[1].inverse_tensor * spin);
    let turns = answer.above(Lanes::ZERO);
    let stop = spin * turns.select(spin.dot(spin) / answer, Lanes::ZERO);
    (before - stop).shortened_to(most)
}

/// An angular impulse on the first bodies, and its opposite on the second ones; `driven` is what kinematic bodies add to their relative
/// spin [rad/s]. Returns the energy given [J].
#[inline(always)]
pub(crate) fn turn<I: Instructions>(
    sides: &mut [Side<I>; 2],
    driven: Lanes3<I>,
    angular_impulse: Lanes3<I>,
) -> Lanes<I> {
    let before = sides[0].angular - sides[1].angular;
    sides[0].turn(angular_impulse);
    sides[1].turn(-angular_impulse);
    let after = sides[0].angular - sides[1].angular;
    angular_impulse.dot((before + after) * Lanes::splat(0.5) + driven)
}

/// Gravity's kick on the first bodies less that on the second ones [m/s].
#[inline(always)]
pub(crate) fn kick_of<I: Instructions>(sides: &[Side<I>; 2], beat: &Beat) -> Lanes3<I> {
    Lanes3::splat(beat.kick) * (sides[0].falls - sides[1].falls)
}
