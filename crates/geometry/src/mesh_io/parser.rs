//! A file in memory, and polygons and strips as triangles.

use crate::mesh::TriMesh;
use crate::mesh_check::MeshError;
use crate::mesh_io::attributes::Parsed;
use crate::polygon::triangulate;
use std::path::Path;

/// Parses a format without validation.
pub(crate) type Parser = fn(&File) -> Result<Parsed, MeshError>;

/// A file in memory.
pub(crate) struct File<'a> {
    pub(crate) name: &'a str,
    pub(crate) path: &'a Path,
    pub(crate) bytes: &'a [u8],
    /// True if attributes are wanted besides the shape.
    pub(crate) wanted: bool,
}

/// Characters of a word in a sentence.
const LONGEST_WORD: usize = 60;

impl File<'_> {
    pub(crate) fn malformed(&self, format: &'static str, reason: impl ToString) -> MeshError {
        // A word of a damaged file may be as long as the file.
        let reason = reason.to_string();
        let words = reason.split(' ').map(|word| match word.char_indices().nth(LONGEST_WORD) {
            Some((end, _)) => format!("{}...", &word[..end]),
            None => word.to_owned(),
        });
        let reason = words.collect::<Vec<_>>().join(" ");
        MeshError::Malformed { mesh: self.name.to_owned(), format, reason }
    }
}

/// Appends a polygon as triangles between its corners: a fan around the first one if it is convex;
/// less than three corners make none.
pub(crate) fn push_polygon(mesh: &mut TriMesh, polygon: &[u32]) {
    let at = |vertex: u32| mesh.positions[vertex as usize];
    let triangles = triangulate(polygon, &at);
    mesh.triangles.extend(triangles);
}

/// The triangles of a strip: each corner from the third on makes one with the two before it, every
/// other one turned.
pub(crate) fn strip(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    corners
        .windows(3)
        .enumerate()
        .map(|(n, t)| if n % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] })
}
