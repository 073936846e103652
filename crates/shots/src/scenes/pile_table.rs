//! A table under a load of balls, all of them broken before they fall: nine thousand pieces that
//! fit, and no two alike.

use crate::random::Random;
use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::geometry::{HalfSpace, Hull, PlaneClipper};
use frangible::{BodyDesc, Resolution, SceneDesc, ShapeDesc};
use glam::DVec3;

/// Scene for comparisons of engines.
pub(crate) const TABLE: Shot = Shot {
    name: "pile-table",
    caption: "a table of 992 pieces and 1000 balls of 8 pieces each fall into a heap",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: pile_table,
};

/// Half of the table's edge lengths [m].
const HALF: DVec3 = DVec3::new(7.5, 0.5, 5.0);

/// Drop height [m].
const DROP: f64 = 1.0;

/// Number of cells of the table.
const TABLE_CELLS: usize = 992;

/// Of the balls [m].
const RADIUS: f64 = 0.335;

/// Over the table, and each of them broken into.
const BALLS: usize = 1000;
const BALL_CELLS: usize = 8;

/// From the middle of a ball to the points of its cells, at most and from each other at least [m].
const REACH: f64 = 0.25;
const SPACED: f64 = 0.12;

/// Balls beside each other along x and z, and from middle to middle along the axes [m]: they do not
/// touch.
const ABREAST: [usize; 2] = [20, 13];
const APART: DVec3 = DVec3::new(0.75, 0.72, 0.77);

/// [kg/m^3]
const DENSITY: f64 = 1000.0;

/// Between the table and the lowest of them [m].
const GAP: f64 = 0.01;

fn pile_table(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let mut scene = SceneDesc::new("");
    scene.bodies.push(BodyDesc { restitution: 0.0, ..BodyDesc::ground(0.0) });

    let mut random = Random::new(options.seed);
    let points: Vec<DVec3> = (0..TABLE_CELLS).map(|_| HALF * in_cube(&mut random)).collect();
    let table = cells(&Hull::cuboid(HALF), &points);
    scene
        .bodies
        .extend(table.iter().map(|cell| piece("table", cell, DVec3::new(0.0, DROP + HALF.y, 0.0))));

    // The balls, in layers.
    let ball = Hull::ball(RADIUS);
    let bottom = DROP + 2.0 * HALF.y + GAP - ball.bounds().0.y;
    for number in 0..BALLS {
        let [abreast, deep] = ABREAST;
        let [i, k, j] = [number % abreast, number / abreast % deep, number / (abreast * deep)];
        let place = DVec3::new(along(i, abreast), j as f64, along(k, deep));
        let middle = APART * place + bottom * DVec3::Y;
        scene.bodies.extend(
            cells(&ball, &points_in_ball(&mut random))
                .iter()
                .map(|cell| piece("ball", cell, middle)),
        );
    }
    Ok(scene)
}

/// The place in a row around the origin, in steps.
fn along(place: usize, count: usize) -> f64 {
    place as f64 - 0.5 * (count as f64 - 1.0)
}

/// Uniform in the cube from -1 to 1.
fn in_cube(random: &mut Random) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| random.between(-1.0, 1.0)))
}

fn points_in_ball(random: &mut Random) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = Vec::with_capacity(BALL_CELLS);
    while points.len() < BALL_CELLS {
        let point = REACH * in_cube(random);
        let is_apart = |other: &DVec3| point.distance_squared(*other) > SPACED * SPACED;
        if point.length_squared() < REACH * REACH && points.iter().all(is_apart) {
            points.push(point);
        }
    }
    points
}

/// Voronoi cells of points in a hull.
fn cells(hull: &Hull, points: &[DVec3]) -> Vec<Hull> {
    let between = |here: DVec3, there: DVec3| {
        let normal = (there - here).normalize();
        HalfSpace { normal, offset: 0.5 * normal.dot(here + there) }
    };
    let mut clipper = PlaneClipper::default();
    let mut cell = |&here: &DVec3| {
        let others = points.iter().filter(|&&other| other != here);
        let cuts: Vec<HalfSpace> = others.map(|&there| between(here, there)).collect();
        clipper.clipped(hull, &cuts)
    };
    points.iter().filter_map(&mut cell).collect()
}

fn piece(name: &str, hull: &Hull, position: DVec3) -> BodyDesc {
    let points = hull.vertices().iter().map(DVec3::to_array).collect();
    BodyDesc {
        position: position.to_array(),
        density: DENSITY,
        friction: 0.5,
        restitution: 0.0,
        ..BodyDesc::new(name, ShapeDesc::Hull { points, resolution: Resolution::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible::World;

    #[test]
    fn the_pieces_fill_the_table_and_the_balls() {
        let scene = pile_table(&ShotOptions::default()).unwrap();
        let count = |name: &str| scene.bodies.iter().filter(|body| body.name == name).count();
        assert_eq!([count("table"), count("ball")], [TABLE_CELLS, BALLS * BALL_CELLS]);
        let whole = 8.0 * HALF.element_product() + BALLS as f64 * Hull::ball(RADIUS).volume();
        let world = World::build(&scene).unwrap();
        let mass: f64 = world.bodies().masses.iter().filter(|mass| mass.is_finite()).sum();
        assert!((mass / (DENSITY * whole) - 1.0).abs() < 1e-9, "{mass} kg in {whole} m^3");
    }
}
