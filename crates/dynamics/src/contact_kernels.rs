//! What one row does to its bodies: each kernel acts in the lanes that it is told.

use crate::contact_batch::Hold;
use crate::contact_rows::{Beat, Point, Row, RowImpulse, Stage};
use crate::lanes::{Instructions, Mask, Single, Single3};
use crate::moving::{Side, Sides};

/// A visit to some pairs: their bodies, and what has been done to them.
pub(crate) struct Visit<I> {
    /// As they were when it began.
    pub(crate) before: [Side<I>; 2],
    /// As rows see them now.
    pub(crate) now: Sides<I>,
    /// Gravity's kick on the first bodies less that on the second ones [m/s].
    kick: Single3<I>,
    /// Sum of the impulses on the first bodies [N s], and of the angular impulses about their centres of mass, and against those of the second ones [N m s].
    impulse: Single3<I>,
    moments: [Single3<I>; 2],
    /// Energy given by normal impulses, where they stop what meets fast and elsewhere [J].
    pub(crate) by_collision: Single<I>,
    pub(crate) by_contact: Single<I>,
    /// Of which closing overlaps did as a wedge would [J].
    pub(crate) projected: Single<I>,
    /// Work of kinematic bodies [J].
    pub(crate) work: Single<I>,
    /// Whether any impulse acted.
    pub(crate) has_acted: bool,
}

impl<I: Instructions> Visit<I> {
    #[inline(always)]
    pub(crate) fn new(before: [Side<I>; 2], beat: &Beat) -> Self {
        Self {
            now: Sides::of(&before),
            kick: Single3::splat(beat.kick) * (before[0].falls - before[1].falls),
            before,
            impulse: Single3::ZERO,
            moments: [Single3::ZERO; 2],
            by_collision: Single::ZERO,
            by_contact: Single::ZERO,
            projected: Single::ZERO,
            work: Single::ZERO,
            has_acted: false,
        }
    }

    /// An impulse at a point, on the first bodies; its opposite on the second ones.
    #[inline(always)]
    pub(crate) fn push(&mut self, point: &Point<I>, impulse: Single3<I>) {
        let moments = [point.levers[0].cross(impulse), point.levers[1].cross(impulse)];
        self.now.push(moments, impulse);
        self.impulse = self.impulse + impulse;
        self.moments = [self.moments[0] + moments[0], self.moments[1] + moments[1]];
        if let Some(drive) = point.drive {
            self.work = self.work - impulse.dot(drive);
        }
        self.has_acted = true;
    }

    /// An angular impulse on the first bodies, and its opposite on the second ones; `driven` is what kinematic bodies add to their
    /// relative spin [rad/s].
    #[inline(always)]
    pub(crate) fn turn(&mut self, driven: Single3<I>, angular_impulse: Single3<I>) {
        self.now.turn([angular_impulse; 2]);
        self.moments = [self.moments[0] + angular_impulse, self.moments[1] + angular_impulse];
        self.work = self.work - angular_impulse.dot(driven);
        self.has_acted = true;
    }

    /// Notes what normal impulses gave at a mean speed along them.
    #[inline(always)]
    pub(crate) fn note_normal(
        &mut self,
        impulse: Single<I>,
        speed: Single<I>,
        (point, bounces): (&Point<I>, Mask),
    ) {
        let energy = impulse * (speed - self.kick.dot(point.basis.normal));
        self.by_collision = self.by_collision + bounces.select(energy, Single::ZERO);
        self.by_contact = self.by_contact + bounces.select(Single::ZERO, energy);
    }

    /// The bodies at its end, as they are seen.
    #[inline(always)]
    pub(crate) fn after(&self) -> [Side<I>; 2] {
        let [first, second] = &self.before;
        let [spin, other_spin] = self.now.rates.spins;
        [
            Side { linear: first.linear + self.impulse * first.inverse_mass, angular: spin, ..*first },
            Side {
                linear: second.linear - self.impulse * second.inverse_mass,
                angular: other_spin,
                ..*second
            },
        ]
    }

    /// What acted: see [`Batch::pending`](crate::contact_batch::Batch::pending).
    #[inline(always)]
    pub(crate) fn acted(&self) -> [Single3<I>; 3] {
        [self.impulse, self.moments[0], self.moments[1]]
    }

    /// Energy given to the bodies in all, without gravity's and a kinematic body's work [J].
    #[inline(always)]
    pub(crate) fn given(&self) -> Single<I> {
        let [first, second] = &self.before;
        let [spin, other_spin] = self.now.rates.spins;
        let [moment, opposite] = self.moments;
        let linear = (self.now.rates.apart + (first.linear - second.linear)).dot(self.impulse);
        let turned = (first.angular + spin).dot(moment) - (second.angular + other_spin).dot(opposite);
        (linear + turned) * Single::splat(0.5) - self.kick.dot(self.impulse) - self.work
    }
}

/// Normal and friction. Normal: no approach beyond the gap; before the drift an overlap begins to close at the soft rate; what bounces
/// leaves at `leaving` [m/s]. Friction, if it `rubs`: against the slip that is left, inside Coulomb's cone; what it cannot hold slides
/// against it.
#[inline(always)]
pub(crate) fn stop<I: Instructions>(
    row: &mut Row<I>,
    point: &Point<I>,
    (hold, leaving): (&Hold<I>, Single<I>),
    visit: &mut Visit<I>,
    (beat, acts, rubs): (&Beat, Mask, bool),
) {
    let at = beat.stage.at();
    let before = row.impulses[at].normal;
    let velocity = point.relative_velocity(&visit.now.rates);

    // Along the normal.
    let speed = velocity.dot(point.basis.normal);
    let (target, softens) = row.target_speed(hold.soft.rate, beat);
    let target = if beat.stage == Stage::Bounce { leaving } else { target };
    let mass_scale = softens.select(hold.soft.mass_scale, hold.relaxation);
    let impulse_scale = softens.select(hold.soft.impulse_scale, Single::ZERO);
    let change = row.response.mass * mass_scale * (target - speed) - impulse_scale * before;
    let total = acts.select((before + change).max(Single::ZERO), before);
    let change = total - before;

    // Across it.
    let tangent = row.impulses[at].tangent;
    let mut held = tangent;
    let to_normal = row.response.to_normal;
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
    visit.note_normal(change, speed + Single::splat(0.5) * to_normal.x * change, (point, row.meets(beat)));
    row.impulses[at] = RowImpulse { normal: total, tangent: held };
}

/// The tangent impulses that would end a slip [m/s], if none is longer than `most`; else those that go against it [Cat24].
#[inline(always)]
fn hold_slip<I: Instructions>(
    row: &Row<I>,
    slip: [Single<I>; 2],
    tangent: [Single<I>; 2],
    most: Single<I>,
) -> [Single<I>; 2] {
    let Single3 { x, y, z } = row.response.slip_mass;
    let stick = [tangent[0] - (x * slip[0] + z * slip[1]), tangent[1] - (z * slip[0] + y * slip[1])];
    let slides = (stick[0] * stick[0] + stick[1] * stick[1]).above(most * most);
    if !slides.any() {
        return stick;
    }
    let mass = row.response.least_slip_mass;
    let against = [tangent[0] - mass * slip[0], tangent[1] - mass * slip[1]];
    let squared = against[0] * against[0] + against[1] * against[1];
    let scale = squared.above(most * most).select(most / squared.sqrt(), Single::splat(1.0));
    [slides.select(against[0] * scale, stick[0]), slides.select(against[1] * scale, stick[1])]
}

/// Rolling and spinning friction: against the relative spin, no more than their lengths times the normal impulse `load`. Returns the
/// angular impulse that acts then, instead of `twist`.
#[inline(always)]
pub(crate) fn stop_roll<I: Instructions>(
    visit: &mut Visit<I>,
    normal: Single3<I>,
    ([rolling, spinning], driven): (&[Single<I>; 2], Single3<I>),
    (load, twist, acts): (Single<I>, Single3<I>, Mask),
) -> Single3<I> {
    let sides = &visit.now;
    let spin = sides.rates.spins[0] - sides.rates.spins[1] + driven;
    let about = normal * spin.dot(normal);
    let twist_about = normal * twist.dot(normal);
    let next = held(sides, about, twist_about, *spinning * load)
        + held(sides, spin - about, twist - twist_about, *rolling * load);
    let next = acts.select(next, twist);
    visit.turn(driven, next - twist);
    next
}

/// The angular impulse that takes a part of the relative spin out, no longer than `most` in all.
#[inline(always)]
fn held<I: Instructions>(
    sides: &Sides<I>,
    spin: Single3<I>,
    before: Single3<I>,
    most: Single<I>,
) -> Single3<I> {
    let [first, second] = sides.inverse_tensors;
    let answer = spin.dot(first * spin + second * spin);
    let turns = answer.above(Single::ZERO);
    let stop = spin * turns.select(spin.dot(spin) / answer, Single::ZERO);
    (before - stop).shortened_to(most)
}
