//! Where a point is in the space that a closed sheet parts, and the sheet as it is seen from there.

use crate::mesh::TriMesh;
use crate::static_mesh::StaticMesh;
use crate::static_mesh::closed_sheet::{ClosedSheet, Compartment};
use crate::static_mesh::kinds::Sides;
use glam::DVec3;

/// Ways out of a surface, of which most decide: a way may meet an edge. In general position.
const WAYS: [DVec3; 3] = [
    DVec3::new(0.836_421_3, 0.421_937_1, 0.350_117_9),
    DVec3::new(-0.312_718_9, 0.787_653_1, -0.530_911_7),
    DVec3::new(0.219_313_7, -0.603_117_1, -0.766_928_3),
];

impl StaticMesh {
    /// True for a two-sided mesh whose surfaces have no border.
    pub fn is_closed_sheet(&self) -> bool {
        self.closed.is_some()
    }

    /// Where a point is; outside, for any mesh but a [closed sheet](Self::is_closed_sheet).
    pub fn compartment(&self, point: DVec3) -> Compartment {
        let around = |closed: &ClosedSheet| self.innermost(closed, point);
        self.closed.as_deref().map_or_else(Compartment::default, around)
    }

    /// The innermost surface around a point that an odd number of its triangles meets on its way
    /// out.
    fn innermost(&self, closed: &ClosedSheet, point: DVec3) -> Compartment {
        let (low, high) = self.bounds();
        if point.cmplt(low).any() || point.cmpgt(high).any() {
            return Compartment::default();
        }
        let out = 2.0 * (high - low).length();
        let mut inside = vec![0_u8; closed.volumes.len()];
        for way in WAYS {
            let end = point + out * way;
            let mut is_inside = vec![false; closed.volumes.len()];
            self.visit_way([point, end], 0.0, |triangle| {
                if is_crossed(self.corners(triangle), point, end - point) {
                    is_inside[closed.surface_of[triangle] as usize] ^= true;
                }
            });
            is_inside.iter().zip(&mut inside).for_each(|(&one, votes)| *votes += u8::from(one));
        }
        let around =
            (0..inside.len()).filter(|&surface| 2 * usize::from(inside[surface]) > WAYS.len());
        let innermost = around.min_by(|&a, &b| closed.volumes[a].total_cmp(&closed.volumes[b]));
        Compartment(innermost.map_or(0, |surface| surface as u32 + 1))
    }

    /// The mesh for a body in a compartment: solid beyond it. Any mesh but a closed sheet is the
    /// same for all bodies.
    pub fn seen_from(&self, compartment: Compartment) -> &Self {
        let Some(closed) = &self.closed else { return self };
        let Some(seen) = self.seen.get(compartment.0 as usize) else { return self };
        if let Some(known) = seen.get() {
            return known;
        }
        let triangles = closed.facing(&self.triangles, compartment);
        let one_sided = TriMesh { positions: self.positions.clone(), triangles };
        match Self::new(&one_sided, Sides::One) {
            Some(one_sided) => seen.get_or_init(|| Box::new(one_sided)),
            None => self,
        }
    }
}

/// True if a way from a point goes through a triangle [MT97].
fn is_crossed([a, b, c]: [DVec3; 3], from: DVec3, way: DVec3) -> bool {
    let (along, across) = (b - a, c - a);
    let p = way.cross(across);
    let determinant = along.dot(p);
    if determinant == 0.0 {
        return false;
    }
    let to = from - a;
    let u = to.dot(p) / determinant;
    let q = to.cross(along);
    let v = way.dot(q) / determinant;
    let t = across.dot(q) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t)
}
