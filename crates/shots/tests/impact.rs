//! Any mesh breaks where the ball hits it: the Stanford bunny, and a mesh with holes.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

mod common;

use common::bunny;
use frangible::geometry::TriMesh;
use frangible::{World, step};
use frangible_shots::{Shot, ShotError, ShotOptions};
use std::fs;
use std::path::PathBuf;

fn breaks_well(mesh: PathBuf) {
    let options = ShotOptions { mesh: Some(mesh), ..ShotOptions::default() };
    let mut world = World::build(&Shot::find("impact").unwrap().scene(&options).unwrap()).unwrap();
    let mut fractures = Vec::new();
    let mut first_mass = None;
    for _ in 0..45 {
        let report = step(&mut world);
        let mass = *first_mass.get_or_insert(report.mass);
        assert!((report.mass - mass).abs() < 1e-9 * mass);
        assert!(report.momentum.linear_error < 1e-9 && report.momentum.angular_error < 1e-9);
        assert!(report.energy.gain < 1e-9 * report.energy.kinetic, "{} J", report.energy.gain);
        assert!(report.quarantined.is_empty());
        fractures.extend(report.fractures);
    }
    assert_eq!(fractures.len(), 1, "the mesh breaks once");
    let fracture = &fractures[0];
    assert!(fracture.fragments.len() >= 10, "{} pieces", fracture.fragments.len());
    assert!(fracture.imbalance.momentum < 1e-9 && fracture.imbalance.angular_momentum < 1e-9);
    assert!(fracture.imbalance.mass < 1e-9 && fracture.imbalance.kinetic_energy < 1e-9);
    assert!(fracture.point[0] > 0.0, "struck on the side that the ball came from");

    // Nothing vanishes: every piece is there, near where it began, and above the ground.
    assert_eq!(world.bodies().len(), 2 + fracture.fragments.len());
    assert!(
        world.bodies().poses[1..]
            .iter()
            .all(|pose| pose.position.y > -0.05 && pose.position.length() < 50.0)
    );
}

#[test]
fn the_bunny_breaks() {
    let folder = tempfile::tempdir().unwrap();
    breaks_well(bunny(folder.path(), |_| false));
}

#[test]
fn a_bunny_with_holes_breaks_too() {
    let folder = tempfile::tempdir().unwrap();
    breaks_well(bunny(folder.path(), |triangle| triangle % 50 == 0));
}

/// A low, light mesh breaks as well, and the ball flies above the ground.
#[test]
fn a_plank_breaks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plank.obj");
    let corners = (0..8).map(|n| {
        format!("v {} {} {}\n", 2 * (n & 1), 0.2 * f64::from(n >> 1 & 1), 0.5 * f64::from(n >> 2))
    });
    let faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
    let text: String = corners.chain(faces.map(|face| format!("f {face}\n"))).collect();
    fs::write(&path, text).unwrap();
    let scene = Shot::find("impact").unwrap();
    let scene = scene.scene(&ShotOptions { mesh: Some(path), ..ShotOptions::default() }).unwrap();
    let mut world = World::build(&scene).unwrap();
    assert!(world.bodies().poses[2].position.y >= 0.25);
    let broke = (0..30).map(|_| step(&mut world).fractures.len()).sum::<usize>();
    assert_eq!(broke, 1);
}

/// The surfaces of the pieces are closed, and together enclose the bunny's volume.
#[test]
fn pieces_have_closed_surfaces_that_enclose_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = Some(bunny(folder.path(), |_| false));
    let scene = Shot::find("impact")
        .unwrap()
        .scene(&ShotOptions { mesh, ..ShotOptions::default() })
        .unwrap();
    let mut world = World::build(&scene).unwrap();
    let whole = world.bodies().shapes[1].volume;
    while world.bodies().len() == 3 {
        step(&mut world);
    }
    let mut sum = 0.0;
    for (index, label) in
        world.labels().iter().enumerate().filter(|(_, label)| label.parent.is_some())
    {
        let surface = world.surface(world.bodies().ids[index]).unwrap();
        assert!(is_closed(&surface.mesh), "{} is open", label.name);
        assert!(surface.interior.contains(&true), "{} has inner faces", label.name);
        sum += surface.mesh.mass_properties().volume;
    }
    assert!((sum - whole).abs() < 0.02 * whole, "{sum} m^3 of {whole}");
}

/// True if every directed edge has its opposite.
fn is_closed(mesh: &TriMesh) -> bool {
    let directed = |triangle: &[u32; 3]| {
        let [a, b, c] = *triangle;
        [(a, b), (b, c), (c, a)]
    };
    let mut edges: Vec<(u32, u32)> = mesh.triangles.iter().flat_map(directed).collect();
    let mut opposites: Vec<(u32, u32)> = edges.iter().map(|&(a, b)| (b, a)).collect();
    edges.sort_unstable();
    opposites.sort_unstable();
    edges == opposites
}

#[test]
fn what_cannot_be_run_says_why() {
    let error = Shot::find("wall-e").unwrap_err();
    assert_eq!(
        error.to_string(),
        "unknown shot 'wall-e', must be one of: wall, wall-middle, wall-corner, wall-ball, wall-natural, cylinder, \
         bunny, refracture, rain-25, rain-100, rain-1000, pane, masonry, timber, concrete, impact, pillar, \
         bonded-pillar, plank, stack, incline, pile-spread, pile-deep, pile-table, bricks, \
         bricks-still, tower, pyramid, load, arch, slab, debris, plate, nut, cradle, card-house (did you mean 'wall'?)"
    );
    let impact = Shot::find("impact").unwrap();
    assert!(matches!(impact.scene(&ShotOptions::default()), Err(ShotError::NeedsMesh("impact"))));
    let mesh = Some(PathBuf::from("nowhere.obj"));
    let error =
        impact.scene(&ShotOptions { mesh: mesh.clone(), ..ShotOptions::default() }).unwrap_err();
    assert!(error.to_string().starts_with("nowhere.obj: "), "{error}");
    let error = Shot::find("wall")
        .unwrap()
        .scene(&ShotOptions { mesh, ..ShotOptions::default() })
        .unwrap_err();
    assert!(matches!(error, ShotError::TakesNoMesh(_)), "{error}");
}
