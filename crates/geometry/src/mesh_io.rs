//! Mesh files.

pub(crate) mod attributes;
pub(crate) mod gltf;
pub(crate) mod obj;
pub(crate) mod parser;
pub(crate) mod ply;
pub(crate) mod stl;

use crate::mesh::TriMesh;
use crate::mesh_check::MeshError;
use crate::mesh_io::attributes::MeshAttributes;
use crate::mesh_io::parser::File;
use crate::mesh_io::parser::Parser;
use crate::read_file;
use attributes::Parsed;
use std::io::ErrorKind;
use std::path::Path;

/// Reads an OBJ, PLY, STL, glTF or GLB file, the format chosen by its ending.
///
/// Polygons are cut into triangles between their corners, concave ones too; lines, points,
/// materials and animations are left out, and so are triangles without area. The vertices of an STL
/// file are welded. A mesh that faces inward as a whole is turned. Lengths are taken for metres,
/// and no axis is changed.
pub fn load(path: &Path) -> Result<TriMesh, MeshError> {
    read(path, false).map(|parsed| parsed.mesh)
}

/// The same mesh, and what the file says of its triangles besides their shape.
///
/// # Errors
/// As for [`load`].
pub fn load_with_attributes(path: &Path) -> Result<(TriMesh, MeshAttributes), MeshError> {
    read(path, true).map(|parsed| (parsed.mesh, parsed.attributes))
}

/// Reads a file, with attributes where they are `wanted`.
fn read(path: &Path, wanted: bool) -> Result<Parsed, MeshError> {
    // Read the file.
    let name = path.display().to_string();
    let ending =
        path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
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

    let format = match ending.as_str() {
        "obj" => "OBJ",
        "ply" => "PLY",
        "stl" => "STL",
        _ => "glTF",
    };
    if is_utf16(&bytes) {
        let reason = "it is text in UTF-16, must be in UTF-8".to_owned();
        return Err(MeshError::Malformed { mesh: name, format, reason });
    }
    // A mark at the beginning says that it is UTF-8.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);

    // Turn it into a mesh that keeps the rules.
    let mut parsed = parse(&File { name: &name, path, bytes, wanted })?;
    TriMesh::check_size(&name, parsed.mesh.triangles.len())?;
    parsed.mesh.check(&name)?;
    parsed.drop_unused();
    if parsed.mesh.mass_properties().volume < 0.0 {
        parsed.flip();
    }
    Ok(parsed)
}

/// True if a file begins as text in UTF-16 does: with its mark, or with characters and zeros by
/// turns.
fn is_utf16(bytes: &[u8]) -> bool {
    let by_turns = |zero: usize| {
        bytes.len() >= 16
            && bytes[..16].iter().enumerate().all(|(n, &byte)| (byte == 0) == (n % 2 == zero))
            && bytes[..16].is_ascii()
    };
    bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") || by_turns(0) || by_turns(1)
}
