//! Mesh files: accepted content, and messages for errors.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use common::{CUBE_FACES, TestFile, open_box, refusal};
use frangible_geometry::{TriMesh, mesh_io};
use glam::DVec3;
use proptest::prelude::*;

/// The unit cube, each coordinate exact in single precision.
fn cube() -> TriMesh {
    open_box(DVec3::new(-0.5, 0.25, 1.0), DVec3::new(0.5, 1.25, 2.0), 0)
}

fn assert_is_cube(mesh: &TriMesh) {
    assert!(mesh.is_watertight());
    let (info, expected) = (mesh.info(), cube().info());
    assert_eq!((info.triangles, info.parts), (12, 1));
    assert_eq!(info.bounds, expected.bounds);
    assert!((info.volume - 1.0).abs() < 1e-15);
    assert!((info.center - expected.center).length() < 1e-15);
}

// --- OBJ -----------------------------------------------------------------------------------------

fn obj_vertices() -> String {
    cube().positions.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect()
}

fn obj_quads() -> String {
    CUBE_FACES
        .iter()
        .map(|[a, b, c, d]| format!("f {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1))
        .collect()
}

#[test]
fn obj_of_quads_is_read() {
    let mesh = TestFile::new("cube.obj", obj_vertices() + &obj_quads()).load();
    assert_eq!(mesh, cube());
    assert_eq!(TestFile::new("CUBE.OBJ", obj_vertices() + &obj_quads()).load(), cube());
}

/// Colours, normals between the vertices, texture coordinates of one number, a missing material
/// file, groups, lines, points, bytes that are no UTF-8, Windows line ends, joined lines, and
/// indices counted from the end.
#[test]
fn obj_with_everything_around_the_shape_is_read() {
    let mut text =
        b"# \xe9t\xe9\r\nmtllib missing.mtl\r\no caf\xe9\r\nusemtl red\r\ns off\r\nvt 0.5\r\n"
            .to_vec();
    for p in &cube().positions {
        text.extend(format!("vn 0 0 1\r\nv {} {} {} 0.5 0.25 1\r\n", p.x, p.y, p.z).bytes());
    }
    text.extend(b"p 1\r\nl 1 2 3\r\ng one\r\n");
    for [a, b, c, d] in CUBE_FACES {
        let [a, b, c, d] = [a, b, c, d].map(|vertex| i64::from(vertex) - 8);
        text.extend(format!("f {a}/1/1 {b}//2 \\\r\n {c}/1 {d}\r\n").bytes());
    }
    text.extend(b"f 1 1 2\r\nf 1 2\r\n");
    assert_eq!(TestFile::new("cube.obj", text).load(), cube());
}

#[test]
fn obj_polygon_becomes_a_fan() {
    let text = "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\n";
    assert_eq!(
        TestFile::new("pentagon.obj", text).load().triangles,
        [[0, 1, 2], [0, 2, 3], [0, 3, 4]]
    );
}

/// A wall that is an L: cut into triangles inside of it, in each format that has polygons.
#[test]
fn concave_polygons_are_cut_within_them() {
    let outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)];
    let mut faces = vec![vec![5, 4, 3, 2, 1, 0], vec![6, 7, 8, 9, 10, 11]];
    faces.extend((0..6).map(|n| vec![n, (n + 1) % 6, 6 + (n + 1) % 6, 6 + n]));
    for first in 0..6 {
        faces[0].rotate_left(1);
        faces[1].rotate_right(first);
        let points = [0, 1].map(|z| outline.map(|(x, y)| format!("{x} {y} {z}\n"))).concat();
        let obj: String = points.iter().map(|point| format!("v {point}")).collect();
        let line = |face: &Vec<i32>, base: i32| {
            face.iter().map(|corner| format!(" {}", corner + base)).collect::<String>()
        };
        let obj =
            obj + &faces.iter().map(|face| format!("f{}\n", line(face, 1))).collect::<String>();
        let header = "ply\nformat ascii 1.0\nelement vertex 12\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 8\nproperty list uchar int vertex_indices\nend_header\n";
        let ply = faces
            .iter()
            .map(|face| format!("{}{}\n", face.len(), line(face, 0)))
            .collect::<String>();
        let ply = header.to_owned() + &points.concat() + &ply;
        for mesh in [TestFile::new("l.obj", obj).load(), TestFile::new("l.ply", ply).load()] {
            assert!((mesh.mass_properties().volume - 3.0).abs() < 1e-12);
            assert!((mesh.area() - 14.0).abs() < 1e-12, "{}", mesh.area());
        }
    }
}

#[test]
fn text_in_utf_16_is_named_and_a_mark_of_utf_8_is_passed_over() {
    let text = obj_vertices() + &obj_quads();
    let utf16 =
        |order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
    for bytes in [utf16(u16::to_le_bytes), utf16(u16::to_be_bytes)] {
        let sentence = "a.obj: is not a valid OBJ file: it is text in UTF-16, must be in UTF-8";
        assert_eq!(refusal("a.obj", &bytes), sentence);
        let mark = if bytes[0] == 0 { b"\xfe\xff" } else { b"\xff\xfe" };
        assert_eq!(refusal("a.obj", [mark.as_slice(), &bytes].concat()), sentence);
    }
    assert_eq!(TestFile::new("cube.obj", format!("\u{feff}{text}")).load(), cube());
}

#[test]
fn obj_refusals_name_the_line() {
    let vertices = obj_vertices();
    assert_eq!(
        refusal("a.obj", format!("{vertices}f 1 2 9\n")),
        "a.obj: line 9 refers to vertex 9, must be 1 to 8"
    );
    assert_eq!(
        refusal("a.obj", format!("{vertices}\nf 0 1 2\n")),
        "a.obj: line 10 refers to vertex 0, must be 1 to 8"
    );
    assert_eq!(
        refusal("a.obj", format!("{vertices}f -9 1 2\n")),
        "a.obj: line 9 refers to vertex -9, must be -8 to -1"
    );
    assert_eq!(
        refusal("a.obj", "v 0 0 zero\n"),
        "a.obj: is not a valid OBJ file: line 1 has zero for a coordinate, must be a number"
    );
    assert_eq!(
        refusal("a.obj", "v 0 0\n"),
        "a.obj: is not a valid OBJ file: line 1 has nothing for a coordinate, must be a number"
    );
    assert_eq!(
        refusal("a.obj", format!("{vertices}f 1 2 x\n")),
        "a.obj: is not a valid OBJ file: line 9 has x for a corner, must be the number of a vertex"
    );
    assert_eq!(
        refusal("a.obj", "\u{1}\u{2}binary"),
        "a.obj: is not a valid OBJ file: it has 0 vertices (lines that begin with v)"
    );
}

// --- PLY -----------------------------------------------------------------------------------------

fn ply_header(format: &str, coordinate: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made by a test\nelement vertex 8\nproperty {coordinate} x\n\
         property {coordinate} y\nproperty uchar red\nproperty {coordinate} z\nelement material 1\n\
         property list uchar short shades\nelement face 6\nproperty uchar flag\n\
         property list uchar int vertex_indices\nend_header\n"
    )
}

fn ply_text() -> String {
    let mut text = ply_header("ascii", "float");
    for p in &cube().positions {
        text += &format!("{} {} 200 {}\n", p.x, p.y, p.z);
    }
    text += "2 7 8\n";
    for [a, b, c, d] in CUBE_FACES {
        text += &format!("0 4 {a} {b} {c} {d}\n");
    }
    text
}

#[test]
fn ply_text_is_read() {
    assert_eq!(TestFile::new("cube.ply", ply_text()).load(), cube());
    let windows = ply_text().replace('\n', "\r\n").replace("0.5", ".5");
    assert_eq!(TestFile::new("cube.ply", windows).load(), cube());
    let other_name = ply_text().replace("vertex_indices", "vertex_index");
    assert_eq!(TestFile::new("cube.ply", other_name).load(), cube());
}

fn ply_binary(little: bool) -> Vec<u8> {
    let order = if little { "binary_little_endian" } else { "binary_big_endian" };
    let mut bytes = ply_header(order, "double").into_bytes();
    let mut push = |mut number: Vec<u8>| {
        if !little {
            number.reverse();
        }
        bytes.extend(number);
    };
    for p in &cube().positions {
        push(p.x.to_le_bytes().to_vec());
        push(p.y.to_le_bytes().to_vec());
        push(vec![200]);
        push(p.z.to_le_bytes().to_vec());
    }
    push(vec![2]);
    push(7_i16.to_le_bytes().to_vec());
    push((-8_i16).to_le_bytes().to_vec());
    for face in CUBE_FACES {
        push(vec![0]);
        push(vec![4]);
        for vertex in face {
            push(vertex.to_le_bytes().to_vec());
        }
    }
    bytes
}

#[test]
fn ply_binary_is_read_in_both_byte_orders() {
    for little in [true, false] {
        let mut bytes = ply_binary(little);
        assert_eq!(TestFile::new("cube.ply", &bytes).load(), cube());

        bytes.pop();
        assert_eq!(
            refusal("cube.ply", bytes),
            "cube.ply: is not a valid PLY file: element \"face\" 5 has a number missing or misspelt"
        );
    }
}

#[test]
fn ply_refusals_name_the_place() {
    assert_eq!(
        refusal("a.ply", ply_text().replace("4 0 4 6 2", "4 0 4 6 8")),
        "a.ply: face 0 refers to vertex 8, must be 0 to 7"
    );
    assert_eq!(
        refusal("a.ply", ply_text().replace("4 0 4 6 2", "4 0 4 6 -1")),
        "a.ply: face 0 refers to vertex -1, must be 0 to 7"
    );
    assert_eq!(
        refusal("a.ply", ply_text().replace("-0.5 0.25 200 1\n", "nan 0.25 200 1\n")),
        "a.ply: vertex 0 is (NaN, 0.25, 1), coordinates must be finite and at most 1e12"
    );
    assert_eq!(
        refusal("a.ply", ply_text().replace("element vertex 8", "element vertex 999999999999")),
        "a.ply: is not a valid PLY file: its 202 bytes cannot hold 999999999999 elements \"vertex\""
    );
    assert_eq!(
        refusal("a.ply", ply_text().replace("float z", "float depth")),
        "a.ply: is not a valid PLY file: its vertices have no x, y and z"
    );
    assert_eq!(
        refusal("a.ply", ply_text().replace("vertex_indices", "corners")),
        "a.ply: is not a valid PLY file: its faces have no vertex_indices"
    );
    assert_eq!(
        refusal("a.ply", "solid\n"),
        "a.ply: is not a valid PLY file: its first line is \"solid\", must be \"ply\""
    );
    for (line, number) in
        [("element face six", 10), ("property list uchar int", 12), ("propperty uchar flag", 11)]
    {
        let lines: Vec<String> = ply_text().lines().map(str::to_owned).collect();
        let mut lines = lines;
        lines[number - 1] = line.to_owned();
        assert_eq!(
            refusal("a.ply", lines.join("\n")),
            format!(
                "a.ply: is not a valid PLY file: line {number} of its header is \"{line}\", must be a statement of PLY \
                 in its place"
            )
        );
    }
    let cut = refusal("a.ply", &ply_text()[..60]);
    assert_eq!(
        cut,
        "a.ply: is not a valid PLY file: its header breaks off before the line \"end_header\""
    );
}

/// Strips as MeshLab's oldest files have them: the corners of the next triangle are the last two
/// and a new one, and a negative number begins another strip.
#[test]
fn ply_strips_are_read() {
    // Around four sides of the cube, then its top and its bottom.
    let mut text = ply_text().replace("element face 6\nproperty uchar flag", "element tristrips 1");
    let first = text.find("0 4 0 4 6 2").unwrap();
    text.truncate(first);
    text += "20 0 2 4 6 5 7 1 3 0 2 -1 2 3 6 7 -1 1 0 5 4\n";
    let mesh = TestFile::new("cube.ply", &text).load();
    assert_is_cube(&mesh);
    assert_eq!(
        refusal("a.ply", text.replace(" 5 4\n", " 5 8\n")),
        "a.ply: strip 0 refers to vertex 8, must be 0 to 7"
    );
}

/// A line of an exporter's own before the first element; a misspelt statement after it stays one.
#[test]
fn ply_lines_without_a_keyword_before_the_first_element_are_passed_over() {
    for made in [
        "Created by Blender3D 247 - www.blender.org, source file: ",
        "comments: none",
        "\u{e9}t\u{e9}",
    ] {
        let text = ply_text().replace("comment made by a test", made);
        assert_eq!(TestFile::new("cube.ply", &text).load(), cube());
        assert_eq!(TestFile::new("cube.ply", text.replace('\n', "\r\n")).load(), cube());
    }
}

// --- STL -----------------------------------------------------------------------------------------

fn stl_text() -> String {
    let mesh = cube();
    let mut text = "solid cube\n".to_owned();
    for triangle in 0..mesh.triangles.len() {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for p in mesh.corners(triangle) {
            text += &format!("      vertex {} {:e} {}\n", p.x, p.y, p.z);
        }
        text += "    endloop\n  endfacet\n";
        if triangle == 5 {
            text += "endsolid cube\nsolid second half\n";
        }
    }
    text + "endsolid cube\n"
}

fn stl_binary(header: &str) -> Vec<u8> {
    let mesh = cube();
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend(12_u32.to_le_bytes());
    for triangle in 0..mesh.triangles.len() {
        bytes.extend([0; 12]);
        for p in mesh.corners(triangle) {
            bytes.extend(p.as_vec3().to_array().iter().flat_map(|number| number.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn stl_text_is_read_and_welded() {
    let mesh = TestFile::new("cube.stl", stl_text()).load();
    assert_eq!(mesh.positions.len(), 8);
    assert_is_cube(&mesh);
    assert_is_cube(
        &TestFile::new("cube.stl", stl_text().replace("solid cube", "solid").to_uppercase()).load(),
    );
}

/// Many programs begin the header of binary files with the word of text files.
#[test]
fn stl_binary_is_read_and_welded() {
    for header in ["made by a test", "solid cube"] {
        let mesh = TestFile::new("cube.stl", stl_binary(header)).load();
        assert_eq!(mesh.positions.len(), 8);
        assert_is_cube(&mesh);
    }
}

/// Bytes may follow the triangles, also where the header begins with the word of text files.
#[test]
fn stl_binary_with_bytes_behind_it_is_no_text() {
    for header in ["made by a test", "solid cube"] {
        let mut bytes = stl_binary(header);
        bytes.extend([0; 30]);
        assert_is_cube(&TestFile::new("cube.stl", bytes).load());
    }
}

#[test]
fn obj_lines_may_end_with_a_carriage_return() {
    let text = format!("{}{}", obj_vertices(), obj_quads());
    for ending in ["\r", "\r\n"] {
        assert_eq!(TestFile::new("cube.obj", text.replace('\n', ending)).load(), cube());
    }
}

#[test]
fn stl_refusals_name_the_line() {
    assert_eq!(
        refusal("a.stl", stl_text().replacen("vertex -0.5", "vertex x", 1)),
        "a.stl: is not a valid STL file: line 4 has x for a coordinate, must be a number"
    );
    assert_eq!(
        refusal("a.stl", stl_text().replacen("vertex", "vortex", 1)),
        "a.stl: is not a valid STL file: line 8 ends a facet that has not 3 vertices"
    );
    assert_eq!(
        refusal("a.stl", stl_text().replace("endsolid cube\n", "")),
        "a.stl: is not a valid STL file: it breaks off before the word endsolid"
    );
    assert_eq!(
        refusal("a.stl", stl_text().replacen("vertex -0.5", "vertex inf", 1)),
        "a.stl: vertex 0 is (inf, 0.25, 1), coordinates must be finite and at most 1e12"
    );
    let mut short = stl_binary("made by a test");
    short.pop();
    assert_eq!(
        refusal("a.stl", short),
        "a.stl: is not a valid STL file: it has neither the word solid in front, as text has, nor the 84 + 50 n bytes of \
         n binary triangles"
    );
}

// --- Common to all formats -----------------------------------------------------------------------

#[test]
fn mesh_that_faces_inward_is_turned() {
    let mut inward = obj_vertices();
    for [a, b, c, d] in CUBE_FACES {
        inward += &format!("f {} {} {} {}\n", d + 1, c + 1, b + 1, a + 1);
    }
    assert_is_cube(&TestFile::new("cube.obj", inward).load());
}

#[test]
fn vertices_without_a_triangle_are_left_out() {
    let text = format!("{}v 100 100 100\nf 9 9 1\n{}", obj_vertices(), obj_quads());
    assert_eq!(TestFile::new("cube.obj", text).load(), cube());
}

#[test]
fn each_bad_path_has_its_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let sentence = |name: &str| {
        let sentence = mesh_io::load(&folder.path().join(name)).unwrap_err().to_string();
        sentence.replace(&format!("{}/", folder.path().display()), "")
    };
    std::fs::create_dir(folder.path().join("shapes.obj")).unwrap();
    assert_eq!(sentence("none.obj"), "none.obj: no such file");
    assert_eq!(
        sentence("shapes.obj"),
        "shapes.obj: is a folder, must be a mesh file (.obj, .ply, .stl, .gltf, .glb)"
    );
    assert_eq!(refusal("a.obj", ""), "a.obj: has 0 bytes, must hold a mesh");
    assert_eq!(
        refusal("a.fbx", "x"),
        "a.fbx: ends in \".fbx\", must end in one of .obj, .ply, .stl, .gltf, .glb"
    );
    assert_eq!(
        refusal("a", "x"),
        "a: ends in \"\", must end in one of .obj, .ply, .stl, .gltf, .glb"
    );
    assert_eq!(
        refusal("a.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 -inf\nf 1 2 3\n"),
        "a.obj: vertex 1 is (1, NaN, 0), coordinates must be finite and at most 1e12"
    );
    assert_eq!(
        refusal("a.obj", "v 0 0 0\n"),
        "a.obj: has 0 triangles with an area, must have at least 1"
    );
}

proptest! {
    /// A damaged file is read or refused, whatever the damage.
    #[test]
    fn damage_is_never_fatal(damages in common::any_damages()) {
        common::load_damaged("a.obj", (obj_vertices() + &obj_quads()).into_bytes(), &damages);
        common::load_damaged("a.ply", ply_text().into_bytes(), &damages);
        common::load_damaged("a.ply", ply_binary(true), &damages);
        common::load_damaged("a.stl", stl_text().into_bytes(), &damages);
        common::load_damaged("a.stl", stl_binary("made by a test"), &damages);
    }
}
