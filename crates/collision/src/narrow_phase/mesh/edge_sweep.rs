//! A moving ball against edges and corners of a mesh that stand out.

use crate::narrow_phase::mesh::triangle_sweep::{Sweep, nearest_part, sweep_round};
use frangible_geometry::{EdgeKind, Sides, StaticMesh};
use glam::DVec3;

/// Sine of the angle by which a direction may leave the region where an edge or a corner is the
/// nearest feature [1].
pub(crate) const ASIDE: f64 = 1e-3;

/// One minus the cosine of the angle to a triangle's normal within which a ball touches an edge as
/// it would the triangle [1]: 4 degrees, as far as a ball that overlaps what bears it by a resting
/// contact's depth meets the next edge ahead.
const FLUSH: f64 = 2.5e-3;

/// Distance of a ball's centre from an edge that it touches, relative to its radius [1]: what passes
/// further away passes along the direction from it, not along a triangle's normal.
const TOUCH: f64 = 1.0 + 1e-5;

/// The normal of one of some triangles, if a direction hardly differs from it, or else the
/// direction.
pub(crate) fn flush(direction: DVec3, normals: impl Iterator<Item = DVec3>) -> DVec3 {
    let facing = normals.map(|normal| if normal.dot(direction) < 0.0 { -normal } else { normal });
    let nearest = facing.max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)));
    nearest.filter(|normal| normal.dot(direction) >= 1.0 - FLUSH).unwrap_or(direction)
}

/// Directions at an edge: along it, and from it into its triangles at right angles to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshEdge {
    pub(crate) ends: [DVec3; 2],
    pub(crate) along: DVec3,
    into: [DVec3; 2],
    /// Of a border that is solid behind.
    front: Option<DVec3>,
}

impl MeshEdge {
    /// The edge that begins at a corner of a triangle.
    pub(crate) fn of(mesh: &StaticMesh, triangle: usize, corner: usize) -> Option<Self> {
        let corners = mesh.corners(triangle);
        let ends = [corners[corner], corners[(corner + 1) % 3]];
        let along = (ends[1] - ends[0]).try_normalize()?;
        let own = mesh.normal(triangle).cross(along);
        let is_border = mesh.edge_kind(triangle, corner) == EdgeKind::Border;
        let other = mesh.neighbour_normal(triangle, corner).filter(|_| !is_border);
        let front = mesh.normal(triangle);
        Some(Self {
            ends,
            along,
            into: [own, other.map_or(own, |normal| -normal.cross(along))],
            front: (is_border && mesh.sides() == Sides::One).then_some(front),
        })
    }

    /// True if a body may touch the edge from a unit direction at right angles to it.
    pub(crate) fn stands_out(&self, direction: DVec3, aside: f64) -> bool {
        self.into.iter().all(|into| into.dot(direction) <= aside)
            && self.front.is_none_or(|front| front.dot(direction) >= -aside)
    }

    /// The normal of the triangle over which a direction leans, or the direction.
    pub(crate) fn within_arc(&self, direction: DVec3) -> DVec3 {
        let Some(into) = self.into.iter().find(|into| into.dot(direction) > 0.0) else {
            return direction;
        };
        let normal = into.cross(self.along);
        if normal.dot(direction) < 0.0 { -normal } else { normal }
    }

    /// The normal of one of the triangles, if a direction hardly differs from it, or else the
    /// direction.
    pub(crate) fn flush(&self, direction: DVec3) -> DVec3 {
        let normals = [self.into[0].cross(self.along), self.into[1].cross(self.along)];
        flush(direction, normals.into_iter())
    }

    /// Meeting of a ball whose centre moves straight with the edge; with its foot [m] and the
    /// normal.
    pub(crate) fn sweep(&self, way: [DVec3; 2], radius: f64) -> Option<(Sweep, DVec3, DVec3)> {
        let [from, to] = self.across(way);
        let sweep = sweep_round(from, to, radius);
        self.met_from(way[0].lerp(way[1], sweep.at), radius)
            .map(|(foot, normal)| (sweep, foot, normal))
    }

    /// Where a ball whose centre moves straight comes nearest to the edge: least separation, foot
    /// [m], normal.
    pub(crate) fn nearest(&self, way: [DVec3; 2], radius: f64) -> Option<(f64, DVec3, DVec3)> {
        let [from, to] = self.across(way);
        let at = nearest_part(from, to);
        let least = from.lerp(to, at).length() - radius;
        self.met_from(way[0].lerp(way[1], at), radius).map(|(foot, normal)| (least, foot, normal))
    }

    /// Two points relative to the edge's line, at right angles to it.
    fn across(&self, way: [DVec3; 2]) -> [DVec3; 2] {
        way.map(|point| {
            let lever = point - self.ends[0];
            lever - lever.dot(self.along) * self.along
        })
    }

    /// Foot on the edge [m] and the normal of a ball of `radius` [m] with its centre there; `None`
    /// if something else is nearer.
    fn met_from(&self, center: DVec3, radius: f64) -> Option<(DVec3, DVec3)> {
        let part = (center - self.ends[0]).dot(self.along);
        if part < 0.0 || part > self.ends[0].distance(self.ends[1]) {
            return None;
        }
        let foot = self.ends[0] + part * self.along;
        let direction = (center - foot).try_normalize()?;
        let touches = center.distance(foot) <= TOUCH * radius;
        let normal = if touches { self.flush(direction) } else { direction };
        self.stands_out(direction, ASIDE).then_some((foot, normal))
    }
}

/// [`MeshEdge::sweep`] with a corner.
pub(crate) fn sweep_corner(
    mesh: &StaticMesh,
    vertex: usize,
    way: [DVec3; 2],
    radius: f64,
) -> Option<(Sweep, DVec3, DVec3)> {
    let corner = mesh.positions()[vertex];
    let sweep = sweep_round(way[0] - corner, way[1] - corner, radius);
    let normal = corner_met_from(mesh, vertex, way[0].lerp(way[1], sweep.at), radius)?;
    Some((sweep, corner, normal))
}

/// [`MeshEdge::nearest`] with a corner.
pub(crate) fn nearest_to_corner(
    mesh: &StaticMesh,
    vertex: usize,
    way: [DVec3; 2],
    radius: f64,
) -> Option<(f64, DVec3, DVec3)> {
    let corner = mesh.positions()[vertex];
    let center = way[0].lerp(way[1], nearest_part(way[0] - corner, way[1] - corner));
    let normal = corner_met_from(mesh, vertex, center, radius)?;
    Some((center.distance(corner) - radius, corner, normal))
}

/// Normal of a ball of `radius` [m] with its centre there; `None` if something else is nearer.
fn corner_met_from(mesh: &StaticMesh, vertex: usize, center: DVec3, radius: f64) -> Option<DVec3> {
    let direction = (center - mesh.positions()[vertex]).try_normalize()?;
    // A solid's corner is not met from behind.
    let is_in_front = mesh.sides() == Sides::Two
        || mesh.around(vertex).iter().any(|&t| mesh.normal(t as usize).dot(direction) > 0.0);
    let is_met = is_in_front && mesh.is_peak(vertex, direction, ASIDE);
    let normals = mesh.around(vertex).iter().map(|&triangle| mesh.normal(triangle as usize));
    let touches = center.distance(mesh.positions()[vertex]) <= TOUCH * radius;
    is_met.then(|| if touches { flush(direction, normals) } else { direction })
}
