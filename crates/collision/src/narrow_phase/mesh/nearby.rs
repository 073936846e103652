//! Triangles near a body on its way, looked up once for all of its points.

use frangible_geometry::StaticMesh;
use glam::DVec3;
use std::cell::Cell;

/// Most triangles that are listed [1]: to go through a longer list for each point costs more than
/// to go down the mesh's tree.
const MOST_LISTED: usize = 256;

/// A triangle of a mesh, mesh frame [m].
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearTriangle {
    pub(crate) index: usize,
    pub(crate) corners: [DVec3; 3],
    /// Unit, out of its front.
    pub(crate) normal: DVec3,
}

/// All triangles whose boxes meet a box, if they are few and some of them stand for an edge or a
/// corner: of others each point meets its own.
#[derive(Clone, Debug)]
pub(crate) struct Nearby {
    /// The box; empty if there is no list.
    low: DVec3,
    high: DVec3,
    /// In the order of the tree, with their own boxes.
    listed: Vec<(NearTriangle, [DVec3; 2])>,
    /// Around them.
    around: [DVec3; 2],
}

/// Triangles in a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holds {
    Nothing,
    /// Triangles that stand for no edge and no corner.
    Faces,
    Features,
}

/// Triangles for which a list has room from its beginning.
const EXPECTED: usize = 64;

impl NearTriangle {
    pub(crate) fn of(mesh: &StaticMesh, index: usize) -> Self {
        Self { index, corners: mesh.corners(index), normal: mesh.normal(index) }
    }
}

impl Default for Nearby {
    fn default() -> Self {
        let (low, high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        Self { low, high, listed: Vec::new(), around: [low, high] }
    }
}

fn meet([low, high]: [DVec3; 2], [other_low, other_high]: [DVec3; 2]) -> bool {
    low.cmple(other_high).all() && other_low.cmple(high).all()
}

impl Nearby {
    /// Lists the triangles in a box, or tells why it does not.
    pub(crate) fn gather(mesh: &StaticMesh, low: DVec3, high: DVec3) -> (Holds, Self) {
        let any = Cell::new(false);
        let enters =
            |box_low: DVec3, box_high: DVec3| !any.get() && meet([low, high], [box_low, box_high]);
        mesh.visit_features(enters, |_| any.set(true));
        if !any.get() {
            mesh.visit(enters, |_| any.set(true));
            let holds = if any.get() { Holds::Faces } else { Holds::Nothing };
            return (holds, Self::default());
        }
        let mut found = Self { low, high, ..Self::default() };
        found.listed.reserve(EXPECTED);
        let is_full = Cell::new(false);
        let enters = |box_low: DVec3, box_high: DVec3| {
            !is_full.get() && meet([low, high], [box_low, box_high])
        };
        mesh.visit(enters, |index| {
            let [a, b, c] = mesh.corners(index);
            let own = [a.min(b).min(c), a.max(b).max(c)];
            if !is_full.get() && meet([low, high], own) {
                found.around = [found.around[0].min(own[0]), found.around[1].max(own[1])];
                found.listed.push((NearTriangle::of(mesh, index), own));
                is_full.set(found.listed.len() > MOST_LISTED);
            }
        });
        (Holds::Features, if is_full.get() { Self::default() } else { found })
    }

    /// All triangles of the list; `None` if there is none.
    pub(crate) fn listed(&self) -> Option<impl Iterator<Item = &NearTriangle>> {
        let is_list = self.low.cmple(self.high).all();
        is_list.then(|| self.listed.iter().map(|(triangle, _)| triangle))
    }

    /// True if the list holds all triangles that meet a box.
    fn covers(&self, low: DVec3, high: DVec3) -> bool {
        self.low.cmple(low).all() && high.cmple(self.high).all()
    }

    /// Calls `visit` with all triangles whose boxes meet a box [m].
    #[inline]
    pub(crate) fn visit_box(
        &self,
        mesh: &StaticMesh,
        (low, high): (DVec3, DVec3),
        mut visit: impl FnMut(&NearTriangle),
    ) {
        if !self.covers(low, high) {
            mesh.visit_box(low, high, |index| visit(&NearTriangle::of(mesh, index)));
        } else {
            self.visit_listed([low, high], visit);
        }
    }

    /// Calls `visit` with all triangles that come within `margin` [m] of a straight way, and some
    /// others.
    #[inline]
    pub(crate) fn visit_way(
        &self,
        mesh: &StaticMesh,
        way: [DVec3; 2],
        margin: f64,
        mut visit: impl FnMut(&NearTriangle),
    ) {
        let (low, high) = (way[0].min(way[1]) - margin, way[0].max(way[1]) + margin);
        if !self.covers(low, high) {
            mesh.visit_way(way, margin, |index| visit(&NearTriangle::of(mesh, index)));
        } else {
            self.visit_listed([low, high], visit);
        }
    }

    /// Calls `visit` with all listed triangles whose boxes meet a box [m].
    #[inline]
    fn visit_listed(&self, of_box: [DVec3; 2], mut visit: impl FnMut(&NearTriangle)) {
        if meet(of_box, self.around) {
            let met = self.listed.iter().filter(|(_, own)| meet(of_box, *own));
            met.for_each(|(triangle, _)| visit(triangle));
        }
    }
}
