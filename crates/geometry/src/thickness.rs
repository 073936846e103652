//! How thick a solid is at a point of its surface: the diameter of the ball that grows from there
//! as far as the solid lets it [MBC12].

mod walls;

use crate::closed_form::ClosedForm;
use crate::shape::{Geometry, Shape};
use glam::DVec3;
use walls::{Foot, Walls};

/// The ball begins this far under the surface, and what the point touches lies as near, relative
/// to the longest side of the body [1].
const UNDER: f64 = 1e-6;

/// What is beyond the ball's radius by less than this part of it touches the ball [1].
const TOUCHING: f64 = 1e-3;

/// A ball grows fully while its radius grows by this part of its way, as at the tip of a shard of 30
/// degrees; in sharper wedges its growth counts by the fourth power of how much slower it is, so
/// that they have their own thickness and yet some at the tip. A plate lets it grow by nothing, the
/// edges and corners of a box by 0.71 and 0.58.
const BLUNT: f64 = 0.25;

/// Slower growth is none [1]: it counts for less than a hundredth.
const FLAT: f64 = 0.05;

/// Legs of the ball's way. A box takes three, a polyhedron a leg for each of the faces that it
/// meets.
const MOST_LEGS: usize = 24;

/// Surface points that a leg is shortened by; three are enough where the surface is flat.
const MOST_SHORTER: usize = 12;

/// Touched points that a direction is made of; more lie around a curved surface, and say the same.
const MOST_TOUCHED: usize = 12;

/// A ball inside of the solid.
#[derive(Clone, Copy, Debug)]
struct Ball {
    center: DVec3,
    radius: f64,
}

impl Shape {
    /// Thickness at a point of the surface, body frame [m]: the diameter of the largest ball inside
    /// that touches it. A plate has its thickness, a column the side of its section, at its ends
    /// too.
    ///
    /// The ball begins at the point and grows inward until it meets the other side. In edges and
    /// corners, where balls that touch the point are small, it moves on along the medial axis as
    /// long as it grows: by [`BLUNT`] of its way, and less in sharper ones. Infinite for what has no
    /// volume.
    pub fn thickness(&self, point_body: DVec3) -> f64 {
        let point = self.body_from_grid.inverse().point(point_body);
        let (low, high) = self.bounds;
        let extent = (high - low).max_element();
        let walls = match &self.geometry {
            Geometry::ClosedForm(form) => match form_thickness(form) {
                Some(thickness) => return thickness,
                None => Walls::of_form(form, point),
            },
            Geometry::Hull(hull) => Walls::of_hull(hull),
            Geometry::Compound(compound) => Walls::of_compound(compound),
            Geometry::Grid(solid) => Walls::of_grid(solid, point),
            Geometry::Solid(solid) => Walls::of_solid(solid),
            Geometry::Mesh(_) => return f64::INFINITY,
        };
        walls.thickness(point, extent)
    }

    /// The least thickness at some points of the surface [m], at most `most`: at corners, where it
    /// is least, and at samples. Elsewhere it may be less.
    pub fn least_thickness(&self, most: usize) -> f64 {
        let points: Vec<DVec3> = match (&self.geometry, &self.hull) {
            (Geometry::ClosedForm(form), _) => match form_thickness(form) {
                Some(thickness) => return thickness,
                None => self.samples().iter().map(|sample| sample.as_dvec3()).collect(),
            },
            (Geometry::Solid(solid), _) => {
                solid.vertices().iter().map(|&vertex| self.body_from_grid.point(vertex)).collect()
            }
            (_, Some(hull)) => hull.vertices().to_vec(),
            _ => self.samples().iter().map(|sample| sample.as_dvec3()).collect(),
        };
        let step = points.len().div_ceil(most).max(1);
        let least = |least: f64, point: &DVec3| least.min(self.thickness(*point));
        points.iter().step_by(step).fold(f64::INFINITY, least)
    }
}

/// Of formulas that are equally thick everywhere [m].
fn form_thickness(form: &ClosedForm) -> Option<f64> {
    match *form {
        ClosedForm::Sphere { radius } | ClosedForm::Capsule { radius, .. } => Some(2.0 * radius),
        ClosedForm::Box { half } => Some(2.0 * half.min_element()),
        ClosedForm::Cylinder { radius, half_height } => Some(2.0 * radius.min(half_height)),
        ClosedForm::HalfSpace(_) => Some(f64::INFINITY),
        ClosedForm::Cone { .. } => None,
    }
}

impl Walls<'_> {
    /// At a point, of a body of this longest side [m].
    fn thickness(&self, point: DVec3, extent: f64) -> f64 {
        let Some(mut ball) = self.first_ball(point, UNDER * extent) else { return 0.0 };
        let mut radius = ball.radius;
        for _ in 0..MOST_LEGS {
            let touched = self.near(ball.center, ball.radius * (1.0 + TOUCHING));
            let away = least_in_hull(&directions_from(&touched, ball.center));
            let slope = away.length();
            if slope < FLAT {
                break;
            }
            let Some(next) = self.grown(ball, away / slope, slope, extent) else { break };
            let growth = next.radius - ball.radius;
            let rate = growth / next.center.distance(ball.center);
            let counts = (rate / BLUNT).min(1.0);
            radius += counts * counts * counts * counts * growth;
            ball = next;
        }
        2.0 * radius
    }

    /// A tiny ball at a point of the surface; `None` without a surface.
    fn first_ball(&self, point: DVec3, under: f64) -> Option<Ball> {
        // Contacts lie a little beside the surface.
        let mut on_surface = point;
        for _ in 0..3 {
            let foot = self.nearest(on_surface)?;
            on_surface = foot.point;
        }
        let touched = self.near(on_surface, under);
        let inward: Vec<DVec3> = touched.iter().map(|foot| -foot.normal).collect();
        let away = least_in_hull(&inward);
        // Where the normals cancel, as on a knife's edge, any of them will do.
        let inward = away.try_normalize().or(inward.first().copied())?;
        let center = on_surface + under * inward;
        Some(Ball { center, radius: self.nearest(center)?.distance.abs() })
    }

    /// The ball once it has moved in a direction as far as it grows by `slope` of its way; `None`
    /// if it does not grow.
    fn grown(&self, ball: Ball, direction: DVec3, slope: f64, extent: f64) -> Option<Ball> {
        // From too far back to where it touches the point that was too near [MBC12].
        let mut way = extent;
        for _ in 0..MOST_SHORTER {
            let center = ball.center + way * direction;
            let foot = self.nearest(center)?;
            let wanted = ball.radius + slope * way;
            if foot.distance >= wanted * (1.0 - 1e-9) {
                return Some(Ball { center, radius: foot.distance });
            }
            way = way_to(&foot, center, ball, (direction, slope)).clamp(0.0, way);
            if way <= 1e-3 * ball.radius {
                break;
            }
        }

        // Along curved surfaces it grows at another rate.
        let mut way = ball.radius;
        for _ in 0..8 {
            let center = ball.center + way * direction;
            let radius = self.nearest(center)?.distance;
            if radius >= ball.radius + 0.5 * slope * way {
                return Some(Ball { center, radius });
            }
            way *= 0.5;
        }
        None
    }
}

/// How far a ball that grows by `slope` of its way moves until it touches a point that is nearest to
/// another centre, or the plane there [m].
fn way_to(foot: &Foot, center: DVec3, ball: Ball, (direction, slope): (DVec3, f64)) -> f64 {
    let across = (center - foot.point).dot(foot.normal).abs();
    if across >= foot.distance.abs() * (1.0 - 1e-9) {
        let height = (foot.point - ball.center).dot(foot.normal) - ball.radius;
        // A plane that the ball does not come nearer to says nothing.
        let rate = slope + foot.normal.dot(direction);
        return if rate > 0.0 { height / rate } else { 0.0 };
    }
    // |center + way direction - point| = radius + slope way.
    let from = ball.center - foot.point;
    let apart = (from.length_squared() - ball.radius * ball.radius).max(0.0);
    let half_linear = ball.radius * slope - direction.dot(from);
    let square = 1.0 - slope * slope;
    let root = (half_linear * half_linear - square * apart).max(0.0).sqrt();
    // The smaller of both, without cancellation.
    if half_linear + root > 0.0 { apart / (half_linear + root) } else { 0.0 }
}

/// Unit vectors from touched points to the ball's centre: at most [`MOST_TOUCHED`], those that
/// differ most.
fn directions_from(touched: &[Foot], center: DVec3) -> Vec<DVec3> {
    let away = |foot: &Foot| (center - foot.point).try_normalize();
    let all: Vec<DVec3> = touched.iter().filter_map(away).collect();
    let Some(&first) = all.first() else { return Vec::new() };
    let mut chosen = vec![first];
    let mut nearness: Vec<f64> = all.iter().map(|one| one.dot(first)).collect();
    while chosen.len() < MOST_TOUCHED {
        let farthest = (0..all.len()).min_by(|&a, &b| nearness[a].total_cmp(&nearness[b]));
        let Some(next) = farthest.filter(|&at| nearness[at] < 1.0 - 1e-9) else { break };
        chosen.push(all[next]);
        for (nearness, one) in nearness.iter_mut().zip(&all) {
            *nearness = nearness.max(one.dot(all[next]));
        }
    }
    chosen
}

/// The point of the convex hull of some vectors that is nearest to the origin; zero if that lies
/// inside. The distance to what is touched grows fastest along it, by its length.
fn least_in_hull(vectors: &[DVec3]) -> DVec3 {
    let is_least = |point: DVec3| {
        let square = point.length_squared();
        vectors.iter().all(|one| one.dot(point) >= square - 1e-9)
    };
    let count = vectors.len();
    for a in 0..count {
        if is_least(vectors[a]) {
            return vectors[a];
        }
    }
    for a in 0..count {
        for b in a + 1..count {
            let side = vectors[b] - vectors[a];
            let part = -vectors[a].dot(side) / side.length_squared();
            let point = vectors[a] + part * side;
            if (0.0..=1.0).contains(&part) && is_least(point) {
                return point;
            }
        }
    }
    for a in 0..count {
        for b in a + 1..count {
            for c in b + 1..count {
                let normal = (vectors[b] - vectors[a]).cross(vectors[c] - vectors[a]);
                let Some(unit) = normal.try_normalize() else { continue };
                let point = unit.dot(vectors[a]) * unit;
                let inside = [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
                    let side = vectors[to] - vectors[from];
                    normal.dot(side.cross(point - vectors[from])) >= -1e-12
                });
                if inside && is_least(point) {
                    return point;
                }
            }
        }
    }
    DVec3::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball that grows while it moves away from a wall as fast: the wall bounds no way.
    #[test]
    fn walls_that_stay_as_near_bound_no_way() {
        let ball = Ball { center: DVec3::Y, radius: 1.0 };
        let direction = DVec3::new(0.75_f64.sqrt(), -0.5, 0.0);
        let foot = Foot { point: 2.0 * DVec3::Y, normal: DVec3::Y, distance: 1.0 };
        let way = way_to(&foot, DVec3::Y, ball, (direction, 0.5));
        assert!(way >= 0.0 && way.is_finite(), "{way}");
    }
}
