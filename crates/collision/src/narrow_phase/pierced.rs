//! Samples that have come through a convex body: a corner that an impact turned through a thin
//! plate. The surface that is nearest to them is the far one, and would hold them there.

use crate::narrow_phase::convex_shape::ConvexShape;
use crate::relative_motion::Placed;
use frangible_geometry::{HalfSpace, Hull, Shape};
use frangible_math::RigidTransform;
use glam::DVec3;

/// Samples of a body that have come through another one, with the face through which they came.
pub(crate) struct Pierced {
    /// Unit, world frame, out of the face: towards the side on which the sampled body is.
    pub(crate) outward: DVec3,
    /// Samples by number, with their height over the face [m], which is negative.
    pub(crate) samples: Vec<(u32, f64)>,
}

/// The samples of a body that lie in the further half of a convex one or behind it, if the way from
/// the sampled body's centre to them enters the other one in the sampled body. The centre itself is
/// on the side from which the body came (`frame_rate::containment`).
pub(crate) fn pierced(body: Placed, other: Placed) -> Option<Pierced> {
    let ConvexShape::Hull(hull) = ConvexShape::of(other.shape) else { return None };
    let other_from_body =
        other.pose.world_from_body().inverse().after(&body.pose.world_from_body());
    let center = other_from_body.translation;
    let (face, above) = highest_face(hull, center)?;
    let lowest = |low: f64, vertex: &DVec3| low.min(face.distance(*vertex));
    let middle = 0.5 * hull.vertices().iter().fold(0.0, lowest);
    if above - body.shape.radius() >= middle {
        return None;
    }
    let way = Way { hull, body: body.shape, face, center, above, other_from_body };
    let mut samples = Vec::new();
    for cluster in body.shape.sample_clusters() {
        let height = face.distance(other_from_body.point(cluster.center.as_dvec3()));
        if height - f64::from(cluster.radius) >= middle {
            continue;
        }
        for index in cluster.first..cluster.first + cluster.count {
            let sample = other_from_body.point(body.shape.samples()[index as usize].as_dvec3());
            let height = face.distance(sample);
            if height < middle && way.pierces(sample, height) {
                samples.push((index, height));
            }
        }
    }
    let outward = other.pose.orientation * face.normal;
    (!samples.is_empty()).then_some(Pierced { outward, samples })
}

/// The face that a point lies highest above, and how high [m]; `None` for a point inside.
fn highest_face(hull: &Hull, point: DVec3) -> Option<(HalfSpace, f64)> {
    let heights = hull.planes().iter().map(|plane| (*plane, plane.distance(point)));
    heights.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, above)| *above > 0.0)
}

/// Ways from the centre of a sampled body, in the frame of the other one.
struct Way<'a> {
    hull: &'a Hull,
    body: &'a Shape,
    face: HalfSpace,
    center: DVec3,
    /// Height of the centre over the face [m].
    above: f64,
    other_from_body: RigidTransform,
}

impl Way<'_> {
    /// True if the way to a sample below the face enters the hull there, within the body.
    fn pierces(&self, sample: DVec3, height: f64) -> bool {
        let entry = self.center.lerp(sample, self.above / (self.above - height));
        let is_on_face = |plane: &HalfSpace| *plane == self.face || plane.distance(entry) <= 0.0;
        self.hull.planes().iter().all(is_on_face)
            && self.body.distance_and_gradient(self.other_from_body.inverse().point(entry)).0 < 0.0
    }
}
