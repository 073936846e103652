//! The convex hull of points: quickhull [BDH96] with exact predicates [She97], then faces that are
//! flat but for the points' rounding are merged.

use super::Hull;
use super::face_loops::FaceLoops;
use super::flatten::{at_odds, flattened};
use crate::half_space::HalfSpace;
use crate::hull::edges::{plane_of, sides};
use glam::DVec3;
use robust::{Coord3D, orient3d};
use std::collections::BTreeMap;
use std::ops::Range;

/// Points this close to a common plane, relative to their longest extent, make one face:
/// coordinates that went through single precision or a text file still give the faces that were
/// meant.
const COPLANAR: f64 = 1e-6;

/// The same of points that were cut in double precision.
const ROUNDED: f64 = 1e-10;

/// A hull thinner than this, relative to its longest extent, has no inside that can be told from
/// its faces.
const FLAT: f64 = 1e-5;

/// Why points have no convex hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HullError {
    /// Fewer than four.
    #[error("at least 4 points that span a volume")]
    TooFew,
    /// A coordinate is infinite or NaN.
    #[error("points of finite coordinates")]
    NotFinite,
    /// All of them lie on a plane, a line or a point.
    #[error("points that do not all lie on a plane")]
    Flat,
}

impl Hull {
    /// The convex hull of points [m]. Its vertices are some of them, in their order; where a
    /// millionth of the points' extent makes several faces one, they are moved onto it.
    ///
    /// # Errors
    /// If the points span no volume.
    pub fn of_points(points: &[DVec3]) -> Result<Self, HullError> {
        Self::of_most_points(points, COPLANAR, usize::MAX, 0.0)
    }

    /// A hull of few of the points [m]: those that lie farthest outside of what there is, one after
    /// the other, until no point lies farther out than `within` [m] or there are `most`. It lies in
    /// the hull of all of them, but for rounding.
    ///
    /// # Errors
    /// If the points span no volume.
    pub fn of_few_points(points: &[DVec3], most: usize, within: f64) -> Result<Self, HullError> {
        Self::of_most_points(points, ROUNDED, most, within)
    }

    fn of_most_points(
        points: &[DVec3],
        coplanar: f64,
        most: usize,
        within: f64,
    ) -> Result<Self, HullError> {
        if points.iter().any(|point| !point.is_finite()) {
            return Err(HullError::NotFinite);
        }
        if points.len() < 4 {
            return Err(HullError::TooFew);
        }
        let low = points.iter().fold(DVec3::INFINITY, |low, &point| low.min(point));
        let high = points.iter().fold(DVec3::NEG_INFINITY, |high, &point| high.max(point));
        let close = coplanar * (high - low).max_element();
        let points = &welded(points, close);
        let triangles = Quickhull::run(points, most, within)?;
        // Should merging leave anything but a sphere's topology, the triangles are the hull.
        Self::with_merged_faces(points, &triangles, close, close / coplanar)
            .or_else(|| {
                let Merged { planes, loops, .. } = merged(points, &triangles, 0.0, &[])?;
                Self::from_loops(points, planes, loops)
            })
            .ok_or(HullError::Flat)
    }

    /// The hull of triangles, all within `close` [m] of a plane as one face, as far as its vertices
    /// then lie on their faces' planes and inside of all others.
    fn with_merged_faces(
        points: &[DVec3],
        triangles: &[[u32; 3]],
        close: f64,
        extent: f64,
    ) -> Option<Self> {
        let mut alone = vec![false; triangles.len()];
        loop {
            let Merged { mut planes, loops, face_of } = merged(points, triangles, close, &alone)?;
            let moved = flattened(points, &mut planes, &loops);
            let at_odds = at_odds(&moved, &planes, &loops, extent);
            let mut count = vec![0; planes.len()];
            face_of.iter().for_each(|&face| count[face] += 1);
            // Triangles that were faces of their own already stay.
            let is_new = |face: usize| at_odds[face] && count[face] > 1;
            if !(0..planes.len()).any(is_new) {
                return Self::from_loops(&moved, planes, loops);
            }
            alone.iter_mut().zip(&face_of).for_each(|(alone, &face)| *alone |= is_new(face));
        }
    }
}

/// Points without those less than `close` [m] from an earlier one: two corners that rounding has made
/// of one have an edge, and faces beside it, in any direction.
fn welded(points: &[DVec3], close: f64) -> Vec<DVec3> {
    let mut along_x: Vec<usize> = (0..points.len()).collect();
    along_x.sort_by(|&a, &b| points[a].x.total_cmp(&points[b].x).then(a.cmp(&b)));
    let mut is_kept = vec![true; points.len()];
    for (at, &point) in along_x.iter().enumerate() {
        let is_near = |other: &&usize| points[**other].x - points[point].x < close;
        for &other in along_x[at + 1..].iter().take_while(is_near) {
            if is_kept[point] && is_kept[other] && points[point].distance(points[other]) < close {
                is_kept[point.max(other)] = false;
            }
        }
    }
    points.iter().zip(is_kept).filter(|(_, is_kept)| *is_kept).map(|(&point, _)| point).collect()
}

/// Points that a hull begins with.
const FIRST: usize = 4;

/// Triangles of the growing hull.
struct Quickhull<'a> {
    points: &'a [DVec3],
    triangles: Vec<Triangle>,
    /// Of each vertex on the last rim the new triangle that runs along the rim from there.
    from_vertex: Vec<usize>,
}

struct Triangle {
    /// Counter-clockwise seen from outside.
    corners: [u32; 3],
    /// The triangles behind its sides, in their order.
    beside: [usize; 3],
    /// Points outside of its plane that no other triangle has.
    outside: Vec<u32>,
    alive: bool,
}

impl<'a> Quickhull<'a> {
    /// Up to `most` points, and until none lies farther out than `within` [m].
    fn run(points: &'a [DVec3], most: usize, within: f64) -> Result<Vec<[u32; 3]>, HullError> {
        let [a, b, c, d] = first_tetrahedron(points)?;
        let mut hull = Self { points, triangles: Vec::new(), from_vertex: vec![0; points.len()] };
        let all: Vec<u32> = (0..points.len() as u32).collect();
        hull.insert([a, b, c], [1, 2, 3]);
        hull.insert([a, d, b], [3, 2, 0]);
        hull.insert([b, d, c], [1, 3, 0]);
        hull.insert([c, d, a], [2, 1, 0]);
        hull.share_out(0..FIRST, all);

        if most < points.len() || within > 0.0 {
            hull.grow_farthest(most, within);
        } else {
            hull.grow_all();
        }
        Ok(hull
            .triangles
            .iter()
            .filter(|triangle| triangle.alive)
            .map(|triangle| triangle.corners)
            .collect())
    }

    /// Adds the furthest point of each triangle until nothing is outside.
    fn grow_all(&mut self) {
        let mut next = 0;
        while next < self.triangles.len() {
            if let Some(apex) = self.furthest(next) {
                self.grow(next, apex);
            } else {
                next += 1;
            }
        }
    }

    /// Adds the furthest point of all until there are `most`, or none lies farther out than
    /// `within` [m].
    fn grow_farthest(&mut self, most: usize, within: f64) {
        let mut heights: Vec<(f64, u32)> = Vec::new();
        for _ in FIRST..most {
            for triangle in heights.len()..self.triangles.len() {
                let apex = self.furthest(triangle);
                let height = apex.map(|apex| (self.height(triangle, apex), apex));
                heights.push(height.unwrap_or((0.0, 0)));
            }
            let alive = (0..heights.len()).filter(|&triangle| self.triangles[triangle].alive);
            let higher =
                |&a: &usize, &b: &usize| heights[a].0.total_cmp(&heights[b].0).then(b.cmp(&a));
            match alive.max_by(higher) {
                Some(triangle) if heights[triangle].0 > within => {
                    self.grow(triangle, heights[triangle].1);
                }
                _ => return,
            }
        }
    }

    /// Height of a point over a triangle's plane [m].
    fn height(&self, triangle: usize, point: u32) -> f64 {
        let [a, b, c] = self.triangles[triangle].corners.map(|corner| self.points[corner as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        normal.dot(self.points[point as usize] - a)
    }

    /// True for points strictly outside a triangle's plane, exactly.
    fn sees(&self, point: u32, triangle: usize) -> bool {
        let coord = |index: u32| {
            let DVec3 { x, y, z } = self.points[index as usize];
            Coord3D { x, y, z }
        };
        let [a, b, c] = self.triangles[triangle].corners.map(coord);
        orient3d(a, b, c, coord(point)) < 0.0
    }

    fn insert(&mut self, corners: [u32; 3], beside: [usize; 3]) {
        self.triangles.push(Triangle { corners, beside, outside: Vec::new(), alive: true });
    }

    /// Gives each point to the first of the new triangles that it is outside of.
    fn share_out(&mut self, new: Range<usize>, points: Vec<u32>) {
        for point in points {
            if let Some(triangle) = new.clone().find(|&triangle| self.sees(point, triangle)) {
                self.triangles[triangle].outside.push(point);
            }
        }
    }

    /// The point outside of a triangle that is furthest from its plane; `None` if there is none.
    fn furthest(&self, triangle: usize) -> Option<u32> {
        let Triangle { corners: [a, b, c], ref outside, .. } = self.triangles[triangle];
        let [a, b, c] = [a, b, c].map(|corner| self.points[corner as usize]);
        let normal = (b - a).cross(c - a);
        let height = |point: &u32| normal.dot(self.points[*point as usize] - a);
        outside.iter().copied().max_by(|p, q| height(p).total_cmp(&height(q)).then(q.cmp(p)))
    }

    /// Replaces all triangles that can be seen from `apex`, of which `seen` is one, by a cone to
    /// their rim.
    fn grow(&mut self, seen: usize, apex: u32) {
        // Walk over what is seen, and collect its rim.
        let mut rim = Vec::new();
        let mut orphans = Vec::new();
        let mut open = vec![seen];
        self.triangles[seen].alive = false;
        while let Some(triangle) = open.pop() {
            orphans.append(&mut self.triangles[triangle].outside);
            let Triangle { corners, beside, .. } = self.triangles[triangle];
            for ([a, b], beside) in sides(&corners).zip(beside) {
                if !self.triangles[beside].alive {
                    continue;
                }
                if self.sees(apex, beside) {
                    self.triangles[beside].alive = false;
                    open.push(beside);
                } else {
                    rim.push(([a, b], beside));
                }
            }
        }
        self.close(&rim, apex);
        orphans.retain(|&point| point != apex);
        self.share_out(self.triangles.len() - rim.len()..self.triangles.len(), orphans);
    }

    /// Adds the cone from `apex` to a rim, of which the triangles beside it are known.
    fn close(&mut self, rim: &[([u32; 2], usize)], apex: u32) {
        let first = self.triangles.len();
        for (index, &([a, _], _)) in (first..).zip(rim) {
            self.from_vertex[a as usize] = index;
        }
        for (index, &([a, b], beside)) in (first..).zip(rim) {
            self.insert([a, b, apex], [beside, self.from_vertex[b as usize], first]);
            let Triangle { corners, beside: theirs, .. } = &mut self.triangles[beside];
            let slot = corners.iter().position(|&corner| corner == b).unwrap_or(0);
            theirs[slot] = index;
        }
        // The one before it along the rim.
        for index in first..self.triangles.len() {
            let next = self.triangles[index].beside[1];
            self.triangles[next].beside[2] = index;
        }
    }
}

/// Four points far apart, the last below the plane of the others.
fn first_tetrahedron(points: &[DVec3]) -> Result<[u32; 4], HullError> {
    let furthest = |from: &dyn Fn(DVec3) -> f64| {
        let distance = |index: &usize| from(points[*index]);
        (0..points.len())
            .max_by(|a, b| distance(a).total_cmp(&distance(b)).then(b.cmp(a)))
            .unwrap_or(0)
    };
    // The two ends along the longest axis, what is furthest from the line through them, and from
    // the plane.
    let low = points.iter().fold(DVec3::INFINITY, |low, &point| low.min(point));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, &point| high.max(point));
    let axis = (high - low).max_position();
    let (a, b) = (furthest(&|point| -point[axis]), furthest(&|point| point[axis]));
    let along = points[b] - points[a];
    let from_line = |point: DVec3| along.cross(point - points[a]).length();
    let c = furthest(&from_line);
    let normal = along.cross(points[c] - points[a]);
    let height = |point: DVec3| normal.dot(point - points[a]);
    let d = furthest(&|point| height(point).abs());

    let thin = FLAT * (high - low).max_element();
    let is_flat = from_line(points[c]) <= thin * along.length()
        || height(points[d]).abs() <= thin * normal.length();
    if is_flat {
        return Err(HullError::Flat);
    }
    let [a, b, c, d] = [a, b, c, d].map(|index| index as u32);
    Ok(if height(points[d as usize]) < 0.0 { [a, b, c, d] } else { [a, c, b, d] })
}

/// Faces of triangles.
struct Merged {
    planes: Vec<HalfSpace>,
    loops: FaceLoops,
    /// The face of each triangle.
    face_of: Vec<usize>,
}

/// Merges triangles into faces, starting with the largest: all triangles within `close` [m] of its
/// plane, but for those `alone`. `None` if a face has a hole.
fn merged(points: &[DVec3], triangles: &[[u32; 3]], close: f64, alone: &[bool]) -> Option<Merged> {
    let mut triangle_along: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for (index, triangle) in triangles.iter().enumerate() {
        triangle_along.extend(sides(triangle).map(|side| (side, index)));
    }
    let areas: Vec<DVec3> = triangles
        .iter()
        .map(|triangle| triangle.map(|corner| points[corner as usize]))
        .map(|[a, b, c]| (b - a).cross(c - a))
        .collect();
    let mut largest_first: Vec<usize> = (0..triangles.len()).collect();
    largest_first.sort_by(|&a, &b| {
        areas[b].length_squared().total_cmp(&areas[a].length_squared()).then(a.cmp(&b))
    });

    // Grow the faces.
    let is_alone = |triangle: usize| alone.get(triangle).is_some_and(|&alone| alone);
    let mut face_of: Vec<Option<usize>> = vec![None; triangles.len()];
    let mut seeds = Vec::new();
    for seed in largest_first {
        if face_of[seed].is_some() {
            continue;
        }
        let normal = areas[seed].normalize_or_zero();
        let middle = points[triangles[seed][0] as usize];
        let mut open = if is_alone(seed) { Vec::new() } else { vec![seed] };
        face_of[seed] = Some(seeds.len());
        while let Some(triangle) = open.pop() {
            for [a, b] in sides(&triangles[triangle]) {
                let beside = *triangle_along.get(&[b, a])?;
                let is_near =
                    |&corner: &u32| normal.dot(points[corner as usize] - middle).abs() <= close;
                let is_free = face_of[beside].is_none() && !is_alone(beside);
                if is_free && triangles[beside].iter().all(is_near) {
                    face_of[beside] = Some(seeds.len());
                    open.push(beside);
                }
            }
        }
        seeds.push(seed);
    }

    // Walk around them.
    let mut rims: Vec<BTreeMap<u32, u32>> = vec![BTreeMap::new(); seeds.len()];
    for (&[a, b], &triangle) in &triangle_along {
        let face = face_of[triangle]?;
        if face_of[*triangle_along.get(&[b, a])?] != Some(face) && rims[face].insert(a, b).is_some()
        {
            return None;
        }
    }
    let (mut planes, mut loops) = (Vec::with_capacity(rims.len()), FaceLoops::default());
    for rim in &rims {
        let start = *rim.keys().next()?;
        let mut vertices = vec![start];
        let mut at = *rim.get(&start)?;
        while at != start {
            vertices.push(at);
            at = *rim.get(&at)?;
        }
        planes.push(plane_of(vertices.iter().map(|&vertex| points[vertex as usize]))?);
        if vertices.len() != rim.len() {
            return None;
        }
        loops.push(false, vertices);
    }
    Some(Merged { planes, loops, face_of: face_of.into_iter().collect::<Option<_>>()? })
}
