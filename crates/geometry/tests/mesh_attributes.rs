//! Attributes of triangles from files, in the order of the triangles.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use frangible_geometry::MeshAttributes;
use frangible_geometry::TriMesh;
use frangible_geometry::mesh_io::load_with_attributes;
use glam::{DVec3, Vec2, Vec3};
use std::fs;

fn load(name: &str, content: &[u8]) -> (TriMesh, MeshAttributes) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, content).unwrap();
    load_with_attributes(&path).unwrap()
}

/// Texture coordinates are x and y of the vertices, whichever way a polygon is cut.
#[test]
fn polygons_keep_what_their_corners_have() {
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nv 0 0 3\n\
        vt 0 0\nvt 2 0\nvt 2 2\nvt 1 0.5\nvt 0 2\nvn 0 0 2\n\
        o left\nusemtl red\nf 1/1/1 2/2/1 3/3/1 4/4/1 5/5/1\nf 1 2 2\nusemtl blue\n\
        o right\ng door\nf 1 6 2\nusemtl red\nf -6 -2/-1 -1\n";
    let (mesh, said) = load("a.obj", text.as_bytes());
    let path =
        |face: usize| said.faces[face].object.map(|object| said.objects[object as usize].join("/"));
    assert_eq!(said.materials, ["red", "blue"]);
    assert_eq!(said.faces.len(), mesh.triangles.len());
    assert_eq!(mesh.triangles.len(), 5, "the one without an area is left out");
    for (triangle, face) in said.faces.iter().enumerate().take(3) {
        assert_eq!((path(triangle).as_deref(), face.material), (Some("left"), Some(0)));
        for (corner, at) in face.corners.iter().zip(mesh.corners(triangle)) {
            assert_eq!(corner.coordinates, Some(at.truncate().as_vec2()));
            assert_eq!(corner.normal.map(|normal| normal.abs()), Some(Vec3::Z));
        }
    }
    assert_eq!((path(3).as_deref(), said.faces[3].material), (Some("right/door"), Some(1)));
    assert_eq!((path(4).as_deref(), said.faces[4].material), (Some("right/door"), Some(0)));
    let places: Vec<_> = said.faces[4].corners.iter().map(|corner| corner.coordinates).collect();
    assert!(places.contains(&Some(Vec2::new(0.0, 2.0))) && places.contains(&None));
}

#[test]
fn colours_of_vertices_are_made_linear() {
    let text = "v 0 0 0 1 0 0.5\nv 1 0 0 1 0 0.5\nv 0 1 0 1 0 0.5\nv 0 0 1 1 0 0.5\n\
        f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let (mesh, said) = load("a.obj", text.as_bytes());
    assert!(mesh.mass_properties().center.distance(DVec3::splat(0.25)) < 1e-12);
    let [red, green, blue, alpha] = said.faces[0].corners[0].colour.unwrap();
    assert_eq!((red, green, alpha), (1.0, 0.0, 1.0));
    assert!((blue - 0.214_04).abs() < 1e-4);
}

#[test]
fn a_file_of_a_shape_only_says_nothing() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    assert!(load("a.obj", text.as_bytes()).1.is_empty());
}

/// Comments name the images of a PLY file, faces their numbers.
#[test]
fn images_of_ply_are_materials() {
    let header = |images: &str, number: &str| {
        format!(
            "ply\nformat ascii 1.0\n{images}element vertex 4\nproperty float x\nproperty float y\n\
             property float z\nelement face 4\nproperty list uchar int vertex_indices\n{number}end_header\n\
             0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
        )
    };
    let two = "comment TextureFile wood.png\ncomment TextureFile <this>_a b.jpg\n";
    let text =
        header(two, "property int texnumber\n") + "3 0 2 1 1\n3 0 1 3 0\n3 1 2 3 -1\n3 2 0 3 7\n";
    let (_, said) = load("a.ply", text.as_bytes());
    assert_eq!(said.materials, ["wood.png", "a_a b.jpg"]);
    let materials: Vec<_> = said.faces.iter().map(|face| face.material).collect();
    assert_eq!(materials, [Some(1), Some(0), None, None]);

    // An image without an index applies to all faces.
    let faces = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    let (_, said) =
        load("a.ply", (header("comment TextureFile wood.png\n", "") + faces).as_bytes());
    assert!(said.faces.iter().all(|face| face.material == Some(0)));
    let (_, said) = load("a.ply", (header("", "") + faces).as_bytes());
    assert!(said.is_empty());
}
