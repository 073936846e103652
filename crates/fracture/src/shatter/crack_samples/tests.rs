#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use super::*;
use crate::align::Impact;
use crate::generators::voronoi::Voronoi;
use crate::pattern::Pattern;
use frangible_geometry::{ClosedForm, GridSolid, Shape};

/// Both sides of a crack have bit-identical points between the edges.
#[test]
fn both_sides_of_a_crack_have_the_same_points() {
    let solid =
        GridSolid::from_closed_form(ClosedForm::Sphere { radius: 0.5 }, [21; 3], 2).unwrap();
    let shape = Shape::from_grid_solid(solid.clone(), Vec::new()).unwrap();
    let pattern =
        Pattern::voronoi(&Voronoi { half_extent: DVec3::ONE, ..Voronoi::default() }).unwrap();
    let normal_body = DVec3::new(0.3, 0.9, -0.2).normalize();
    let impact = Impact { point_body: 0.5 * normal_body, normal_body };
    let placement = Placement::new(&pattern, &impact, &shape);
    let regions = pattern.planar().unwrap();
    let planes = placement.planes(regions);

    let parent = Parent::new(&solid);
    let mut sampler = Sampler::new(&parent, 2.0 * solid.grid().spacing);
    let mut faces: Vec<(DVec3, Vec<DVec3>)> = Vec::new();
    for (planes, of_pattern) in planes.iter().zip(regions) {
        let own = sampler.sample(planes, &placement, of_pattern);
        faces.extend(
            own.filter(|face| !face.inner.is_empty())
                .map(|face| (face.normal, face.inner.to_vec())),
        );
    }
    assert!(faces.len() > 10, "{} faces", faces.len());
    for (normal, points) in &faces {
        let across = faces.iter().filter(|(other, _)| is_same(*other, -*normal, 1e-9));
        assert_eq!(
            across.filter(|(_, others)| others == points).count(),
            1,
            "{} points",
            points.len()
        );
    }
}
