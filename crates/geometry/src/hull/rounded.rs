//! The surface of a part of a ball or a cylinder: round where the body was, flat along its cracks.

use super::Hull;
use super::face_loops::FaceLoops;
use super::half_edges::HalfEdgeMesh;
use super::round::prism;
use crate::closed_form::ClosedForm;
use crate::closed_form_surface::DRAWN_SIDES;
use crate::closed_form_surface::closed_form_surface;
use crate::half_space::HalfSpace;
use crate::hull::edges::plane_of;
use crate::hull::plane_clip::PlaneClipper;
use crate::mesh::Surface;
use glam::DVec3;

/// Steps of Newton's method from a chord to the round surface.
const STEPS: usize = 6;

/// Squared sine of the angle below which planes touch the round surface and have no edge with it.
const LEAST_SLOPE: f64 = 0.01;

/// A vertex is moved by less than this part of the radius: chords lie no deeper.
const FARTHEST: f64 = 0.05;

/// The closed surface, in the frame of `form`, of the part of a ball or a cylinder that lies behind
/// the inner faces of `hull`: the triangles that the whole body is drawn with, cut by these faces.
/// Vertices lie on the round surface, also along the rims of the cracks. `None` for other forms,
/// and for a part outside of the round body.
pub(crate) fn rounded_surface(form: &ClosedForm, hull: &Hull) -> Option<Surface> {
    let whole = fine_hull(form)?;
    let cracks: Vec<HalfSpace> =
        hull.faces().filter(|face| face.inner).map(|face| face.plane).collect();
    let mut part = PlaneClipper::default().clipped(&whole, &cracks)?;
    let planes = planes_at_vertices(form, &part);
    for (vertex, planes) in part.vertices.iter_mut().zip(&planes) {
        // Cracks that graze the round surface meet it far away or never: they bend slightly.
        let place = planes.as_ref().and_then(|planes| {
            on_surface(form, *vertex, planes).or_else(|| on_surface(form, *vertex, &[]))
        });
        *vertex = place.unwrap_or(*vertex);
    }
    Some(part.tagged_surface())
}

/// A polyhedron of many faces with its vertices on a ball or a cylinder, as the whole body is
/// drawn.
fn fine_hull(form: &ClosedForm) -> Option<Hull> {
    let (mut loops, mut planes) = (FaceLoops::default(), Vec::new());
    let positions = match *form {
        ClosedForm::Sphere { .. } => {
            let mesh = closed_form_surface(form);
            for (number, &corners) in mesh.triangles.iter().enumerate() {
                planes.push(plane_of(mesh.corners(number).into_iter())?);
                loops.push(false, corners);
            }
            mesh.positions
        }
        ClosedForm::Cylinder { radius, half_height } => {
            return Some(prism(radius, half_height, DRAWN_SIDES));
        }
        ClosedForm::Box { .. }
        | ClosedForm::HalfSpace(_)
        | ClosedForm::Capsule { .. }
        | ClosedForm::Cone { .. } => return None,
    };
    Some(Hull::new(positions, planes, HalfEdgeMesh::of(&loops)?))
}

/// For each vertex the normals of the flat faces around it; `None` for one without a round face.
fn planes_at_vertices(form: &ClosedForm, hull: &Hull) -> Vec<Option<Vec<DVec3>>> {
    let is_cap = |face: usize| {
        matches!(form, ClosedForm::Cylinder { .. }) && hull.planes[face].normal.y.abs() > 0.5
    };
    let is_round = |face: usize| !hull.net.is_inner(face) && !is_cap(face);
    let mut around: Vec<Option<Vec<DVec3>>> = vec![None; hull.vertices.len()];
    for face in (0..hull.planes.len()).filter(|&face| is_round(face)) {
        for &vertex in hull.net.corners(face) {
            around[vertex as usize].get_or_insert_default();
        }
    }
    for face in (0..hull.planes.len()).filter(|&face| !is_round(face)) {
        for &vertex in hull.net.corners(face) {
            if let Some(planes) = &mut around[vertex as usize] {
                planes.push(hull.planes[face].normal);
            }
        }
    }
    around
}

/// The point of the round surface near a point of a chord, in all the planes that the point lies
/// in.
fn on_surface(form: &ClosedForm, from: DVec3, planes: &[DVec3]) -> Option<DVec3> {
    let radius = match *form {
        ClosedForm::Sphere { radius } | ClosedForm::Cylinder { radius, .. } => radius,
        ClosedForm::Box { .. }
        | ClosedForm::HalfSpace(_)
        | ClosedForm::Capsule { .. }
        | ClosedForm::Cone { .. } => return None,
    };
    // Across the surface from its middle, or its axis.
    let across = |point: DVec3| match form {
        ClosedForm::Cylinder { .. } => DVec3::new(point.x, 0.0, point.z),
        _ => point,
    };
    let mut held: Vec<DVec3> = Vec::with_capacity(2);
    for &normal in planes {
        let rest = held.iter().fold(normal, |rest, &known| rest - known * known.dot(rest));
        held.extend(rest.try_normalize().filter(|_| rest.length_squared() > LEAST_SLOPE));
    }
    let mut point = from;
    for _ in 0..STEPS {
        let outward = across(point);
        let distance = outward.length();
        let outward = outward.try_normalize()?;
        let along = held.iter().fold(outward, |along, &normal| along - normal * normal.dot(along));
        if along.length_squared() < LEAST_SLOPE {
            return None;
        }
        point += along * ((radius - distance) / along.length_squared());
    }
    (point.distance(from) < FARTHEST * radius).then_some(point)
}
