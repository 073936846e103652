//! Geometry of fragments: level sets, samples, slivers.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use common::solid;
use frangible_fracture::{Fragment, Pattern, Radial, ShatterSettings, Voronoi, shatter};
use frangible_geometry::{ClosedForm, Root, Shape, polygonize};
use glam::DVec3;
use rand::RngExt;

/// Breaks of all bodies with all patterns: name, parent, its fragments.
fn breaks(settings: &ShatterSettings) -> Vec<(&'static str, Shape, Vec<Fragment>)> {
    let mut random = common::random(31);
    let mut breaks = Vec::new();
    for (name, body) in common::bodies() {
        for pattern in common::patterns(6) {
            let impact = common::random_impact(&body, &mut random);
            let fragments = shatter(&body, &pattern, &impact, settings);
            breaks.push((name, body.clone(), fragments));
        }
    }
    breaks
}

/// Signed distance [m] of a fragment at a point in the grid frame [m].
fn value(fragment: &Fragment, point_grid: DVec3) -> f64 {
    f64::from(solid(&fragment.shape).value(point_grid))
}

#[test]
fn level_sets_do_not_overlap_and_leave_no_gap() {
    let mut random = common::random(32);
    for (name, body, fragments) in breaks(&ShatterSettings::default()) {
        let level_set = solid(&body).level_set();
        let grid = level_set.grid();
        let (low, high) = grid.bounds();
        for _ in 0..2000 {
            let point =
                low + (high - low) * DVec3::new(random.random(), random.random(), random.random());
            let mut values: Vec<f64> =
                fragments.iter().map(|fragment| value(fragment, point)).collect();
            values.sort_by(f64::total_cmp);
            assert!(
                values[1] > -0.5 * grid.spacing,
                "{name}: two pieces overlap by {}",
                -values[1]
            );
            if f64::from(level_set.value(point)) < -grid.spacing {
                assert!(values[0] < grid.spacing, "{name}: a gap of {} in the body", values[0]);
            }
        }
    }
}

/// At the nodes of a piece the sign is right, and inside of the body the value is the distance to
/// the nearest surface of parent and cracks: for convex bodies, whose pieces are what their
/// outlines say.
#[test]
fn inside_the_level_set_is_the_outline() {
    let settings = ShatterSettings { smallest_fragment_voxels: 0.0, ..ShatterSettings::default() };
    for (name, _, fragments) in breaks(&settings) {
        for fragment in &fragments {
            let solid = solid(&fragment.shape);
            let grid = solid.grid();
            let coverage = solid.coverage();
            let Root::ClosedForm(form) = solid.outline.root else { continue };
            for (node, &phi) in solid.level_set().phi().iter().enumerate() {
                if phi <= 0.0 {
                    let [i, j, k] = grid.coordinates(node);
                    let point = grid.node(i, j, k);
                    let root = form.distance_and_gradient(point).0;
                    let outline = solid
                        .outline
                        .cuts
                        .iter()
                        .map(|cut| cut.distance(point))
                        .fold(root, f64::max);
                    assert!((outline - f64::from(phi)).abs() < 1e-6, "{name}: {outline} {phi}");
                    assert!(coverage[node] > 0.0);
                }
            }
        }
    }
}

/// Signed distance [m] of a fragment's exact surface at a point in the grid frame [m].
fn outline_distance(fragment: &Fragment, point: DVec3) -> f64 {
    let outline = &solid(&fragment.shape).outline;
    let root = match &outline.root {
        Root::ClosedForm(form) => form.distance_and_gradient(point).0,
        Root::Hull(hull) => hull.distance_and_gradient(point).0,
        Root::Sampled(level_set) => f64::from(level_set.value(point)),
    };
    outline.cuts.iter().map(|cut| cut.distance(point)).fold(root, f64::max)
}

/// Nearly all samples are within half a voxel of the level set's surface. The others are sharp
/// tips, which the level set rounds off: on the exact surface, but for the odd tip of a merged
/// sliver.
#[test]
fn samples_lie_on_their_fragment_and_in_no_other() {
    let (mut all, mut near, mut off) = (0_usize, 0_usize, 0_usize);
    for (name, body, fragments) in breaks(&ShatterSettings::default()) {
        let h = solid(&body).grid().spacing;
        for fragment in &fragments {
            assert!(fragment.shape.samples().len() >= 4, "{name}");
            let grid_from_body = fragment.shape.body_from_grid.inverse();
            for sample in fragment.shape.samples() {
                let point = grid_from_body.point(sample.as_dvec3());
                let distance = value(fragment, point).abs() / h;
                let exact = outline_distance(fragment, point).abs() / h;
                off += usize::from(distance > 1.0 && exact > 0.05);
                all += 1;
                near += usize::from(distance <= 0.5);
                for other in &fragments {
                    let depth = -value(other, point) / h;
                    assert!(depth <= 0.5, "{name}: {depth} voxels inside of another fragment");
                }
            }
        }
    }
    assert!(off <= all / 1000, "{off} of {all} are off the surface");
    assert!(
        near as f64 > 0.98 * all as f64,
        "{near} of {all} lie within half a voxel of the surface"
    );
}

/// No sample of the parent is lost, except where a crack's sample takes its place; none goes to two
/// fragments, except where it lies on a crack.
#[test]
fn the_parents_samples_are_shared_out() {
    for (name, body, fragments) in breaks(&ShatterSettings::default()) {
        let h = solid(&body).grid().spacing;
        for &sample in body.samples() {
            let point_grid = body.body_from_grid.inverse().point(sample.as_dvec3());
            let (mut exact, mut on_crack, mut nearest) = (0, false, f32::INFINITY);
            for fragment in &fragments {
                let own =
                    fragment.parent_from_fragment.inverse().point(sample.as_dvec3()).as_vec3();
                let distances = fragment.shape.samples().iter().map(|other| (other - own).length());
                let here = distances.fold(f32::INFINITY, f32::min);
                exact += usize::from(here < 1e-6);
                nearest = nearest.min(here);
                let cuts = &solid(&fragment.shape).outline.cuts;
                on_crack |= cuts.iter().any(|cut| cut.distance(point_grid).abs() < 1e-5);
            }
            assert!(exact <= 1 || on_crack, "{name}: a sample in {exact} fragments");
            assert!(
                f64::from(nearest) < h,
                "{name}: a sample is lost, the nearest is {nearest} m away"
            );
        }
    }
}

/// A curved body's cracks have their rims sampled: points on both the sphere and a crack.
#[test]
fn cracks_through_a_sphere_have_rims() {
    let sphere = common::bodies().swap_remove(0).1;
    let mut random = common::random(33);
    let impact = common::random_impact(&sphere, &mut random);
    let pattern = Pattern::voronoi(&Voronoi { cells: 12, ..Voronoi::default() }).unwrap();
    let fragments = shatter(&sphere, &pattern, &impact, &ShatterSettings::default());
    for fragment in &fragments {
        let outline = &solid(&fragment.shape).outline;
        let Root::ClosedForm(ClosedForm::Sphere { radius }) = outline.root else {
            panic!("a sphere")
        };
        let grid_from_body = fragment.shape.body_from_grid.inverse();
        let points: Vec<DVec3> = fragment
            .shape
            .samples()
            .iter()
            .map(|sample| grid_from_body.point(sample.as_dvec3()))
            .collect();
        let on_sphere = |point: &&DVec3| (point.length() - radius).abs() < 1e-5;
        for cut in &outline.cuts {
            let on_cut = |point: &&DVec3| cut.distance(**point).abs() < 1e-5;
            let face = points.iter().filter(on_cut).count();
            let rim = points.iter().filter(on_cut).filter(on_sphere).count();
            // A crack that only touches the voxels has no face; one within the sphere has no rim.
            assert!(
                face < 12
                    || rim >= 3
                    || points.iter().filter(on_cut).all(|p| p.length() < 0.9 * radius)
            );
        }
    }
}

#[test]
fn slivers_join_a_neighbour() {
    let count = |fragments: &[Fragment], voxel: f64| {
        fragments.iter().filter(|fragment| fragment.shape.volume < 27.0 * voxel).count()
    };
    let keep = ShatterSettings { smallest_fragment_voxels: 0.0, ..ShatterSettings::default() };
    let (mut kept, mut merged) = (0, 0);
    for (with, without) in breaks(&ShatterSettings::default()).iter().zip(breaks(&keep)) {
        let voxel = solid(&with.1).grid().voxel_volume();
        kept += count(&without.2, voxel);
        merged += count(&with.2, voxel);
    }
    assert!(kept > 20 && merged == 0, "{kept} slivers without merging, {merged} with it");
}

/// A crumb that touches nothing else is a fragment, however small.
#[test]
fn what_stands_alone_stays() {
    let body = common::sampled(DVec3::splat(-0.5), DVec3::splat(0.5), [20; 3], |point| {
        let ball = (point + 0.1).length() - 0.3;
        let crumb = (point - DVec3::splat(0.4)).length() - 0.06;
        ball.min(crumb)
    });
    let mut random = common::random(34);
    let impact = common::random_impact(&body, &mut random);
    let pattern = Pattern::radial(&Radial { spokes: 3, ..Radial::default() }).unwrap();
    let fragments = shatter(&body, &pattern, &impact, &ShatterSettings::default());
    let voxel = solid(&body).grid().voxel_volume();
    let crumbs: Vec<&Fragment> =
        fragments.iter().filter(|f| f.shape.volume < 27.0 * voxel).collect();
    assert_eq!(crumbs.len(), 1);
    assert!(
        crumbs[0].shape.samples().len() >= 4 && crumbs[0].shape.unit_moments.min_element() > 0.0
    );
}

/// The same break gives the same bits.
#[test]
fn breaks_repeat() {
    let settings = ShatterSettings::default();
    for (first, second) in breaks(&settings).iter().zip(breaks(&settings)) {
        assert_eq!(first.2.len(), second.2.len());
        for (a, b) in first.2.iter().zip(&second.2) {
            assert_eq!(a.parent_from_fragment, b.parent_from_fragment);
            assert_eq!(a.shape.samples(), b.shape.samples());
            assert_eq!(solid(&a.shape).level_set().phi(), solid(&b.shape).level_set().phi());
        }
    }
}

/// The fragments' surfaces are closed, and together they enclose what the parent's does.
#[test]
fn surfaces_fit_together() {
    for (name, body, fragments) in breaks(&ShatterSettings::default()) {
        let volume = |shape: &Shape| polygonize(solid(shape)).mesh.mass_properties().volume;
        let whole = volume(&body);
        let parts: f64 = fragments.iter().map(|fragment| volume(&fragment.shape)).sum();
        // The missing volume is rounded off along the rims, where three surfaces meet within a
        // voxel.
        assert!(parts < 1.001 * whole && parts > 0.97 * whole, "{name}: {parts} of {whole} m^3");
    }
}
