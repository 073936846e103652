//! Fracture: conditions, number of pieces, and momentum and energy taken from the blow.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BreakingDesc, MaterialDesc, MaterialName, Method, PatternDesc, Resolution, SceneDesc,
    ShapeDesc, StepReport, StrengthDesc, World, step,
};
use glam::DVec3;

fn voronoi(cells: usize) -> PatternDesc {
    PatternDesc::Voronoi(Voronoi { cells, clustering: 0.0, seed: 7, ..Voronoi::default() })
}

fn cuboid(size: [f64; 3]) -> ShapeDesc {
    ShapeDesc::Box { size, resolution: Resolution::default() }
}

/// A steel ball.
fn ball(radius: f64, speed: f64) -> BodyDesc {
    BodyDesc {
        position: [radius + 0.6, 0.0, 0.0],
        linear_velocity: [-speed, 0.0, 0.0],
        density: 7800.0,
        ..BodyDesc::new("ball", ShapeDesc::Sphere { radius, resolution: Resolution::default() })
    }
}

/// A ball flies along x at something, with nothing else in the world.
fn in_space(target: BodyDesc, ball: BodyDesc) -> World {
    let mut scene = SceneDesc::new("space");
    scene.gravity = [0.0; 3];
    scene.bodies = vec![target, ball];
    World::build(&scene).unwrap()
}

fn glass(thickness: f64, cells: usize) -> BodyDesc {
    BodyDesc {
        density: 2500.0,
        breaking: Some(BreakingDesc::once(
            StrengthDesc::Named(MaterialName::Glass),
            voronoi(cells),
        )),
        ..BodyDesc::new("pane", cuboid([thickness, 1.0, 1.0]))
    }
}

/// Index of the body of a name.
fn find(world: &World, name: &str) -> usize {
    world.labels().iter().position(|label| label.name == name).unwrap()
}

/// Sum of the momenta of all bodies that satisfy a condition on their names.
fn momentum(world: &World, counts: impl Fn(&str) -> bool) -> DVec3 {
    let bodies = world.bodies();
    let counted = (0..bodies.len()).filter(|&i| counts(&world.labels()[i].name));
    counted.map(|i| bodies.masses[i] * bodies.velocities[i].linear).sum()
}

#[test]
fn a_thin_pane_slows_the_ball_a_little_and_a_thick_wall_stops_it() {
    let speeds: Vec<f64> = [0.005, 0.05, 0.2]
        .into_iter()
        .map(|thickness| {
            let mut world = in_space(glass(thickness, 25), ball(0.1, 20.0));
            let broken = (0..15).map(|_| step(&mut world).fractures.len()).sum::<usize>();
            assert_eq!(broken, 1, "{thickness} m");
            -world.bodies().velocities[find(&world, "ball")].linear.x
        })
        .collect();
    assert!(speeds[0] > 0.8 * 20.0, "{speeds:?}");
    assert!(speeds[1] < speeds[0] && speeds[2] < speeds[1], "{speeds:?}");
    assert!(speeds[2] < 0.2 * 20.0, "{speeds:?}");
}

/// The ball's momentum loss equals the gain of the wall's pieces, and vice versa.
#[test]
fn momentum_is_exact_through_a_break_both_ways() {
    for method in [Method::FrameRate, Method::Paper] {
        for wall_breaks in [true, false] {
            let resolution = Resolution { voxels: Some([24; 3]), sample_spacing: None };
            let size = [0.3, 1.2, 1.5];
            let wall = BodyDesc::new("wall", ShapeDesc::Box { size, resolution });
            let mut ball = ball(0.25, 6.0);
            ball.shape = ShapeDesc::Sphere { radius: 0.25, resolution };
            ball.position = [0.8, 0.2, 0.1];
            ball.angular_velocity = [1.0, 5.0, -2.0];
            let breaking = Some(BreakingDesc::once(300.0, voronoi(12)));
            let (wall, ball) = if wall_breaks {
                (BodyDesc { breaking, ..wall }, ball)
            } else {
                (wall, BodyDesc { breaking, ..ball })
            };
            let mut scene = SceneDesc::new("space");
            (scene.gravity, scene.method, scene.bodies) = ([0.0; 3], method, vec![wall, ball]);
            let mut world = World::build(&scene).unwrap();
            let of = |world: &World, name: &str| momentum(world, |other| other.starts_with(name));
            let (ball_before, wall_before) = (of(&world, "ball"), of(&world, "wall"));
            let mut fractures = 0;
            for _ in 0..20 {
                fractures += step(&mut world).fractures.len();
                let lost = ball_before - of(&world, "ball");
                let gained = of(&world, "wall") - wall_before;
                assert!((lost - gained).length() < 1e-12 * ball_before.length(), "{lost} {gained}");
            }
            assert_eq!(fractures, 1, "{method:?}, wall breaks: {wall_breaks}");
            let lost = ball_before - of(&world, "ball");
            assert!(
                lost.length() > 0.05 * ball_before.length(),
                "{method:?}: they did meet, {lost}"
            );
        }
    }
}

/// Runs until a fracture; returns the report of this frame.
fn first_fracture(world: &mut World) -> Option<StepReport> {
    (0..30).map(|_| step(world)).find(|report| !report.fractures.is_empty())
}

#[test]
fn cracks_take_no_more_than_the_blow_brings() {
    let mut pieces = Vec::new();
    for fracture_energy in [1.0, 1e3, 1e4, 1e5, 1e8] {
        let Some(StrengthDesc::Named(name)) =
            glass(0.1, 64).breaking.map(|breaking| breaking.strength)
        else {
            unreachable!()
        };
        let material = MaterialDesc { fracture_energy, ..name.properties() };
        let mut target = glass(0.1, 64);
        target.breaking = Some(BreakingDesc::once(StrengthDesc::Material(material), voronoi(64)));
        let mut world = in_space(target, ball(0.1, 20.0));
        let kinetic = world.energy().0;
        let Some(report) = first_fracture(&mut world) else {
            pieces.push(1);
            continue;
        };
        let fracture = &report.fractures[0];
        assert!(fracture.energy > 0.0 && fracture.energy < kinetic, "{}", fracture.energy);
        let booked = report.energy.causes.fracture;
        assert!((booked + fracture.energy).abs() < 1e-9 * kinetic, "{booked} J are booked");
        pieces.push(fracture.fragments.len());
    }
    assert!(pieces[0] > 15, "{pieces:?}");
    assert!(pieces.is_sorted_by(|a, b| a >= b) && pieces[2] < pieces[0], "{pieces:?}");
    assert_eq!(pieces[4], 1, "it has not the energy for a single crack");
}

#[test]
fn both_bodies_of_a_pair_may_break() {
    // The one that bears more breaks on the fragments of the other, in the same frame.
    for bears in [[50.0, 50.0], [50.0, 80.0]] {
        let rock = |name: &str, x: f64, bears: f64| BodyDesc {
            position: [x, 0.0, 0.0],
            linear_velocity: [-20.0 * x.signum(), 0.0, 0.0],
            breaking: Some(BreakingDesc::once(bears, voronoi(8))),
            ..BodyDesc::new(name, cuboid([0.4; 3]))
        };
        let mut world = in_space(rock("left", -0.6, bears[0]), rock("right", 0.6, bears[1]));
        let report = first_fracture(&mut world).unwrap();
        assert_eq!(report.fractures.len(), 2, "{bears:?}");
        assert!(world.labels().iter().all(|label| label.parent.is_some()));
    }
}

#[test]
fn fragments_break_again_until_they_are_too_small_or_too_late() {
    let drop = |generations: u32, smallest: f64| {
        let mut scene = SceneDesc::new("drop");
        let breaking =
            BreakingDesc { generations, smallest, ..BreakingDesc::once(20.0, voronoi(6)) };
        scene.bodies = vec![
            BodyDesc::ground(0.0),
            BodyDesc {
                position: [0.0, 4.0, 0.0],
                breaking: Some(breaking),
                ..BodyDesc::new("block", cuboid([0.5; 3]))
            },
        ];
        let mut world = World::build(&scene).unwrap();
        (0..60).for_each(|_| drop_report(step(&mut world)));
        world
    };
    fn drop_report(report: StepReport) {
        for fracture in &report.fractures {
            let worst = [
                fracture.imbalance.mass,
                fracture.imbalance.momentum,
                fracture.imbalance.kinetic_energy,
            ];
            assert!(worst.iter().all(|&relative| relative < 1e-10), "{worst:?}");
        }
    }
    let depth =
        |world: &World| world.labels().iter().map(|label| label.name.matches('.').count()).max();
    let once = drop(1, 0.0);
    assert_eq!(depth(&once), Some(1));
    let thrice = drop(3, 0.0);
    assert!(depth(&thrice) > Some(1) && thrice.bodies().len() > once.bodies().len());
    let coarse = drop(3, 10.0);
    assert_eq!(depth(&coarse), Some(1), "no fragment is ten metres long");

    // Where strength is a material's, smaller means stronger in stress.
    let mut world = in_space(glass(0.05, 8), ball(0.1, 20.0));
    let parent = world.labels()[0].breaking.clone().unwrap();
    let mut finer = glass(0.05, 8);
    finer.breaking.as_mut().unwrap().generations = 2;
    let mut again = in_space(finer, ball(0.1, 20.0));
    assert!(first_fracture(&mut world).is_some() && first_fracture(&mut again).is_some());
    let tensile = |strength: frangible::Strength| match strength {
        frangible::Strength::Material(material) => material.tensile_strength,
        frangible::Strength::Impulse(_) => panic!("glass is a material"),
    };
    // Those that broke again in that frame are at the end of it.
    let fragments = again.labels().iter().filter(|label| label.parent.is_some());
    let left: Vec<_> = fragments.filter_map(|fragment| fragment.breaking.as_ref()).collect();
    assert!(!left.is_empty());
    assert!(left.iter().all(|breaking| tensile(breaking.strength) > tensile(parent.strength)));
    assert!(world.labels().iter().all(|label| label.breaking.is_none()));
}

#[test]
fn a_thousand_bodies_break_in_one_frame() {
    let mut scene = SceneDesc::new("burst");
    scene.bodies.push(BodyDesc::ground(0.0));
    for index in 0..1000 {
        let [x, z] = [f64::from(index % 32), f64::from(index / 32)];
        scene.bodies.push(BodyDesc {
            position: [2.0 * x, 0.6, 2.0 * z],
            linear_velocity: [0.0, -10.0, 0.0],
            breaking: Some(BreakingDesc::once(1.0, voronoi(9))),
            ..BodyDesc::new("brick", cuboid([0.4, 0.5, 0.6]))
        });
    }
    let mut world = World::build(&scene).unwrap();
    let mass: f64 = step_until_broken(&mut world);
    let after: f64 = world.bodies().masses.iter().filter(|mass| mass.is_finite()).sum();
    assert!((after / mass - 1.0).abs() < 1e-12);
    assert!(world.bodies().len() > 5000);
}

/// Steps to the frame in which everything breaks; the mass before.
fn step_until_broken(world: &mut World) -> f64 {
    let mass = world.bodies().masses.iter().filter(|mass| mass.is_finite()).sum();
    let report = first_fracture(world).unwrap();
    assert_eq!(report.fractures.len(), 1000);
    mass
}
