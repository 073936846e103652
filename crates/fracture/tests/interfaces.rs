//! Contacts between the pieces of a break, against formulas.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use common::solid;
use frangible_fracture::{
    Fragment, Impact, Interface, Pattern, ShatterSettings, Voronoi, align_pattern, interfaces,
    shatter,
};
use frangible_geometry::{ClosedForm, Geometry, HalfSpace, Hull, Shape};
use frangible_math::RigidTransform;
use glam::{DQuat, DVec3};

const HALF: DVec3 = DVec3::new(0.5, 0.3, 0.4);

/// A blow on top, off the middle.
const IMPACT: Impact = Impact { point_body: DVec3::new(0.1, 0.3, -0.05), normal_body: DVec3::Y };

fn voronoi(cells: usize, seed: u64) -> Pattern {
    Pattern::voronoi(&Voronoi { cells, seed, ..Voronoi::default() }).unwrap()
}

/// A box on a grid.
fn grid_box() -> Shape {
    common::sampled_form(ClosedForm::Box { half: HALF }, [50, 30, 40])
}

/// A polyhedron as a piece of a parent whose body frame is the polyhedron's.
fn hull_piece(hull: Hull) -> Fragment {
    let shape = Shape::convex(hull, 0.1).unwrap();
    let parent_from_fragment = shape.body_from_grid.inverse();
    Fragment { shape, parent_from_fragment, cell: 0 }
}

/// The pieces of a box, cut exactly.
fn hull_pieces(parent: &Shape, pattern: &Pattern) -> Vec<Fragment> {
    let clip = |region: &frangible_fracture::Region| {
        region.cuts.iter().try_fold(Hull::cuboid(HALF), |hull, cut| hull.clipped(&cut.half_space))
    };
    align_pattern(pattern, &IMPACT, parent).iter().filter_map(clip).map(hull_piece).collect()
}

/// The section of the box in a plane.
fn section(plane: &HalfSpace) -> f64 {
    let half = Hull::cuboid(HALF).clipped(plane).unwrap();
    let face = half.faces().find(|face| face.plane == *plane).unwrap();
    let corner = |n: usize| half.vertices()[face.vertices[n] as usize];
    let fan =
        (2..face.vertices.len()).map(|n| (corner(n - 1) - corner(0)).cross(corner(n) - corner(0)));
    0.5 * fan.sum::<DVec3>().length()
}

#[test]
fn a_box_cut_by_a_tilted_plane_has_the_section_as_contact() {
    let parent = grid_box();
    for seed in 1..=12 {
        let fragments = shatter(&parent, &voronoi(2, seed), &IMPACT, &ShatterSettings::default());
        if fragments.len() < 2 {
            continue;
        }
        let plane = solid(&fragments[0].shape).outline.cuts[0];
        let [contact] = interfaces(&fragments).try_into().unwrap();
        let Interface { a, b, area, centroid, normal, .. } = contact;
        assert_eq!((a, b), (0, 1));
        assert!(
            (area / section(&plane) - 1.0).abs() < 0.04,
            "seed {seed}: {area} {}",
            section(&plane)
        );
        assert!((normal - plane.normal).length() < 1e-9, "from the first piece to the second");
        assert!(plane.distance(centroid).abs() < 0.002, "on the crack");
    }
}

#[test]
fn a_disc_is_the_contact_of_two_halves_of_a_ball() {
    let parent = common::sampled_form(ClosedForm::Sphere { radius: 0.5 }, [40; 3]);
    let impact = Impact { point_body: DVec3::new(0.0, 0.5, 0.0), normal_body: DVec3::Y };
    let fragments = shatter(&parent, &voronoi(2, 3), &impact, &ShatterSettings::default());
    let plane = solid(&fragments[0].shape).outline.cuts[0];
    let disc = std::f64::consts::PI * (0.25 - plane.offset * plane.offset);
    let [contact] = interfaces(&fragments).try_into().unwrap();
    assert!((contact.area / disc - 1.0).abs() < 0.02, "{} {disc}", contact.area);
    assert!((contact.centroid - plane.normal * plane.offset).length() < 0.01);
}

/// The exact path is the oracle of the grid path: piece by piece and in all.
#[test]
fn many_pieces_on_a_grid_touch_as_the_exact_ones_do() {
    let parent = grid_box();
    let settings = ShatterSettings { smallest_fragment_voxels: 0.0, ..ShatterSettings::default() };
    for (without_planes, of_all) in [(false, 0.01), (true, 0.04)] {
        let (mut sums, mut off) = ((0.0, 0.0), Vec::new());
        for seed in 1..=4 {
            let pattern = voronoi(20, seed);
            let mut fragments = shatter(&parent, &pattern, &IMPACT, &settings);
            let exact = interfaces(&hull_pieces(&parent, &pattern));
            if without_planes {
                for fragment in &mut fragments {
                    let Geometry::Grid(solid) = &mut fragment.shape.geometry else { continue };
                    solid.outline.cuts.clear();
                }
            }
            let sampled = interfaces(&fragments);

            // Contacts one by one, by their place, down to three voxels across. Of flat wedges
            // little is left without their planes.
            for contact in exact.iter().filter(|contact| contact.area > 0.004 && !without_planes) {
                let same = |other: &&Interface| {
                    (other.centroid - contact.centroid).length() < 0.02
                        && other.normal.cross(contact.normal).length() < 0.1
                };
                let found = sampled.iter().find(same).unwrap();
                off.push((found.area / contact.area - 1.0).abs());
                assert!(off[off.len() - 1] < 0.03 || contact.area < 0.02, "{found:?} {contact:?}");
            }
            sums.0 += sampled.iter().map(|contact| contact.area).sum::<f64>();
            sums.1 += exact.iter().map(|contact| contact.area).sum::<f64>();
        }
        assert!((sums.0 / sums.1 - 1.0).abs() < of_all, "{sums:?}");
        off.sort_by(f64::total_cmp);
        if !without_planes {
            let [half, most] = [0.5, 0.9].map(|part| off[(part * off.len() as f64) as usize]);
            assert!(half < 4e-3 && most < 2e-2, "median {half}, nine in ten {most}");
        }
    }
}

/// All of a piece's surface that is not the box's is contact, so the faces of the pieces and the
/// contacts close up.
#[test]
fn exact_contacts_cover_the_cracks_exactly() {
    let parent = grid_box();
    for seed in 1..=5 {
        let fragments = hull_pieces(&parent, &voronoi(30, seed));
        let mut outward: Vec<DVec3> = vec![DVec3::ZERO; fragments.len()];
        let mut cracks: Vec<f64> = vec![0.0; fragments.len()];
        for (piece, fragment) in fragments.iter().enumerate() {
            let surface = fragment.shape.surface().mesh;
            for triangle in 0..surface.triangles.len() {
                let corners = surface
                    .corners(triangle)
                    .map(|corner| fragment.parent_from_fragment.point(corner));
                let on_wall = (0..3).any(|axis| {
                    [-HALF, HALF]
                        .iter()
                        .any(|wall| corners.iter().all(|p| (p[axis] - wall[axis]).abs() < 1e-9))
                });
                let vector = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                if !on_wall {
                    outward[piece] += vector;
                    cracks[piece] += vector.length();
                }
            }
        }
        for contact in interfaces(&fragments) {
            assert!((contact.normal.length() - 1.0).abs() < 1e-12 && contact.area > 0.0);
            for (piece, sign) in [(contact.a, 1.0), (contact.b, -1.0)] {
                outward[piece] -= sign * contact.area * contact.normal;
                cracks[piece] -= contact.area;
            }
        }
        assert!(outward.iter().all(|rest| rest.length() < 1e-9), "{outward:?}");
        assert!(cracks.iter().all(|rest| rest.abs() < 1e-9), "{cracks:?}");
    }
}

#[test]
fn boxes_glued_off_centre_touch_where_they_overlap() {
    let cuboid = |half: DVec3, center: DVec3| {
        let turn = RigidTransform::new(DQuat::from_rotation_y(0.4), DVec3::new(1.0, 2.0, 3.0));
        let place = turn.after(&RigidTransform::new(DQuat::IDENTITY, center));
        Fragment {
            shape: Shape::closed_form(ClosedForm::Box { half }, 0.1),
            parent_from_fragment: place,
            cell: 0,
        }
    };
    let turn = RigidTransform::new(DQuat::from_rotation_y(0.4), DVec3::new(1.0, 2.0, 3.0));
    let fragments = [
        cuboid(DVec3::splat(0.5), DVec3::new(1.0, 0.0, 0.0)),
        cuboid(DVec3::splat(0.5), DVec3::new(0.3, 1.0, 0.2)),
        // Touches the first along an edge only, and lies beside the second with a gap.
        cuboid(DVec3::splat(0.5), DVec3::new(2.0, 1.0, 0.0)),
    ];
    let [contact] = interfaces(&fragments).try_into().unwrap();
    assert_eq!((contact.a, contact.b), (0, 1));
    assert!((contact.area - 0.3 * 0.8).abs() < 1e-12);
    assert!((contact.centroid - turn.point(DVec3::new(0.65, 0.5, 0.1))).length() < 1e-12);
    assert!((contact.normal - turn.direction(DVec3::Y)).length() < 1e-12);
}
