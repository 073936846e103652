//! Where planar cracks meet the surface of a body that is known from samples only.

use frangible_geometry::polygonize;
use frangible_geometry::{Grid, GridSolid, HalfSpace, LevelSet, Outline, Root, Surface};
use glam::DVec3;
use std::sync::Arc;

/// Distances that should be zero, in cells.
#[derive(Debug, Default)]
struct RimErrors {
    /// Corners of interior triangles to the nearest crack.
    off_crack: f64,
    /// All vertices to the outside of the cracks.
    beyond_crack: f64,
    /// Each vertex between interior and other triangles to the samples' zero. Not on blades of less
    /// than 30 degrees: they are thinner than a cell for several cells.
    off_root: Vec<f64>,
    /// Area of interior triangles that do not lie in one crack, as a part of all.
    bent_area: f64,
}

fn measure(solid: &GridSolid, surface: &Surface) -> RimErrors {
    let Root::Sampled(root) = &solid.outline.root else { unreachable!() };
    let spacing = root.grid().spacing;
    let mesh = &surface.mesh;
    let off =
        |cut: &HalfSpace, vertex: u32| cut.distance(mesh.positions[vertex as usize]) / spacing;
    let mut errors = RimErrors::default();
    let mut touches = vec![[false; 2]; mesh.positions.len()];
    let mut interior_area = 0.0;
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let interior = surface.interior[triangle];
        for &vertex in corners {
            touches[vertex as usize][usize::from(interior)] = true;
        }
        if interior {
            let [a, b, c] = mesh.corners(triangle);
            let area = (b - a).cross(c - a).length();
            interior_area += area;
            let in_one = solid
                .outline
                .cuts
                .iter()
                .any(|cut| corners.iter().all(|&v| off(cut, v).abs() < 0.02));
            errors.bent_area += if in_one { 0.0 } else { area };
        }
    }
    errors.bent_area /= interior_area;
    for (vertex, position) in mesh.positions.iter().enumerate() {
        let cuts = || solid.outline.cuts.iter().map(|cut| off(cut, vertex as u32));
        errors.beyond_crack = cuts().fold(errors.beyond_crack, f64::max);
        if touches[vertex][1] {
            errors.off_crack =
                errors.off_crack.max(cuts().map(f64::abs).fold(f64::INFINITY, f64::min));
        }
        let (value, gradient) = root.value_and_gradient(*position);
        let is_blade = solid.outline.cuts.iter().zip(cuts()).any(|(cut, off)| {
            off.abs() < 0.02 && cut.normal.dot(gradient.as_dvec3().normalize()) < -0.85
        });
        if touches[vertex] == [true, true] && !is_blade {
            errors.off_root.push(f64::from(value).abs() / spacing);
        }
    }
    errors
}

/// The eight parts into which three planes cut a body.
fn octants(root: &Arc<LevelSet>, planes: [HalfSpace; 3]) -> Vec<GridSolid> {
    let part = |sides: usize| {
        let turned = |(n, plane): (usize, HalfSpace)| match sides >> n & 1 {
            0 => plane,
            _ => plane.flipped(),
        };
        let cuts: Vec<HalfSpace> = planes.into_iter().enumerate().map(turned).collect();
        let distance = |point: DVec3| {
            cuts.iter()
                .fold(f64::from(root.value(point)), |largest, cut| largest.max(cut.distance(point)))
        };
        let mut solid = GridSolid::from_level_set(LevelSet::sample(*root.grid(), distance));
        solid.outline = Outline { root: Root::Sampled(root.clone()), cuts, rough: Vec::new() };
        solid
    };
    (0..8).map(part).collect()
}

/// Three planes that are nearly at right angles, and pass near the middle.
fn planes(turn: f64) -> [HalfSpace; 3] {
    [0.0, 1.0, 2.0].map(|n| {
        let wobble = DVec3::new(
            libm::sin(turn + 3.0 * n),
            libm::cos(2.0 * turn + n),
            libm::sin(5.0 * turn - n),
        );
        let normal = (DVec3::AXES[n as usize] + 0.4 * wobble).normalize();
        HalfSpace { normal, offset: 0.15 * libm::sin(7.0 * turn + n) }
    })
}

fn ball(point: DVec3) -> f64 {
    point.length() - 0.9
}

/// A ring around the z axis.
fn ring(point: DVec3) -> f64 {
    let from_circle = (point.x * point.x + point.y * point.y).sqrt() - 0.65;
    (from_circle * from_circle + point.z * point.z).sqrt() - 0.3
}

/// A ball whose surface is as uneven as that of a scan.
fn scan(point: DVec3) -> f64 {
    let wave = |x: f64| libm::sin(14.0 * x);
    ball(point) + 0.008 * (wave(point.x) + wave(point.y) + wave(point.z))
}

fn sampled(distance: fn(DVec3) -> f64) -> Arc<LevelSet> {
    let grid = Grid::around_box(DVec3::splat(-1.0), DVec3::splat(1.0), [40; 3], 2);
    Arc::new(LevelSet::sample(grid, distance))
}

#[test]
fn cracks_are_flat_up_to_their_rims_and_rims_lie_on_the_surface() {
    for distance in [ball, ring, scan] {
        let root = sampled(distance);
        let whole =
            polygonize(&GridSolid::from_level_set((*root).clone())).mesh.mass_properties().volume;
        for turn in [0.0, 0.7, 1.9, 2.8] {
            let mut volume = 0.0;
            let mut off_root = Vec::new();
            for solid in octants(&root, planes(turn)) {
                let surface = polygonize(&solid);
                volume += surface.mesh.mass_properties().volume;
                let RimErrors { off_crack, beyond_crack, off_root: on_rims, bent_area } =
                    measure(&solid, &surface);
                assert!(
                    off_crack < 1e-6 && beyond_crack < 0.02,
                    "{turn}: {off_crack}, {beyond_crack}"
                );
                assert!(bent_area < 0.005, "{turn}: {bent_area}");
                off_root.extend(on_rims);
            }
            // Where two cracks and the surface meet, a cell can be too coarse for all corners.
            let far = off_root.iter().filter(|&&off| off > 0.1).count();
            assert!(
                off_root.len() > 500 && far * 100 < off_root.len(),
                "{turn}: {far} of {}",
                off_root.len()
            );
            assert!((volume / whole - 1.0).abs() < 2e-3, "{turn}: {volume} of {whole}");
        }
    }
}

#[test]
fn a_rim_that_stands_out_is_measured() {
    let solid = octants(&sampled(ball), planes(0.7)).remove(0);
    let mut surface = polygonize(&solid);
    let cut = solid.outline.cuts[0];
    let spacing = solid.grid().spacing;
    let mesh = &mut surface.mesh;
    let on_rim = mesh
        .positions
        .iter_mut()
        .find(|p| cut.distance(**p).abs() < 1e-9 && ball(**p).abs() < 0.1 * spacing);
    *on_rim.unwrap() += 0.3 * spacing * cut.normal;
    let errors = measure(&solid, &surface);
    assert!(
        errors.beyond_crack > 0.29 && errors.off_crack > 0.1 && errors.bent_area > 0.0,
        "{errors:?}"
    );
}
