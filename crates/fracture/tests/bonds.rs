//! Strength of glue between pieces, against beam formulas.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible_fracture::{BondStrength, Glued, PointLoad};
use frangible_geometry::Hull;
use frangible_math::RigidTransform;
use glam::{DQuat, DVec3};

const GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);
const DENSITY: f64 = 2400.0;

fn cuboid(low: DVec3, high: DVec3) -> Hull {
    Hull::cuboid(0.5 * (high - low))
        .transformed(&RigidTransform::new(DQuat::IDENTITY, 0.5 * (low + high)))
}

/// Cubes of edge `edge` [m] in a row along an axis, the first from the origin on.
fn row(count: usize, edge: f64, axis: DVec3) -> Vec<Hull> {
    let low = |n: usize| n as f64 * edge * axis;
    (0..count).map(|n| cuboid(low(n), low(n) + edge)).collect()
}

fn glued(hulls: Vec<Hull>, anchored: impl Fn(DVec3) -> bool, tension: f64, shear: f64) -> Glued {
    Glued::new(hulls.into(), anchored, BondStrength { tension, shear })
}

/// A beam of square section out of a wall: sigma = M c / I at the root, by its weight and by a load
/// on its end.
#[test]
fn a_cantilever_breaks_at_its_root_when_the_formula_says_so() {
    let (count, edge) = (10, 0.2);
    let wall = |center: DVec3| center.x < edge;
    // Of the part beyond the root, whose face is that of the anchored cube.
    let length = (count - 1) as f64 * edge;
    let section_modulus = edge * edge * edge / 6.0;
    let weight_moment = DENSITY * 9.81 * edge * edge * length * length / 2.0;
    let root_of_weight = weight_moment / section_modulus;
    for (force, expected) in
        [(0.0, root_of_weight), (5e3, root_of_weight + 5e3 * length / section_modulus)]
    {
        let tip = DVec3::new(edge * count as f64, 0.5 * edge, 0.5 * edge);
        let loads = [PointLoad { point: tip, force: DVec3::new(0.0, -force, 0.0) }];
        let mut beam = glued(row(count, edge, DVec3::X), wall, 1.0, 1e12);
        let strains = beam.strains(&loads, GRAVITY, DENSITY);
        let worst = (0..strains.len()).max_by(|&a, &b| strains[a].total_cmp(&strains[b])).unwrap();
        assert_eq!((beam.bonds()[worst].a, beam.bonds()[worst].b), (0, 1));
        assert!(
            (strains[worst] / expected - 1.0).abs() < 1e-3,
            "{} Pa, not {expected}",
            strains[worst]
        );

        // With slightly more strength it holds; with slightly less it breaks there, and nowhere
        // else.
        let mut strong = glued(row(count, edge, DVec3::X), wall, 1.05 * expected, 1e12);
        assert!(strong.give_way(&loads, GRAVITY, DENSITY).broken.is_empty());
        let mut weak = glued(row(count, edge, DVec3::X), wall, 0.95 * expected, 1e12);
        let broken = weak.give_way(&loads, GRAVITY, DENSITY).broken;
        assert_eq!(broken.len(), 1, "{broken:?}");
        let islands = weak.islands();
        assert_eq!(islands.iter().map(|island| island.hulls().len()).collect::<Vec<_>>(), [1, 9]);
        assert!(islands[0].is_anchored() && !islands[1].is_anchored());
    }
}

/// A hanging chain breaks at its top, where it carries all; standing, it is pressed, and nothing
/// breaks.
#[test]
fn a_hanging_chain_breaks_at_its_top() {
    let (count, edge) = (8, 0.3);
    let pulls = DENSITY * 9.81 * edge * (count - 1) as f64;
    let top = |center: DVec3| center.y > edge * (count - 1) as f64;
    let mut chain = glued(row(count, edge, DVec3::Y), top, pulls * 0.99, pulls);
    let strains = chain.strains(&[], GRAVITY, DENSITY);
    for (bond, strain) in chain.bonds().iter().zip(&strains) {
        let expected = DENSITY * 9.81 * edge * bond.b as f64 / (pulls * 0.99);
        assert!((strain / expected - 1.0).abs() < 1e-3, "{bond:?}: {strain}");
    }
    let broken = chain.give_way(&[], GRAVITY, DENSITY).broken;
    assert_eq!(
        broken.iter().map(|bond| (bond.a, bond.b)).collect::<Vec<_>>(),
        [(count - 2, count - 1)]
    );

    let mut tower = glued(row(count, edge, DVec3::Y), |center| center.y < edge, 1.0, 1.0);
    assert!(tower.give_way(&[], GRAVITY, DENSITY).broken.is_empty());
}

/// A free body feels no field, and a push on its end only where it must pass it on: the force falls
/// linearly along the row.
#[test]
fn inertia_balances_what_nothing_holds() {
    let (count, edge) = (5, 0.5);
    let mut free = glued(row(count, edge, DVec3::X), |_| false, 1.0, 1.0);
    assert!(free.strains(&[], GRAVITY, DENSITY).iter().all(|strain| strain.abs() < 1e-6));
    let pull = 1e3;
    let point = DVec3::new(edge * count as f64, 0.5 * edge, 0.5 * edge);
    let loads = [PointLoad { point, force: DVec3::new(pull, 0.0, 0.0) }];
    let strains = free.strains(&loads, DVec3::ZERO, DENSITY);
    for (bond, strain) in free.bonds().iter().zip(strains) {
        let expected = pull * bond.b as f64 / count as f64 / (edge * edge);
        assert!((strain / expected - 1.0).abs() < 1e-3, "{bond:?}: {strain}, not {expected}");
    }
}

/// A table on four legs that stand fast: each leg carries a quarter; overloaded on one side the top
/// comes off there first.
#[test]
fn a_table_stands_on_its_legs() {
    let leg = |x: f64, z: f64| cuboid(DVec3::new(x, 0.0, z), DVec3::new(x + 0.2, 1.0, z + 0.2));
    let top = cuboid(DVec3::new(0.0, 1.0, 0.0), DVec3::new(2.0, 1.2, 1.0));
    let hulls = vec![top, leg(0.0, 0.0), leg(1.8, 0.0), leg(0.0, 0.8), leg(1.8, 0.8)];
    let on_ground = |center: DVec3| center.y < 0.6;
    let mut table = glued(hulls.clone(), on_ground, 1e5, 1e5);
    assert_eq!(table.bonds().len(), 4);
    let strains = table.strains(&[], GRAVITY, DENSITY);
    assert!(strains.iter().all(|strain| (strain / strains[0] - 1.0).abs() < 1e-3 && *strain < 1.0));
    // A pull upwards on the end of the top opens the two legs there.
    let loads = [PointLoad { point: DVec3::new(2.0, 1.2, 0.5), force: DVec3::new(0.0, 3e4, 0.0) }];
    let strains = table.strains(&loads, GRAVITY, DENSITY);
    let far = strains[1].min(strains[3]);
    assert!(far > strains[0].max(strains[2]) && far > 1.0, "{strains:?}");
    let broken = table.give_way(&loads, GRAVITY, DENSITY).broken;
    assert!([2, 4].iter().all(|leg| broken.iter().any(|bond| bond.b == *leg)), "{broken:?}");
}
