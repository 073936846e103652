//! The least overlap of two cores over all normals: a polytope in their difference that grows where
//! its surface is nearest to the origin [Bergen01].
//!
//! The overlap along a direction is how far the difference reaches there. The plane of the nearest
//! face says how far it reaches at least, the support point beyond it how far at most.

use glam::DVec3;

/// Points of the surface at most. Two rims need about sixty.
const MOST_POINTS: usize = 400;

/// A point lies outside of a face if it is this part of the body's size beyond its plane.
const ROUNDING: f64 = 1e-15;

/// A triangle of the surface.
pub(crate) struct Face {
    /// [m], in turn as seen from outside.
    pub(crate) corners: [DVec3; 3],
    /// Unit, outward.
    normal: DVec3,
    /// Of its plane, along the normal from the origin [m]; infinite without area.
    offset: f64,
    /// No point lies beyond it.
    is_last: bool,
}

impl Face {
    fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        match (b - a).cross(c - a).try_normalize() {
            Some(normal) => {
                let offsets = corners.map(|corner| corner.dot(normal)).into_iter();
                Self {
                    corners,
                    normal,
                    offset: offsets.fold(f64::INFINITY, f64::min),
                    is_last: false,
                }
            }
            None => Self { corners, normal: DVec3::ZERO, offset: f64::INFINITY, is_last: true },
        }
    }

    pub(crate) fn sides(&self) -> [[DVec3; 2]; 3] {
        let [a, b, c] = self.corners;
        [[a, b], [b, c], [c, a]]
    }

    fn is_seen_from(&self, point: DVec3, rounding: f64) -> bool {
        self.offset.is_finite() && point.dot(self.normal) - self.offset > rounding
    }
}

/// The direction in which a convex body reaches least far.
pub(crate) struct Least {
    /// Unit.
    pub(crate) direction: DVec3,
    /// A closed surface of points of the body.
    pub(crate) surface: Vec<Face>,
}

/// The least reach of a convex body with the origin inside, within `precise` [m]; `None` for a flat
/// one. Where rounding ends the search earlier it is the least of all that were tried.
pub(crate) fn least_reach(support: impl Fn(DVec3) -> DVec3, precise: f64) -> Option<Least> {
    let mut surface = tetrahedron(&support)?;
    let corners = surface.iter().flat_map(|face| face.corners);
    let rounding = ROUNDING * corners.map(DVec3::length).fold(0.0, f64::max);
    let (mut least, mut direction) = (f64::INFINITY, DVec3::Y);
    for _ in 0..MOST_POINTS {
        let growing = (0..surface.len()).filter(|&at| !surface[at].is_last);
        let by_offset = |&a: &usize, &b: &usize| surface[a].offset.total_cmp(&surface[b].offset);
        let Some(at) = growing.min_by(by_offset) else { break };
        let Face { normal, offset, .. } = surface[at];
        let point = support(normal);
        let reach = point.dot(normal);
        if reach < least {
            (least, direction) = (reach, normal);
        }
        if least - offset <= precise || surface.len() > 2 * MOST_POINTS {
            break;
        }
        // A known point cannot lie outside: rounding has spoiled the normal.
        if surface.iter().any(|face| face.corners.contains(&point)) {
            surface[at].is_last = true;
        } else {
            grow(&mut surface, point, rounding);
        }
    }
    Some(Least { direction, surface })
}

impl Least {
    /// Normals of the faces nearest to the origin, nearest first.
    pub(crate) fn nearest_faces(&self, count: usize) -> Vec<DVec3> {
        let faces = self.surface.iter().filter(|face| face.offset.is_finite());
        let mut faces: Vec<&Face> = faces.collect();
        faces.sort_by(|a, b| a.offset.total_cmp(&b.offset));
        faces.into_iter().take(count).map(|face| face.normal).collect()
    }
}

/// Replaces the faces that a point sees by those between it and their rim.
fn grow(surface: &mut Vec<Face>, point: DVec3, rounding: f64) {
    let mut rim: Vec<[DVec3; 2]> = Vec::new();
    surface.retain(|face| {
        let is_seen = face.is_seen_from(point, rounding);
        for [from, to] in face.sides().into_iter().filter(|_| is_seen) {
            match rim.iter().position(|&side| side == [to, from]) {
                Some(back) => drop(rim.swap_remove(back)),
                None => rim.push([from, to]),
            }
        }
        !is_seen
    });
    surface.extend(rim.into_iter().map(|[from, to]| Face::new([from, to, point])));
}

/// Four points of a body, far from each other; `None` for a flat one.
fn tetrahedron(support: impl Fn(DVec3) -> DVec3) -> Option<Vec<Face>> {
    let [a, b] = [DVec3::X, -DVec3::X].map(&support);
    let along = (b - a).try_normalize()?;
    let furthest = |way: DVec3| {
        let away = |point: &DVec3| (*point - a).dot(way).abs();
        let points = [way, -way].map(&support);
        if away(&points[0]) >= away(&points[1]) { points[0] } else { points[1] }
    };
    let (across, other) = along.any_orthonormal_pair();
    let off_line = |point: DVec3| (point - a).cross(along).length_squared();
    let [u, v] = [across, other].map(furthest);
    let c = if off_line(u) >= off_line(v) { u } else { v };
    let normal = (b - a).cross(c - a).try_normalize()?;
    let d = furthest(normal);
    // The fourth point lies behind the first three.
    let [b, c] = if (d - a).dot(normal) < 0.0 { [b, c] } else { [c, b] };
    let faces = [[a, b, c], [a, c, d], [c, b, d], [b, a, d]].map(Face::new);
    faces.iter().all(|face| face.offset.is_finite()).then(|| faces.into())
}
