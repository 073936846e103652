//! glTF and GLB: the triangles of the default scene, where its nodes put them.

pub(crate) mod accessor;
pub(crate) mod attributes;

use super::attributes::{FaceAttributes, Parsed, number_of};
use crate::mesh::TriMesh;
use crate::mesh_check::MeshError;
use crate::mesh_io::gltf::accessor::items;
use crate::mesh_io::parser::{File, strip};
use crate::read_file;
use base64::Engine;
use glam::{DMat4, DVec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Source;
use gltf::json::validation::Checked;
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Node, Primitive, Semantic};
use std::path::{Component, Path};

pub(super) fn parse(file: &File) -> Result<Parsed, MeshError> {
    let malformed = |reason: String| file.malformed("glTF", reason);
    let (document, buffers) = open(file).map_err(malformed)?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| malformed("it has no scene".to_owned()))?;

    let placed = nodes_with_meshes(&document, scene.nodes()).map_err(malformed)?;

    // Nodes may share a mesh: a small file can hold any number of triangles.
    let all = placed.iter().flat_map(|of| of.node.mesh()).flat_map(|mesh| mesh.primitives());
    let bytes = buffers.iter().map(Vec::len).sum();
    let count =
        all.map(|primitive| most_triangles(&primitive, bytes)).fold(0, usize::saturating_add);
    TriMesh::check_size(file.name, count)?;

    let mut parsed = Parsed::default();
    let materials = 0..document.materials().len();
    parsed.attributes.materials = materials.map(|number| number.to_string()).collect();
    for placed in placed {
        for primitive in placed.node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            append(&mut parsed, &placed, &primitive, &buffers, file)?;
        }
    }
    Ok(parsed)
}

/// A node with a mesh, where its parents put it.
struct Placed<'a> {
    node: Node<'a>,
    scene_from_node: DMat4,
    /// Names from the scene down to the node.
    path: Vec<String>,
}

/// Walks down the scene's nodes.
fn nodes_with_meshes<'a>(
    document: &Document,
    roots: impl Iterator<Item = Node<'a>>,
) -> Result<Vec<Placed<'a>>, String> {
    let mut seen = vec![false; document.nodes().len()];
    let mut waiting: Vec<(Node, DMat4, Vec<String>)> =
        roots.map(|node| (node, DMat4::IDENTITY, Vec::new())).collect();
    let mut placed = Vec::new();
    while let Some((node, scene_from_parent, above)) = waiting.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(format!("node {} is the child of more than one node", node.index()));
        }
        let columns = node.transform().matrix().map(|column| column.map(f64::from));
        let scene_from_node = scene_from_parent * DMat4::from_cols_array_2d(&columns);

        let mut path = above;
        path.extend(attributes::name(&node));
        waiting.extend(node.children().map(|child| (child, scene_from_node, path.clone())));
        if node.mesh().is_some() {
            placed.push(Placed { node, scene_from_node, path });
        }
    }
    Ok(placed)
}

/// Appends the triangles of a node's primitive, and their attributes where they are wanted.
fn append(
    parsed: &mut Parsed,
    Placed { node, scene_from_node, path }: &Placed,
    primitive: &Primitive,
    buffers: &[Vec<u8>],
    file: &File,
) -> Result<(), MeshError> {
    let place = format!("node {}, primitive {}", node.index(), primitive.index());
    let (positions, indices) = read(primitive, buffers)
        .map_err(|reason| file.malformed("glTF", format!("{place} {reason}")))?;
    let last = positions.len() as i64 - 1;
    if let Some(&index) = indices.iter().find(|&&index| i64::from(index) > last) {
        let (mesh, index) = (file.name.to_owned(), i64::from(index));
        return Err(MeshError::IndexOutOfRange { mesh, place, index, first: 0, last });
    }
    let Parsed { mesh, attributes: said, .. } = parsed;
    let base = mesh.positions.len() as u32;
    let mirrored = scene_from_node.determinant() < 0.0;
    mesh.positions
        .extend(positions.iter().map(|&position| scene_from_node.transform_point3(position)));
    let turned = triangles(primitive.mode(), &indices)
        .into_iter()
        .map(|[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] });
    let own: Vec<[u32; 3]> = turned.collect();
    mesh.triangles.extend(own.iter().map(|corners| corners.map(|corner| base + corner)));
    if !file.wanted {
        return Ok(());
    }

    let corners = attributes::corners(primitive, buffers, scene_from_node, positions.len());
    let material = primitive.material().index().map(|index| index as u32);
    let object = (!path.is_empty()).then(|| number_of(&mut said.objects, path.clone()));
    said.faces.extend(own.iter().map(|triangle| FaceAttributes {
        object,
        material,
        corners: triangle.map(|corner| corners[corner as usize]),
    }));
    Ok(())
}

/// The document and the bytes of its buffers; the error completes the sentence "it is not a valid
/// glTF file".
fn open(file: &File) -> Result<(Document, Vec<Vec<u8>>), String> {
    // The library takes the length in the header of a GLB file for at least the header's own.
    let length = file
        .bytes
        .get(8..12)
        .map_or(0, |bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    if file.bytes.starts_with(b"glTF") && (length < 12 || length as usize > file.bytes.len()) {
        return Err(format!("its header says {length} bytes, and it has {}", file.bytes.len()));
    }

    // Of the extensions that a reader is required to know, those about materials and the like do
    // not matter here.
    let Gltf { document, mut blob } =
        Gltf::from_slice_without_validation(file.bytes).map_err(|error| error.to_string())?;
    let mut json = document.into_json();
    json.extensions_required.retain(|extension| extension.contains("mesh"));

    // The library's check of the indices takes that of the positions for good.
    let accessors = json.accessors.len();
    for primitive in json.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        if let Some(index) =
            positions.map(|index| index.value()).filter(|&index| index >= accessors)
        {
            return Err(format!("it refers to accessor {index}, and has {accessors}"));
        }
    }
    let document = Document::from_json(json).map_err(|error| error.to_string())?;

    // Each buffer is in the file itself or beside it.
    let buffers = document
        .buffers()
        .map(|buffer| match buffer.source() {
            Source::Bin => {
                blob.take().ok_or_else(|| format!("buffer {} is missing", buffer.index()))
            }
            Source::Uri(uri) => {
                read_uri(file, uri).map_err(|reason| format!("buffer {} {reason}", buffer.index()))
            }
        })
        .collect::<Result<_, _>>()?;
    Ok((document, buffers))
}

/// The bytes that a URI names: its own in base64, or those of a file relative to the document.
fn read_uri(file: &File, uri: &str) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, data) = data.split_once(";base64,").ok_or("is embedded, but not as base64")?;
        return base64::engine::general_purpose::STANDARD
            .decode(data)
            .map_err(|error| format!("is not base64: {error}"));
    }
    let relative = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let path = file.path.with_file_name(relative.as_ref());
    let unreadable =
        |error: std::io::Error| format!("in {} cannot be read: {error}", path.display());
    let foreign = || format!("is in {uri:?}, must be a file in the document's own folder");

    // A path that leads out of the folder is not read, be it by a link.
    let is_below = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    let is_elsewhere = uri.contains(':') || relative.contains(['\\', '\0']);
    if is_elsewhere || !Path::new(relative.as_ref()).components().all(is_below) {
        return Err(foreign());
    }
    let found = path.canonicalize().map_err(unreadable)?;
    let folder = file.path.canonicalize().map_err(unreadable)?;
    if !folder.parent().is_some_and(|folder| found.starts_with(folder)) {
        return Err(foreign());
    }
    read_file(&found).map_err(unreadable)
}

/// Positions in the node's frame and indices of a primitive; the error completes "node 2, primitive
/// 0".
fn read(primitive: &Primitive, buffers: &[Vec<u8>]) -> Result<(Vec<DVec3>, Vec<u32>), String> {
    let positions = primitive.get(&Semantic::Positions).ok_or("has no positions")?;
    if (positions.data_type(), positions.dimensions()) != (DataType::F32, Dimensions::Vec3) {
        return Err("has positions other than 3 floats each".to_owned());
    }
    let number =
        |bytes: &[u8]| f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    let positions: Vec<DVec3> = items(&positions, buffers)?
        .iter()
        .map(|bytes| DVec3::new(number(&bytes[0..4]), number(&bytes[4..8]), number(&bytes[8..12])))
        .collect();
    let Some(indices) = primitive.indices() else {
        let all = (0..positions.len() as u32).collect();
        return Ok((positions, all));
    };
    if indices.dimensions() != Dimensions::Scalar
        || !matches!(indices.data_type(), DataType::U8 | DataType::U16 | DataType::U32)
    {
        return Err("has indices that are not unsigned integers".to_owned());
    }
    let index = |bytes: &&[u8]| bytes.iter().rev().fold(0, |high, &low| high << 8 | u32::from(low));
    let indices = items(&indices, buffers)?.iter().map(index).collect();
    Ok((positions, indices))
}

/// Upper bound of a primitive's triangles; 0 if its corners exceed `bytes`, reported on reading.
fn most_triangles(primitive: &Primitive, bytes: usize) -> usize {
    let positions = || primitive.get(&Semantic::Positions);
    let corners = primitive.indices().or_else(positions).map_or(0, |accessor| accessor.count());
    let corners = if corners <= bytes { corners } else { 0 };
    match primitive.mode() {
        Mode::Triangles => corners / 3,
        Mode::TriangleStrip | Mode::TriangleFan => corners.saturating_sub(2),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => 0,
    }
}

/// The triangles of a list, a strip or a fan of indices; none for points and lines.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::Triangles => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        Mode::TriangleStrip => strip(indices).collect(),
        Mode::TriangleFan => indices.windows(2).skip(1).map(|t| [indices[0], t[0], t[1]]).collect(),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    }
}
