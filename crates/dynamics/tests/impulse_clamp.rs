//! A clamped impulse never raises the kinetic energy of the pair in the non-split state
//! [Su09 sec. 3.2].

#[path = "../../bodies/tests/common/mod.rs"]
mod common;

use common::{Random, Tensors, Toucher};
use frangible_bodies::{PairSurface, Velocity};
use frangible_dynamics::{
    Clamp, ClampSide, Impulse, apply_impulse, clamp_impulse, collision_impulse, contact_matrix,
};
use glam::{DQuat, DVec3};

/// Kind of the other body.
#[derive(Clone, Copy, Debug)]
enum Partner {
    Dynamic,
    Static,
    Kinematic,
}

/// Counts of outcomes.
#[derive(Default)]
struct Tally {
    approaching: u32,
    gained_without_clamp: u32,
    scaled: u32,
    blocked: u32,
}

fn side(body: &Toucher, non_split: DQuat, impulse: Impulse) -> ClampSide {
    ClampSide::Dynamic {
        inertia: body.inertia,
        orientation: non_split,
        velocity: body.velocity,
        impulse,
    }
}

/// An impulse and a torque impulse on a body.
fn on(body: &Toucher, impulse: DVec3, torque_impulse: DVec3) -> Impulse {
    let at_lever = Impulse::at(body.lever, impulse);
    Impulse { angular: at_lever.angular + torque_impulse, ..at_lever }
}

/// Collides random bodies whose split orientation differs from the non-split orientation by up to
/// `split` [rad].
fn collide(tensors: Tensors, partner: Partner, split: f64, restitution: f64, torque: f64) -> Tally {
    let mut random = Random::new(3);
    let mut tally = Tally::default();
    for _ in 0..200_000 {
        let [a, b] = [0; 2].map(|_| Toucher::random(&mut random, tensors));
        let [a_non_split, b_non_split] = [&a, &b]
            .map(|body| DQuat::from_scaled_axis(split * random.vector()) * body.orientation);

        // The impulse of the split state.
        let wall_velocity = match partner {
            Partner::Kinematic => 20.0 * random.vector(),
            _ => DVec3::ZERO,
        };
        let dynamic = matches!(partner, Partner::Dynamic);
        let mut matrix = contact_matrix(a.inertia.inverse_mass, a.inverse_tensor(), a.lever);
        let mut relative = a.point_velocity(&a.velocity) - wall_velocity;
        if dynamic {
            matrix += contact_matrix(b.inertia.inverse_mass, b.inverse_tensor(), b.lever);
            relative -= b.point_velocity(&b.velocity);
        }
        let surfaces = PairSurface::new(restitution, 0.5);
        let impulse = collision_impulse(matrix, relative, random.direction(), surfaces);
        if impulse == DVec3::ZERO {
            continue;
        }
        let torque_impulse = torque * impulse.length() * random.vector();

        let other = if dynamic {
            side(&b, b_non_split, on(&b, -impulse, -torque_impulse))
        } else {
            ClampSide::Prescribed { point_velocity: wall_velocity }
        };
        let clamp = clamp_impulse(&side(&a, a_non_split, on(&a, impulse, torque_impulse)), &other);

        // Energy of the pair in the non-split state, in the frame of the wall.
        let after = |scale: f64| {
            let (j, t) = (scale * impulse, scale * torque_impulse);
            let of_a = apply_impulse(&a.velocity, a.inertia.inverse_mass, &on(&a, j, t));
            let of_b = apply_impulse(&b.velocity, b.inertia.inverse_mass, &on(&b, -j, -t));
            (of_a, if dynamic { of_b } else { Velocity::default() })
        };
        let energy = |(of_a, of_b): (Velocity, Velocity)| {
            let relative_a = Velocity { linear: of_a.linear - wall_velocity, ..of_a };
            a.kinetic_energy(&relative_a, a_non_split) + b.kinetic_energy(&of_b, b_non_split)
        };
        let (before, clamped, whole) =
            (energy(after(0.0)), energy(after(clamp.scale())), energy(after(1.0)));
        assert!(
            clamped - before <= 1e-12 * before,
            "{tensors:?} {partner:?}: {before} becomes {clamped}, {clamp:?}"
        );

        // A scaled impulse leaves the energy unchanged; a whole impulse was harmless, all others
        // were not.
        match clamp {
            Clamp::Scaled(scale) => {
                assert!(0.0 < scale && scale < 1.0);
                assert!((clamped - before).abs() <= 1e-12 * before);
                tally.scaled += 1;
            }
            Clamp::Blocked => tally.blocked += 1,
            Clamp::Whole => {}
        }
        let gained = whole - before > 1e-12 * (before + whole);
        assert!(!gained || clamp != Clamp::Whole);
        tally.gained_without_clamp += u32::from(gained);
        tally.approaching += 1;

        // Equal and opposite impulses keep the momentum, to rounding.
        if dynamic {
            let momentum = |(of_a, of_b): (Velocity, Velocity)| {
                of_a.linear / a.inertia.inverse_mass + of_b.linear / b.inertia.inverse_mass
            };
            let change = momentum(after(clamp.scale())) - momentum(after(0.0));
            let size = (a.velocity.linear / a.inertia.inverse_mass).length()
                + (b.velocity.linear / b.inertia.inverse_mass).length()
                + impulse.length();
            assert!(change.length() <= 1e-14 * size);
        }
    }
    tally
}

#[test]
fn clamped_impulses_never_raise_the_energy_and_unclamped_ones_do() {
    for partner in [Partner::Dynamic, Partner::Static, Partner::Kinematic] {
        for tensors in Tensors::ALL {
            for (split, restitution, torque) in
                [(0.3, 0.5, 0.0), (0.0, 0.5, 0.0), (0.0, 1.0, 0.0), (0.3, 0.0, 0.1)]
            {
                let tally = collide(tensors, partner, split, restitution, torque);
                let percent = |count: u32| 100.0 * f64::from(count) / f64::from(tally.approaching);
                println!("{partner:?} {tensors:?} split {split} e {restitution} torque {torque}:");
                let [gained, scaled, blocked] =
                    [tally.gained_without_clamp, tally.scaled, tally.blocked].map(percent);
                println!(
                    "  {gained:.3} % gain without the clamp, {scaled:.3} % scaled, {blocked:.3} % blocked"
                );
                // Near-round bodies hardly ever gain energy; thin bodies do, and exercise the
                // clamp.
                assert!(tally.approaching > 50_000);
                if split > 0.0 && !matches!(tensors, Tensors::Mild) {
                    assert!(
                        tally.gained_without_clamp > 1000
                            && tally.scaled > 1000
                            && tally.blocked > 1000
                    );
                }
            }
        }
    }
}
