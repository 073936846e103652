//! Point of a simplex nearest to the origin [Eri05 sec. 5.1].

use glam::DVec3;

/// A point of the difference of two bodies, and the points of both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference {
    /// On the first and on the second body [m].
    pub(crate) on: [DVec3; 2],
    /// From the second to the first [m].
    pub(crate) between: DVec3,
}

/// Up to four corners, with the weights of the point nearest to the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Simplex {
    pub(crate) corners: [Difference; 4],
    pub(crate) weights: [f64; 4],
    pub(crate) count: usize,
}

impl Simplex {
    pub(crate) fn new(corner: Difference) -> Self {
        Self { corners: [corner; 4], weights: [1.0, 0.0, 0.0, 0.0], count: 1 }
    }

    /// The nearest point [m]: across the sides of the simplex. The weights of corners that are ten
    /// thousand times as far leave a part along them, by which the normal of near bodies would turn.
    pub(crate) fn nearest(&self) -> DVec3 {
        let rough = self.weighted(|corner| corner.between);
        let side = |from: usize, to: usize| self.corners[to].between - self.corners[from].between;
        match self.count {
            2 => without(rough, side(0, 1)),
            3 => {
                let sides = [side(0, 1), side(1, 2), side(2, 0)];
                let lengths = sides.map(DVec3::length_squared);
                let longest = usize::from(lengths[1] > lengths[0]);
                let longest = if lengths[2] > lengths[longest] { 2 } else { longest };
                let other = across(sides[(longest + 1) % 3], sides[longest]);
                without(without(rough, other), sides[longest])
            }
            _ => rough,
        }
    }

    /// The nearest points on both bodies [m].
    pub(crate) fn on_bodies(&self) -> [DVec3; 2] {
        [0, 1].map(|side| self.weighted(|corner| corner.on[side]))
    }

    fn weighted(&self, value: impl Fn(&Difference) -> DVec3) -> DVec3 {
        let used = self.corners.iter().zip(self.weights).take(self.count);
        used.map(|(corner, weight)| weight * value(corner)).sum()
    }

    pub(crate) fn contains(&self, other: &Difference) -> bool {
        self.corners[..self.count].iter().any(|corner| corner.between == other.between)
    }

    /// The smallest simplex of these corners and a new one that holds the point nearest to the
    /// origin; `None` if the origin is inside. It is not in one that `is_apart` from it.
    pub(crate) fn with(&self, corner: Difference, is_apart: bool) -> Option<Self> {
        let mut all = self.corners;
        all[self.count] = corner;
        let points = all.map(|corner| corner.between);
        let part = match self.count {
            1 => of_segment(&points, 0, 1),
            2 => of_triangle(&points, [0, 1, 2]),
            _ => of_tetrahedron(&points, is_apart)?,
        };
        let mut simplex = Self { corners: all, weights: [0.0; 4], count: 0 };
        for (corner, weight) in all.into_iter().zip(part.weights) {
            if weight > 0.0 {
                simplex.corners[simplex.count] = corner;
                simplex.weights[simplex.count] = weight;
                simplex.count += 1;
            }
        }
        Some(simplex)
    }
}

/// A vector without its part along a side; of shorter sides rounding leaves a larger part of the
/// direction than of the vector.
fn without(vector: DVec3, side: DVec3) -> DVec3 {
    let length_squared = side.length_squared();
    if length_squared > vector.length_squared() {
        vector - vector.dot(side) / length_squared * side
    } else {
        vector
    }
}

/// The part of a side across another one.
fn across(side: DVec3, other: DVec3) -> DVec3 {
    side - side.dot(other) / other.length_squared() * other
}

/// The nearest point of some corners: weights of all, and its squared distance.
#[derive(Clone, Copy)]
struct Nearest {
    weights: [f64; 4],
    squared: f64,
}

impl Nearest {
    fn new(points: &[DVec3; 4], corners: &[(usize, f64)]) -> Self {
        let mut weights = [0.0; 4];
        let mut point = DVec3::ZERO;
        for &(corner, weight) in corners {
            weights[corner] = weight;
            point += weight * points[corner];
        }
        Self { weights, squared: point.length_squared() }
    }

    fn or(self, other: Self) -> Self {
        if other.squared < self.squared { other } else { self }
    }
}

fn of_segment(points: &[DVec3; 4], a: usize, b: usize) -> Nearest {
    let along = points[b] - points[a];
    let length_squared = along.length_squared();
    let part = if length_squared > 0.0 { -points[a].dot(along) / length_squared } else { 0.0 };
    if part <= 0.0 {
        return Nearest::new(points, &[(a, 1.0)]);
    }
    if part >= 1.0 {
        return Nearest::new(points, &[(b, 1.0)]);
    }
    Nearest::new(points, &[(a, 1.0 - part), (b, part)])
}

fn of_triangle(points: &[DVec3; 4], corners: [usize; 3]) -> Nearest {
    // Seen along the longest side, which is then one point: the triangles of a long edge and a short
    // one are thin, and the cross of their sides has no direction that rounding leaves alone.
    let [a, b, c] = corners;
    let way = |p: usize, q: usize| points[p].distance_squared(points[q]);
    let [of_a, of_b, of_c] = [way(b, c), way(c, a), way(a, b)];
    let [a, b, c] = if of_a >= of_b && of_a >= of_c {
        [a, b, c]
    } else if of_b >= of_c {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let side = points[c] - points[b];
    let length_squared = side.length_squared();
    if length_squared > 0.0 {
        let along = [a, b].map(|corner| points[corner].dot(side) / length_squared);
        let [tip, foot] = [points[a] - along[0] * side, points[b] - along[1] * side];
        let across = tip - foot;
        let of_a = -foot.dot(across) / across.length_squared();
        let of_c = -(of_a * along[0] + (1.0 - of_a) * along[1]);
        let of_b = 1.0 - of_a - of_c;
        if of_a > 0.0 && of_b > 0.0 && of_c > 0.0 {
            return Nearest::new(points, &[(a, of_a), (b, of_b), (c, of_c)]);
        }
    }
    of_segment(points, a, b).or(of_segment(points, b, c)).or(of_segment(points, c, a))
}

fn of_tetrahedron(points: &[DVec3; 4], is_apart: bool) -> Option<Nearest> {
    const FACES: [[usize; 4]; 4] = [[1, 2, 3, 0], [2, 3, 0, 1], [3, 0, 1, 2], [0, 1, 2, 3]];
    let is_within = |[a, b, c, opposite]: [usize; 4]| {
        let normal = (points[b] - points[a]).cross(points[c] - points[a]);
        let height = (points[opposite] - points[a]).dot(normal);
        let of_origin = -points[a].dot(normal);
        of_origin * height > 0.0
    };
    if !is_apart && FACES.into_iter().all(is_within) {
        return None;
    }
    // The newest corner is on the nearest face. All faces with it: which ones look at the origin is
    // not certain for a flat tetrahedron.
    let [first, second, third, _] = FACES.map(|[a, b, c, _]| of_triangle(points, [a, b, c]));
    Some(first.or(second).or(third))
}
