//! What one row does to its bodies: each kernel acts in the lanes that it is told.

use crate::contact_batch::Hold;
use crate::contact_rows::{Beat, Point, Row, RowImpulse, Stage};
use crate::lanes::{Instructions, Lanes, Lanes3, Mask};
use crate::moving::Side;

/// A visit to some pairs: their bodies, and what has been done to them.
pub(crate) struct Visit<I> {
    pub(crate) sides: [Side<I>; 2],
    /// As they were when it began.
    pub(crate) before: [Side<I>; 2],
    /// Gravity's kick on the first bodies less that on the second ones [m/s].
    pub(crate) kick: Lanes3<I>,
    /// Sum of the impulses on the first bodies [N s].
    pub(crate) impulse: Lanes3<I>,
    /// Energy given by normal impulses, where they stop what meets fast and elsewhere [J].
    pub(crate) by_collision: Lanes<I>,
    pub(crate) by_contact: Lanes<I>,
    /// Of which closing overlaps did as a wedge would [J].
    pub(crate) projected: Lanes<I>,
    /// Work of kinematic bodies [J].
    pub(crate) work: Lanes<I>,
    /// Whether any impulse acted.
    pub(crate) acted: bool,
}

impl<I: Instructions> Visit<I> {
    #[inline(always)]
    pub(crate) fn new(sides: [Side<I>; 2], beat: &Beat) -> Self {
        Self {
            sides,
            before: sides,
            kick: Lanes3::splat(beat.kick) * (sides[0].falls - sides[1].falls),
            impulse: Lanes3::ZERO,
            by_collision: Lanes::ZERO,
            by_contact: Lanes::ZERO,
            projected: Lanes::ZERO,
            work: Lanes::ZERO,
            acted: false,
        }
    }

    /// An impulse at a point, on the first bodies; its opposite on the second ones.
    #[inline(always)]
    pub(crate) fn push(&mut self, point: &Point<I>, impulse: Lanes3<I>) {
        self.sides[0].push(point.levers[0], impulse);
        self.sides[1].push(point.levers[1], -impulse);
        self.impulse = self.impulse + impulse;
        if let Some(drive) = point.drive {
            self.work = self.work - impulse.dot(drive);
        }
        self.acted = true;
    }

    /// An angular impulse on the first bodies, and its opposite on the second ones; `driven` is what kinematic bodies add to their
    /// relative spin [rad/s].
    #[inline(always)]
    pub(crate) fn turn(&mut self, driven: Lanes3<I>, angular_impulse: Lanes3<I>) {
        self.sides[0].turn(angular_impulse);
        self.sides[1].turn(-angular_impulse);
        self.work = self.work - angular_impulse.dot(driven);
        self.acted = true;
    }

    /// Notes what normal impulses gave at a mean speed along them.
    #[inline(always)]
    pub(crate) fn note_normal(
        &mut self,
        impulse: Lanes<I>,
        speed: Lanes<I>,
        (point, bounces): (&Point<I>, Mask),
    ) {
        let energy = impulse * (speed - self.kick.dot(point.basis.normal));
        self.by_collision = self.by_collision + bounces.select(energy, Lanes::ZERO);
        self.by_contact = self.by_contact + bounces.select(Lanes::ZERO, energy);
    }

    /// Energy given to the bodies in all, without gravity's and a kinematic body's work [J].
    #[inline(always)]
    pub(crate) fn given(&self) -> Lanes<I> {
        let [first, second] = &self.sides;
        let [first_before, second_before] = &self.before;
        let linear =
            (first.linear + first_before.linear - second.linear - second_before.linear).dot(self.impulse);
        let turn = |after: &Side<I>, before: &Side<I>| {
            (after.angular + before.angular).dot(after.angular_momentum - before.angular_momentum)
        };
        let turned = turn(first, first_before) + turn(second, second_before);
        (linear + turned) * Lanes::splat(0.5) - self.kick.dot(self.impulse) - self.work
    }
}

/// Normal and friction. Normal: no approach beyond the gap; before the drift an overlap begins to close at the soft rate; what bounces
/// leaves at `leaving` [m/s]. Friction, if it `rubs`: against the slip that is left, inside Coulomb's cone; what it cannot hold slides
/// against it.
#[inline(always)]
pub(crate) fn stop<I: Instructions>(
    row: &mut Row<I>,
    point: &Point<I>,
    (hold, leaving): (&Hold<I>, Lanes<I>),
    visit: &mut Visit<I>,
    (beat, acts, rubs): (&Beat, Mask, bool),
) {
    let at = beat.stage.at();
    let before = row.impulses[at].normal.lanes();
    let velocity = point.relative_velocity(&visit.sides);

    // Along the normal.
    let speed = velocity.dot(point.basis.normal);
    let (target, softens) = row.target_speed(hold.soft.rate, beat);
    let target = if beat.stage == Stage::Bounce { leaving } else { target };
    let mass_scale = softens.select(hold.soft.mass_scale, hold.relaxation);
    let impulse_scale = softens.select(hold.soft.impulse_scale, Lanes::ZERO);
    let change = row.response.mass.lanes() * mass_scale * (target - speed) - impulse_scale * before;
    let total = acts.select((before + change).max(Lanes::ZERO), before);
    let change = total - before;

    // Across it.
    let tangent = row.impulses[at].tangent;
    let tangent = [tangent[0].lanes(), tangent[1].lanes()];
    let mut held = tangent;
    let to_normal = row.response.to_normal.lanes();
    // What carries nothing, and has carried nothing, does not rub.
    let carries =
        total.differs_from_zero().or(tangent[0].differs_from_zero()).or(tangent[1].differs_from_zero());
    if rubs && carries.any() {
        let slip = [
            velocity.dot(point.basis.tangents[0]) + to_normal.y * change,
            velocity.dot(point.basis.tangents[1]) + to_normal.z * change,
        ];
        let rubbed = hold_slip(row, slip, tangent, hold.friction * total);
        held = [acts.select(rubbed[0], tangent[0]), acts.select(rubbed[1], tangent[1])];
    }
    let rub = [held[0] - tangent[0], held[1] - tangent[1]];
    if !change.differs_from_zero().or(rub[0].differs_from_zero()).or(rub[1].differs_from_zero()).any() {
        return;
    }
    visit.push(point, point.impulse(change, rub));
    visit.note_normal(change, speed + Lanes::splat(0.5) * to_normal.x * change, (point, row.meets(beat)));
    row.impulses[at] = RowImpulse { normal: total.kept(), tangent: [held[0].kept(), held[1].kept()] };
}

/// The tangent impulses that would end a slip [m/s], if none is longer than `most`; else those that go against it [Cat24].
#[inline(always)]
fn hold_slip<I: Instructions>(
    row: &Row<I>,
    slip: [Lanes<I>; 2],
    tangent: [Lanes<I>; 2],
    most: Lanes<I>,
) -> [Lanes<I>; 2] {
    let Lanes3 { x, y, z } = row.response.slip_mass.lanes();
    let stick = [tangent[0] - (x * slip[0] + z * slip[1]), tangent[1] - (z * slip[0] + y * slip[1])];
    let slides = (stick[0] * stick[0] + stick[1] * stick[1]).above(most * most);
    if !slides.any() {
        return stick;
    }
    let mass = row.response.least_slip_mass.lanes();
    let against = [tangent[0] - mass * slip[0], tangent[1] - mass * slip[1]];
    let squared = against[0] * against[0] + against[1] * against[1];
    let scale = squared.above(most * most).select(most / squared.sqrt(), Lanes::splat(1.0));
    [slides.select(against[0] * scale, stick[0]), slides.select(against[1] * scale, stick[1])]
}

/// Rolling and spinning friction: against the relative spin, no more than their lengths times the normal impulse `load`. Returns the
/// angular impulse that acts then, instead of `twist`.
#[inline(always)]
pub(crate) fn stop_roll<I: Instructions>(
    visit: &mut Visit<I>,
    normal: Lanes3<I>,
    ([rolling, spinning], driven): (&[Lanes<I>; 2], Lanes3<I>),
    (load, twist, acts): (Lanes<I>, Lanes3<I>, Mask),
) -> Lanes3<I> {
    let sides = &visit.sides;
    let spin = sides[0].angular - sides[1].angular + driven;
    let about = normal * spin.dot(normal);
    let twist_about = normal * twist.dot(normal);
    let next = held(sides, about, twist_about, *spinning * load)
        + held(sides, spin - about, twist - twist_about, *rolling * load);
    let next = acts.select3(next, twist);
    visit.turn(driven, next - twist);
    next
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
