//! Mesh files.

mod gltf;
mod obj;
mod ply;
mod stl;

use crate::{MeshError, TriMesh, read_file};
use std::io::ErrorKind;
use std::path::Path;

/// Reads an OBJ, PLY, STL, glTF or GLB file, the format chosen by its ending.
///
/// Polygons become fans of triangles; lines, points, materials and animations are left out, and so are triangles
/// without area. The vertices of an STL file are welded. A mesh that faces inward as a whole is turned. Lengths are
/// taken for metres, and no axis is changed.
pub fn load(path: &Path) -> Result<TriMesh, MeshError> {
    // Read the file.
    let name = path.display().to_string();
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    if path.is_dir() {
        return Err(MeshError::Folder { mesh: name });
    }
    let parse: Parser = match ending.as_str() {
        "obj" => obj::parse,
        "ply" => ply::parse,
        "stl" => stl::parse,
        "gltf" | "glb" => gltf::parse,
        _ => {
            let ending = if ending.is_empty() { ending } else { format!(".{ending}") };
            return Err(MeshError::UnknownEnding { mesh: name, ending });
        }
    };
    let bytes = read_file(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => MeshError::Missing { mesh: name.clone() },
        _ => MeshError::Unreadable { mesh: name.clone(), reason: error.to_string() },
    })?;
    if bytes.is_empty() {
        return Err(MeshError::Empty { mesh: name });
    }

    // Turn it into a mesh that keeps the rules.
    let mut mesh = parse(&File { name: &name, path, bytes: &bytes })?;
    mesh.check(&name)?;
    mesh.drop_unused();
    if mesh.mass_properties().volume < 0.0 {
        mesh.flip();
    }
    Ok(mesh)
}

/// Reads what a format says, without judging it.
type Parser = fn(&File) -> Result<TriMesh, MeshError>;

/// A file in memory.
struct File<'a> {
    name: &'a str,
    path: &'a Path,
    bytes: &'a [u8],
}

impl File<'_> {
    fn malformed(&self, format: &'static str, reason: impl ToString) -> MeshError {
        MeshError::Malformed { mesh: self.name.to_owned(), format, reason: reason.to_string() }
    }
}

/// Appends a polygon as a fan of triangles around its first corner; less than three corners make none.
fn push_fan(triangles: &mut Vec<[u32; 3]>, polygon: &[u32]) {
    if let [first, rest @ ..] = polygon {
        triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
    }
}
