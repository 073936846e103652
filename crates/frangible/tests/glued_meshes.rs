//! Glue between pieces of meshes, of rough patterns, and of files of pieces.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::{Concrete, Voronoi};
use frangible::{
    BodyDesc, BondsDesc, Fracture, PatternDesc, Resolution, SceneDesc, ShapeDesc, World, step,
};

/// A corner of two walls, seen from above: x and z [m].
const OUTLINE: [[f64; 2]; 6] =
    [[0.0, 0.0], [0.0, 2.0], [0.3, 2.0], [0.3, 0.3], [2.0, 0.3], [2.0, 0.0]];
const HEIGHT: f64 = 1.5;

fn bonds(pattern: Option<PatternDesc>) -> BondsDesc {
    BondsDesc {
        pattern,
        point: None,
        normal: [0.0, 1.0, 0.0],
        tensile_strength: 5e5,
        shear_strength: 5e5,
        anchors: Vec::new(),
        strength_points: Vec::new(),
        strength_triangles: Vec::new(),
    }
}

fn triangles(positions: Vec<[f64; 3]>, quads: &[[u32; 4]]) -> ShapeDesc {
    let halves = |&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]];
    ShapeDesc::Triangles {
        positions,
        triangles: quads.iter().flat_map(halves).collect(),
        thickness: None,
        sides: None,
        resolution: Resolution { voxels: Some([40, 30, 40]), sample_spacing: None },
    }
}

/// The corner as one closed surface.
fn corner() -> ShapeDesc {
    let at = |y: f64| OUTLINE.map(|[x, z]| [x, y, z]);
    let sides = (0..6).map(|n| [n, (n + 1) % 6, (n + 1) % 6 + 6, n + 6].map(|n| n as u32));
    let mut quads: Vec<[u32; 4]> = sides.collect();
    quads.extend([[0, 3, 2, 1], [0, 5, 4, 3], [6, 7, 8, 9], [6, 9, 10, 11]]);
    triangles([at(0.0), at(HEIGHT)].concat(), &quads)
}

/// The corner in blocks that touch: three courses of five along x, and of four along z.
fn blocks() -> ShapeDesc {
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let along_x = (0..5).map(|n| [[0.4 * n as f64, 0.0], [0.4 * (n + 1) as f64, 0.3]]);
    let along_z = (0..4).map(|n| [[0.0, 0.3 + 0.425 * n as f64], [0.3, 0.725 + 0.425 * n as f64]]);
    let mut positions = Vec::new();
    let mut quads = Vec::new();
    for [low, high] in along_x.chain(along_z) {
        for course in 0..3 {
            let [bottom, top] = [0.5 * f64::from(course), 0.5 * f64::from(course + 1)];
            let ends = [[low[0], bottom, low[1]], [high[0], top, high[1]]];
            let first = positions.len() as u32;
            quads.extend(faces.map(|face| face.map(|n: u32| n + first)));
            let corner = |n: usize| std::array::from_fn(|axis| ends[n >> axis & 1][axis]);
            positions.extend((0..8).map(corner));
        }
    }
    triangles(positions, &quads)
}

fn voronoi() -> PatternDesc {
    PatternDesc::Voronoi(Voronoi { cells: 100, ..Voronoi::default() })
}

fn concrete() -> PatternDesc {
    PatternDesc::Concrete(Concrete { cells: 60, ..Concrete::default() })
}

fn body(shape: ShapeDesc, bonds: BondsDesc) -> BodyDesc {
    BodyDesc {
        density: 2000.0,
        friction: 0.7,
        restitution: 0.1,
        bonds: Some(bonds),
        ..BodyDesc::new("glued", shape)
    }
}

/// A steel ball on its way to the wall along x.
fn ball(speed: f64) -> BodyDesc {
    BodyDesc {
        position: [1.2, 0.9, -1.0],
        linear_velocity: [0.0, 0.0, speed],
        density: 7800.0,
        ..BodyDesc::new(
            "ball",
            ShapeDesc::Sphere { radius: 0.1, resolution: Resolution::default() },
        )
    }
}

fn world(bodies: impl IntoIterator<Item = BodyDesc>) -> World {
    let mut scene = SceneDesc::new("glued");
    scene.bodies.push(BodyDesc::ground(0.0));
    scene.bodies.extend(bodies);
    World::build(&scene).unwrap()
}

/// Frames in which the books close and mass stays; what broke.
fn run(world: &mut World, frames: u32) -> Vec<Fracture> {
    let mut fractures = Vec::new();
    for _ in 0..frames {
        let report = step(world);
        assert!(report.energy.gain <= 1e-8, "frame {}: {} J", report.frame, report.energy.gain);
        assert!(report.momentum.linear_error < 1e-9 && report.momentum.angular_error < 1e-9);
        fractures.extend(report.fractures);
    }
    fractures
}

fn masses(world: &World) -> Vec<f64> {
    let mut masses: Vec<f64> =
        world.bodies().masses.iter().copied().filter(|mass| mass.is_finite()).collect();
    masses.sort_by(f64::total_cmp);
    masses
}

/// Glued bodies, each on its foot: a mesh that is not convex, in pieces of a pattern; the same as a
/// mesh of closed parts; a wall in pieces with rough faces.
fn bodies() -> [(&'static str, BodyDesc); 3] {
    let wall = ShapeDesc::Box { size: [2.0, 1.5, 0.3], resolution: Resolution::default() };
    let rough = body(wall, bonds(Some(concrete())));
    [
        ("corner", body(corner(), bonds(Some(voronoi())))),
        ("blocks", body(blocks(), bonds(None))),
        ("rough", BodyDesc { position: [1.0, 0.75, 0.15], ..rough }),
    ]
}

/// What is glued stands for 5 s, and its pieces are all of it.
#[test]
fn glued_meshes_stand() {
    for (what, glued) in bodies() {
        let mut world = world([glued]);
        let [mass] = masses(&world)[..] else { panic!("{what}") };
        let pieces = world.labels()[1].bonds.as_ref().unwrap().glued().pieces().to_vec();
        let sum = 2000.0 * pieces.iter().map(|piece| piece.volume).sum::<f64>();
        assert!(pieces.len() > 2 && (sum / mass - 1.0).abs() < 1e-12, "{what}: {sum} of {mass}");
        let start = world.bodies().poses[1].position;
        assert!(run(&mut world, 150).is_empty(), "{what}");
        let moved = world.bodies().poses[1].position.distance(start);
        assert!(moved < 2e-3, "{what}: {moved} m");
    }
}

/// A ball breaks it where it hits: what is there comes loose, what stands on the ground stays
/// together. Mass, momentum and energy are those of the body; equal worlds have equal bits.
#[test]
fn glued_meshes_break_where_they_are_hit() {
    for (what, glued) in bodies() {
        let both = [(); 2].map(|()| {
            let mut world = world([glued.clone(), ball(20.0)]);
            let mass: f64 = masses(&world).iter().sum();
            let broke = run(&mut world, 30);
            (world, mass, broke)
        });
        let (world, mass, broke) = &both[0];
        assert_eq!(world.state_hash(), both[1].0.state_hash(), "{what}");
        assert!(!broke.is_empty(), "{what}");
        for Fracture { imbalance, .. } in broke {
            let worst = imbalance.mass.max(imbalance.momentum).max(imbalance.angular_momentum);
            assert!(worst.max(imbalance.kinetic_energy) < 1e-11, "{what}: {imbalance:?}");
        }
        let after: f64 = masses(world).iter().sum();
        assert!((after / mass - 1.0).abs() < 1e-12, "{what}");
        // The first blow is the ball's; what stands is most of it, and where it was.
        assert!((broke[0].point[0] - 1.2).abs() < 0.01 && broke[0].point[2].abs() < 0.01, "{what}");
        let bodies = world.bodies();
        let mass = |&i: &usize| if bodies.masses[i].is_finite() { bodies.masses[i] } else { 0.0 };
        let largest = (0..bodies.len()).max_by(|a, b| mass(a).total_cmp(&mass(b))).unwrap();
        assert!(mass(&largest) > 0.25 * after && bodies.poses[largest].position.y > 0.5, "{what}");
    }
}

/// Contacts of closed parts are the faces that they have in common; other areas may be said of
/// pieces in a file.
#[test]
fn contacts_are_of_the_cut() {
    let areas = |shape: ShapeDesc| -> Vec<f64> {
        let world = world([body(shape, bonds(None))]);
        let glued = world.labels()[1].bonds.as_ref().unwrap().glued();
        glued.bonds().iter().map(|bond| bond.area).collect()
    };
    let exact = areas(blocks());
    // Between courses, along the walls, and at the corner.
    let wanted = 10.0 * 0.12 + 8.0 * 0.1275 + 12.0 * 0.15 + 9.0 * 0.15 + 3.0 * 0.15;
    assert_eq!(exact.len(), 42);
    assert!((exact.iter().sum::<f64>() / wanted - 1.0).abs() < 1e-12, "{exact:?}");
}
