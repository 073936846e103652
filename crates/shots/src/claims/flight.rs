//! Bodies without contacts lose nothing.

use super::scenes::{METHODS, cuboid, free_world};
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use frangible::bodies::Inertia;
use frangible::{BodyDesc, Method};
use glam::{DQuat, DVec3};

/// A thin box that spins fast.
pub(super) const FREE_BOX: Claim = Claim {
    name: "free-box",
    says: "a box of half extents 1, 0.1, 0.02 m that spins at 35 rad/s keeps its energy and the direction of its angular momentum",
    source: "Su09 sec. 2",
    measure: free_box,
};

/// Half extents [m].
const HALF: DVec3 = DVec3::new(1.0, 0.1, 0.02);

/// [rad/s]
const RATE: f64 = 35.0;

fn free_box() -> Result<Vec<Finding>, Obstacle> {
    let orientation = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.7, 0.2);
    let spin = RATE * (orientation * DVec3::new(35.0, 5.0, -3.0).normalize());
    let body = BodyDesc {
        orientation: orientation.to_array(),
        angular_velocity: spin.to_array(),
        ..BodyDesc::new("box", cuboid((2.0 * HALF).to_array()))
    };
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let mut world = free_world(method, vec![body.clone()])?;
        let start = world.bodies().velocities[0].angular_momentum;
        let energy = world.energy().0;
        let (mut change, mut tilt) = (0.0_f64, 0.0_f64);
        for _ in 0..300 {
            change = largest([change, (step(&mut world).energy.kinetic / energy - 1.0).abs()]);
            // The angular momentum that the body's orientation and its rate amount to.
            let (pose, velocity) = (&world.bodies().poses[0], &world.bodies().velocities[0]);
            let inertia: &Inertia = &world.bodies().inertias[0];
            let rate = inertia.angular_velocity(pose.orientation, velocity.angular_momentum);
            let momentum = inertia.tensor(pose.orientation) * rate;
            tilt = largest([
                tilt,
                momentum.cross(start).length() / (momentum.length() * start.length()),
            ]);
        }
        let most = if method == Method::FrameRate { 1e-12 } else { 1e-9 };
        findings.push(Finding::at_most(
            format!("change of the energy in 10 s, {name}"),
            "1",
            change,
            most,
        ));
        findings.push(Finding::at_most(
            format!("turn of the angular momentum, {name}"),
            "rad",
            tilt,
            1e-12,
        ));
    }
    Ok(findings)
}
