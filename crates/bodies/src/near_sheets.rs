//! Sides of closed sheets that bodies are on: known from when a body first came near, so that it
//! comes back where it has sunk in.

use crate::bodies::Bodies;
use crate::body_id::BodyId;
use crate::pair::Pair;
use frangible_geometry::{Compartment, Geometry, Shape, StaticMesh};
use glam::DVec3;

/// Depth at which a body is no longer where it was, in units of its radius and of its way in a
/// frame [1]: a caller may have put the sheet elsewhere.
const LOST: f64 = 2.0;

/// The triangles of a closed sheet.
fn closed_sheet(shape: &Shape) -> Option<&StaticMesh> {
    match &shape.geometry {
        Geometry::Mesh(mesh) if mesh.is_closed_sheet() => Some(mesh),
        _ => None,
    }
}

/// A point inside of a body, body frame [m].
fn point_inside(shape: &Shape) -> DVec3 {
    if let Some(compound) = &shape.compound {
        let middles = compound.parts().iter().map(|part| {
            let vertices = part.hull.vertices();
            vertices.iter().sum::<DVec3>() / vertices.len() as f64
        });
        let nearest = middles.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        return nearest.unwrap_or(DVec3::ZERO);
    }
    let is_hollow = matches!(shape.geometry, Geometry::Grid(_))
        && shape.distance_and_gradient(DVec3::ZERO).0 > 0.0;
    let sample = if is_hollow { shape.samples().first() } else { None };
    sample.map_or(DVec3::ZERO, |sample| sample.as_dvec3())
}

impl Bodies {
    /// Notes where the bodies of pairs are that may meet closed sheets in frames of `dt` [s]. What
    /// was noted before holds; a body that is new is where its parent was.
    pub fn note_enclosures(
        &mut self,
        pairs: &[Pair],
        dt: f64,
        parent: impl Fn(usize) -> Option<BodyId>,
    ) {
        let is_sheet: Vec<bool> = (0..self.len())
            .map(|i| self.inertias[i].is_infinite() && closed_sheet(&self.shapes[i]).is_some())
            .collect();
        if !is_sheet.contains(&true) {
            self.enclosures.known.clear();
            return;
        }
        let last = std::mem::take(&mut self.enclosures.known);
        for &pair in pairs {
            let sides = [(pair.first, pair.second), (pair.second, pair.first)];
            for (sheet, body) in sides.into_iter().filter(|&(sheet, _)| is_sheet[sheet]) {
                let Some(mesh) = closed_sheet(&self.shapes[sheet]) else { continue };
                let of_body = |id: BodyId| last.get(&[self.ids[sheet], id]).copied();
                let noted = of_body(self.ids[body]).or_else(|| of_body(parent(body)?));
                let sheet_from_world = self.poses[sheet].world_from_body().inverse();
                let inside = self.poses[body].world_from_body().point(self.point_inside(body));
                let point = sheet_from_world.point(inside);
                let way = dt * self.velocities[body].linear.length();
                let least = -LOST * (self.radii[body] + way);
                let holds = |&noted: &u32| {
                    mesh.seen_from(Compartment(noted)).distance_and_gradient(point).0 > least
                };
                let noted = noted.filter(holds).unwrap_or_else(|| mesh.compartment(point).0);
                self.enclosures.known.insert([self.ids[sheet], self.ids[body]], noted);
            }
        }
    }

    /// A point inside of a body, body frame [m].
    pub fn point_inside(&self, body: usize) -> DVec3 {
        point_inside(&self.shapes[body])
    }

    /// Closed sheets and the bodies near them, by dense index.
    pub fn enclosed(&self) -> Vec<[usize; 2]> {
        let pairs = self.enclosures.known.keys();
        pairs
            .filter_map(|&[sheet, body]| Some([self.index_of(sheet)?, self.index_of(body)?]))
            .collect()
    }

    /// True if the side of a mesh is known that a body is on.
    pub fn is_enclosed(&self, sheet: usize, body: usize) -> bool {
        self.enclosures.known.contains_key(&[self.ids[sheet], self.ids[body]])
    }

    /// The mesh of a body, as another one meets it.
    #[inline]
    pub fn seen_by<'a>(&self, mesh: &'a StaticMesh, sheet: usize, body: usize) -> &'a StaticMesh {
        if !mesh.is_closed_sheet() {
            return mesh;
        }
        let known = self.enclosures.known.get(&[self.ids[sheet], self.ids[body]]);
        known.map_or(mesh, |&compartment| mesh.seen_from(Compartment(compartment)))
    }
}
