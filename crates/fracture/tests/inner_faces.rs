//! For any way to break a body, crack faces are marked, and equal the contact area of both sides.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use frangible_fracture::{
    Bricks, Concrete, Fragment, Impact, Natural, Pattern, Radial, ShatterSettings, Slices,
    Splinters, Voronoi, break_on_grid, interfaces, shatter,
};
use frangible_geometry::{ClosedForm, GridSolid, Shape, closed_form_surface};
use glam::DVec3;

fn patterns() -> Vec<(&'static str, Pattern)> {
    let half_extent = DVec3::new(1.0, 0.6, 0.8);
    let bricks = Bricks { columns: 3, courses: 5, mortar: 0.0, half_extent, ..Bricks::default() };
    vec![
        ("radial", Pattern::radial(&Radial { rings: 1, ..Radial::default() }).unwrap()),
        ("voronoi", Pattern::voronoi(&Voronoi::default()).unwrap()),
        ("natural", Pattern::natural(&Natural { cells: 20, ..Natural::default() }).unwrap()),
        ("slices", Pattern::slices(&Slices { cells: 6, ..Slices::default() }).unwrap()),
        ("bricks", Pattern::bricks(&bricks).unwrap()),
        (
            "splinters",
            Pattern::splinters(&Splinters { fibres: 10, ..Splinters::default() }).unwrap(),
        ),
        ("concrete", Pattern::concrete(&Concrete { cells: 12, ..Concrete::default() }).unwrap()),
        (
            "gravel",
            Pattern::concrete(&Concrete {
                cells: 12,
                roughness: 1.0,
                grain: 1.5,
                ..Concrete::default()
            })
            .unwrap(),
        ),
    ]
}

/// Area of what cracks laid bare over twice the area of the contacts.
fn ratio(fragments: &[Fragment]) -> f64 {
    let mut inner = 0.0;
    for fragment in fragments {
        let surface = fragment.shape.surface();
        for (triangle, &interior) in surface.interior.iter().enumerate() {
            let [a, b, c] = surface.mesh.corners(triangle);
            inner += f64::from(u8::from(interior)) * 0.5 * (b - a).cross(c - a).length();
        }
    }
    inner / (2.0 * interfaces(fragments).iter().map(|contact| contact.area).sum::<f64>())
}

/// Maximum difference of the two areas. Wedges around a blow end in tips thinner than a voxel.
fn most(pattern: &str) -> f64 {
    match pattern {
        "radial" => 0.1,
        "concrete" | "gravel" => 0.06,
        _ => 0.04,
    }
}

const BLOW: Impact = Impact { point_body: DVec3::new(0.05, 0.02, 0.2), normal_body: DVec3::Z };

#[test]
fn inner_faces_are_those_of_the_contacts_on_meshes() {
    let ball = closed_form_surface(&ClosedForm::Sphere { radius: 0.3 });
    let slab = closed_form_surface(&ClosedForm::Box { half: DVec3::new(0.5, 0.3, 0.2) });
    for (body, mesh) in [("ball", ball), ("slab", slab)] {
        for (name, pattern) in patterns() {
            let voxels = if pattern.planar().is_some() { 72 } else { 48 };
            let (_, fragments) = break_on_grid(&mesh, &pattern, &BLOW, voxels).unwrap();
            let ratio = ratio(&fragments);
            assert!((ratio - 1.0).abs() < most(name), "{body} along {name}: {ratio}");
        }
    }
}

#[test]
fn inner_faces_are_those_of_the_contacts_on_formulas() {
    let forms = [
        ClosedForm::Box { half: DVec3::new(0.5, 0.3, 0.2) },
        ClosedForm::Sphere { radius: 0.3 },
        ClosedForm::Cylinder { radius: 0.25, half_height: 0.3 },
    ];
    for form in forms {
        let along = (form.bounds().1 / form.bounds().1.max_element())
            .to_array()
            .map(|part| (56.0 * part) as usize);
        let solid = GridSolid::from_closed_form(form, along, 2).unwrap();
        let on_grid = Shape::from_grid_solid(solid, Vec::new()).unwrap();
        let exact = Shape::breakable(form, 0.05).unwrap();
        for (name, pattern) in patterns() {
            for (body, most) in [(&on_grid, most(name)), (&exact, 1e-2)] {
                let fragments = shatter(body, &pattern, &BLOW, &ShatterSettings::default());
                if !fragments.is_empty() {
                    let ratio = ratio(&fragments);
                    assert!((ratio - 1.0).abs() < most, "{form:?} along {name}: {ratio}");
                }
            }
        }
    }
}
