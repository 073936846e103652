//! glTF files: accepted content, and messages for errors.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use base64::Engine;
use common::{TestFile, open_box, refusal};
use frangible_geometry::{MeshInfo, TriMesh};
use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};

fn cube() -> TriMesh {
    open_box(DVec3::ZERO, DVec3::ONE, 0)
}

/// The cube's positions as f32, then its indices as u16.
fn cube_buffer() -> Vec<u8> {
    let mesh = cube();
    let positions = mesh.positions.iter().flat_map(|p| p.as_vec3().to_array());
    let mut bytes: Vec<u8> = positions.flat_map(f32::to_le_bytes).collect();
    bytes.extend(mesh.triangles.iter().flatten().flat_map(|&vertex| (vertex as u16).to_le_bytes()));
    bytes
}

fn embedded(bytes: &[u8]) -> String {
    format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(bytes)
    )
}

/// A scene with one cube.
fn cube_document() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 96},
            {"buffer": 0, "byteOffset": 96, "byteLength": 72},
        ],
        "buffers": [{"byteLength": 168, "uri": embedded(&cube_buffer())}],
    })
}

fn load(document: &Value) -> MeshInfo {
    TestFile::new("a.gltf", document.to_string()).load().info()
}

fn refuse(change: impl Fn(&mut Value)) -> String {
    let mut document = cube_document();
    change(&mut document);
    refusal("a.gltf", document.to_string())
}

/// A small file whose nodes share a mesh holds any number of triangles.
#[test]
fn instances_are_counted_before_they_are_made() {
    let most = TriMesh::MOST_TRIANGLES / 12;
    for (count, is_refused) in [(20, false), (most + 1, true)] {
        let change = |document: &mut Value| {
            document["nodes"] = json!(vec![json!({"mesh": 0}); count]);
            document["scenes"][0]["nodes"] = json!((0..count).collect::<Vec<_>>());
        };
        if is_refused {
            assert_eq!(
                refuse(change),
                "a.gltf: has 3000012 triangles, each instance counted, must have at most 3000000"
            );
        } else {
            let mut document = cube_document();
            change(&mut document);
            assert_eq!(load(&document).triangles, 12 * count);
        }
    }
}

/// The cube in a GLB file.
fn cube_glb() -> Vec<u8> {
    let mut document = cube_document();
    document["buffers"][0].as_object_mut().unwrap().remove("uri");
    binary(&document, &cube_buffer())
}

/// A GLB file of a document and the bytes of its buffer.
fn binary(document: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((28 + text.len() as u32 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text.as_slice()), (b"BIN\0", buffer)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

#[test]
fn buffer_may_be_embedded_beside_or_in_the_file() {
    assert_eq!(TestFile::new("a.gltf", cube_document().to_string()).load(), cube());

    let mut document = cube_document();
    document["buffers"][0]["uri"] = json!("the%20cube.bin");
    let file = TestFile::new("a.gltf", document.to_string());
    let missing = file.refusal();
    assert!(
        missing.starts_with(
            "a.gltf: is not a valid glTF file: buffer 0 in the cube.bin cannot be read"
        ),
        "{missing}"
    );
    std::fs::write(file.folder.path().join("the cube.bin"), cube_buffer()).unwrap();
    assert_eq!(file.load(), cube());

    assert_eq!(TestFile::new("a.glb", cube_glb()).load(), cube());
}

#[test]
fn buffers_lie_in_the_documents_own_folder() {
    let mut document = cube_document();
    let file = TestFile::new("a.gltf", document.to_string());
    let folder = file.folder.path();
    let outside = tempfile::tempdir().unwrap();
    std::fs::write(outside.path().join("out.bin"), cube_buffer()).unwrap();
    std::os::unix::fs::symlink(outside.path().join("out.bin"), folder.join("link.bin")).unwrap();
    std::fs::create_dir(folder.join("below")).unwrap();
    std::fs::write(folder.join("below/in.bin"), cube_buffer()).unwrap();
    let mut with = |uri: &str| {
        document["buffers"][0]["uri"] = json!(uri);
        std::fs::write(folder.join("a.gltf"), document.to_string()).unwrap();
    };
    with("below/in.bin");
    assert_eq!(file.load(), cube());
    let absolute = outside.path().join("out.bin").display().to_string();
    for uri in [
        &absolute,
        "/dev/zero",
        "../out.bin",
        "below/../../out.bin",
        "%2e%2e/out.bin",
        "file:///dev/zero",
        "link.bin",
    ] {
        with(uri);
        let sentence = file.refusal();
        assert!(
            sentence.ends_with("must be a file in the document's own folder"),
            "{uri}: {sentence}"
        );
    }
    with("below");
    assert!(file.refusal().contains("must be a regular file"));
}

#[test]
fn nodes_move_turn_scale_and_mirror() {
    let mut document = cube_document();
    document["nodes"] = json!([
        {"children": [1, 2], "translation": [10, 0, 0]},
        {"mesh": 0, "scale": [2, 1, 1]},
        {"mesh": 0, "scale": [-1, 1, 1], "translation": [0, 5, 0], "rotation": [0, 0, 0.5_f64.sqrt(), 0.5_f64.sqrt()]},
        {"mesh": 0, "translation": [99, 99, 99]},
    ]);
    let info = load(&document);

    // The first is 2 m long, the second mirrored into x < 0 and then turned by a right angle about
    // z; the last is not in the scene.
    assert_eq!((info.parts, info.triangles), (2, 24));
    assert!(
        (info.volume - 3.0).abs() < 1e-5,
        "a mirrored cube has its volume too: {}",
        info.volume
    );
    let (low, high) = info.bounds;
    assert!(
        (low - DVec3::new(9.0, 0.0, 0.0)).length() < 1e-5
            && (high - DVec3::new(12.0, 5.0, 1.0)).length() < 1e-5
    );
}

#[test]
fn strips_fans_and_lists_without_indices_are_triangles() {
    // A tetrahedron as a strip of four triangles, and as a fan of three with the fourth in a list.
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let positions = |order: &[usize]| -> Vec<u8> {
        order
            .iter()
            .flat_map(|&at| corners[at].as_vec3().to_array())
            .flat_map(f32::to_le_bytes)
            .collect()
    };
    let document = |primitives: &[(u32, &[usize])]| {
        let buffers: Vec<Vec<u8>> = primitives.iter().map(|(_, order)| positions(order)).collect();
        let mut document = cube_document();
        document["buffers"] = buffers
            .iter()
            .map(|bytes| json!({"byteLength": bytes.len(), "uri": embedded(bytes)}))
            .collect();
        document["bufferViews"] = (0..buffers.len())
            .map(|n| json!({"buffer": n, "byteLength": buffers[n].len()}))
            .collect();
        document["accessors"] = (0..buffers.len())
            .map(|n| {
                let count = buffers[n].len() / 12;
                let bounds = json!([[0, 0, 0], [1, 1, 1]]);
                json!({"bufferView": n, "componentType": 5126, "count": count, "type": "VEC3", "min": bounds[0], "max": bounds[1]})
            })
            .collect();
        document["meshes"][0]["primitives"] = primitives
            .iter()
            .enumerate()
            .map(|(n, (mode, _))| json!({"attributes": {"POSITION": n}, "mode": mode}))
            .collect();
        document
    };
    let (points, lines, list, strip, fan) = (0, 1, 4, 5, 6);
    for primitives in [
        vec![(strip, [1, 0, 2, 3, 1, 0].as_slice())],
        vec![
            (points, [0, 1].as_slice()),
            (fan, &[0, 1, 3, 2, 1]),
            (lines, &[0, 1]),
            (list, &[1, 2, 3]),
        ],
    ] {
        let info = load(&document(&primitives));
        assert!(info.watertight, "{primitives:?}");
        assert_eq!((info.triangles, info.parts), (4, 1));
        assert!((info.volume - 1.0 / 6.0).abs() < 1e-7);
    }
}

#[test]
fn only_extensions_that_hold_the_shape_are_required() {
    let mut document = cube_document();
    document["extensionsRequired"] = json!(["KHR_texture_basisu", "KHR_materials_unlit"]);
    assert!(load(&document).watertight);
    let draco =
        refuse(|document| document["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]));
    assert!(
        draco.starts_with("a.gltf: is not a valid glTF file: ")
            && draco.contains("KHR_draco_mesh_compression"),
        "{draco}"
    );
}

#[test]
fn each_refusal_names_the_place() {
    assert_eq!(
        refuse(|document| document["accessors"][0]["count"] = json!(7)),
        "a.gltf: node 0, primitive 0 refers to vertex 7, must be 0 to 6"
    );
    let beyond = "a.gltf: is not a valid glTF file: node 0, primitive 0 refers to accessor 1, which reaches beyond its buffer";
    assert_eq!(refuse(|document| document["accessors"][1]["count"] = json!(37)), beyond);
    assert_eq!(refuse(|document| document["accessors"][1]["count"] = json!(1_u64 << 62)), beyond);
    assert_eq!(refuse(|document| document["accessors"][1]["byteOffset"] = json!(u64::MAX)), beyond);
    assert_eq!(
        refuse(|document| document["bufferViews"][1]["byteLength"] = json!(u64::MAX)),
        beyond
    );
    assert_eq!(
        refuse(|document| document["nodes"] = json!([{"children": [1]}, {"children": [0]}])),
        "a.gltf: is not a valid glTF file: node 0 is the child of more than one node"
    );
    assert_eq!(
        refuse(|document| document["scenes"] = json!([])).split(": ").take(2).collect::<Vec<_>>(),
        ["a.gltf", "is not a valid glTF file"]
    );
    assert_eq!(
        refuse(|document| document
            .as_object_mut()
            .unwrap()
            .retain(|key, _| !key.starts_with("scene"))),
        "a.gltf: is not a valid glTF file: it has no scene"
    );
    assert_eq!(
        refuse(|document| document["accessors"][0]["componentType"] = json!(5123)),
        "a.gltf: is not a valid glTF file: node 0, primitive 0 has positions other than 3 floats each"
    );
    assert_eq!(
        refuse(|document| document["accessors"][1]["componentType"] = json!(5126)),
        "a.gltf: is not a valid glTF file: node 0, primitive 0 has indices that are not unsigned integers"
    );
    assert_eq!(
        refuse(
            |document| document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(2)
        ),
        "a.gltf: is not a valid glTF file: it refers to accessor 2, and has 2"
    );
    assert_eq!(
        refuse(|document| document["nodes"] = json!([{}])),
        "a.gltf: has 0 triangles with an area, must have at least 1"
    );
    let nan = refuse(|document| {
        let mut bytes = cube_buffer();
        bytes[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
        document["buffers"][0]["uri"] = json!(embedded(&bytes));
    });
    assert_eq!(
        nan,
        "a.gltf: vertex 1 is (NaN, NaN, NaN), coordinates must be finite and at most 1e12"
    );
    for content in
        ["{", "glTF", "glTF\u{2}\0\0\0\u{1}\0\0\0....", "glTF\u{2}\0\0\0\u{7f}\0\0\0....", "[1, 2]"]
    {
        let sentence = refusal("a.glb", content);
        assert!(sentence.starts_with("a.glb: is not a valid glTF file: "), "{sentence}");
    }
}

proptest! {
    /// A damaged file is read or refused, whatever the damage.
    #[test]
    fn damage_is_never_fatal(damages in common::any_damages()) {
        common::load_damaged("a.glb", cube_glb(), &damages);
        common::load_damaged("a.gltf", cube_document().to_string().into_bytes(), &damages);
    }
}
