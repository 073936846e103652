//! Which cells of a pattern can be the nearest at a place: looked up, instead of sought among all
//! of them.

use glam::DVec3;

/// Number of halvings of the box along each axis.
const HALVINGS: u32 = 5;

/// Cubes along each axis.
const CUBES: usize = 1 << HALVINGS;

/// No cell, or none that is known for sure.
const NONE: u32 = u32::MAX;

/// For each of the cuboids that a pattern's box is divided into, the cells that are nearest or
/// second nearest to any of its points.
#[derive(Clone, Debug)]
pub(crate) struct Nearby {
    half_extent: DVec3,
    /// Candidate cells in ascending order, cuboid by cuboid.
    cells: Vec<u32>,
    /// Offset of each cuboid's list, and the end.
    first: Vec<u32>,
    /// The nearest cell everywhere in a cuboid, if unique.
    sure: Vec<u32>,
}

impl Nearby {
    /// Of so many cells in the box of `half_extent`, with the distance of each to a point, which
    /// changes by at most `slope` times the way between two points.
    pub(crate) fn new(
        half_extent: DVec3,
        count: usize,
        slope: f64,
        distance: impl Fn(usize, DVec3) -> f64,
    ) -> Self {
        let all: Vec<u32> = (0..count as u32).collect();
        let mut of_cuboids = vec![(Vec::new(), NONE); CUBES * CUBES * CUBES];
        let search = Search { half_extent, slope, distance };
        search.divide([0; 3], 0, &all, &mut of_cuboids);
        let mut nearby = Self { half_extent, cells: Vec::new(), first: vec![0], sure: Vec::new() };
        for (cells, sure) in of_cuboids {
            nearby.cells.extend(cells);
            nearby.first.push(nearby.cells.len() as u32);
            nearby.sure.push(sure);
        }
        nearby
    }

    /// The cells that are nearest or second nearest at a point, in ascending order, and perhaps
    /// others; `None` beyond the box.
    #[inline]
    pub(crate) fn around(&self, point: DVec3) -> Option<&[u32]> {
        let at = self.cuboid(point)?;
        Some(&self.cells[self.first[at] as usize..self.first[at + 1] as usize])
    }

    /// The nearest cell, if it is the same all around a point.
    #[inline]
    pub(crate) fn sure(&self, point: DVec3) -> Option<usize> {
        let cell = self.sure[self.cuboid(point)?];
        (cell != NONE).then_some(cell as usize)
    }

    #[inline]
    fn cuboid(&self, point: DVec3) -> Option<usize> {
        let place = (point / self.half_extent + 1.0) * (0.5 * CUBES as f64);
        let is_inside =
            place.cmpge(DVec3::ZERO).all() && place.cmple(DVec3::splat(CUBES as f64)).all();
        let [i, j, k] = place.to_array().map(|along| (along as usize).min(CUBES - 1));
        is_inside.then_some(i + CUBES * (j + CUBES * k))
    }
}

struct Search<D> {
    half_extent: DVec3,
    slope: f64,
    distance: D,
}

impl<D: Fn(usize, DVec3) -> f64> Search<D> {
    /// Finds candidates among `cells` for a cuboid or its parts; the cuboid is at `place` after
    /// `halvings`.
    fn divide(
        &self,
        place: [usize; 3],
        halvings: u32,
        cells: &[u32],
        found: &mut [(Vec<u32>, u32)],
    ) {
        let along = (1_u32 << halvings) as f64;
        let half = self.half_extent / along;
        let middle = 2.0 * half * DVec3::from(place.map(|n| n as f64 + 0.5)) - self.half_extent;

        // A little more than rounding beyond what any point of the cuboid can see.
        let reach = 1.001 * self.slope * half.length();
        let distances: Vec<f64> =
            cells.iter().map(|&cell| (self.distance)(cell as usize, middle)).collect();
        let (mut least, mut second) = (f64::INFINITY, f64::INFINITY);
        for &distance in &distances {
            if distance < least {
                (least, second) = (distance, least);
            } else if distance < second {
                second = distance;
            }
        }
        let near: Vec<u32> = (cells.iter().zip(&distances))
            .filter(|&(_, &distance)| distance <= second + 2.0 * reach)
            .map(|(&cell, _)| cell)
            .collect();
        if halvings < HALVINGS {
            for part in 0..8 {
                let of_part = std::array::from_fn(|axis| 2 * place[axis] + (part >> axis & 1));
                self.divide(of_part, halvings + 1, &near, found);
            }
            return;
        }
        let is_sure = least + 2.0 * reach < second;
        let nearest = cells.iter().zip(&distances).find(|&(_, &distance)| distance == least);
        let sure = nearest.filter(|_| is_sure).map_or(NONE, |(&cell, _)| cell);
        let [i, j, k] = place;
        found[i + CUBES * (j + CUBES * k)] = (near, sure);
    }
}
