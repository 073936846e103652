use super::cell_tree::Cell;
use super::convex_parts::PlaneSearch;
use super::*;
use crate::hull::Hull;
use proptest::prelude::*;

/// A cube of two metres with a cubic cavity of one.
fn hollow_cube() -> Solid {
    let cube = |half: f64| Hull::cuboid(DVec3::splat(half)).surface();
    let (outer, mut inner) = (cube(1.0), cube(0.5));
    inner.flip();
    let first = outer.positions.len() as u32;
    let mut mesh = outer;
    mesh.positions.extend(inner.positions);
    mesh.triangles.extend(inner.triangles.iter().map(|corners| corners.map(|at| at + first)));
    Solid::of_mesh(&mesh).unwrap()
}

fn plane(normal: DVec3, offset: f64) -> HalfSpace {
    HalfSpace { normal: normal.normalize(), offset }
}

/// An L of three unit cubes, whose step lies in the plane x = 0.
fn step() -> Solid {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 0.0), (0.0, 0.0), (0.0, 1.0), (-1.0, 1.0)];
    let place = |z: f64| corners.map(|(x, y)| DVec3::new(x, y, z));
    let positions = [place(0.0), place(1.0)].concat();
    let lid = [[0, 1, 2], [0, 2, 3], [0, 3, 5], [3, 4, 5]];
    let mut triangles: Vec<[u32; 3]> = lid.map(|[a, b, c]| [a + 6, b + 6, c + 6]).to_vec();
    triangles.extend(lid.map(|[a, b, c]| [a, c, b]));
    for a in 0..6 {
        let b = (a + 1) % 6;
        triangles.extend([[a, b, b + 6], [a, b + 6, a + 6]]);
    }
    Solid::of_mesh(&TriMesh { positions, triangles }).unwrap()
}

#[test]
fn a_cavity_is_cut_with_its_solid() {
    let solid = hollow_cube();
    assert!((solid.mass_properties().volume - 7.0).abs() < 1e-12);
    // Through the cavity, the section is a square with a hole.
    let parts = solid.inside_of(&[plane(DVec3::X, 0.25)]);
    assert_eq!(parts.len(), 1);
    assert!((parts[0].mass.volume - (5.0 - 0.75)).abs() < 1e-12);
    let (mesh, _) = parts[0].solid.triangles();
    assert!(mesh.is_watertight());
    assert!((mesh.mass_properties().volume - 4.25).abs() < 1e-12);
    // Beside it, the cavity stays with the larger part.
    let parts = solid.inside_of(&[plane(DVec3::X, 0.75)]);
    assert_eq!(parts.len(), 1);
    assert!((parts[0].mass.volume - 6.0).abs() < 1e-12);
    assert!(parts[0].solid.triangles().0.is_watertight());
}

#[test]
fn a_plane_through_faces_and_edges_leaves_no_fins() {
    let solid = step();
    let volume = |plane: HalfSpace| -> f64 {
        let parts = solid.inside_of(&[plane]);
        assert_eq!(parts.len(), 1);
        let (mesh, _) = parts[0].solid.triangles();
        assert!(mesh.is_watertight());
        // Nothing stands out where the step was.
        let (low, high) = parts[0].solid.bounds();
        let hull = Hull::of_points(parts[0].solid.vertices()).unwrap();
        assert!(((high - low).element_product() - hull.volume()).abs() < 1e-9);
        parts[0].mass.volume
    };
    assert!((volume(plane(DVec3::X, 0.0)) - 2.0).abs() < 1e-12);
    assert!((volume(plane(-DVec3::X, 0.0)) - 1.0).abs() < 1e-12);
    assert!((volume(plane(DVec3::Y, 0.0)) - 2.0).abs() < 1e-12);
    assert!((volume(plane(-DVec3::Y, 0.0)) - 1.0).abs() < 1e-12);
    // The step's own face is no crack.
    let part = &solid.inside_of(&[plane(DVec3::X, 0.0)])[0].solid;
    let cracks = part.faces().iter().filter(|face| face.origin == FaceOrigin::Crack);
    assert_eq!(cracks.count(), 1);
}

#[test]
fn arms_that_a_cut_parts_are_parts() {
    let arms = step().inside_of(&[plane(DVec3::new(-1.0, -1.0, 0.0), -0.25)]);
    assert_eq!(arms.len(), 2);
    assert!((arms[0].mass.volume - arms[1].mass.volume).abs() < 1e-12);
    assert!(arms.iter().all(|arm| arm.solid.triangles().0.is_watertight()));
}

/// A cube of two metres with an octahedral cavity, whose corners are half a metre from its middle.
fn cube_around_an_octahedron() -> Solid {
    let corners = DVec3::AXES.map(|axis| [0.5 * axis, -0.5 * axis]).concat();
    let mut inner = Hull::of_points(&corners).unwrap().surface();
    inner.flip();
    let mut mesh = inner;
    let first = mesh.positions.len() as u32;
    let outer = Hull::cuboid(DVec3::ONE).surface();
    mesh.positions.extend(outer.positions);
    mesh.triangles.extend(outer.triangles.iter().map(|corners| corners.map(|at| at + first)));
    Solid::of_mesh(&mesh).unwrap()
}

#[test]
fn a_cavity_that_touches_a_cut_stays() {
    let cavity = 4.0 / 3.0 * 0.125;
    let parts = cube_around_an_octahedron().inside_of(&[plane(DVec3::X, 0.5)]);
    assert_eq!(parts.len(), 1);
    assert!((parts[0].mass.volume - (6.0 - cavity)).abs() < 1e-12);
    // Its section touches the second cut.
    for turned in [1.0, -1.0] {
        let planes = [plane(DVec3::Z * turned, 0.0), plane(DVec3::X * turned, 0.5)];
        let parts = cube_around_an_octahedron().inside_of(&planes);
        assert_eq!(parts.len(), 1);
        assert!((parts[0].mass.volume - 0.5 * (6.0 - cavity)).abs() < 1e-12);
        let (mesh, of_face) = parts[0].solid.triangles();
        assert!(mesh.is_watertight());
        for (triangle, &face) in of_face.iter().enumerate() {
            let normal = parts[0].solid.faces()[face as usize].plane.normal;
            assert!(mesh.vector_area(triangle).dot(normal) > -1e-12);
        }
    }
}

#[test]
fn halves_are_joined_without_a_crack() {
    let solid = hollow_cube();
    let [below, above] = [1.0, -1.0].map(|side| {
        let mut parts = solid.inside_of(&[plane(side * DVec3::X, side * 0.25)]);
        parts.remove(0).solid
    });
    let joined = below.joined(&above, 1e-9).unwrap();
    assert!(joined.faces().iter().all(|face| face.origin != FaceOrigin::Crack));
    assert!((joined.mass_properties().volume - 7.0).abs() < 1e-12);
    assert!(joined.triangles().0.is_watertight());
    // Beyond a gap there is nothing to join.
    let apart = solid.inside_of(&[plane(-DVec3::X, -0.5)]).remove(0).solid;
    assert!(below.joined(&apart, 1e-9).is_none());
}

/// Two bricks on a third one, whose sides cross.
#[test]
fn what_a_crack_has_beyond_the_other_stays() {
    let cuboid = Solid::of_mesh(&Hull::cuboid(DVec3::ONE).surface()).unwrap();
    let part = |planes: &[HalfSpace]| cuboid.inside_of(planes).remove(0).solid;
    let below = part(&[plane(DVec3::Z, 0.0), plane(DVec3::X, 0.5)]);
    let above = part(&[plane(-DVec3::Z, 0.0), plane(DVec3::Y, 0.25), plane(-DVec3::X, 0.5)]);
    let joined = below.joined(&above, 1e-9).unwrap();
    assert!((joined.mass_properties().volume - (1.5 * 2.0 + 1.25 * 1.5)).abs() < 1e-12);
    let (mesh, of_face) = joined.triangles();
    assert!(mesh.is_watertight());
    // Of the cracks at z = 0, the lower one has 1.75 beyond the upper one, and that one 0.625.
    let open: Vec<f64> = [1.0, -1.0]
        .map(|up| {
            let is_level = |&triangle: &usize| {
                joined.faces()[of_face[triangle] as usize].plane == plane(up * DVec3::Z, 0.0)
            };
            let areas = (0..of_face.len()).filter(is_level);
            areas.map(|triangle| up * mesh.vector_area(triangle).z).sum()
        })
        .to_vec();
    assert!((open[0] - 1.75).abs() < 1e-12 && (open[1] - 0.625).abs() < 1e-12, "{open:?}");
}

#[test]
fn a_step_is_two_convex_parts() {
    let parts = step().convex_parts(12, 0.1, PlaneSearch::Thorough);
    assert_eq!(parts.len(), 2);
    let hulls = parts.iter().map(|part| Hull::of_points(part.solid.vertices()).unwrap().volume());
    assert!((hulls.sum::<f64>() - 3.0).abs() < 1e-9);
    assert_eq!(step().convex_parts(12, 0.2, PlaneSearch::Quick).len(), 1);
    assert_eq!(hollow_cube().convex_parts(1, 0.0, PlaneSearch::Quick).len(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Cells between random planes, and through vertices, edges and faces, fill the solid; each
    /// part is closed, and its triangles enclose what its edges say.
    #[test]
    fn cells_fill_the_solid(
        cuts in prop::collection::vec((prop::array::uniform3(-2..3i32), -2..3i32), 1..5),
        shifts in prop::collection::vec(prop_oneof![Just(0.0), -0.3..0.3f64], 5),
        is_hollow in any::<bool>(),
    ) {
        let solid = if is_hollow { hollow_cube() } else { step() };
        let planes: Vec<HalfSpace> = cuts
            .iter()
            .zip(&shifts)
            .filter(|((normal, _), _)| *normal != [0; 3])
            .map(|((normal, offset), shift)| {
                let normal = DVec3::from_array(normal.map(f64::from));
                plane(normal, 0.25 * f64::from(*offset) + shift)
            })
            .collect();
        let cells: Vec<Cell> = (0..1 << planes.len())
            .map(|bits: usize| {
                let side = |(at, plane): (usize, &HalfSpace)| {
                    if bits >> at & 1 == 1 { plane.flipped() } else { *plane }
                };
                let planes = planes.iter().enumerate().map(side).collect();
                Cell { planes, bounds: solid.bounds() }
            })
            .collect();
        let parts = solid.cut(&cells);
        let volume = solid.mass_properties().volume;
        let sum: f64 = parts.iter().map(|(_, part)| part.mass.volume).sum();
        prop_assert!((sum / volume - 1.0).abs() < 1e-11, "{}", sum / volume - 1.0);
        for (cell, part) in &parts {
            prop_assert!(part.solid.is_closed());
            let (mesh, _) = part.solid.triangles();
            prop_assert!(mesh.is_watertight());
            let of_mesh = mesh.mass_properties();
            prop_assert!((of_mesh.volume - part.mass.volume).abs() < 1e-11 * volume);
            prop_assert!(of_mesh.center.abs_diff_eq(part.mass.center, 1e-6));
            for plane in &cells[*cell].planes {
                for &vertex in part.solid.vertices() {
                    prop_assert!(plane.distance(vertex) < 1e-11);
                }
            }
        }
    }
}
