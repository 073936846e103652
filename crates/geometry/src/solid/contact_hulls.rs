//! The hulls as which a solid meets others.

use super::Solid;
use super::convex_parts::PlaneSearch;
use crate::hull::Hull;

/// How closely hulls stand for a solid in contact.
#[derive(Clone, Copy, Debug)]
pub struct ContactHulls {
    /// Most vertices of a hull.
    pub vertices: usize,
    /// A hull leaves out points that lie no farther outside of it, relative to the diagonal of its
    /// part [1].
    pub within: f64,
    /// One hull stands for a solid that it exceeds by less volume, relative to the solid's [1].
    pub convex: f64,
    /// Else so many parts at most.
    pub parts: usize,
    /// And fewer if their hulls exceed the solid by less than this [1].
    pub excess: f64,
    /// How well the parts are chosen.
    pub search: PlaneSearch,
}

impl ContactHulls {
    /// The hulls of a solid, and by how much they exceed it, relative to its volume; none for one
    /// without a volume. They overlap none of a solid that a plane parts from this one.
    pub fn of(&self, solid: &Solid) -> (Vec<Hull>, f64) {
        let volume = solid.mass_properties().volume;
        let Some(hull) = self.hull(solid) else { return (Vec::new(), 0.0) };
        let excess = |hulls: &[Hull]| hulls.iter().map(Hull::volume).sum::<f64>() / volume - 1.0;
        let alone = vec![hull];
        let of_one = excess(&alone);
        if of_one <= self.convex || self.parts < 2 {
            return (alone, of_one);
        }
        let parts = solid.convex_parts(self.parts, self.excess, self.search);
        let hulls: Vec<Hull> = parts.iter().filter_map(|part| self.hull(&part.solid)).collect();
        let of_parts = excess(&hulls);
        if hulls.is_empty() { (alone, of_one) } else { (hulls, of_parts) }
    }

    fn hull(&self, solid: &Solid) -> Option<Hull> {
        let (low, high) = solid.bounds();
        let within = self.within * (high - low).length();
        Hull::of_few_points(solid.vertices(), self.vertices, within).ok()
    }
}
