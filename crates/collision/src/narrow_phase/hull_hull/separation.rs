//! Exact separation of two hulls, in double precision: closest points where they are apart, and
//! where they overlap the least way out over all faces and pairs of edges.
//!
//! [`contact`](super::contact) prefers faces, and axes of before, to the best one; it scans in
//! single precision. This is for measurements, and ten times as slow.

use crate::narrow_phase::hull_hull::placement::{Placement, Ridge, View};
use crate::narrow_phase::revolved::closest::{PRECISE, closest};
use crate::narrow_phase::revolved::partner::furthest_vertex;
use crate::narrow_phase::revolved::simplex::Difference;
use frangible_geometry::Hull;
use frangible_math::RigidTransform;
use glam::DVec3;

/// Squared sine of the angle below which edges are parallel [1]: rounding.
const PARALLEL: f64 = 1e-24;

/// Separation by which an edge's normals must be better than those of its faces, relative to the
/// size [1]: rounding.
const NO_BETTER: f64 = 1e-12;

/// Separation [m], negative for overlap, and the unit normal from the second hull to the first, in
/// the second's frame. `size` [m] is the smaller hull's.
pub(crate) fn hull_separation(
    hulls: [&Hull; 2],
    second_from_first: &RigidTransform,
    size: f64,
) -> (f64, DVec3) {
    let placement = Placement::new(second_from_first);
    let views = [
        View { hull: hulls[0], here_from_hull: Some(&placement) },
        View { hull: hulls[1], here_from_hull: None },
    ];
    let support = |normal: DVec3| {
        let on = [furthest(&views[0], -normal), furthest(&views[1], normal)];
        Difference { on, between: on[0] - on[1] }
    };
    let apart = closest(&support, (size, PRECISE, f64::INFINITY), placement.shift);
    if let Some(apart) = apart {
        return (apart.distance, apart.normal);
    }
    let mut least =
        LeastOverlap { support, known: Vec::new(), gap: f64::NEG_INFINITY, normal: DVec3::Y };
    for (view, sign) in views.iter().zip([-1.0, 1.0]) {
        for plane in view.hull.planes() {
            least.offer(sign * view.direction(plane.normal));
        }
    }
    // An edge whose normals are no better than what is known meets no other one.
    let close = NO_BETTER * size;
    let [first, second] = [(&views[0], -1.0), (&views[1], 1.0)].map(|(view, sign)| {
        let mut ridges = ridges(view);
        ridges.retain(|ridge| least.bound(ridge, sign) > least.gap + close);
        ridges
    });
    for a in &first {
        if least.bound(a, -1.0) <= least.gap + close {
            continue;
        }
        for b in second.iter().filter(|b| may_touch(a, b)) {
            let across = a.along.cross(b.along);
            let lengths = a.along.length_squared() * b.along.length_squared();
            if across.length_squared() > PARALLEL * lengths {
                let normal = across.normalize();
                least.offer(normal);
                least.offer(-normal);
            }
        }
    }
    (least.gap, least.normal)
}

/// Search for the normal of least overlap.
struct LeastOverlap<F> {
    /// Of the difference of both hulls, against a normal.
    support: F,
    /// Points of the difference that were furthest along normals that were offered [m].
    known: Vec<DVec3>,
    /// Separation along the best normal [m], and that.
    gap: f64,
    normal: DVec3,
}

impl<F: Fn(DVec3) -> Difference> LeastOverlap<F> {
    fn offer(&mut self, normal: DVec3) {
        // One known point is enough to show that a normal is no better.
        if self.known.iter().rev().any(|between| between.dot(normal) <= self.gap) {
            return;
        }
        let between = (self.support)(normal).between;
        self.known.push(between);
        let gap = between.dot(normal);
        if gap > self.gap {
            (self.gap, self.normal) = (gap, normal);
        }
    }

    /// Upper bound of the separation along the normals of an edge, of which `sign` is that of those
    /// from the second hull to the first [m].
    fn bound(&self, ridge: &Ridge, sign: f64) -> f64 {
        ridge.most_apart(self.known.iter().map(|&between| sign * between))
    }
}

/// True for edges whose arcs on the Gauss map may meet, up to rounding.
fn may_touch(a: &Ridge, b: &Ridge) -> bool {
    const ROUNDING: f64 = 1e-9;
    let of_a = a.normals.map(|normal| normal.dot(b.along) / b.along.length());
    let of_b = b.normals.map(|normal| normal.dot(a.along) / a.along.length());
    let crosses = |[from, to]: [f64; 2]| from.min(to) <= ROUNDING && from.max(to) >= -ROUNDING;
    crosses(of_a) && crosses(of_b)
}

/// The vertex furthest in a direction [m].
fn furthest(view: &View, direction: DVec3) -> DVec3 {
    view.vertex(furthest_vertex(view.hull, view.into_hull(direction)))
}

fn ridges(view: &View) -> Vec<Ridge> {
    let ridge = |edge: usize| {
        let ends = view.ends(edge);
        let faces = view.hull.edges()[edge].faces;
        let normals = faces.map(|face| view.direction(view.hull.planes()[face as usize].normal));
        Ridge { edge, ends, along: ends[1] - ends[0], normals, bound: f64::INFINITY }
    };
    (0..view.hull.edges().len()).map(ridge).collect()
}
