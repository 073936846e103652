//! The exact path: convex bodies broken by planes.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a panic is how a test fails")]

mod common;

use frangible_fracture::{
    Cells, Cut, Fragment, Impact, Pattern, Radial, Region, ShatterSettings, Smallest,
    fragment_velocity, shatter, shatter_hull,
};
use frangible_geometry::{ClosedForm, Geometry, HalfSpace, Hull, PlaneClipper, Shape, Surface};
use glam::{DMat3, DVec3};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

const EVERY_CRUMB: ShatterSettings = ShatterSettings {
    smallest_fragment_voxels: 0.0,
    sample_spacing_voxels: 2.0,
    smallest: Smallest { part: 0.0, volume: 0.0, slenderness: 0.0 },
    reach: None,
    twist: 0.0,
};

/// Pieces below a part of the mean join their neighbours.
fn with_part(part: f64) -> ShatterSettings {
    ShatterSettings { smallest: Smallest { part, ..EVERY_CRUMB.smallest }, ..EVERY_CRUMB }
}

fn vector(half: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-half..half).prop_map(DVec3::from_array)
}

/// Boxes, balls, cylinders, prisms of few sides and hulls of points.
fn convex() -> impl Strategy<Value = Shape> {
    let form = (vector(1.0), 0..3).prop_map(|(size, kind)| {
        let half = size.abs() + 0.05;
        let form = match kind {
            0 => ClosedForm::Box { half },
            1 => ClosedForm::Sphere { radius: half.x },
            _ => ClosedForm::Cylinder { radius: half.x, half_height: half.y },
        };
        Shape::breakable(form, 0.1).unwrap()
    });
    let cloud = prop::collection::vec(vector(1.0), 5..30)
        .prop_filter_map("flat", |points| Shape::convex(Hull::of_points(&points).ok()?, 0.1).ok());
    prop_oneof![form, cloud]
}

/// Kind and seed of a pattern.
fn kind() -> impl Strategy<Value = (usize, u64)> {
    (0..4_usize, 0..50_u64)
}

fn pattern_of((kind, seed): (usize, u64)) -> Pattern {
    common::patterns(seed).swap_remove(kind)
}

/// A blow from outside on one of the corners, or on a point of the surface.
fn blow(shape: &Shape, place: f64, direction: DVec3) -> Impact {
    let vertices = shape.hull.as_ref().unwrap().vertices();
    let corner = vertices[(place * vertices.len() as f64) as usize];
    Impact { point_body: corner, normal_body: direction.try_normalize().unwrap_or(DVec3::Y) }
}

/// The polyhedron of a fragment in the parent's grid frame.
fn hull(fragment: &Fragment) -> &Hull {
    match &fragment.shape.geometry {
        Geometry::Hull(hull) => hull,
        _ => panic!("an exact fragment is a hull"),
    }
}

fn area(hull: &Hull, inner: bool) -> f64 {
    let of_face = |corners: &[u32]| {
        let corner = |at: usize| hull.vertices()[corners[at] as usize];
        let fan = (1..corners.len() - 1)
            .map(|at| (corner(at) - corner(0)).cross(corner(at + 1) - corner(0)));
        0.5 * fan.sum::<DVec3>().length()
    };
    hull.faces().filter(|face| face.inner == inner).map(|face| of_face(face.vertices)).sum()
}

/// The largest relative difference between what moves before and after: mass, momentum, angular
/// momentum, kinetic energy.
fn defect(parent: &Shape, fragments: &[Fragment]) -> f64 {
    let (velocity, omega) = (DVec3::new(3.0, -2.0, 1.0), DVec3::new(-4.0, 1.0, 5.0));
    let motion = |shape: &Shape, axes: DMat3, center: DVec3| {
        let velocity = fragment_velocity(velocity, omega, DVec3::ZERO, center);
        let spin = axes * (shape.unit_moments * (axes.transpose() * omega));
        let momentum = shape.volume * velocity;
        let energy = 0.5 * (momentum.dot(velocity) + spin.dot(omega));
        (shape.volume, momentum, spin + center.cross(momentum), energy)
    };
    let before = motion(parent, DMat3::IDENTITY, DVec3::ZERO);
    let mut after = (0.0, DVec3::ZERO, DVec3::ZERO, 0.0);
    for Fragment { shape, parent_from_fragment, .. } in fragments {
        let part = motion(shape, parent_from_fragment.matrix(), parent_from_fragment.translation);
        after.0 += part.0;
        after.1 += part.1;
        after.2 += part.2;
        after.3 += part.3;
    }
    let radius = (0.5 * (parent.bounds.1 - parent.bounds.0)).length();
    let defects = [
        (after.0 - before.0).abs() / before.0,
        (after.1 - before.1).length() / before.1.length(),
        (after.2 - before.2).length() / (before.2.length() + before.1.length() * radius),
        (after.3 - before.3).abs() / before.3,
    ];
    defects.into_iter().fold(0.0, f64::max)
}

/// Sums of the fragments are the parent's; each is a snug body where it was.
fn assert_exact(parent: &Shape, fragments: &[Fragment]) {
    let volume: f64 = fragments.iter().map(|fragment| fragment.shape.volume).sum();
    assert!((volume / parent.volume - 1.0).abs() < 1e-9, "{volume} of {}", parent.volume);
    let defect = defect(parent, fragments);
    assert!(defect < 1e-10, "{defect}");
    // Absorbed slivers leave an unnoticeable void.
    let filled: f64 = fragments.iter().map(|fragment| hull(fragment).volume()).sum();
    assert!(
        filled > (1.0 - 1e-4) * parent.breaks_as().unwrap().volume(),
        "{filled} of {}",
        parent.volume
    );
    let whole = parent.breaks_as().unwrap();
    let (low, high) = whole.bounds();
    let size = (high - low).max_element();
    for fragment in fragments {
        let hull = hull(fragment);
        assert!(
            hull.vertices()
                .iter()
                .all(|&vertex| whole.distance_and_gradient(vertex).0 < 1e-9 * size)
        );
        for face in hull.faces() {
            for &vertex in face.vertices {
                assert!(face.plane.distance(hull.vertices()[vertex as usize]).abs() < 1e-9 * size);
            }
        }
        assert!(hull.surface().is_watertight());
        // The absorbed mass lies at most as far off as the parent is long.
        let in_parent = parent.body_from_grid.point(hull.mass_properties().center);
        let absorbed = (fragment.shape.volume - hull.volume()).max(0.0) / fragment.shape.volume;
        let most = (2.0 * absorbed + 1e-9) * size;
        assert!(in_parent.distance(fragment.parent_from_fragment.translation) < most);
    }
}

/// Volume common to two polyhedra [m^3].
fn overlap(a: &Hull, b: &Hull) -> f64 {
    PlaneClipper::default().clipped(a, b.planes()).map_or(0.0, |common| common.volume())
}

/// Planes through the middle of a box: eight, four or two boxes.
fn grid_pattern(axes: usize) -> Pattern {
    let half_space =
        |axis: usize, sign: f64| HalfSpace { normal: sign * DVec3::AXES[axis], offset: 0.0 };
    let region = |number: usize| {
        let sides: Vec<HalfSpace> = (0..axes)
            .map(|axis| half_space(axis, if number >> axis & 1 == 1 { -1.0 } else { 1.0 }))
            .collect();
        Region::from_half_spaces(&sides, DVec3::ONE)
    };
    let cells = Cells::Planar((0..1 << axes).filter_map(region).collect());
    Pattern {
        half_extent: DVec3::ONE,
        center: DVec3::ZERO,
        magnification: 1.0,
        scale: None,
        cells,
        joints: Vec::new(),
    }
}

#[test]
fn a_box_cut_into_octants_is_the_textbook_s() {
    let half = DVec3::new(0.5, 0.3, 0.2);
    let parent = Shape::closed_form(ClosedForm::Box { half }, 0.1);
    let impact = Impact { point_body: DVec3::ZERO, normal_body: DVec3::Y };
    let fragments = shatter(&parent, &grid_pattern(3), &impact, &ShatterSettings::default());
    assert_eq!(fragments.len(), 8);
    assert_exact(&parent, &fragments);
    let octant = ClosedForm::Box { half: 0.5 * half }.mass_properties().unwrap();
    for fragment in &fragments {
        assert!((fragment.shape.volume - octant.volume).abs() < 1e-16);
        let axes = fragment.parent_from_fragment.matrix();
        let inertia = axes * DMat3::from_diagonal(fragment.shape.unit_moments) * axes.transpose();
        assert!(inertia.abs_diff_eq(octant.inertia, 1e-16));
        let center = fragment.parent_from_fragment.translation.abs();
        assert!((center - 0.5 * half).length() < 1e-15);
        // Three faces are cracks, of the areas of the box's own.
        let hull = hull(fragment);
        assert_eq!(hull.faces().filter(|face| face.inner).count(), 3);
        assert!((area(hull, true) - area(hull, false)).abs() < 1e-15);
    }
}

/// Where a pattern's centre lies on an edge or a corner, and its planes in the faces: cells that
/// only touch leave nothing.
#[test]
fn cells_that_only_touch_leave_nothing() {
    let half = DVec3::new(0.5, 0.3, 0.2);
    let parent = Shape::closed_form(ClosedForm::Box { half }, 0.1);
    for (point_body, pieces) in
        [(half, 1), (half.with_x(0.0), 2), (half.with_x(0.0).with_y(0.0), 4)]
    {
        let impact = Impact { point_body, normal_body: DVec3::Z };
        let fragments = shatter(&parent, &grid_pattern(3), &impact, &EVERY_CRUMB);
        assert_eq!(fragments.len(), pieces);
        assert_exact(&parent, &fragments);
    }
}

/// A slab with a crack close below its face: the sliver joins what lies behind the crack, and
/// nothing changes.
#[test]
fn a_sliver_joins_its_neighbour() {
    let parent = Shape::closed_form(ClosedForm::Box { half: DVec3::new(0.5, 0.3, 0.2) }, 0.1);
    let impact = Impact { point_body: DVec3::new(0.1, 0.3 - 1e-5, 0.0), normal_body: DVec3::Y };
    let count = |settings: &ShatterSettings| {
        let fragments = shatter(&parent, &grid_pattern(3), &impact, settings);
        assert_exact(&parent, &fragments);
        fragments.len()
    };
    assert_eq!(count(&EVERY_CRUMB), 8);
    assert_eq!(count(&ShatterSettings::default()), 4);
}

/// A small cell in the middle of bigger ones fits to none of them: it stays.
#[test]
fn a_sliver_that_fits_to_nothing_stays() {
    // A cube around the centre, and the rest of space in six parts that turn around it.
    let plane = |normal: DVec3, offset: f64| HalfSpace { normal, offset };
    let cut = |half_space: HalfSpace| Cut { half_space, face: Vec::new() };
    let region =
        |planes: &[HalfSpace]| Region { cuts: planes.iter().map(|&plane| cut(plane)).collect() };
    let (x, y, small) = (DVec3::X, DVec3::Y, 0.02);
    let pinwheel = vec![
        region(&[plane(x, small), plane(-x, small), plane(y, small), plane(-y, small)]),
        region(&[plane(-x, -small), plane(-y, small)]),
        region(&[plane(-y, -small), plane(x, small)]),
        region(&[plane(x, -small), plane(y, small)]),
        region(&[plane(y, -small), plane(-x, small)]),
    ];
    let pattern = Pattern {
        half_extent: DVec3::ONE,
        center: DVec3::ZERO,
        cells: Cells::Planar(pinwheel),
        magnification: 1.0,
        scale: None,
        joints: Vec::new(),
    };
    let parent = Shape::closed_form(ClosedForm::Box { half: DVec3::new(0.5, 0.4, 0.3) }, 0.1);
    let impact = Impact { point_body: DVec3::ZERO, normal_body: DVec3::Z };
    let settings = with_part(0.01);
    let fragments = shatter(&parent, &pattern, &impact, &settings);
    assert_exact(&parent, &fragments);
    let smallest =
        fragments.iter().map(|fragment| fragment.shape.volume).fold(f64::INFINITY, f64::min);
    assert_eq!((fragments.len(), smallest < 0.01 * parent.volume), (5, true));
}

/// Three generations of a body with a scene's settings. Of a rod a thousand times as long as thick,
/// cut lengthwise again and again, pieces add up to their parent or there are none.
#[test]
fn what_is_too_thin_to_be_cut_stays_whole() {
    let rod = Shape::convex(Hull::cuboid(DVec3::new(0.005, 5.0, 0.005)), 0.8).unwrap();
    let corner = DVec3::new(-0.005, 5.0, -0.005);
    let (mut broken, mut whole) = (0, 0);
    for seed in 0..40 {
        let pattern =
            Pattern::radial(&Radial { spokes: 12, rings: 1, seed, ..Radial::default() }).unwrap();
        let mut generation = vec![(rod.clone(), corner)];
        for _ in 0..3 {
            let mut next = Vec::new();
            for (parent, point_body) in generation {
                let impact = Impact { point_body, normal_body: point_body.normalize() };
                let pieces = shatter_hull(&parent, &pattern, &impact, &ShatterSettings::default());
                let volume: f64 = pieces.iter().map(|piece| piece.shape.volume).sum();
                let complete = (volume / parent.volume - 1.0).abs() < 1e-9;
                assert!(
                    pieces.is_empty() || complete,
                    "seed {seed}: {volume} of {} m^3",
                    parent.volume
                );
                *(if pieces.is_empty() { &mut whole } else { &mut broken }) += 1;
                let chosen = pieces.into_iter().step_by(5);
                next.extend(chosen.map(|piece| {
                    let top = DVec3::new(0.0, piece.shape.bounds.1.y, 0.0);
                    (piece.shape, top)
                }));
            }
            generation = next;
        }
    }
    assert!(broken > 100 && whole > 0, "{broken} broke, {whole} did not");
}

#[test]
fn fragments_break_again() {
    let mut random = common::random(21);
    for form in [
        ClosedForm::Box { half: DVec3::new(0.5, 0.1, 0.4) },
        ClosedForm::Sphere { radius: 0.4 },
        ClosedForm::Cylinder { radius: 0.3, half_height: 0.5 },
    ] {
        let mut parent = Shape::breakable(form, 0.05).unwrap();
        for pattern in common::patterns(3) {
            let impact = common::random_impact(&parent, &mut random);
            let mut fragments = shatter(&parent, &pattern, &impact, &EVERY_CRUMB);
            assert!(fragments.len() > 1);
            assert_exact(&parent, &fragments);
            // Inner faces stay inner and outer faces outer: no surface is lost, and cracks have two
            // sides.
            let whole = parent.breaks_as().unwrap();
            let sums = |inner: bool| fragments.iter().map(|f| area(hull(f), inner)).sum::<f64>();
            assert!((sums(false) - area(whole, false)).abs() < 1e-9 * area(whole, false).max(1e-3));
            assert!(sums(true) > area(whole, true) + 1e-3 * area(whole, false));
            fragments.sort_by(|a, b| b.shape.volume.total_cmp(&a.shape.volume));
            parent = fragments.swap_remove(0).shape;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Any convex body, any pattern, struck at a corner from any side.
    #[test]
    fn breaks_are_exact(
        parent in convex(), kind in kind(), place in 0.0..1.0f64, direction in vector(1.0),
        smallest in prop::sample::select(vec![0.0, 1e-4, 0.02]),
    ) {
        let pattern = pattern_of(kind);
        let impact = blow(&parent, place, direction);
        let settings = with_part(smallest);
        let fragments = shatter(&parent, &pattern, &impact, &settings);
        assert_exact(&parent, &fragments);
        for (at, a) in fragments.iter().enumerate() {
            for b in &fragments[at + 1..] {
                let overlap = overlap(hull(a), hull(b));
                prop_assert!(overlap < 1e-9 * parent.volume, "{overlap}");
            }
        }
    }

    /// Without merging, each corner of a crack is a corner of at least two fragments or lies on a
    /// face or an edge of another, and those that are close are the same, bit for bit.
    #[test]
    fn neighbours_share_their_vertices(parent in convex(), kind in kind(), place in 0.0..1.0f64, direction in vector(1.0)) {
        let fragments = shatter(&parent, &pattern_of(kind), &blow(&parent, place, direction), &EVERY_CRUMB);
        let (low, high) = parent.bounds;
        let close = 1e-13 * (high - low).max_element();
        let all: Vec<DVec3> = fragments.iter().flat_map(|fragment| hull(fragment).vertices().to_vec()).collect();
        for (at, a) in all.iter().enumerate() {
            for b in &all[at + 1..] {
                prop_assert!(a == b || a.distance(*b) > close, "{}", a.distance(*b));
            }
        }
    }
}

/// Every corner of a Voronoi crack is met by another fragment's: faces coincide.
#[test]
fn faces_of_cells_coincide() {
    let parent = Shape::closed_form(ClosedForm::Box { half: DVec3::new(0.5, 0.4, 0.3) }, 0.1);
    let impact = Impact { point_body: DVec3::new(0.1, 0.4, 0.05), normal_body: DVec3::Y };
    let pattern = common::patterns(7).swap_remove(2);
    let fragments = shatter(&parent, &pattern, &impact, &EVERY_CRUMB);
    let mut faces: BTreeMap<BTreeSet<[u64; 3]>, usize> = BTreeMap::new();
    for fragment in &fragments {
        let hull = hull(fragment);
        for face in hull.faces().filter(|face| face.inner) {
            let bits =
                |&vertex: &u32| hull.vertices()[vertex as usize].to_array().map(f64::to_bits);
            *faces.entry(face.vertices.iter().map(bits).collect()).or_default() += 1;
        }
    }
    assert!(faces.len() > 20, "{}", faces.len());
    let alone = faces.values().filter(|&&sides| sides != 2).count();
    assert_eq!(alone, 0, "of {}", faces.len());
}

/// Area in space and in texture of the triangles with a tag [m^2].
fn areas(surface: &Surface, inner: bool) -> (f64, f64) {
    let mut sums = (0.0, 0.0);
    for (triangle, &[p, q, r]) in surface.coordinates.iter().enumerate() {
        if surface.interior[triangle] == inner {
            let [a, b, c] = surface.mesh.corners(triangle);
            sums.0 += 0.5 * (b - a).cross(c - a).length();
            sums.1 += 0.5 * f64::from((q - p).perp_dot(r - p)).abs();
        }
    }
    sums
}

/// Surfaces are closed, tagged as the faces are, and laid out flat: inner triangles are as large in
/// the texture as they are, and equal on both sides of a crack. After a second break as well.
#[test]
fn surfaces_are_closed_tagged_and_laid_out() {
    let mut random = common::random(31);
    let half = DVec3::new(0.4, 0.35, 0.3);
    let mut parent = Shape::breakable(ClosedForm::Box { half }, 0.05).unwrap();
    assert!(!parent.surface().interior.contains(&true));
    for pattern in common::patterns(5).into_iter().skip(1) {
        let impact = common::random_impact(&parent, &mut random);
        let mut fragments = shatter(&parent, &pattern, &impact, &EVERY_CRUMB);
        let mut layout: BTreeMap<([u64; 3], [u64; 3]), [f32; 2]> = BTreeMap::new();
        let mut met = 0;
        for fragment in &fragments {
            let surface = fragment.shape.surface();
            assert!(surface.mesh.is_watertight());
            assert!(
                (surface.mesh.mass_properties().volume / fragment.shape.volume - 1.0).abs() < 1e-9
            );
            for inner in [false, true] {
                let (in_space, in_texture) = areas(&surface, inner);
                assert!((in_space - area(hull(fragment), inner)).abs() < 1e-9);
                assert!(
                    !inner || (in_texture / in_space - 1.0).abs() < 1e-4,
                    "{in_texture} {in_space}"
                );
            }
            // The same corner of the same plane has the same coordinates in all fragments.
            let tagged = hull(fragment).tagged_surface();
            let faces = hull(fragment)
                .faces()
                .flat_map(|face| std::iter::repeat_n(face, face.vertices.len() - 2));
            for ((triangle, face), at) in tagged.mesh.triangles.iter().zip(faces).zip(0..) {
                let plane =
                    if face.plane.normal.x < 0.0 { -face.plane.normal } else { face.plane.normal };
                let key = (plane * 1e6).round().to_array().map(f64::to_bits);
                for (&vertex, place) in triangle.iter().zip(tagged.coordinates[at]) {
                    let corner =
                        tagged.mesh.positions[vertex as usize].to_array().map(f64::to_bits);
                    if face.inner
                        && let Some(other) = layout.insert((key, corner), place.to_array())
                    {
                        let away = (place - glam::Vec2::from_array(other)).length();
                        assert!(away < 1e-6, "{away}");
                        met += 1;
                    }
                }
            }
        }
        assert!(met > 50, "{met}");
        fragments.sort_by(|a, b| b.shape.volume.total_cmp(&a.shape.volume));
        parent = fragments.swap_remove(0).shape;
    }
    // Without a face the surface is open: the check can fail.
    let mut open = parent.surface().mesh;
    open.triangles.pop();
    assert!(!open.is_watertight());
}

/// On the grid, too, cracks are laid out in their planes.
#[test]
fn cracks_on_the_grid_are_laid_out_flat() {
    let mut random = common::random(32);
    for parent in [common::wall(), common::bitten_box()] {
        let impact = common::random_impact(&parent, &mut random);
        let pattern = common::patterns(6).swap_remove(2);
        let fragments = shatter(&parent, &pattern, &impact, &ShatterSettings::default());
        let (mut in_space, mut in_texture) = (0.0, 0.0);
        for fragment in &fragments {
            let surface = fragment.shape.surface();
            assert!(surface.mesh.is_watertight());
            assert_eq!(surface.coordinates.len(), surface.mesh.triangles.len());
            let sums = areas(&surface, true);
            in_space += sums.0;
            in_texture += sums.1;
        }
        assert!(
            in_space > 0.1 && (in_texture / in_space - 1.0_f64).abs() < 0.01,
            "{in_texture} {in_space}"
        );
    }
}
