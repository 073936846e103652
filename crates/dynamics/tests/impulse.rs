//! Restitution is met, friction stays in Coulomb's cone, and jams do no harm.

#[path = "../../bodies/tests/common/mod.rs"]
mod common;

use common::{Random, Tensors, Toucher};
use frangible_bodies::PairSurface;
use frangible_dynamics::{Impulse, apply_impulse, collision_impulse, contact_matrix};
use glam::DVec3;

#[test]
fn restitution_is_met_and_friction_stays_in_the_cone() {
    for tensors in Tensors::ALL {
        let mut random = Random::new(2);
        let (mut sticking, mut sliding, mut turned) = (0, 0, 0);
        for _ in 0..200_000 {
            let [a, b] = [0; 2].map(|_| Toucher::random(&mut random, tensors));
            let matrix = contact_matrix(a.inertia.inverse_mass, a.inverse_tensor(), a.lever)
                + contact_matrix(b.inertia.inverse_mass, b.inverse_tensor(), b.lever);
            let relative = a.point_velocity(&a.velocity) - b.point_velocity(&b.velocity);
            let normal = random.direction();
            let (restitution, friction) = (random.uniform(-1.0, 1.0), random.uniform(0.0, 2.0));

            let impulse = collision_impulse(
                matrix,
                relative,
                normal,
                PairSurface::new(restitution, friction),
            );
            let approach = normal.dot(relative);
            if approach >= 0.0 {
                assert_eq!(impulse, DVec3::ZERO, "separating points are left alone");
                continue;
            }

            // The impulse pushes, and its friction is in the cone.
            let normal_impulse = normal.dot(impulse);
            let friction_impulse = impulse - normal_impulse * normal;
            assert!(normal_impulse >= 0.0);
            assert!(
                friction_impulse.length() <= friction * normal_impulse + 1e-12 * impulse.length()
            );

            // The velocities of the bodies, not only K, show the restitution.
            let after_a =
                apply_impulse(&a.velocity, a.inertia.inverse_mass, &Impulse::at(a.lever, impulse));
            let after_b =
                apply_impulse(&b.velocity, b.inertia.inverse_mass, &Impulse::at(b.lever, -impulse));
            let after = a.point_velocity(&after_a) - b.point_velocity(&after_b);
            let rounding = 1e-13 * (relative.length() + matrix.x_axis.length() * impulse.length());
            let missed = normal.dot(after) + restitution * approach;
            assert!(
                missed.abs() <= 100.0 * rounding,
                "{tensors:?}: missed by {missed:e}, rounding {rounding:e}"
            );

            // Count the branches.
            let tangential = relative - approach * normal;
            if (after - normal.dot(after) * normal).length() <= 1e-6 * tangential.length() {
                sticking += 1;
            } else if friction_impulse.dot(tangential)
                <= -(1.0 - 1e-9) * friction_impulse.length() * tangential.length()
            {
                sliding += 1;
            } else {
                let gain = impulse.dot(relative) + 0.5 * impulse.dot(matrix * impulse);
                assert!(
                    gain <= rounding * impulse.length(),
                    "{tensors:?}: turned friction gains {gain:e} J"
                );
                turned += 1;
            }
        }
        println!("{tensors:?}: {sticking} stick, {sliding} slide, {turned} turned");
        assert!(sticking > 1000 && sliding > 1000 && turned > 0);
    }
}
