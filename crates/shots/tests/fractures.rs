//! The captions of the figures with fracture hold (figure 4: `wall.rs`).

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

mod common;

use common::bunny;
use frangible::{Fracture, Method, StepReport, World, id_from_number, step};
use frangible_shots::{Shot, ShotOptions};
use glam::DVec3;

fn world(name: &str, options: &ShotOptions) -> World {
    World::build(&Shot::find(name).unwrap().scene(options).unwrap()).unwrap()
}

/// Steps once and checks what holds in every frame: mass, momentum, energy, and that nobody is
/// lost.
fn checked(world: &mut World, mass: f64) -> StepReport {
    let report = step(world);
    assert!(report.quarantined.is_empty());
    assert!((report.mass / mass - 1.0).abs() < 1e-9, "{} kg of {mass}", report.mass);
    assert!(report.momentum.linear_error < 1e-9 && report.momentum.angular_error < 1e-9);
    assert!(
        report.energy.gain <= 1e-9 * report.energy.kinetic.max(1.0),
        "{} J",
        report.energy.gain
    );
    for fracture in &report.fractures {
        let error = fracture.imbalance;
        let worst = [error.mass, error.momentum, error.angular_momentum, error.kinetic_energy];
        assert!(worst.iter().all(|&relative| relative < 1e-9), "{error:?}");
    }
    report
}

fn dynamic_mass(world: &World) -> f64 {
    world.bodies().masses.iter().filter(|mass| mass.is_finite()).sum()
}

/// Runs a shot and returns all fractures.
fn run(world: &mut World, frames: usize) -> Vec<Fracture> {
    let mass = dynamic_mass(world);
    (0..frames).flat_map(|_| checked(world, mass).fractures).collect()
}

/// "A cylinder (level set resolution of 55x105x55) is shattered into 25 pieces by a sphere." [Su09
/// fig. 5]
#[test]
fn figure_5_a_ball_shatters_the_cylinder_into_25_pieces_or_more() {
    for method in [Method::FrameRate, Method::Paper] {
        let mut world = world("cylinder", &ShotOptions { method, ..ShotOptions::default() });
        let fractures = run(&mut world, 60);
        assert_eq!(fractures.len(), 1, "{method:?}");
        assert!(fractures[0].fragments.len() >= 25, "{method:?}: {}", fractures[0].fragments.len());
        // Shattered: few pieces are where they were.
        let left = world.bodies().poses[1..]
            .iter()
            .filter(|pose| pose.position.with_y(0.0).length() < 0.3);
        assert!(2 * left.count() < fractures[0].fragments.len(), "{method:?}");
    }
}

/// "A complex bunny model with a level set resolution of 70x60x45 is shattered into 35 pieces."
/// [Su09 fig. 6]
#[test]
fn figure_6_a_ball_shatters_the_bunny_into_35_pieces_or_more() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = Some(bunny(folder.path(), |_| false));
    let mut world = world("bunny", &ShotOptions { mesh, ..ShotOptions::default() });
    let fractures = run(&mut world, 60);
    assert_eq!(fractures.len(), 1);
    assert!(fractures[0].fragments.len() >= 35, "{}", fractures[0].fragments.len());
    assert!(world.bodies().poses[1..].iter().all(|pose| pose.position.y > -0.05));
    // Shattered: the pieces part.
    let poses = &world.bodies().poses;
    let spread = (2..poses.len()).filter(|&i| poses[i].position.with_y(0.0).length() > 1.5).count();
    assert!(spread >= 8, "{spread} pieces flew off");
}

/// "A wall is fractured in the lower right corner with a sphere, creating large pieces away from
/// the fracture location (left). Then, a second sphere fractures one of the large fragments
/// (right)." [Su09 fig. 7]
#[test]
fn figure_7_the_second_ball_breaks_a_large_fragment() {
    let mut world = world("refracture", &ShotOptions::default());
    let wall = dynamic_mass(&world);
    let ids: Vec<u64> = world.bodies().ids.iter().map(|&id| frangible::id_number(id)).collect();
    let [first_ball, second_ball] = [ids[2], ids[3]];
    let mut fractures = Vec::new();
    let mut mass_of = std::collections::BTreeMap::new();
    for _ in 0..75 {
        let report = checked(&mut world, wall);
        for &id in report.fractures.iter().flat_map(|fracture| &fracture.fragments) {
            if let Some(i) = world.bodies().index_of(id_from_number(id)) {
                mass_of.insert(id, (world.bodies().masses[i], world.bodies().poses[i].position));
            }
        }
        fractures.extend(report.fractures);
    }
    // The corner breaks off in small pieces, and large ones stay.
    let first = &fractures[0];
    assert_eq!(first.striker, first_ball);
    let struck = DVec3::from_array(first.point);
    assert!(
        struck.y < -0.9 && struck.z < -1.9,
        "{struck} is not in the lower right corner, seen from the ball"
    );
    let pieces: Vec<(f64, f64)> = first
        .fragments
        .iter()
        .filter_map(|id| mass_of.get(id))
        .map(|&(mass, position)| (mass, position.distance(struck)))
        .collect();
    let mean = |keep: &dyn Fn(f64) -> bool| {
        let chosen: Vec<f64> =
            pieces.iter().filter(|(_, away)| keep(*away)).map(|(mass, _)| *mass).collect();
        chosen.iter().sum::<f64>() / chosen.len() as f64
    };
    let (near, far) = (mean(&|away| away < 1.5), mean(&|away| away > 2.5));
    assert!(far > 5.0 * near, "pieces of {near} kg near the blow, of {far} kg away from it");

    // The second ball breaks a large one of these.
    let second = fractures.iter().find(|fracture| fracture.striker == second_ball).unwrap();
    assert!(first.fragments.contains(&second.body), "a fragment of the wall");
    assert!(mass_of[&second.body].0 > 5.0 * near, "{} kg", mass_of[&second.body].0);
}

/// "1000 small spheres are dropped onto a table and then a larger sphere is dropped to fracture the
/// table, resulting in 8992 rigid body fragments" [Su09 fig. 8]; with 25 and 100, too, as in the
/// paper's text.
fn rains(name: &str, balls: usize) {
    let mut world = world(name, &ShotOptions::default());
    let shot = Shot::find(name).unwrap();
    let table = frangible::id_number(world.bodies().ids[1]);
    let mass = dynamic_mass(&world);
    let mut broken = Vec::new();
    for frame in 0..shot.frames {
        let report = checked(&mut world, mass);
        broken.extend(report.fractures.into_iter().map(|fracture| (frame, fracture)));
    }
    let (tables, rain): (Vec<_>, Vec<_>) =
        broken.iter().partition(|(_, fracture)| fracture.body == table);
    assert_eq!(tables.len(), 1, "{name}");
    // Some balls come down softly on the rubble of others, and break later or not at all.
    let before = rain.iter().filter(|(frame, _)| *frame <= tables[0].0).count();
    assert!(10 * before >= 8 * balls, "{name}: the rain breaks first, {before} of {balls} balls");
    assert!(10 * rain.len() >= 9 * balls, "{name}: {} of {balls} balls break", rain.len());
    let pieces: usize = rain.iter().map(|(_, fracture)| fracture.fragments.len()).sum();
    let of_a_ball = pieces as f64 / rain.len() as f64;
    assert!((7.0..11.0).contains(&of_a_ball), "{name}: {of_a_ball} pieces a ball");
    println!("{name}: {} bodies at the end", world.bodies().len());
}

#[test]
fn figure_8_balls_break_on_the_table_and_the_larger_one_breaks_it() {
    rains("rain-25", 25);
}

/// Minutes long: `make soak`.
#[test]
#[ignore = "minutes long, see `make soak`"]
fn figure_8_with_100_and_1000_balls() {
    rains("rain-100", 100);
    rains("rain-1000", 1000);
}

/// "A wall is fractured using a realistic fracture pattern." [Su09 fig. 9]
#[test]
fn figure_9_the_wall_breaks_as_stone_does() {
    let mut world = world("wall-natural", &ShotOptions::default());
    let fractures = run(&mut world, 60);
    assert_eq!(fractures.len(), 1);
    // The radial pattern of figure 4 makes 27, of which none has a fourteenth of another's mass.
    assert!(fractures[0].fragments.len() >= 40, "{}", fractures[0].fragments.len());
    let masses: Vec<f64> =
        world.bodies().masses.iter().copied().filter(|mass| mass.is_finite()).collect();
    let (least, most) =
        masses.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), &x| (l.min(x), m.max(x)));
    assert!(most > 100.0 * least, "of many sizes: {least} to {most} kg");
}

/// Glass, timber and concrete break by the strength of their material, and the cracks' energy is in
/// the books.
#[test]
fn materials_break() {
    for (name, least) in [("pane", 80), ("timber", 20), ("concrete", 20)] {
        let mut world = world(name, &ShotOptions::default());
        let mass = dynamic_mass(&world);
        let fracture = (0..15).map(|_| checked(&mut world, mass)).find_map(|report| {
            let booked = report.energy.causes.fracture;
            report.fractures.into_iter().next().inspect(|fracture| {
                assert!(
                    (booked + fracture.energy).abs() < 1e-9 * fracture.energy,
                    "{name}: {booked} J"
                );
            })
        });
        let pieces = fracture.map_or(0, |fracture| fracture.fragments.len());
        assert!(pieces >= least, "{name}: {pieces} pieces");
    }
}
