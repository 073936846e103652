//! Bodies of glued pieces.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::Voronoi;
use frangible::{
    AnchorDesc, BodyDesc, BondsDesc, Fracture, PartDesc, PatternDesc, Resolution, SceneDesc,
    ShapeDesc, World, step,
};

const NONE: Resolution = Resolution { voxels: None, sample_spacing: None };

fn bonds(strength: f64) -> BondsDesc {
    BondsDesc {
        pattern: None,
        point: None,
        normal: [0.0, 1.0, 0.0],
        tensile_strength: strength,
        shear_strength: 1e3 * strength,
        anchors: Vec::new(),
        strength_points: Vec::new(),
        strength_triangles: Vec::new(),
    }
}

/// A beam of ten cubes of 20 cm along x from the origin on, the first of them anchored.
fn cantilever(strength: f64) -> BodyDesc {
    let part = |n: usize| PartDesc::Box {
        size: [0.2; 3],
        position: [0.2 * n as f64 + 0.1, 0.1, 0.1],
        orientation: [0.0, 0.0, 0.0, 1.0],
    };
    let anchors = vec![AnchorDesc { low: [-0.1; 3], high: [0.2, 3.0, 0.2] }];
    BodyDesc {
        position: [0.0, 2.0, 0.0],
        bonds: Some(BondsDesc { anchors, ..bonds(strength) }),
        ..BodyDesc::new(
            "beam",
            ShapeDesc::Compound { parts: (0..10).map(part).collect(), resolution: NONE },
        )
    }
}

fn world(bodies: impl IntoIterator<Item = BodyDesc>) -> World {
    let mut scene = SceneDesc::new("bonds");
    scene.bodies.push(BodyDesc::ground(0.0));
    scene.bodies.extend(bodies);
    World::build(&scene).unwrap()
}

/// Frames in which the books close; what broke.
fn run(world: &mut World, frames: u32) -> Vec<Fracture> {
    let mut fractures = Vec::new();
    for _ in 0..frames {
        let report = step(world);
        let scale = report.energy.total.abs() + report.energy.kinetic + 1.0;
        assert!(
            report.energy.gain <= 1e-9 * scale,
            "frame {}: {} J",
            report.frame,
            report.energy.gain
        );
        assert!(report.momentum.linear_error < 1e-9 && report.momentum.angular_error < 1e-9);
        fractures.extend(report.fractures);
    }
    fractures
}

/// sigma = M c / I at the root of a beam of 1.8 m under its own weight [Pa].
const AT_ROOT: f64 = 2400.0 * 9.81 * 0.04 * 1.8 * 1.8 / 2.0 / (0.008 / 6.0);

/// An anchored beam holds or breaks at its root as the formula says, by its weight and by what
/// lands softly on its end and stays there.
#[test]
fn a_cantilever_carries_what_the_formula_says() {
    let mut holds = world([cantilever(1.1 * AT_ROOT)]);
    assert!(run(&mut holds, 30).is_empty());
    let mut breaks = world([cantilever(0.9 * AT_ROOT)]);
    let fractures = run(&mut breaks, 12);
    assert_eq!(fractures.len(), 1);
    assert_eq!(fractures[0].fragments.len(), 2);
    let bodies = breaks.bodies();
    let (root, rest) = (1, 2);
    assert!(bodies.inertias[root].is_infinite() && !bodies.inertias[rest].is_infinite());
    assert!((bodies.masses[rest] / (9.0 * 0.008 * 2400.0) - 1.0).abs() < 1e-12);
    assert!(bodies.poses[rest].position.y < 1.8, "it falls");

    // A cube on the last piece: its weight acts 1.7 m from the root.
    let density = 3000.0;
    let weight = BodyDesc {
        position: [1.9, 2.3, 0.1],
        density,
        restitution: 0.0,
        ..BodyDesc::new("weight", ShapeDesc::Box { size: [0.2; 3], resolution: NONE })
    };
    let loaded = AT_ROOT + density * 9.81 * 0.008 * 1.7 / (0.008 / 6.0);
    let mut holds = world([cantilever(1.2 * loaded), weight.clone()]);
    assert!(run(&mut holds, 60).is_empty());
    let mut breaks = world([cantilever(0.8 * loaded), weight]);
    assert!(0.8 * loaded > AT_ROOT && !run(&mut breaks, 60).is_empty());
}

/// A brick of glued pieces that falls from low down comes to rest whole; from high up it breaks,
/// and no sum changes by that.
#[test]
fn a_fall_breaks_bonds_if_it_is_high() {
    let brick = |height: f64| BodyDesc {
        position: [0.0, 0.3 + height, 0.0],
        restitution: 0.1,
        angular_velocity: [0.3, 0.5, -0.4],
        linear_velocity: [1.0, 0.0, 0.5],
        bonds: Some(BondsDesc {
            pattern: Some(PatternDesc::Voronoi(Voronoi { cells: 30, ..Voronoi::default() })),
            shear_strength: 2e7,
            ..bonds(2e7)
        }),
        ..BodyDesc::new("brick", ShapeDesc::Box { size: [1.0, 0.6, 0.8], resolution: NONE })
    };
    let mut low = world([brick(0.01)]);
    assert!(run(&mut low, 90).is_empty());
    let mut high = world([brick(8.0)]);
    let fractures = run(&mut high, 90);
    assert!(!fractures.is_empty());
    for fracture in &fractures {
        let off = fracture.imbalance;
        let worst = off.mass.max(off.momentum).max(off.angular_momentum).max(off.kinetic_energy);
        assert!(worst < 1e-10, "{off:?}");
        assert!(fracture.borne <= fracture.impulse);
    }
    let mass: f64 = high.bodies().masses.iter().filter(|mass| mass.is_finite()).sum();
    assert!((mass / (2400.0 * 0.48) - 1.0).abs() < 1e-10);
}

/// Without gravity nothing loads a body between blows: glue that bore the blow holds on.
#[test]
fn glue_without_a_load_holds() {
    let part = |n: usize| PartDesc::Box {
        size: [0.25; 3],
        position: std::array::from_fn(|axis| 0.25 * (n >> axis & 1) as f64),
        orientation: [0.0, 0.0, 0.0, 1.0],
    };
    let shape = ShapeDesc::Compound { parts: (0..8).map(part).collect(), resolution: NONE };
    for rate in [30.0, 240.0] {
        let mut scene = SceneDesc::new("space");
        (scene.gravity, scene.frames_per_second) = ([0.0; 3], rate);
        let body = BodyDesc {
            position: [0.0, 1.0, 0.0],
            linear_velocity: [0.0, -10.0, 0.0],
            bonds: Some(bonds(1e9)),
            ..BodyDesc::new("cubes", shape.clone())
        };
        scene.bodies = vec![BodyDesc::ground(0.0), body];
        let mut world = World::build(&scene).unwrap();
        assert!(run(&mut world, rate as u32).is_empty(), "{rate} Hz");
    }
}

/// A ball that strikes an anchored wall of pieces knocks some out, and the rest stands.
#[test]
fn an_anchored_wall_loses_what_is_struck() {
    let wall = BodyDesc {
        position: [0.0, 1.0, 0.0],
        bonds: Some(BondsDesc {
            pattern: Some(PatternDesc::Voronoi(Voronoi { cells: 150, ..Voronoi::default() })),
            shear_strength: 1e6,
            anchors: vec![AnchorDesc { low: [-1.0, 0.0, -3.0], high: [1.0, 0.5, 3.0] }],
            ..bonds(1e6)
        }),
        ..BodyDesc::new("wall", ShapeDesc::Box { size: [0.3, 2.0, 3.0], resolution: NONE })
    };
    let ball = BodyDesc {
        position: [-2.0, 1.4, 0.1],
        linear_velocity: [15.0, 0.0, 0.0],
        density: 7850.0,
        ..BodyDesc::new("ball", ShapeDesc::Sphere { radius: 0.2, resolution: NONE })
    };
    let mut world = world([wall, ball]);
    let fractures = run(&mut world, 60);
    assert!(!fractures.is_empty());
    let (bodies, labels) = (world.bodies(), world.labels());
    let is_wall = |i: &usize| labels[*i].name.starts_with("wall");
    let stands: Vec<usize> =
        (0..bodies.len()).filter(is_wall).filter(|&i| bodies.inertias[i].is_infinite()).collect();
    let volume: f64 = (0..bodies.len()).filter(is_wall).map(|i| bodies.shapes[i].volume).sum();
    assert!((volume / 1.8 - 1.0).abs() < 1e-9, "{volume}");
    let standing: f64 = stands.iter().map(|&i| bodies.shapes[i].volume).sum();
    assert!(standing > 0.4 && standing < 1.79, "{standing} m^3 of 1.8 stand");
}

/// A column of twelve pieces that leans and falls over breaks into as many at all frame rates.
#[test]
fn a_column_that_falls_over_breaks_the_same_at_all_rates() {
    let (width, piece, lean) = (0.4_f64, 0.25, 12_f64.to_radians());
    let part = |n: usize| PartDesc::Box {
        size: [width, piece, width],
        position: [0.0, piece * (n as f64 - 5.5), 0.0],
        orientation: [0.0, 0.0, 0.0, 1.0],
    };
    let pieces = |strength: f64, rate: f64| {
        let column = BodyDesc {
            position: [0.0, 1.5 * lean.cos() + 0.5 * width * lean.sin(), 0.0],
            orientation: [0.0, 0.0, -(0.5 * lean).sin(), (0.5 * lean).cos()],
            friction: 0.6,
            restitution: 0.1,
            bonds: Some(BondsDesc { shear_strength: strength, ..bonds(strength) }),
            ..BodyDesc::new(
                "column",
                ShapeDesc::Compound { parts: (0..12).map(part).collect(), resolution: NONE },
            )
        };
        let mut scene = SceneDesc::new("bonds");
        scene.frames_per_second = rate;
        scene.bodies.extend([BodyDesc { friction: 0.6, ..BodyDesc::ground(0.0) }, column]);
        let mut world = World::build(&scene).unwrap();
        run(&mut world, (2.5 * rate) as u32);
        world.bodies().len() - 1
    };
    for strength in [1e6, 3e6] {
        let counts = [24.0, 60.0, 240.0, 1000.0].map(|rate| pieces(strength, rate));
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(*least > 2 && *most as f64 <= 1.2 * *least as f64, "{strength} Pa: {counts:?}");
    }
}

/// User errors are reported with their place and the rule.
#[test]
fn wrong_bonds_are_explained() {
    let error = |body: BodyDesc| {
        let mut scene = SceneDesc::new("wrong");
        scene.bodies.push(body);
        World::build(&scene).unwrap_err().to_string()
    };
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mesh = BodyDesc {
        bonds: Some(bonds(1e6)),
        ..BodyDesc::new(
            "mesh",
            ShapeDesc::Triangles {
                positions,
                triangles,
                thickness: None,
                sides: None,
                resolution: NONE,
            },
        )
    };
    assert!(error(mesh).starts_with("bodies[0].bonds: "));
    let mut beam = cantilever(1e6);
    beam.bonds.as_mut().unwrap().anchors[0].high = [-5.0; 3];
    assert!(error(beam).starts_with("bodies[0].bonds.anchors: "));
    let mut beam = cantilever(1e6);
    beam.bonds.as_mut().unwrap().tensile_strength = 0.0;
    assert!(error(beam).starts_with("bodies[0].bonds.tensile_strength: 0"));
}
