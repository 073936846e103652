//! Polygons in space, cut into triangles between their own corners.

use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A loop of more corners than this is halved first: clipping ears takes their number squared.
const MOST_CORNERS: usize = 20_000;

/// Triangles that fill a loop of vertices in its direction: two fewer than it has vertices, each
/// edge of the loop in one of them. `at` gives a vertex's position [m].
///
/// A convex loop becomes a fan around its first vertex. Of others ears are clipped off, those with
/// the shortest side first, as seen along the loop's mean normal.
pub(crate) fn triangulate(corners: &[u32], at: &impl Fn(u32) -> DVec3) -> Vec<[u32; 3]> {
    if corners.len() < 3 {
        return Vec::new();
    }
    if corners.len() > MOST_CORNERS {
        let middle = corners.len() / 2;
        let mut triangles = triangulate(&corners[..=middle], at);
        triangles.extend(triangulate(&[&corners[middle..], &corners[..1]].concat(), at));
        return triangles;
    }
    let points: Vec<DVec3> = corners.iter().map(|&corner| at(corner) - at(corners[0])).collect();
    let clipper = PlaneClipper::new(points);
    let triangles = if clipper.is_convex() {
        (1..corners.len() - 1).map(|n| [0, n, n + 1]).collect()
    } else {
        clipper.clipped()
    };
    triangles.into_iter().map(|triangle| triangle.map(|corner| corners[corner])).collect()
}

/// A loop whose ears are clipped off.
struct PlaneClipper {
    points: Vec<DVec3>,
    /// Mean normal, a unit.
    normal: DVec3,
    /// Remaining neighbours.
    before: Vec<usize>,
    after: Vec<usize>,
    /// Number of changes of a corner's neighbours; `None` for clipped corners.
    version: Vec<Option<u32>>,
}

impl PlaneClipper {
    fn new(points: Vec<DVec3>) -> Self {
        let count = points.len();
        let pairs = points.iter().zip(points.iter().cycle().skip(1));
        let normal = pairs.map(|(a, b)| a.cross(*b)).sum::<DVec3>().normalize_or(DVec3::Y);
        Self {
            points,
            normal,
            before: (0..count).map(|n| (n + count - 1) % count).collect(),
            after: (0..count).map(|n| (n + 1) % count).collect(),
            version: vec![Some(0); count],
        }
    }

    /// Twice the area of a triangle of corners as seen along the normal [m^2].
    fn turn(&self, a: usize, b: usize, c: usize) -> f64 {
        let [a, b, c] = [a, b, c].map(|corner| self.points[corner]);
        (b - a).cross(c - a).dot(self.normal)
    }

    /// True if a fan around the first corner covers it once.
    fn is_convex(&self) -> bool {
        let count = self.points.len();
        count == 3
            || (0..count).all(|n| self.turn(self.before[n], n, self.after[n]) > 0.0)
                && (1..count - 1).all(|n| self.turn(0, n, n + 1) > 0.0)
    }

    fn side_squared(&self, n: usize) -> f64 {
        self.points[self.before[n]].distance_squared(self.points[self.after[n]])
    }

    /// True if a corner is convex, and no corner of `reflex` lies in the triangle that it makes.
    fn is_ear(&self, n: usize, reflex: &[usize]) -> bool {
        let (a, c) = (self.before[n], self.after[n]);
        if self.turn(a, n, c) <= 0.0 {
            return false;
        }
        let same_place = |p: usize| [a, n, c].iter().any(|&q| self.points[p] == self.points[q]);
        let holds = |p: usize| {
            self.turn(a, n, p) >= 0.0 && self.turn(n, c, p) >= 0.0 && self.turn(c, a, p) >= 0.0
        };
        let left = |p: usize| self.version[p].is_some() && p != a && p != n && p != c;
        !reflex.iter().any(|&p| left(p) && holds(p) && !same_place(p))
    }

    fn clipped(mut self) -> Vec<[usize; 3]> {
        let count = self.points.len();
        let mut triangles = Vec::with_capacity(count - 2);
        while triangles.len() + 3 < count {
            // Convex corners stay convex; only others can lie in an ear.
            let left: Vec<usize> = (0..count).filter(|&n| self.version[n].is_some()).collect();
            let is_reflex = |&n: &usize| self.turn(self.before[n], n, self.after[n]) <= 0.0;
            let reflex: Vec<usize> = left.iter().copied().filter(is_reflex).collect();
            let mut waiting: BinaryHeap<Reverse<(Side, usize, u32)>> = BinaryHeap::new();
            for &n in left.iter().filter(|&&n| self.is_ear(n, &reflex)) {
                waiting.push(Reverse((
                    Side(self.side_squared(n)),
                    n,
                    self.version[n].unwrap_or(0),
                )));
            }
            // A loop that crosses itself may have no ear: then the shortest side goes.
            if waiting.is_empty() {
                let shortest = left.iter().map(|&n| (Side(self.side_squared(n)), n)).min();
                let Some((_, n)) = shortest else { break };
                triangles.push(self.clip(n));
                continue;
            }
            while let Some(Reverse((_, n, version))) = waiting.pop() {
                if triangles.len() + 3 == count {
                    break;
                }
                if self.version[n] != Some(version) {
                    continue;
                }
                triangles.push(self.clip(n));
                for neighbour in [self.before[n], self.after[n]] {
                    if self.is_ear(neighbour, &reflex) {
                        let version = self.version[neighbour].unwrap_or(0);
                        let side = Side(self.side_squared(neighbour));
                        waiting.push(Reverse((side, neighbour, version)));
                    }
                }
            }
        }
        if let Some(n) = (0..count).find(|&n| self.version[n].is_some()) {
            triangles.push([self.before[n], n, self.after[n]]);
        }
        triangles
    }

    /// Takes a corner away; answers with its triangle.
    fn clip(&mut self, n: usize) -> [usize; 3] {
        let (before, after) = (self.before[n], self.after[n]);
        self.version[n] = None;
        (self.after[before], self.before[after]) = (after, before);
        for neighbour in [before, after] {
            self.version[neighbour] = self.version[neighbour].map(|version| version + 1);
        }
        [before, n, after]
    }
}

/// A squared length [m^2] in its order.
#[derive(Clone, Copy, PartialEq)]
struct Side(f64);

impl Eq for Side {}

impl PartialOrd for Side {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Side {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;

    fn filled(points: &[(f64, f64)]) -> TriMesh {
        let positions: Vec<DVec3> =
            points.iter().map(|&(x, y)| DVec3::new(x, 0.3 * x - y, y)).collect();
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        let triangles = triangulate(&corners, &|corner| positions[corner as usize]);
        TriMesh { positions, triangles }
    }

    /// Area of a polygon in the plane.
    fn shoelace(points: &[(f64, f64)]) -> f64 {
        let next = points.iter().cycle().skip(1);
        0.5 * points.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>()
    }

    /// A star and a comb of many corners: the triangles cover them once, in their direction.
    #[test]
    fn concave_polygons_are_covered_once() {
        let star: Vec<(f64, f64)> = (0..14)
            .map(|n| {
                let angle = std::f64::consts::PI * f64::from(n) / 7.0;
                let radius = if n % 2 == 0 { 2.0 } else { 0.7 };
                (radius * libm::cos(angle), radius * libm::sin(angle))
            })
            .collect();
        let mut comb = vec![(0.0, -1.0), (600.0, -1.0)];
        for tooth in (0..300).rev() {
            let x = 2.0 * f64::from(tooth);
            comb.extend([(x + 1.5, 5.0), (x + 0.5, 0.0)]);
        }
        let slope = DVec3::new(-0.3, 1.0, 1.0).length();
        for polygon in [star, comb] {
            for first in [0, 1, polygon.len() / 2] {
                let mut polygon = polygon.clone();
                polygon.rotate_left(first);
                let mesh = filled(&polygon);
                assert_eq!(mesh.triangles.len(), polygon.len() - 2);
                let area = slope * shoelace(&polygon);
                assert!((mesh.area() / area - 1.0).abs() < 1e-12, "{} {area}", mesh.area());
            }
        }
    }

    #[test]
    fn corners_on_a_straight_edge_are_kept() {
        let square = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 2.0), (0.0, 2.0)];
        let mesh = filled(&square);
        assert_eq!(mesh.triangles.len(), 4);
        let mut used: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), 6);
        let slope = DVec3::new(-0.3, 1.0, 1.0).length();
        assert!((mesh.area() - 4.0 * slope).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_polygon_ends() {
        assert!(filled(&[(0.0, 0.0), (1.0, 0.0)]).triangles.is_empty());
        assert_eq!(filled(&[(0.0, 0.0); 7]).triangles.len(), 5);
        assert_eq!(filled(&[(f64::NAN, 0.0); 6]).triangles.len(), 4);
    }
}
