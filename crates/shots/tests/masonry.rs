//! A ball knocks a hole in a wall of mortared bricks, and the rest of it stands.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::bodies::StepSettings;
use frangible::{SceneDesc, World, step};
use frangible_shots::{Shot, ShotOptions};
use glam::DVec3;

fn scene() -> SceneDesc {
    Shot::find("masonry").unwrap().scene(&ShotOptions::default()).unwrap()
}

/// Mortar with a multiple of its strength.
fn with_strength(times: f64) -> SceneDesc {
    let mut scene = scene();
    let bonds = scene.bodies[1].bonds.as_mut().unwrap();
    bonds.tensile_strength *= times;
    bonds.shear_strength *= times;
    scene
}

/// The end of a run.
struct Run {
    world: World,
    /// Where the ball was when bonds first broke [m].
    struck: Option<DVec3>,
}

/// Frames in which the books close.
fn run(world: World, frames: u32) -> Run {
    let mut run = Run { world, struck: None };
    for _ in 0..frames {
        let report = step(&mut run.world);
        assert!(report.quarantined.is_empty());
        assert!(report.momentum.linear_error < 1e-9 && report.momentum.angular_error < 1e-9);
        let scale = report.energy.total.abs() + report.energy.kinetic + 1.0;
        assert!(report.energy.gain <= 1e-9 * scale, "{} J", report.energy.gain);
        let struck = report.fractures.first().map(|fracture| DVec3::from_array(fracture.point));
        run.struck = run.struck.or(struck);
    }
    run
}

impl Run {
    fn of(scene: &SceneDesc, frames: u32) -> Self {
        run(World::build(scene).unwrap(), frames)
    }

    fn ball(&self) -> DVec3 {
        let at = self.world.labels().iter().position(|label| label.name == "ball").unwrap();
        self.world.bodies().poses[at].position
    }

    /// Mass and place of what the wall has lost [kg, m].
    fn loose(&self) -> Vec<(f64, DVec3)> {
        let (bodies, labels) = (self.world.bodies(), self.world.labels());
        let is_loose =
            |&i: &usize| labels[i].name.starts_with("wall") && bodies.masses[i].is_finite();
        (0..bodies.len())
            .filter(is_loose)
            .map(|i| (bodies.masses[i], bodies.poses[i].position))
            .collect()
    }

    /// Volume of the anchored bodies [m^3], and their number.
    fn standing(&self) -> (f64, usize) {
        let (bodies, labels) = (self.world.bodies(), self.world.labels());
        let stands =
            |&i: &usize| labels[i].name.starts_with("wall") && bodies.masses[i].is_infinite();
        let volumes: Vec<f64> =
            (0..bodies.len()).filter(stands).map(|i| bodies.shapes[i].volume).collect();
        (volumes.iter().sum(), volumes.len())
    }
}

/// Of the whole wall [m^3], and its half thickness [m].
const VOLUME: f64 = 3.2 * 2.2 * 0.24;
const HALF: f64 = 0.12;

/// The ball knocks a few bricks out of the wall; the rest stays anchored.
#[test]
fn a_ball_knocks_a_hole() {
    let run = Run::of(&scene(), 45);
    let loose = run.loose();
    let gone = loose.iter().filter(|(_, at)| at.z < -2.0 * HALF).count();
    assert!((8..=30).contains(&loose.len()), "{} bodies are loose", loose.len());
    assert!(gone >= 6, "{gone} bodies of {} have left the wall", loose.len());
    assert!(run.ball().z < -1.0, "the ball is at {}", run.ball());
    let (volume, count) = run.standing();
    assert!(count == 1 && volume > 0.8 * VOLUME, "{volume} m^3 stand in {count} parts");
    let lost: f64 = loose.iter().map(|(mass, _)| mass).sum();
    assert!((lost / 1800.0 + volume - VOLUME).abs() < 1e-9, "{lost} kg");
}

/// The stronger the mortar, the less comes loose; the ball is caught, then bounces off a whole
/// wall.
#[test]
fn mortar_holds_as_it_is_strong() {
    let runs = [0.3, 3.0, 10.0, 100.0].map(|times| Run::of(&with_strength(times), 30));
    let counts = runs.each_ref().map(|run| run.loose().len());
    assert!(counts.is_sorted_by(|a, b| a >= b), "{counts:?}");
    assert!(counts[0] > counts[2] && counts[3] == 0, "{counts:?}");
    assert!(runs[1].ball().z < -HALF, "through mortar of three times the strength");
    let mass = |run: &Run| run.loose().iter().map(|(mass, _)| mass).sum::<f64>();
    // Twice as much, and one or two bricks more or less.
    assert!(mass(&runs[0]) > 1.5 * mass(&runs[1]), "weak mortar lets large parts go");
    assert!(runs[2].ball().z > -HALF && runs[3].ball().z > HALF, "strong mortar catches it");
}

/// A faster ball makes no smaller hole, wherever it strikes; the hole is where it strikes.
#[test]
fn the_hole_is_where_the_ball_strikes() {
    let mut counts = Vec::new();
    for (x, y, speed) in [(0.9, 0.9, 4.0), (0.9, 0.9, 20.0), (-0.8, 1.7, 14.0)] {
        let mut scene = scene();
        scene.bodies[2].position = [x, y, 1.0];
        scene.bodies[2].linear_velocity = [0.0, 0.5, -speed];
        let run = Run::of(&scene, 12);
        let struck = run.struck.unwrap();
        assert!(struck.truncate().distance(DVec3::new(x, y, 0.0).truncate()) < 0.25, "{struck}");
        counts.push(run.loose().len());
        // Before they fall far, the loose bricks are around it.
        let (mass, sum) = run
            .loose()
            .iter()
            .fold((0.0, DVec3::ZERO), |(mass, sum), (part, at)| (mass + part, sum + *part * *at));
        assert!((sum.x / mass - x).abs() < 0.5, "{}", sum / mass);
    }
    assert!(counts[0] <= counts[1], "{counts:?}");
}

/// A wall that stands on the ground by itself has a hole, too, and the rest of it keeps its height.
#[test]
fn a_free_wall_stands_around_its_hole() {
    let mut scene = scene();
    scene.bodies[1].bonds.as_mut().unwrap().anchors.clear();
    let run = Run::of(&scene, 45);
    let loose = run.loose();
    let mass: f64 = loose.iter().map(|(mass, _)| mass).sum();
    assert!((mass / (1800.0 * VOLUME) - 1.0).abs() < 1e-9);
    let gone: f64 = loose.iter().filter(|(_, at)| at.z < -0.5).map(|(mass, _)| mass).sum();
    assert!(gone > 80.0 && gone < 0.3 * mass, "{gone} kg of {mass}");
    assert!(run.ball().z < -0.5, "{}", run.ball());
    let middle = loose.iter().map(|(mass, at)| *mass * at.y).sum::<f64>() / mass;
    assert!(middle > 0.9, "its centre was at 1.1 m, and is at {middle}");
}

/// Where blows break no bonds the ball bounces off.
#[test]
fn without_breaking_it_bounces() {
    let mut world = World::build(&scene()).unwrap();
    let settings = StepSettings { breaking_passes: 0, ..*world.settings() };
    world.set_settings(settings).unwrap();
    let run = run(world, 7);
    assert!(run.ball().z > HALF, "{}", run.ball());
}
