//! Point of a simplex nearest to the origin [Ericson, Real-Time Collision Detection, ch. 5.1].

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

    /// The nearest point [m].
    pub(crate) fn nearest(&self) -> DVec3 {
        self.weighted(|corner| corner.between)
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
    /// origin; `None` if the origin is inside.
    pub(crate) fn with(&self, corner: Difference) -> Option<Self> {
        let mut all = self.corners;
        all[self.count] = corner;
        match self.count {
            1 => Some(of_segment(all[0], all[1])),
            2 => Some(of_triangle(all[0], all[1], all[2])),
            _ => of_tetrahedron(&all),
        }
    }
}

fn of_segment(a: Difference, b: Difference) -> Simplex {
    let along = b.between - a.between;
    let length_squared = along.length_squared();
    let part = if length_squared > 0.0 { -a.between.dot(along) / length_squared } else { 0.0 };
    if part <= 0.0 {
        return Simplex::new(a);
    }
    if part >= 1.0 {
        return Simplex::new(b);
    }
    Simplex { corners: [a, b, a, a], weights: [1.0 - part, part, 0.0, 0.0], count: 2 }
}

fn of_triangle(a: Difference, b: Difference, c: Difference) -> Simplex {
    // From the corner opposite of the longest side: two corners on a rim are near each other.
    let way = |p: Difference, q: Difference| p.between.distance_squared(q.between);
    let [of_a, of_b, of_c] = [way(b, c), way(c, a), way(a, b)];
    let [a, b, c] = if of_a >= of_b && of_a >= of_c {
        [a, b, c]
    } else if of_b >= of_c {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let (ab, ac) = (b.between - a.between, c.between - a.between);
    let normal = ab.cross(ac);
    let area_squared = normal.length_squared();
    // By the sides, not by the corners: corners on a rim are near each other and far away.
    let of_b = -a.between.cross(ac).dot(normal) / area_squared;
    let of_c = -ab.cross(a.between).dot(normal) / area_squared;
    let of_a = 1.0 - of_b - of_c;
    if area_squared > 0.0 && of_a > 0.0 && of_b > 0.0 && of_c > 0.0 {
        return Simplex { corners: [a, b, c, a], weights: [of_a, of_b, of_c, 0.0], count: 3 };
    }
    nearest_of([of_segment(a, b), of_segment(b, c), of_segment(c, a)])
}

fn of_tetrahedron(all: &[Difference; 4]) -> Option<Simplex> {
    let face = |opposite: usize| [1, 2, 3].map(|step| all[(opposite + step) % 4]);
    let is_within = |opposite: usize| {
        let [a, b, c] = face(opposite);
        let normal = (b.between - a.between).cross(c.between - a.between);
        let height = (all[opposite].between - a.between).dot(normal);
        let of_origin = -a.between.dot(normal);
        of_origin * height > 0.0
    };
    if (0..4).all(is_within) {
        return None;
    }
    // All faces: which ones look at the origin is not certain for a flat tetrahedron.
    Some(nearest_of([0, 1, 2, 3].map(|opposite| {
        let [a, b, c] = face(opposite);
        of_triangle(a, b, c)
    })))
}

fn nearest_of<const N: usize>(all: [Simplex; N]) -> Simplex {
    let way = |simplex: &Simplex| simplex.nearest().length_squared();
    all.into_iter().fold(all[0], |a, b| if way(&b) < way(&a) { b } else { a })
}
