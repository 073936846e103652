//! Open sheets made into plates.

use super::WELDED;
use super::pairing::NONE;
use crate::cleaning::assembly::{Assembly, CRACK, Part};
use crate::mesh::TriMesh;
use crate::mesh_check::MeshError;
use glam::DVec3;
use std::collections::BTreeMap;

/// Along a fold the surfaces of a plate are farther from the sheet than beside it, by at most this
/// factor.
const MOST_STRETCH: f64 = 2.0;

/// A mesh with plates for its open parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Thickened {
    /// The closed parts as they were, and the plates.
    pub mesh: TriMesh,
    /// Number of plates.
    pub plates: usize,
}

impl TriMesh {
    /// The mesh with a plate of a `thickness` [m] in place of each open part: its triangles, moved
    /// by half of that along the normals of their vertices to both sides, and walls along its rims.
    /// Parts are found as in [`TriMesh::cleaned`].
    ///
    /// # Errors
    /// As for [`TriMesh::check`], and if the thickness is not above zero. `name` begins the
    /// sentence.
    pub fn thickened(&self, thickness: f64, name: &str) -> Result<Thickened, MeshError> {
        Self::check_size(name, self.triangles.len())?;
        self.check(name)?;
        if !(thickness.is_finite() && thickness > 0.0) {
            return Err(MeshError::Thickness { mesh: name.to_owned(), thickness });
        }
        let (mut assembly, parts) = Assembly::new(self, &WELDED);
        let (open, closed): (Vec<Part>, Vec<Part>) =
            parts.into_iter().partition(|part| assembly.is_open(part));
        let source = |&triangle: &u32| assembly.source[triangle as usize];
        let mut kept: Vec<u32> =
            closed.iter().flat_map(|part| &part.triangles).map(source).collect();
        kept.sort_unstable();
        kept.dedup();
        let mut mesh = TriMesh {
            positions: self.positions.clone(),
            triangles: kept.iter().map(|&triangle| self.triangles[triangle as usize]).collect(),
        };
        for sheet in &open {
            assembly.add_plate(sheet, 0.5 * thickness, &mut mesh);
        }
        Ok(Thickened { mesh, plates: open.len() })
    }
}

impl Assembly {
    fn is_open(&self, part: &Part) -> bool {
        let hole_area = self.holes_area(part);
        hole_area > CRACK * (self.shell(part).area - hole_area)
    }

    /// Adds the surface of a sheet moved by `half` [m] to both sides.
    fn add_plate(&mut self, part: &Part, half: f64, mesh: &mut TriMesh) {
        // Normals of the vertices, weighted by the angles of their triangles.
        let mut vertices: BTreeMap<u32, Vertex> = BTreeMap::new();
        let mut faces = Vec::with_capacity(part.triangles.len());
        for &triangle in &part.triangles {
            let corners = self.corners(triangle);
            let points = self.points(corners);
            let [a, b, c] = points;
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let roots = corners.map(|corner| self.closed.vertices.root(corner));
            for (corner, &root) in roots.iter().enumerate() {
                let (here, to, from) =
                    (points[corner], points[(corner + 1) % 3], points[(corner + 2) % 3]);
                let vertex = vertices.entry(root).or_insert(Vertex::new(here));
                vertex.add(normal, (to - here).angle_between(from - here));
            }
            faces.push(roots);
        }

        // Each vertex twice: in front of the sheet, and behind it.
        for vertex in vertices.values_mut() {
            let aside = half * vertex.aside();
            vertex.front = mesh.positions.len() as u32;
            mesh.positions.extend([vertex.point + aside, vertex.point - aside]);
        }
        let front = |root: u32| vertices.get(&root).map_or(NONE, |vertex| vertex.front);
        let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * faces.len());
        for roots in faces {
            let [a, b, c] = roots.map(front);
            mesh.triangles.extend([[a, b, c], [a + 1, c + 1, b + 1]]);
            edges.extend(
                [(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), from.max(to), from < to)),
            );
        }

        // Walls where an edge has no opposite.
        edges.sort_unstable();
        for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let forward = edge.iter().filter(|edge| edge.2).count();
            let (low, high, _) = edge[0];
            let (from, to) = if 2 * forward > edge.len() { (low, high) } else { (high, low) };
            for _ in 0..forward.abs_diff(edge.len() - forward) {
                mesh.triangles.extend([[from + 1, to + 1, to], [from + 1, to, from]]);
            }
        }
    }
}

/// A vertex of a sheet.
struct Vertex {
    /// [m]
    point: DVec3,
    /// Sums over its triangles, weighted by their angles there: of unit normals, and of one.
    normals: DVec3,
    angles: f64,
    /// Of its first triangle with an area.
    normal: DVec3,
    /// Index of the front vertex; the back vertex follows.
    front: u32,
}

impl Vertex {
    fn new(point: DVec3) -> Self {
        Self { point, normals: DVec3::ZERO, angles: 0.0, normal: DVec3::ZERO, front: NONE }
    }

    fn add(&mut self, normal: DVec3, angle: f64) {
        // A triangle without an area has neither.
        if normal != DVec3::ZERO && angle.is_finite() {
            self.normals += angle * normal;
            self.angles += angle;
            if self.normal == DVec3::ZERO {
                self.normal = normal;
            }
        }
    }

    /// The way to the plate's surface, for a plate that is two units thick beside it.
    fn aside(&self) -> DVec3 {
        let length = self.normals.length();
        let direction = self.normals.try_normalize().unwrap_or(self.normal);
        direction * (self.angles / length).min(MOST_STRETCH)
    }
}
