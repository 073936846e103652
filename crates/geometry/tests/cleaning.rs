//! Raw triangles made into solids: each kind of damage, in several sizes, places and orders.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use common::{icosphere, joined, moved, open_box};
use frangible_geometry::{CleanMesh, TriMesh};
use glam::{DQuat, DVec3};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn cube() -> TriMesh {
    open_box(DVec3::ZERO, DVec3::ONE, 0)
}

fn turned_round(mut mesh: TriMesh) -> TriMesh {
    mesh.flip();
    mesh
}

/// Each triangle with vertices of its own, as in an STL file.
fn soup(mesh: &TriMesh) -> TriMesh {
    let corners = mesh.triangles.iter().flatten();
    let positions = corners.map(|&vertex| mesh.positions[vertex as usize]).collect();
    let triangles =
        (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriMesh { positions, triangles }
}

/// Each coordinate moved by up to `size` [m].
fn with_noise(mut mesh: TriMesh, size: f64, seed: u64) -> TriMesh {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    for position in &mut mesh.positions {
        *position += DVec3::from_array(std::array::from_fn(|_| random.random_range(-size..=size)));
    }
    mesh
}

/// The mesh in other sizes and places, turned, and with its triangles in another order.
fn variants(mesh: &TriMesh) -> Vec<(f64, TriMesh)> {
    let turn = DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(-2.1);
    let placed = |scale: f64, way: DVec3, turn: DQuat| {
        let mut mesh = mesh.clone();
        for position in &mut mesh.positions {
            *position = scale * (turn * *position) + way;
        }
        (scale, mesh)
    };
    let mut shuffled = mesh.clone();
    shuffled.triangles.shuffle(&mut Pcg64Mcg::seed_from_u64(3));
    for (n, triangle) in shuffled.triangles.iter_mut().enumerate() {
        triangle.rotate_left(n % 3);
    }
    vec![
        placed(1.0, DVec3::ZERO, DQuat::IDENTITY),
        placed(1e-3, DVec3::ZERO, turn),
        placed(1e3, DVec3::ONE, DQuat::IDENTITY),
        placed(1.0, DVec3::new(1e3, -1e3, 1e3), turn),
        (1.0, shuffled),
        (1.0, soup(mesh)),
        (1.0, with_noise(soup(mesh), 1e-16, 1)),
    ]
}

/// Checks the invariants of every cleaned mesh.
fn check(clean: &CleanMesh, raw: &TriMesh) {
    let mesh = &clean.mesh;
    assert!(mesh.is_watertight());
    assert_eq!(mesh.triangles.len(), clean.source.len());
    assert_eq!(mesh.triangles.len(), clean.solid.len());
    // Each edge has two triangles, by the mesh's own vertices.
    let mut edges: Vec<[u32; 2]> =
        mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    assert!(edges.windows(2).all(|two| two[0] != two[1]));
    assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()));
    // Each triangle lies in its source.
    let (low, high) = raw.bounds();
    let tolerance = 1e-6 * (high - low).length();
    for (triangle, source) in clean.source.iter().enumerate() {
        let Some(source) = source else { continue };
        let corners = raw.corners(*source as usize);
        for corner in mesh.corners(triangle) {
            let nearest = frangible_geometry::closest_point_on_triangle(corner, &corners);
            assert!(nearest.distance(corner) < tolerance);
        }
    }
}

/// Cleans all variants, and compares the volume.
fn assert_volume(raw: &TriMesh, volume: f64) -> CleanMesh {
    for (scale, mesh) in variants(raw) {
        let clean = mesh.cleaned("the mesh").unwrap();
        check(&clean, &mesh);
        let found = clean.mesh.mass_properties().volume / (scale * scale * scale);
        assert!((found / volume - 1.0).abs() < 1e-6, "{found} of {volume} at scale {scale}");
    }
    raw.cleaned("the mesh").unwrap()
}

#[test]
fn a_clean_mesh_stays_what_it_is() {
    for mesh in [cube(), icosphere(0.7, 3), joined(cube(), &moved(cube(), DVec3::X * 1.5))] {
        let clean = assert_volume(&mesh, mesh.mass_properties().volume);
        assert_eq!(clean.mesh, mesh);
        assert_eq!(clean.changes, Default::default());
        assert!(clean.source.iter().zip(0..).all(|(source, number)| *source == Some(number)));
    }
}

#[test]
fn an_open_floor_is_left_out() {
    let floor = TriMesh {
        positions: [(-1.0, -1.0), (2.0, -1.0), (2.0, 2.0), (-1.0, 2.0)]
            .map(|(x, z)| DVec3::new(x, -1.0, z))
            .to_vec(),
        triangles: vec![[0, 3, 2], [0, 2, 1]],
    };
    for floor in [floor.clone(), turned_round(floor)] {
        for mesh in [joined(cube(), &floor), joined(floor.clone(), &cube())] {
            let clean = assert_volume(&mesh, 1.0);
            assert_eq!(clean.mesh.triangles.len(), 12);
            let [sheet] = clean.changes.sheets.as_slice() else { panic!("{:?}", clean.changes) };
            assert_eq!((sheet.triangles, sheet.area), (2, 9.0));
            assert_eq!(sheet.bounds.0, DVec3::new(-1.0, -1.0, -1.0));
        }
        assert_eq!(
            floor.cleaned("floor.obj").unwrap_err().to_string(),
            "floor.obj: encloses no volume: it has 1 open or flat part of 9 m^2 in all, must have a \
             closed one, or a thickness that makes plates of open ones (--thickness, or a scene's \
             \"thickness\")"
        );
    }
    // Ground that is not plane, beside a cube.
    let mut ground = TriMesh::default();
    for (x, z) in (0..20).flat_map(|x| (0..20).map(move |z| (f64::from(x), f64::from(z)))) {
        ground.positions.push(DVec3::new(x, libm::sin(0.4 * x) + libm::cos(0.3 * z) - 4.0, z));
    }
    for n in (0..380_u32).filter(|n| n % 20 != 19) {
        ground.triangles.extend([[n, n + 1, n + 20], [n + 1, n + 21, n + 20]]);
    }
    let clean = assert_volume(&joined(ground, &cube()), 1.0);
    assert_eq!(clean.changes.sheets.len(), 1);
}

#[test]
fn faces_that_are_turned_round_agree_with_their_neighbours_again() {
    let sphere = icosphere(1.0, 2);
    let volume = sphere.mass_properties().volume;
    for share in [0.01, 0.3, 0.5, 0.9, 1.0] {
        let mut random = Pcg64Mcg::seed_from_u64(7);
        let mut mesh = sphere.clone();
        for triangle in &mut mesh.triangles {
            if random.random::<f64>() < share {
                triangle.swap(1, 2);
            }
        }
        let clean = assert_volume(&mesh, volume);
        assert_eq!(clean.changes.holes, 0);
        assert!(clean.changes.turned <= 160);
    }
    let mut one = cube();
    one.triangles[6].swap(1, 2);
    one.triangles[7].swap(1, 2);
    assert_eq!(assert_volume(&one, 1.0).changes.turned, 2);
    // Parts that face inward each for itself.
    let parts = joined(turned_round(cube()), &moved(cube(), DVec3::X * 3.0));
    assert_volume(&joined(parts, &turned_round(moved(cube(), DVec3::Y * 2.0))), 3.0);
}

#[test]
fn repeated_and_double_sided_faces_count_once() {
    let quads = |missing: usize| open_box(DVec3::ZERO, DVec3::ONE, missing);
    // Each face twenty times, of an open box.
    let mut repeated = quads(1);
    repeated.triangles = repeated.triangles.iter().flat_map(|&triangle| [triangle; 20]).collect();
    let clean = assert_volume(&repeated, 1.0);
    assert_eq!((clean.changes.repeated, clean.changes.holes), (190, 1));
    assert_eq!(clean.mesh.triangles.len(), 12);

    // With the same diagonals and with others, closed and open, all faces and one.
    for missing in [0, 1] {
        let mut same = quads(missing);
        same.triangles.extend(turned_round(quads(missing)).triangles);
        assert_volume(&same, 1.0);
        let mut other = quads(missing);
        let faces: Vec<[u32; 3]> = other.triangles.clone();
        for two in faces.chunks_exact(2) {
            let ([a, b, c], d) = (two[0], two[1][2]);
            other.triangles.extend([[b, a, d], [b, d, c]]);
        }
        assert_volume(&other, 1.0);
    }
    let mut one = cube();
    let [a, b, c] = one.triangles[4];
    one.triangles.push([a, c, b]);
    let clean = assert_volume(&one, 1.0);
    assert_eq!(clean.changes.repeated, 1);
    assert!(clean.changes.sheets.is_empty());

    // A whole part twice, and once more turned round.
    let twice =
        joined(joined(icosphere(1.0, 1), &icosphere(1.0, 1)), &turned_round(icosphere(1.0, 1)));
    assert_volume(&twice, icosphere(1.0, 1).mass_properties().volume);
}

#[test]
fn noise_is_welded_and_thin_plates_are_not() {
    for noise in [1e-16, 1e-13, 1e-10, 1e-7] {
        for mesh in [cube(), icosphere(0.5, 3)] {
            let volume = mesh.mass_properties().volume;
            let raw = with_noise(soup(&mesh), noise, 5);
            let clean = raw.cleaned("noise").unwrap();
            check(&clean, &raw);
            assert_eq!(clean.mesh.triangles.len(), mesh.triangles.len());
            assert_eq!(clean.mesh.positions.len(), mesh.positions.len());
            assert!(
                (clean.mesh.mass_properties().volume / volume - 1.0).abs() < 20.0 * noise + 1e-12
            );
        }
    }
    // A plate a micrometre thick in a metre, as a soup with noise, too.
    let plate = open_box(DVec3::ZERO, DVec3::new(1.0, 1e-6, 1.0), 0);
    assert_volume(&plate, 1e-6);
    let noisy = with_noise(soup(&plate), 1e-9, 2).cleaned("plate").unwrap();
    assert!((noisy.mesh.mass_properties().volume / 1e-6 - 1.0).abs() < 0.01);
    // In single precision, a kilometre away.
    let mut far = soup(&moved(icosphere(1.0, 2), DVec3::splat(1e3)));
    far.positions.iter_mut().for_each(|position| *position = position.as_vec3().as_dvec3());
    let clean = far.cleaned("far").unwrap();
    assert_eq!(clean.changes.holes, 0);
    assert!(
        (clean.mesh.mass_properties().volume / icosphere(1.0, 2).mass_properties().volume - 1.0)
            .abs()
            < 1e-3
    );
}

/// Parts in contact at a vertex, an edge or a face stay two, with or without common vertices.
#[test]
fn what_touches_stays_two() {
    for way in [DVec3::ONE, DVec3::new(1.0, 1.0, 0.0), DVec3::X, DVec3::new(1.0, 0.3, 0.0)] {
        let apart = joined(cube(), &moved(cube(), way));
        let mut shared = apart.clone();
        shared.weld();
        for mesh in [apart, shared] {
            let clean = assert_volume(&mesh, 2.0);
            assert_eq!(clean.mesh.triangles.len(), 24);
            assert_eq!(clean.solid.iter().max(), Some(&1));
            assert_eq!(clean.changes, Default::default());
        }
    }
    // Two cells with one wall between them.
    let mut cells = joined(cube(), &moved(cube(), DVec3::X));
    cells.weld();
    let wall = |mesh: &TriMesh, n: usize| mesh.corners(n).iter().all(|corner| corner.x == 1.0);
    let first = (0..24).find(|&n| wall(&cells, n)).unwrap();
    let kept: Vec<[u32; 3]> = (0..24)
        .filter(|&n| !wall(&cells, n) || n / 2 == first / 2)
        .map(|n| cells.triangles[n])
        .collect();
    cells.triangles = kept;
    assert_volume(&cells, 2.0);
}

#[test]
fn nested_parts_are_solids_and_cavities() {
    let ball = |radius: f64, cavity: bool| {
        let ball = icosphere(radius, 2);
        if cavity { turned_round(ball) } else { ball }
    };
    let volume = |radius: f64| icosphere(radius, 2).mass_properties().volume;
    let hollow = joined(ball(1.0, false), &ball(0.8, true));
    let with_core = joined(hollow.clone(), &ball(0.5, false));
    let all = joined(with_core.clone(), &ball(0.2, true));
    let clean = assert_volume(&all, volume(1.0) - volume(0.8) + volume(0.5) - volume(0.2));
    assert_eq!(clean.solid.iter().max(), Some(&1));
    // All turned round, and in another order.
    assert_volume(&turned_round(all), volume(1.0) - volume(0.8) + volume(0.5) - volume(0.2));
    let other_order = joined(ball(0.5, false), &joined(ball(0.8, true), &ball(1.0, false)));
    assert_volume(&other_order, volume(1.0) - volume(0.8) + volume(0.5));
    // Two cavities; and a solid in a solid, which a union makes one.
    let two =
        joined(moved(ball(0.3, true), DVec3::X * 0.5), &moved(ball(0.3, true), DVec3::X * -0.5));
    assert_volume(&joined(ball(1.0, false), &two), volume(1.0) - 2.0 * volume(0.3));
    let clean = joined(ball(1.0, false), &ball(0.5, false)).cleaned("two").unwrap();
    assert_eq!(clean.solid.iter().max(), Some(&1));
}

/// A non-planar rim is closed in the same way for any order of the file, drawn once or twice.
#[test]
fn a_bent_rim_is_closed_in_one_way() {
    const SIDES: u32 = 8;
    let mut positions = vec![DVec3::ZERO];
    for n in 0..SIDES {
        let angle = 0.1 + f64::from(n) * std::f64::consts::TAU / f64::from(SIDES);
        let height = [1.0, 1.4, 1.1, 1.7][n as usize % 4];
        positions.push(DVec3::new(libm::cos(angle), height, libm::sin(angle)));
    }
    let bowl: Vec<[u32; 3]> = (0..SIDES).map(|n| [0, 1 + n, 1 + (n + 1) % SIDES]).collect();
    let volume = |triangles: Vec<[u32; 3]>| {
        let clean = TriMesh { positions: positions.clone(), triangles }.cleaned("bowl").unwrap();
        assert!(clean.changes.holes > 0);
        clean.mesh.mass_properties().volume
    };
    let once = volume(bowl.clone());
    for first in 0..bowl.len() {
        let mut other = bowl.clone();
        other.rotate_left(first);
        assert!((volume(other.clone()) - once).abs() < 1e-12, "from {first}");
        other.extend(bowl.iter().map(|&[a, b, c]| [a, c, b]));
        assert!((volume(other) - once).abs() < 1e-12, "twice, from {first}");
    }
}

#[test]
fn holes_are_closed_and_counted() {
    for missing in 1..=3 {
        let mesh = open_box(DVec3::ZERO, DVec3::ONE, missing);
        let clean = mesh.cleaned("box").unwrap();
        check(&clean, &mesh);
        assert!(clean.changes.holes >= 1);
    }
    let clean = assert_volume(&open_box(DVec3::ZERO, DVec3::ONE, 1), 1.0);
    assert_eq!(clean.changes.holes, 1);
    assert_eq!(clean.source.iter().filter(|source| source.is_none()).count(), 2);
    // Opposite faces: two holes.
    let mut tube = cube();
    tube.triangles.drain(0..4);
    assert_eq!(assert_volume(&tube, 1.0).changes.holes, 2);
    // Holes that touch at a vertex: a pyramid without two opposite sides.
    let base = [DVec3::X, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Z];
    let positions: Vec<DVec3> = base.into_iter().chain([DVec3::Y]).collect();
    let pyramid =
        TriMesh { positions, triangles: vec![[0, 2, 1], [0, 3, 2], [1, 2, 4], [3, 0, 4]] };
    assert_eq!(assert_volume(&turned_round(pyramid), 2.0 / 3.0).changes.holes, 2);
}

/// One face in strips, whose corners lie on the edges of the other faces.
#[test]
fn edges_that_end_in_the_middle_of_others_are_joined() {
    for strips in [2, 3, 7] {
        let mut mesh = open_box(DVec3::ZERO, DVec3::ONE, 1);
        for strip in 0..strips {
            let at = |n: i32| f64::from(n) / f64::from(strips);
            let base = mesh.positions.len() as u32;
            let (from, to) = (at(strip), at(strip + 1));
            for (x, y) in [(from, 0.0), (to, 0.0), (to, 1.0), (from, 1.0)] {
                mesh.positions.push(DVec3::new(x, y, 1.0));
            }
            mesh.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        }
        let clean = assert_volume(&mesh, 1.0);
        assert_eq!((clean.changes.holes, clean.changes.sheets.len()), (0, 0));
        assert!(clean.source.iter().all(Option::is_some));
        let mut sources: Vec<u32> = clean.source.iter().flatten().copied().collect();
        sources.dedup();
        assert_eq!(sources.len(), mesh.triangles.len());
    }
}

/// A fin on a cube, by the cube's own vertices.
#[test]
fn fins_are_left_out() {
    let mut mesh = cube();
    mesh.positions.push(DVec3::new(2.0, 2.0, 2.0));
    for fin in [[0, 1, 8], [1, 0, 8]] {
        let mut mesh = mesh.clone();
        mesh.triangles.push(fin);
        let clean = assert_volume(&mesh, 1.0);
        assert_eq!(clean.changes.sheets.len(), 1);
    }
}

/// Hundreds of cubes, some of them turned round, in one file.
#[test]
fn many_parts_are_each_a_solid() {
    let mut mesh = TriMesh::default();
    for n in 0..500 {
        let place = DVec3::new(f64::from(n % 8), f64::from(n / 8 % 8), f64::from(n / 64));
        let cube = moved(cube(), 1.25 * place);
        mesh = joined(mesh, &if n % 3 == 0 { turned_round(cube) } else { cube });
    }
    let clean = assert_volume(&mesh, 500.0);
    assert_eq!(clean.solid.iter().max(), Some(&499));
}

/// A closed surface between a flat polygon and the same one at height 1, through all of its
/// corners.
fn extruded(outline: &[(f64, f64)]) -> TriMesh {
    let n = outline.len() as u32;
    let rows = [0.0, 1.0].map(|z| outline.iter().map(move |&(x, y)| DVec3::new(x, y, z)));
    let fans = (1..n - 1).flat_map(|k| [[0, k + 1, k], [n, n + k, n + k + 1]]);
    let sides = (0..n).flat_map(|k| {
        let next = (k + 1) % n;
        [[k, next, n + next], [k, n + next, n + k]]
    });
    TriMesh {
        positions: rows.into_iter().flatten().collect(),
        triangles: fans.chain(sides).collect(),
    }
}

/// Of an outline that crosses itself all edges of the walls end on faces, and none passes through
/// one: the walls cross all the same.
#[test]
fn walls_that_cross_between_flat_ends_are_found() {
    let bow = extruded(&[(0.0, 0.0), (3.0, 2.0), (3.0, 0.0), (0.0, 1.5)]);
    let square = extruded(&[(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 1.5)]);
    for (is_crossing, mesh) in [(true, bow), (false, square)] {
        for (_, mesh) in variants(&mesh) {
            let clean = mesh.cleaned("the mesh").unwrap();
            let meeting = clean.meeting();
            assert_eq!((meeting.others.len(), meeting.others[0]), (1, false));
            // The outline encloses two triangles, one of which faces inward.
            assert_eq!(meeting.buried[0] > 0.2, is_crossing, "{:?}", meeting.buried);
            assert_eq!(meeting.buried[0] > 0.0, is_crossing, "{:?}", meeting.buried);
        }
    }
}

/// A cone over a fan, both of very many sides: nothing crosses, in the time that the number of
/// triangles takes and not its square.
#[test]
fn fans_of_many_sides_are_clean() {
    let sides = 20_000_u32;
    let rim = |n: u32| {
        let (sin, cos) = libm::sincos(2.0 * std::f64::consts::PI * f64::from(n) / f64::from(sides));
        DVec3::new(sin, 0.0, cos)
    };
    let mut positions: Vec<DVec3> = (0..sides).map(rim).collect();
    positions.extend([DVec3::new(0.0, 2.0, 0.0), DVec3::ZERO]);
    let cone = (0..sides).flat_map(|n| {
        let next = (n + 1) % sides;
        [[n, next, sides], [next, n, sides + 1]]
    });
    let clean = TriMesh { positions, triangles: cone.collect() }.cleaned("the mesh").unwrap();
    assert_eq!(clean.mesh.triangles.len(), 40_000);
    let volume = clean.mesh.mass_properties().volume;
    assert!((volume / (2.0 * std::f64::consts::PI / 3.0) - 1.0).abs() < 1e-7, "{volume}");
    let meeting = clean.meeting();
    assert_eq!((meeting.others, meeting.buried), (vec![false], vec![0.0]));
}

/// A quad of a `width` at a height, seen from above or from below.
fn quad(width: DVec3, height: f64, faces_up: bool) -> TriMesh {
    let corners = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)];
    let at = |(x, z): (f64, f64)| DVec3::new(x * width.x, height, z * width.z);
    let quad =
        TriMesh { positions: corners.map(at).to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] };
    if faces_up { quad } else { turned_round(quad) }
}

/// Of a floor between walls two sheets are left where the faces that the walls hide are culled:
/// what they enclose is inside. Two that face one another enclose nothing, nor do two that are far
/// apart.
#[test]
fn what_two_sheets_enclose_is_inside() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    for _ in 0..20 {
        let mut side = || random.random_range(0.5..4.0);
        let width = DVec3::new(side(), 1.0, side());
        let thick = random.random_range(0.02..0.3) * width.x.min(width.z);
        let turn = DQuat::from_rotation_z(random.random_range(0.0..3.0));
        let wall = moved(cube(), DVec3::new(0.5 * width.x + 0.5, 0.0, 0.0));
        let parts = |low: bool, high: bool, thick: f64| {
            let floor = joined(quad(width, 0.0, low), &quad(width, thick, high));
            let mut mesh = joined(wall.clone(), &floor);
            mesh.positions.iter_mut().for_each(|position| *position = turn * *position);
            mesh
        };
        let clean = assert_volume(&parts(false, true, thick), 1.0 + width.x * width.z * thick);
        assert!(clean.changes.sheets.is_empty());
        let inward = assert_volume(&parts(true, false, thick), 1.0);
        assert_eq!(inward.changes.sheets.len(), 2);
        let far = 3.0 * width.x.max(width.z);
        assert_volume(&parts(false, true, far), 1.0);
    }
}

/// A mesh that is mostly sheets says what would make solids of them.
#[test]
fn a_mesh_that_loses_most_of_itself_names_the_thickness() {
    let mut mesh = cube();
    for height in 0..8 {
        mesh = joined(mesh, &quad(DVec3::splat(3.0), 3.0 + f64::from(height), true));
    }
    let clean = mesh.cleaned("cards.obj").unwrap();
    assert!(clean.changes.sentences().iter().any(|sentence| {
        sentence.contains("16 of 28 triangles") && sentence.contains("--thickness")
    }));
}
