//! Which region of the pattern a point of the body is in.

use crate::pattern::Region;
use frangible_geometry::Shape;
use glam::DVec3;

/// The planes of the regions that reach the parent, in its body frame.
pub(super) struct BodyRegions {
    /// What they are among all regions.
    pub(super) numbers: Vec<usize>,
    planes: Vec<(DVec3, f64)>,
    /// Where each region begins in `planes`, and one more entry at the end.
    first: Vec<usize>,
}

impl BodyRegions {
    pub(super) fn new(regions: &[Region], parent: &Shape) -> Self {
        // What is this far beyond the parent's bounds, relative to their size, is nearest to nothing of it.
        const BEYOND: f64 = 1e-6;
        let (low, high) = parent.bounds;
        let reaching = Self::within(regions, parent, BEYOND * 0.5 * (high - low).max_element());
        // A pattern that misses the parent has a nearest region all the same.
        if reaching.numbers.is_empty() { Self::within(regions, parent, f64::INFINITY) } else { reaching }
    }

    /// Those of the regions that are not known to be further than `most` [m] from the parent's bounds.
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

    /// Largest distance to a plane of a region, or one that is larger than `most`.
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

/// The regions that reach into a ball, with those of their planes that pass through it.
#[derive(Default)]
pub(super) struct Neighbourhood {
    /// Each with where its planes end.
    regions: Vec<(usize, usize)>,
    planes: Vec<(DVec3, f64)>,
}

impl Neighbourhood {
    pub(super) fn look(&mut self, regions: &BodyRegions, center: DVec3, radius: f64) {
        self.regions.clear();
        self.planes.clear();
        for region in 0..regions.first.len() - 1 {
            let first = self.planes.len();
            let mut reaches_in = true;
            for &(normal, offset) in &regions.planes[regions.first[region]..regions.first[region + 1]] {
                let distance = normal.dot(center) - offset;
                if distance > radius {
                    reaches_in = false;
                    break;
                }
                if distance >= -radius {
                    self.planes.push((normal, offset));
                }
            }
            if reaches_in {
                self.regions.push((region, self.planes.len()));
            } else {
                self.planes.truncate(first);
            }
        }
    }

    /// The region that a point of the ball lies inside of; `None` on a crack.
    pub(super) fn region_around(&self, point: DVec3) -> Option<usize> {
        let mut first = 0;
        for &(region, end) in &self.regions {
            if self.planes[first..end].iter().all(|(normal, offset)| normal.dot(point) < *offset) {
                return Some(region);
            }
            first = end;
        }
        None
    }
}
