//! Surfaces of solids on grids, as triangles.

use crate::contour_mesh::Quad;
use crate::dual_contour::DualContour;
use crate::grid_solid::GridSolid;
use crate::mesh::{Surface, TriMesh};
use glam::DVec3;

/// The closed surface of a solid in its grid frame: dual contouring [JLSW02] of the signs at the
/// nodes, with crossings and normals from the exact outline, so that edges and corners stay sharp.
///
/// Each directed edge has exactly one opposite. Where two vertices share a corner of the outline,
/// the triangles between them have no area; they are kept, because they close the surface.
pub fn polygonize(solid: &GridSolid) -> Surface {
    let contour = DualContour::new(solid);
    let mut triangles = Vec::with_capacity(2 * contour.quads.len());
    let mut interior = Vec::with_capacity(2 * contour.quads.len());
    let mut normals = Vec::with_capacity(2 * contour.quads.len());
    for quad in &contour.quads {
        let [a, b, c, d] = quad.vertices;
        let halves = if splits_at_first(&contour, quad, solid.grid().spacing) {
            [[a, b, c], [a, c, d]]
        } else {
            [[b, c, d], [b, d, a]]
        };
        for half in halves {
            let (normal, cracked) = side_of(&contour, quad, half, solid.grid().spacing);
            normals.push(normal);
            interior.push(cracked);
        }
        triangles.extend(halves);
    }
    let positions = contour.vertices.iter().map(|vertex| vertex.position).collect();
    Surface::with_coordinates(TriMesh { positions, triangles }, interior, &normals)
}

/// Surface normal at a triangle of a quad, and true for a crack. At a rim the quad's two triangles
/// may lie on two sides: a triangle with all corners on a flat crack belongs to the crack.
fn side_of(contour: &DualContour, quad: &Quad, triangle: [u32; 3], spacing: f64) -> (DVec3, bool) {
    // Relative to the spacing; and the cosine of how far a triangle may lean from its crack.
    const ON_CRACK: f64 = 1e-3;
    const LEANS: f64 = 0.9;
    let pieces = &contour.pieces;
    let corners = triangle.map(|vertex| contour.vertices[vertex as usize].position);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
    let lies_on = |piece: usize| {
        corners.iter().all(|&corner| pieces.value(piece, corner).abs() < ON_CRACK * spacing)
    };
    let faces = |piece: usize| pieces.normal(piece, corners[0]).dot(normal) > LEANS;
    let flat = |piece: usize| pieces.is_cut(piece) && pieces.is_plane(piece);
    match quad.piece {
        Some(piece) if flat(piece) => {
            (quad.normal, lies_on(piece) || normal == DVec3::ZERO || faces(piece))
        }
        // Triangles that the outline does not know were made by a merged sliver's cracks.
        None => (quad.normal, pieces.has_cuts()),
        Some(piece) => {
            let crack = (0..pieces.len()).find(|&cut| flat(cut) && faces(cut) && lies_on(cut));
            crack.map_or((quad.normal, pieces.is_cut(piece)), |cut| {
                (pieces.normal(cut, corners[0]), true)
            })
        }
    }
}

/// True if a quad's diagonal from its first vertex is the better choice.
fn splits_at_first(contour: &DualContour, quad: &Quad, spacing: f64) -> bool {
    let [a, b, c, d] = quad.vertices.map(|vertex| contour.vertices[vertex as usize].position);

    // Along a sharp edge one diagonal lies on the surface, and the other cuts through, by more than
    // a smooth face bends.
    const BEND: f64 = 0.02;
    if quad.piece.is_some() {
        let off_surface =
            |point: DVec3| contour.pieces.max_value(point).map_or(0.0, |(value, _)| value.abs());
        let (first, second) = (off_surface(0.5 * (a + c)), off_surface(0.5 * (b + d)));
        if (first - second).abs() > BEND * spacing {
            return first < second;
        }
    }

    // On a smooth face, the one whose triangles both face outward, or else the shorter.
    let area = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).dot(quad.normal);
    let first = area(a, b, c).min(area(a, c, d));
    let second = area(b, c, d).min(area(b, d, a));
    if (first - second).abs() > 1e-6 * spacing * spacing && first.min(second) <= 0.0 {
        return first > second;
    }
    a.distance_squared(c) <= b.distance_squared(d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_form::ClosedForm;
    use crate::grid::Grid;
    use crate::grid_solid::{Outline, Root};
    use crate::half_space::HalfSpace;
    use crate::level_set::LevelSet;
    use glam::DQuat;
    use proptest::prelude::*;
    use std::collections::BTreeSet;
    use std::sync::Arc;

    /// Each directed edge occurs once, and its opposite once.
    fn is_closed(surface: &Surface) -> bool {
        let mut edges = BTreeSet::new();
        let all_once = surface
            .mesh
            .triangles
            .iter()
            .all(|&[a, b, c]| [(a, b), (b, c), (c, a)].iter().all(|e| edges.insert(*e)));
        all_once && edges.iter().all(|&(a, b)| edges.contains(&(b, a)))
    }

    fn volume(surface: &Surface) -> f64 {
        (0..surface.mesh.triangles.len())
            .map(|triangle| {
                let [a, b, c] = surface.mesh.corners(triangle);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    fn cut_solid(form: ClosedForm, cuts: Vec<HalfSpace>, grid: Grid) -> GridSolid {
        let distance = |p: DVec3| {
            cuts.iter().fold(form.distance_and_gradient(p).0, |d, cut| d.max(cut.distance(p)))
        };
        let mut solid = GridSolid::from_level_set(LevelSet::sample(grid, distance));
        solid.outline = Outline { root: Root::ClosedForm(form), cuts, rough: Vec::new() };
        solid
    }

    fn cubic_grid(half: f64, voxels: usize, shift: DVec3) -> Grid {
        let grid = Grid::around_box(DVec3::splat(-half), DVec3::splat(half), [voxels; 3], 2);
        Grid { origin: grid.origin + shift * grid.spacing, ..grid }
    }

    /// The six faces of a turned box, as the cuts of a root that is far away.
    fn turned_box(half: DVec3, rotation: DQuat) -> Vec<HalfSpace> {
        [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z]
            .map(|axis| HalfSpace { normal: rotation * axis, offset: half.dot(axis.abs()) })
            .to_vec()
    }

    fn corners(half: DVec3) -> impl Iterator<Item = DVec3> {
        let sign = |bit: i32| if bit & 1 == 1 { 1.0 } else { -1.0 };
        (0..8).map(move |c| half * DVec3::new(sign(c), sign(c >> 1), sign(c >> 2)))
    }

    fn nearest(surface: &Surface, point: DVec3) -> f64 {
        surface.mesh.positions.iter().map(|p| p.distance(point)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn turned_boxes_keep_their_corners_and_volume() {
        let half = DVec3::new(0.5, 0.3, 0.4);
        for n in 0..100 {
            let t = f64::from(n);
            let axis =
                DVec3::new(libm::sin(0.7 * t), libm::cos(1.3 * t), libm::sin(0.37 * t) + 0.1)
                    .normalize();
            let rotation = DQuat::from_axis_angle(axis, 0.61 * t);
            let grid = cubic_grid(0.75, 24, DVec3::new(0.13, 0.29, 0.41) * t);
            let grid = Grid {
                origin: grid.origin - (DVec3::new(0.13, 0.29, 0.41) * t).floor() * grid.spacing,
                ..grid
            };
            let surface = polygonize(&cut_solid(
                ClosedForm::Sphere { radius: 10.0 },
                turned_box(half, rotation),
                grid,
            ));
            assert!(is_closed(&surface));
            assert!(surface.interior.iter().all(|&interior| interior));
            for corner in corners(half) {
                assert!(nearest(&surface, rotation * corner) < 0.05 * grid.spacing);
            }
            assert!(
                (volume(&surface) / (8.0 * half.x * half.y * half.z) - 1.0).abs() < 1e-3,
                "{}",
                volume(&surface)
            );
        }
    }

    #[test]
    fn a_box_keeps_its_corners_wherever_the_nodes_lie() {
        let half = DVec3::new(0.5, 0.3, 0.4);
        let form = ClosedForm::Box { half };
        for shift in [0.0, 0.5, 0.21] {
            let grid = cubic_grid(0.5, 20, DVec3::new(shift, 0.3 * shift, 0.5));
            let surface = polygonize(&cut_solid(form, Vec::new(), grid));
            assert!(is_closed(&surface) && !surface.interior.contains(&true));
            assert!((volume(&surface) / form.mass_properties().unwrap().volume - 1.0).abs() < 1e-9);
            assert!(corners(half).all(|corner| nearest(&surface, corner) < 1e-6));
        }
    }

    #[test]
    fn both_halves_of_a_cut_box_are_flat_and_marked() {
        let form = ClosedForm::Box { half: DVec3::new(0.5, 0.3, 0.4) };
        let cut = HalfSpace { normal: DVec3::new(0.8, 0.5, -0.3).normalize(), offset: 0.07 };
        let grid = cubic_grid(0.55, 27, DVec3::new(0.3, 0.4, 0.1));
        let mut volumes = 0.0;
        for side in [cut, cut.flipped()] {
            let surface = polygonize(&cut_solid(form, vec![side], grid));
            assert!(is_closed(&surface));
            let mut area = [0.0; 2];
            for (triangle, &interior) in surface.interior.iter().enumerate() {
                let [a, b, c] = surface.mesh.corners(triangle);
                area[usize::from(interior)] += 0.5 * (b - a).cross(c - a).length();
                for corner in [a, b, c] {
                    let off = if interior {
                        side.distance(corner)
                    } else {
                        form.distance_and_gradient(corner).0
                    };
                    assert!(off.abs() < 1e-6 * grid.spacing, "{off}");
                }
            }
            volumes += volume(&surface);
            assert!(area[1] > 0.2 && area[0] > area[1], "{area:?}");
        }
        assert!((volumes / form.mass_properties().unwrap().volume - 1.0).abs() < 1e-3);
    }

    #[test]
    fn round_solids_have_their_vertices_on_the_surface() {
        let grid = cubic_grid(1.0, 32, DVec3::new(0.2, 0.4, 0.3));
        let ball = ClosedForm::Sphere { radius: 0.9 };
        let drum = ClosedForm::Cylinder { radius: 0.7, half_height: 0.6 };
        for form in [ball, drum] {
            let exact = cut_solid(form, Vec::new(), grid);
            let sampled = GridSolid::from_level_set(exact.level_set().clone());
            let deviation = |solid: &GridSolid| {
                let surface = polygonize(solid);
                assert!(is_closed(&surface));
                let off = |p: &DVec3| form.distance_and_gradient(*p).0.abs() / grid.spacing;
                let volume_error = volume(&surface) / form.mass_properties().unwrap().volume - 1.0;
                (surface.mesh.positions.iter().map(off).fold(0.0, f64::max), volume_error.abs())
            };
            let (worst, volume_error) = deviation(&exact);
            assert!(worst < 1e-6 && volume_error < 5e-3, "{form:?}: {worst} {volume_error}");
            // From samples alone, edges are as round as they are in the samples.
            let (worst, volume_error) = deviation(&sampled);
            let allowed = if form == ball { 0.05 } else { 0.4 };
            assert!(
                worst < allowed && volume_error < 5e-3,
                "{form:?} sampled: {worst} {volume_error}"
            );
        }
    }

    #[test]
    fn a_ring_has_the_topology_of_a_ring() {
        let grid = cubic_grid(1.0, 24, DVec3::ZERO);
        let ring = |p: DVec3| {
            let from_circle = (p.x * p.x + p.z * p.z).sqrt() - 0.65;
            (from_circle * from_circle + p.y * p.y).sqrt() - 0.25
        };
        let surface = polygonize(&GridSolid::from_level_set(LevelSet::sample(grid, ring)));
        assert!(is_closed(&surface));
        let triangles = surface.mesh.triangles.len();
        assert_eq!(
            surface.mesh.positions.len() + triangles,
            3 * triangles / 2,
            "Euler's characteristic is 0"
        );
    }

    #[test]
    fn what_touches_the_border_of_the_grid_is_closed_there() {
        let grid = Grid { origin: DVec3::new(1.0, 2.0, 3.0), spacing: 0.1, dims: [5, 4, 3] };
        let surface =
            polygonize(&GridSolid::from_level_set(LevelSet::new(grid, vec![-1.0; grid.len()])));
        assert!(is_closed(&surface) && !surface.interior.contains(&true));
        assert!(
            (volume(&surface) / (60.0 * grid.voxel_volume()) - 1.0).abs() < 1e-9,
            "{}",
            volume(&surface)
        );
    }

    /// A sliver from beyond a cut was merged: the outline's plane passes through the solid, and
    /// leaves no dent.
    #[test]
    fn a_cut_through_a_merged_sliver_is_ignored() {
        let half = DVec3::new(0.5, 0.3, 0.4);
        let grid = cubic_grid(0.5, 20, DVec3::splat(0.5));
        let form = ClosedForm::Box { half };
        let mut solid = cut_solid(form, Vec::new(), grid);
        solid.outline.cuts = vec![HalfSpace { normal: DVec3::X, offset: 0.5 - 1.6 * grid.spacing }];
        let surface = polygonize(&solid);
        assert!(is_closed(&surface));
        assert!(
            (volume(&surface) / form.mass_properties().unwrap().volume - 1.0).abs() < 1e-3,
            "{}",
            volume(&surface)
        );
    }

    fn noise(dims: [usize; 3]) -> impl Strategy<Value = GridSolid> {
        prop::collection::vec(-1.0..1.0f32, dims[0] * dims[1] * dims[2]).prop_map(move |phi| {
            GridSolid::from_level_set(LevelSet::new(
                Grid { origin: DVec3::ZERO, spacing: 0.5, dims },
                phi,
            ))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// However the signs lie, each edge has one opposite, and what is enclosed has the outside
        /// outside.
        #[test]
        fn noise_has_a_closed_surface(mut solid in noise([5, 4, 6]), x in -1.0..1.0f64, offset in 0.0..2.0f64) {
            let surface = polygonize(&solid);
            prop_assert!(is_closed(&surface));
            let nodes_inside = solid.level_set().phi().iter().filter(|&&phi| phi < 0.0).count();
            prop_assert!(volume(&surface) > 0.0 || nodes_inside < 5);
            // Independent of the outline.
            let normal = DVec3::new(x, 1.0, 0.3).normalize();
            solid.outline = Outline {
                root: Root::Sampled(Arc::new(solid.level_set().clone())),
                cuts: vec![HalfSpace { normal, offset }, HalfSpace { normal: -normal, offset: -0.8 * offset }],
                rough: Vec::new(),
            };
            prop_assert!(is_closed(&polygonize(&solid)));
        }
    }

    #[test]
    fn a_doubled_triangle_is_not_closed() {
        let solid =
            GridSolid::from_closed_form(ClosedForm::Sphere { radius: 1.0 }, [8; 3], 2).unwrap();
        let mut surface = polygonize(&solid);
        assert!(is_closed(&surface));
        let triangle = surface.mesh.triangles.pop().unwrap();
        assert!(!is_closed(&surface));
        surface.mesh.triangles.extend([triangle, triangle]);
        assert!(!is_closed(&surface));
    }
}
