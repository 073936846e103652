//! Repayment: a contact with an energy gain repays it from its pair's relative velocity, and a pair
//! what penetration recovery gave it, before the island must.

use crate::energy::frame_accounts::{EnergyGain, FrameAccounts, lighter_first};
use crate::energy::island::Anchor;
use crate::energy::island_correction::RelativeMotion;
use crate::impulse::pair_impulse::{Approach, PairImpulse, approach_at, pair_contact_matrix};
use frangible_bodies::{Bodies, BodyId, Frame, Motion, Pair};
use frangible_collision::ContactPoint;
use glam::DVec3;

/// Distributes the repayment of `excess` [J] over all contacts with a gain, proportionally, each
/// limited by the energy of the relative velocity. Impulses at the contact are mutual: momentum and
/// angular momentum stay.
pub(crate) fn repay(
    bodies: &mut Bodies,
    gains: &[EnergyGain],
    excess: f64,
    accounts: &mut FrameAccounts,
) {
    let owed: f64 = gains.iter().map(|gain| gain.energy).sum();
    if owed <= 0.0 {
        return;
    }
    let part = (excess / owed).min(1.0);
    for gain in gains {
        let [Some(first), Some(second)] = gain.ids.map(|id| bodies.index_of(id)) else { continue };
        repay_at(bodies, Pair { first, second }, gain.point, part * gain.energy, accounts);
    }
}

/// Takes `excess` [J] from pairs in proportion to the work that penetration recovery did on them,
/// `recovered` [J], each limited by that and by the energy of its relative motion.
pub(crate) fn return_recovered(
    bodies: &mut Bodies,
    recovered: &[([BodyId; 2], f64)],
    excess: f64,
    accounts: &mut FrameAccounts,
) {
    let given = recovered.iter().filter(|(_, energy)| *energy > 0.0);
    let owed: f64 = given.clone().map(|(_, energy)| energy).sum();
    let part = (excess / owed).min(1.0);
    for &(ids, energy) in given {
        let Some(both) = lighter_first(bodies, ids) else { continue };
        PairMotion::of(bodies, both).lose(bodies, part * energy, accounts);
    }
}

/// Slows pairs whose contact gave more than the lighter body's bank cap, until the relative motion
/// is at the cap. The reduction is limited by the contact's gain, by the net gain of all contacts
/// of the lighter body, and by the body's gain in the frame, `gained` [J] per body. Without it a
/// chip pressed against a block squirts out at 20 m/s on the banked energy of the whole heap.
/// Reduces the recorded gains by the repayment, and returns true if any pair was slowed.
pub(crate) fn cap_ejection(
    bodies: &mut Bodies,
    (gains, gained): (&mut [EnergyGain], &[f64]),
    frame: &Frame,
    accounts: &mut FrameAccounts,
) -> bool {
    let mut any = false;
    for gain in gains {
        let Some([lighter, heavier]) = gain.by_weight(bodies) else { continue };
        let most = frame.settings.bank_cap / bodies.inertias[lighter].inverse_mass;
        let gave = gain.energy.min(gain.net).min(gained[lighter]);
        if gave <= most || !may_move_with(bodies, [lighter, heavier], most) {
            continue;
        }
        let pair = PairMotion::of(bodies, [lighter, heavier]);
        let over = pair.motion.energy - most;
        if over > 0.0 {
            let paid = over.min(gave);
            pair.lose(bodies, paid, accounts);
            gain.energy -= paid;
            any = true;
        }
    }
    any
}

/// Relative motion of a pair, whose heavier body may be fixed.
struct PairMotion {
    /// The lighter body first.
    both: [usize; 2],
    is_carried: bool,
    motion: RelativeMotion,
}

impl PairMotion {
    fn of(bodies: &Bodies, both: [usize; 2]) -> Self {
        let is_carried = bodies.inertias[both[1]].is_infinite();
        let anchor = if is_carried { Anchor::of(bodies, both[1]) } else { Anchor::Free };
        let members = &both[..if is_carried { 1 } else { 2 }];
        Self { both, is_carried, motion: RelativeMotion::of(bodies, members, anchor) }
    }

    /// Reduces the relative energy by `energy` [J], at most to zero.
    fn lose(&self, bodies: &mut Bodies, energy: f64, accounts: &mut FrameAccounts) {
        let Self { both, is_carried, motion } = self;
        let paid = energy.min(motion.energy);
        if paid <= 0.0 {
            return;
        }
        let members = &both[..if *is_carried { 1 } else { 2 }];
        motion.lose(bodies, members, paid);
        if *is_carried {
            let change = motion.change(bodies, members);
            accounts.book_outside(bodies, *both, change, motion.work(change));
        }
    }
}

/// True if an upper bound of a pair's relative kinetic energy exceeds `most` [J]: the lighter
/// body's motion relative to the heavier body, plus both spins.
fn may_move_with(bodies: &Bodies, both: [usize; 2], most: f64) -> bool {
    let linear = |i: usize| match bodies.motions[i] {
        Motion::Static => DVec3::ZERO,
        Motion::Kinematic { linear, .. } => linear,
        Motion::Dynamic => bodies.velocities[i].linear,
    };
    let turning = |i: usize| {
        let inverse = bodies.inertias[i].inverse_moments.max_element();
        if inverse > 0.0 {
            inverse * bodies.velocities[i].angular_momentum.length_squared()
        } else {
            0.0
        }
    };
    let turns = both
        .iter()
        .any(|&i| matches!(bodies.motions[i], Motion::Kinematic { angular, .. } if angular != DVec3::ZERO));
    let [lighter, heavier] = both;
    let apart = linear(lighter) - linear(heavier);
    let squared = apart.length_squared() / bodies.inertias[lighter].inverse_mass;
    turns || 0.5 * (squared + turning(lighter) + turning(heavier)) > most
}

/// Energy of a pair's relative velocity u at a point: u.K^-1 u / 2 [J].
pub fn energy_at(bodies: &Bodies, pair: Pair, point: DVec3) -> f64 {
    let (approach, stopping) = stopping_impulse(bodies, pair, point);
    energy_of(&approach, stopping)
}

/// Energy loss by the stopping impulse of a pair [J].
fn energy_of(approach: &Approach, stopping: DVec3) -> f64 {
    let available = -0.5 * stopping.dot(approach.relative_velocity);
    if stopping.is_finite() { available.max(0.0) } else { 0.0 }
}

/// Takes `energy` [J], at most u.K^-1 u / 2, out of a pair's relative velocity u at a point, by an
/// impulse j = -alpha K^-1 u.
pub fn repay_at(
    bodies: &mut Bodies,
    pair: Pair,
    point: DVec3,
    energy: f64,
    accounts: &mut FrameAccounts,
) {
    let (approach, stopping) = stopping_impulse(bodies, pair, point);
    let available = energy_of(&approach, stopping);
    if available <= 0.0 {
        return;
    }
    let alpha = if energy < available { 1.0 - (1.0 - energy / available).sqrt() } else { 1.0 };
    let impulse = PairImpulse::new(&approach, alpha * stopping);
    impulse.apply(pair, &bodies.inertias, &mut bodies.velocities);
    accounts.book_share(bodies, pair, &approach, &impulse);
}

/// Relative motion of a pair at a point, and its stopping impulse -K^-1 u [N s].
fn stopping_impulse(bodies: &Bodies, pair: Pair, point: DVec3) -> (Approach, DVec3) {
    let contact = ContactPoint { point, normal: DVec3::Y };
    let approach = approach_at(bodies, pair, contact, &bodies.poses, &bodies.velocities);
    let k = pair_contact_matrix(pair, approach.levers, &bodies.poses, &bodies.inertias);
    (approach, -(k.inverse() * approach.relative_velocity))
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::{NewBody, Pose, StepSettings, SurfaceProperties, Velocity};
    use frangible_geometry::{ClosedForm, Shape};
    use glam::DQuat;
    use std::sync::Arc;

    fn frame() -> Frame {
        Frame { dt: 1.0 / 30.0, gravity: DVec3::ZERO, settings: StepSettings::default() }
    }

    /// A fast chip, and a block with the given motion.
    fn chip_and_block(motion: Motion) -> Bodies {
        let mut bodies = Bodies::default();
        for (half, motion, position, linear, angular_momentum) in [
            (
                0.05,
                Motion::Dynamic,
                DVec3::ZERO,
                DVec3::new(11.0, 18.0, 1.0),
                DVec3::new(0.1, 0.3, -0.2),
            ),
            (0.5, motion, DVec3::new(0.1, -0.55, 0.0), DVec3::X, DVec3::ZERO),
        ] {
            bodies.spawn(NewBody {
                shape: Arc::new(Shape::closed_form(
                    ClosedForm::Box { half: DVec3::splat(half) },
                    0.1,
                )),
                density: 2000.0,
                motion,
                pose: Pose { position, orientation: DQuat::from_rotation_z(half) },
                velocity: Velocity { linear, angular_momentum },
                surface: SurfaceProperties::new(0.0, 0.5),
            });
        }
        bodies
    }

    fn gain(ids: &[BodyId], energy: f64) -> EnergyGain {
        EnergyGain {
            ids: [ids[0], ids[1]],
            point: DVec3::new(0.0, -0.05, 0.0),
            energy,
            net: energy,
        }
    }

    fn momenta(bodies: &Bodies) -> (DVec3, DVec3) {
        let of = |i: usize| {
            let momentum = bodies.masses[i] * bodies.velocities[i].linear;
            let spin = bodies.velocities[i].angular_momentum;
            (momentum, bodies.poses[i].position.cross(momentum) + spin)
        };
        let mobile = (0..bodies.len()).filter(|&i| !bodies.inertias[i].is_infinite());
        mobile.map(of).fold((DVec3::ZERO, DVec3::ZERO), |(p, l), (dp, dl)| (p + dp, l + dl))
    }

    fn kinetic_energy(bodies: &Bodies) -> f64 {
        let of = |i: usize| {
            let Velocity { linear, angular_momentum } = bodies.velocities[i];
            0.5 * bodies.masses[i] * linear.length_squared()
                + bodies.inertias[i]
                    .rotational_energy(bodies.poses[i].orientation, angular_momentum)
        };
        (0..bodies.len()).filter(|&i| !bodies.inertias[i].is_infinite()).map(of).sum()
    }

    /// A contact with a large gain leaves the chip at its bank cap. The reduction never exceeds the
    /// contact's gain, the net gain of the chip's contacts, or the chip's own gain. For every kind
    /// of block the booked outside impulse matches the change of momenta, the energy change matches
    /// work and repayment, and the gain shrinks by the repayment.
    #[test]
    fn what_a_contact_gave_flings_nothing() {
        let moving = Motion::Kinematic {
            linear: DVec3::new(1.0, 0.2, 0.0),
            angular: DVec3::new(0.0, 0.1, 0.0),
        };
        for motion in [Motion::Static, moving, Motion::Dynamic] {
            let cases = [
                (1e4, 1e4, 1e4, None),
                (5.0, 1e4, 1e4, Some(5.0)),
                (1e4, 3.0, 1e4, Some(3.0)),
                (1e4, 1e4, 2.0, Some(2.0)),
                (1e4, -2.0, 1e4, Some(0.0)),
                (1e4, 1e4, -1.0, Some(0.0)),
                (0.1, 1e4, 1e4, Some(0.0)),
            ];
            for (gave, net, gained, paid) in cases {
                let mut bodies = chip_and_block(motion);
                let mut gains = [EnergyGain { net, ..gain(&bodies.ids, gave) }];
                let (before, energy) = (momenta(&bodies), kinetic_energy(&bodies));
                let mut accounts = FrameAccounts::default();
                let has_paid = cap_ejection(
                    &mut bodies,
                    (&mut gains, &[gained, 0.0]),
                    &frame(),
                    &mut accounts,
                );
                assert_eq!(has_paid, paid != Some(0.0));

                let after = momenta(&bodies);
                let [given, turned] = [after.0 - before.0, after.1 - before.1];
                assert!((given - accounts.outside_impulse).length() < 1e-11, "{motion:?} {given}");
                assert!(
                    (turned - accounts.outside_angular_impulse).length() < 1e-11,
                    "{motion:?} {turned}"
                );
                let lost = energy + accounts.causes.work - kinetic_energy(&bodies);
                assert!((gave - lost - gains[0].energy).abs() < 1e-9, "{motion:?} {gains:?}");
                match paid {
                    Some(paid) => assert!((lost - paid).abs() < 1e-9, "{motion:?} {lost} {paid}"),
                    None => {
                        let (chip, block) = (0, 1);
                        let anchor = if motion == Motion::Dynamic {
                            Anchor::Free
                        } else {
                            Anchor::of(&bodies, block)
                        };
                        let members: &[usize] =
                            if anchor == Anchor::Free { &[chip, block] } else { &[chip] };
                        let left = RelativeMotion::of(&bodies, members, anchor).energy;
                        let most = frame().settings.bank_cap * bodies.masses[chip];
                        assert!((left - most).abs() < 1e-9, "{motion:?} {left} {most}");
                        assert!(lost > 400.0 && lost < gave);
                    }
                }
            }
        }
    }

    /// A body moving along with a block is not slowed, for any speed of the block.
    #[test]
    fn what_moves_along_goes_on() {
        let mut bodies =
            chip_and_block(Motion::Kinematic { linear: 20.0 * DVec3::X, angular: DVec3::ZERO });
        bodies.velocities[0] = Velocity { linear: 20.0 * DVec3::X, angular_momentum: DVec3::ZERO };
        let gain = gain(&bodies.ids, 1e4);
        assert!(!cap_ejection(
            &mut bodies,
            (&mut [gain], &[1e4; 2]),
            &frame(),
            &mut FrameAccounts::default()
        ));
    }
}
