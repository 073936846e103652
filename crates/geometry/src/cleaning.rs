//! Any triangles made into closed surfaces that bound solids: what every use of a mesh begins with.

pub(crate) mod assembly;
pub(crate) mod clean_mesh;
pub(crate) mod enclosed;
pub(crate) mod junctions;
pub(crate) mod meeting;
pub(crate) mod pairing;
pub(crate) mod rims;
pub(crate) mod shells;
pub(crate) mod thicken;

use crate::cleaning::assembly::Assembly;
use crate::cleaning::clean_mesh::CleanMesh;
use crate::mesh::TriMesh;
use crate::mesh_check::MeshError;

/// Vertices at open edges are welded when they are closer than these parts of the bounding box's
/// diagonal, the smallest first: noise of double precision, and of single precision. Two sheets a
/// micrometre apart in a metre stay two.
const WELDED: [f64; 3] = [1e-12, 1e-9, 2.5e-7];
/// Tried where nothing is closed otherwise: parts that were meant to meet.
const WELDED_AT_LAST: [f64; 6] = [1e-12, 1e-9, 2.5e-7, 1e-5, 1e-4, 1e-3];

impl TriMesh {
    /// The solids that the mesh bounds: vertices are welded where edges are open, repeated
    /// triangles dropped, neighbours turned to agree part by part, holes closed by triangles
    /// between the vertices of their rims, outer surfaces turned outward and cavities inward. Open
    /// flat parts are left out. Parts that only touch at a vertex, an edge or a face stay parts.
    ///
    /// # Errors
    /// As for [`TriMesh::check`], if there are more than [`TriMesh::MOST_TRIANGLES`], and
    /// if no part encloses a volume. `name` begins the sentence.
    pub fn cleaned(&self, name: &str) -> Result<CleanMesh, MeshError> {
        Self::check_size(name, self.triangles.len())?;
        self.check(name)?;
        let cleaned = clean(self, &WELDED);
        if !cleaned.mesh.triangles.is_empty() {
            return Ok(cleaned);
        }
        let wider = clean(self, &WELDED_AT_LAST);
        if !wider.mesh.triangles.is_empty() {
            return Ok(wider);
        }
        let sheets = &cleaned.changes.sheets;
        Err(MeshError::NothingClosed {
            mesh: name.to_owned(),
            parts: sheets.len(),
            area: sheets.iter().map(|sheet| sheet.area).sum(),
        })
    }
}

/// Nothing at all if no part encloses a volume.
fn clean(raw: &TriMesh, tolerances: &[f64]) -> CleanMesh {
    let (mut assembly, mut parts) = Assembly::new(raw, tolerances);
    enclosed::join_sheets(&mut assembly, &mut parts);
    assembly.finish(raw, &parts)
}
