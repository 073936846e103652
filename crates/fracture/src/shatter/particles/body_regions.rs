//! Which region of the pattern a point of the body is in.

use crate::pattern::region::Region;
use frangible_geometry::Shape;
use glam::{DVec3, Vec3};

/// The planes of the regions that reach the parent, in its body frame.
pub(super) struct BodyRegions {
    /// Indices among all regions.
    pub(super) numbers: Vec<usize>,
    planes: Vec<(DVec3, f64)>,
    /// Where each region begins in `planes`, and one more entry at the end.
    first: Vec<usize>,
}

impl BodyRegions {
    pub(super) fn new(regions: &[Region], parent: &Shape) -> Self {
        // Regions further beyond the parent's bounds than this fraction of their size are nearest
        // to none of it.
        const BEYOND: f64 = 1e-6;
        let (low, high) = parent.bounds;
        let reaching = Self::within(regions, parent, BEYOND * 0.5 * (high - low).max_element());
        // A pattern that misses the parent has a nearest region all the same.
        if reaching.numbers.is_empty() {
            Self::within(regions, parent, f64::INFINITY)
        } else {
            reaching
        }
    }

    /// Those of the regions that are not known to be further than `most` [m] from the parent's
    /// bounds.
    fn within(regions: &[Region], parent: &Shape, most: f64) -> Self {
        let (low, high) = parent.bounds;
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let mut moved = Self { numbers: Vec::new(), planes: Vec::new(), first: vec![0] };
        for (number, region) in regions.iter().enumerate() {
            let first = moved.planes.len();
            let is_near = region.cuts.iter().all(|cut| {
                let normal = parent.body_from_grid.direction(cut.half_space.normal);
                let offset = cut.half_space.offset + normal.dot(parent.body_from_grid.translation);
                moved.planes.push((normal, offset));
                normal.dot(middle) - offset - normal.abs().dot(half) <= most
            });
            if is_near {
                moved.numbers.push(number);
                moved.first.push(moved.planes.len());
            } else {
                moved.planes.truncate(first);
            }
        }
        moved
    }

    /// Largest distance to a plane of a region; values above `most` are lower bounds.
    #[inline]
    pub(super) fn distance(&self, region: usize, point: DVec3, most: f64) -> f64 {
        let mut largest = f64::NEG_INFINITY;
        for (normal, offset) in &self.planes[self.first[region]..self.first[region + 1]] {
            let distance = normal.dot(point) - offset;
            if distance > largest {
                largest = distance;
                if distance > most {
                    break;
                }
            }
        }
        largest
    }

    /// The region with the least distance; `guess` is looked at first.
    pub(super) fn nearest(&self, point: DVec3, guess: usize) -> usize {
        let mut nearest = (guess, self.distance(guess, point, f64::INFINITY));
        if nearest.1 < 0.0 {
            return guess;
        }
        for region in 0..self.first.len() - 1 {
            let distance = self.distance(region, point, nearest.1);
            if distance < nearest.1 || (distance == nearest.1 && region < nearest.0) {
                nearest = (region, distance);
            }
        }
        nearest.0
    }
}

/// Regions that reach into a ball, with their planes through it.
pub(super) struct Neighbourhood<'a> {
    of: &'a BodyRegions,
    /// Each with where its planes end.
    regions: Vec<(usize, usize)>,
    planes: Vec<(DVec3, f64)>,
    /// Per region, the plane that excluded it from the last ball: a likely separator for the next.
    keeps_out: Vec<usize>,
}

/// Number of points per lookup: a full cluster.
pub(super) const POINTS: usize = 16;

impl<'a> Neighbourhood<'a> {
    pub(super) fn new(of: &'a BodyRegions) -> Self {
        let keeps_out = of.first[..of.first.len() - 1].to_vec();
        Self { of, regions: Vec::new(), planes: Vec::new(), keeps_out }
    }

    /// Of a ball.
    pub(super) fn look(&mut self, center: DVec3, radius: f64) {
        self.regions.clear();
        self.planes.clear();
        let distance = |(normal, offset): &(DVec3, f64)| normal.dot(center) - offset;
        for (region, keeps_out) in self.keeps_out.iter_mut().enumerate() {
            let planes = self.of.first[region]..self.of.first[region + 1];
            if planes.contains(keeps_out) && distance(&self.of.planes[*keeps_out]) > radius {
                continue;
            }
            let first = self.planes.len();
            let mut reaches_in = true;
            for (number, plane) in planes.clone().zip(&self.of.planes[planes]) {
                let distance = distance(plane);
                if distance > radius {
                    (reaches_in, *keeps_out) = (false, number);
                    break;
                }
                if distance >= -radius {
                    self.planes.push(*plane);
                }
            }
            if reaches_in {
                self.regions.push((region, self.planes.len()));
            } else {
                self.planes.truncate(first);
            }
        }
    }

    /// The region that the whole ball lies inside of.
    pub(super) fn region_of_all(&self) -> Option<usize> {
        match self.regions[..] {
            [(region, 0)] => Some(region),
            _ => None,
        }
    }

    /// The regions that up to [`POINTS`] points of the ball lie inside of; `None` on a crack, and
    /// where there is no point.
    pub(super) fn regions_of(&self, points: &[Vec3]) -> [Option<usize>; POINTS] {
        const ON_CRACK: u64 = u64::MAX;
        let mut places = [[0.0; POINTS]; 3];
        for (at, point) in points.iter().enumerate() {
            let point = point.as_dvec3();
            (places[0][at], places[1][at], places[2][at]) = (point.x, point.y, point.z);
        }
        let [x, y, z] = &places;

        // Test all points against one plane at a time, without branches per point. A point belongs
        // to its first region.
        let mut found = [ON_CRACK; POINTS];
        for (n, &(region, end)) in self.regions.iter().enumerate().rev() {
            let first = if n == 0 { 0 } else { self.regions[n - 1].1 };
            let mut farthest = [f64::NEG_INFINITY; POINTS];
            for (normal, offset) in &self.planes[first..end] {
                for at in 0..POINTS {
                    let distance = normal.x * x[at] + normal.y * y[at] + normal.z * z[at] - offset;
                    farthest[at] = if distance > farthest[at] { distance } else { farthest[at] };
                }
            }
            for at in 0..POINTS {
                found[at] = if farthest[at] < 0.0 { region as u64 } else { found[at] };
            }
        }
        found.map(|region| (region != ON_CRACK).then_some(region as usize))
    }
}
