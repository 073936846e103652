//! Bodies to break, and blows.
#![allow(dead_code, unreachable_pub, reason = "each test uses some of these")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a panic is how a test fails")]

use frangible_fracture::{Fragment, Impact, Pattern, Radial, Voronoi, fragment_velocity};
use frangible_geometry::{
    ClosedForm, Geometry, Grid, GridSolid, LevelSet, Shape, TriMesh, surface_samples,
};
use glam::{DMat3, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// The solid of a shape on a grid.
pub fn solid(shape: &Shape) -> &GridSolid {
    match &shape.geometry {
        Geometry::Grid(solid) => solid,
        _ => panic!("a formula has no grid"),
    }
}

/// A formula on a grid, with samples two voxels apart.
pub fn sampled_form(form: ClosedForm, voxels: [usize; 3]) -> Shape {
    let solid = GridSolid::from_closed_form(form, voxels, 2).unwrap();
    let spacing = 2.0 * solid.grid().spacing;
    Shape::from_grid_solid(solid, Shape::closed_form(form, spacing).samples().to_vec()).unwrap()
}

/// Any distance on a grid over `low` to `high`, with samples two voxels apart.
pub fn sampled(
    low: DVec3,
    high: DVec3,
    voxels: [usize; 3],
    distance: impl Fn(DVec3) -> f64,
) -> Shape {
    let grid = Grid::around_box(low, high, voxels, 2);
    let solid = GridSolid::from_level_set(LevelSet::sample(grid, distance));
    let samples = surface_samples(&solid, 2.0 * grid.spacing);
    Shape::from_grid_solid(solid, samples).unwrap()
}

/// The vertices of a cell's mesh that lie on no wall of its pattern's box.
pub fn inside_of_box(pattern: &Pattern, mesh: &TriMesh) -> Vec<DVec3> {
    let is_inside = |point: &DVec3| (point.abs() / pattern.half_extent).max_element() < 1.0 - 1e-9;
    mesh.positions.iter().copied().filter(is_inside).collect()
}

/// The paper's wall: 6 x 0.4 x 4 m on 150 x 10 x 100 voxels.
pub fn wall() -> Shape {
    sampled_form(ClosedForm::Box { half: DVec3::new(3.0, 0.2, 2.0) }, [150, 10, 100])
}

/// A box with a sphere taken out of one corner.
pub fn bitten_box() -> Shape {
    let half = DVec3::new(0.5, 0.3, 0.4);
    let form = ClosedForm::Box { half };
    sampled(-half, half, [30, 18, 24], |point| {
        let bite = 0.25 - (point - half).length();
        form.distance_and_gradient(point).0.max(bite)
    })
}

/// Two balls in one grid that do not touch.
pub fn two_balls() -> Shape {
    let ball = |point: DVec3, center: f64| (point - DVec3::X * center).length() - 0.3;
    sampled(DVec3::new(-0.8, -0.3, -0.3), DVec3::new(0.8, 0.3, 0.3), [48, 18, 18], |point| {
        ball(point, -0.45).min(ball(point, 0.45))
    })
}

/// Bodies of all kinds: convex, hollowed, in two parts.
pub fn bodies() -> Vec<(&'static str, Shape)> {
    vec![
        ("sphere", sampled_form(ClosedForm::Sphere { radius: 0.5 }, [28; 3])),
        ("box", sampled_form(ClosedForm::Box { half: DVec3::new(0.5, 0.1, 0.4) }, [40, 8, 32])),
        (
            "cylinder",
            sampled_form(ClosedForm::Cylinder { radius: 0.3, half_height: 0.6 }, [18, 36, 18]),
        ),
        ("bitten box", bitten_box()),
        ("two balls", two_balls()),
    ]
}

/// A unit vector in any direction.
pub fn direction(random: &mut Pcg64Mcg) -> DVec3 {
    loop {
        let point = DVec3::new(random.random(), random.random(), random.random()) * 2.0 - 1.0;
        if point.length() > 0.1 && point.length() < 1.0 {
            return point.normalize();
        }
    }
}

/// A blow on one of a shape's samples, from outside.
pub fn random_impact(shape: &Shape, random: &mut Pcg64Mcg) -> Impact {
    let sample = shape.samples()[random.random_range(0..shape.samples().len())].as_dvec3();
    let (_, gradient) = shape.distance_and_gradient(sample);
    Impact { point_body: sample, normal_body: (gradient + 0.3 * direction(random)).normalize() }
}

/// Patterns of both kinds.
pub fn patterns(seed: u64) -> Vec<Pattern> {
    vec![
        Pattern::radial(&Radial { spokes: 12, rings: 0, jitter: 0.5, seed }).unwrap(),
        Pattern::radial(&Radial { spokes: 7, rings: 3, jitter: 1.0, seed }).unwrap(),
        Pattern::voronoi(&Voronoi { cells: 25, seed, ..Voronoi::default() }).unwrap(),
        Pattern::voronoi(&Voronoi { cells: 40, clustering: 3.0, seed, ..Voronoi::default() })
            .unwrap(),
    ]
}

pub fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// Mass [m^3 at unit density], momentum, angular momentum about the parent's centre of mass,
/// kinetic energy.
#[derive(Debug)]
pub struct Motion {
    pub mass: f64,
    pub momentum: DVec3,
    pub angular_momentum: DVec3,
    pub energy: f64,
}

/// Of a body at `center` [m] that moves with `velocity` and turns with `omega`; all in one frame.
pub fn motion(shape: &Shape, axes: DMat3, center: DVec3, velocity: DVec3, omega: DVec3) -> Motion {
    let spin = axes * (shape.unit_moments * (axes.transpose() * omega));
    let momentum = shape.volume * velocity;
    Motion {
        mass: shape.volume,
        momentum,
        angular_momentum: spin + center.cross(momentum),
        energy: 0.5 * (momentum.dot(velocity) + spin.dot(omega)),
    }
}

/// The largest relative difference between the parent's motion and the sum of its fragments'.
pub fn defect(parent: &Shape, fragments: &[Fragment], random: &mut Pcg64Mcg) -> f64 {
    let (velocity, omega) = (3.0 * direction(random), 5.0 * direction(random));
    let before = motion(parent, DMat3::IDENTITY, DVec3::ZERO, velocity, omega);
    let mut after =
        Motion { mass: 0.0, momentum: DVec3::ZERO, angular_momentum: DVec3::ZERO, energy: 0.0 };
    for fragment in fragments {
        let center = fragment.parent_from_fragment.translation;
        let velocity = fragment_velocity(velocity, omega, DVec3::ZERO, center);
        let part = motion(
            &fragment.shape,
            fragment.parent_from_fragment.matrix(),
            center,
            velocity,
            omega,
        );
        after.mass += part.mass;
        after.momentum += part.momentum;
        after.angular_momentum += part.angular_momentum;
        after.energy += part.energy;
    }
    let radius = (0.5 * (parent.bounds.1 - parent.bounds.0)).length();
    let momentum = before.mass * velocity.length();
    [
        (after.mass - before.mass) / before.mass,
        (after.momentum - before.momentum).length() / momentum,
        (after.angular_momentum - before.angular_momentum).length() / (momentum * radius),
        (after.energy - before.energy) / before.energy,
    ]
    .into_iter()
    .fold(0.0, |worst, defect: f64| worst.max(defect.abs()))
}

/// Each voxel of the parent is in exactly one fragment, with all of its material.
pub fn assert_voxels_shared_out(parent: &Shape, fragments: &[Fragment]) {
    let parent = solid(parent);
    let grid = parent.grid();
    let mut found = vec![0.0f32; grid.len()];
    let mut owners = vec![0; grid.len()];
    for fragment in fragments {
        let solid = solid(&fragment.shape);
        let own = solid.grid();
        assert_eq!(own.spacing, grid.spacing);
        let shift = grid.lattice_from_point(own.origin);
        assert!((shift - shift.round()).length() < 1e-9, "the same lattice");
        for (node, &coverage) in solid.coverage().iter().enumerate() {
            if coverage > 0.0 {
                let [i, j, k] = own.coordinates(node);
                let at = shift.round() + DVec3::new(i as f64, j as f64, k as f64);
                let index = grid.index(at.x as usize, at.y as usize, at.z as usize);
                found[index] += coverage;
                owners[index] += 1;
            }
        }
    }
    assert_eq!(found, parent.coverage(), "coverage is shared out bit by bit");
    assert!(owners.iter().all(|&count| count <= 1), "no voxel twice");
}
