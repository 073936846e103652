//! STL, binary and text.
//!
//! Read here and not with a library: whether a file is binary shows in its length, for many binary
//! files begin with the word `solid` too; and a text file may hold several solids.

use super::attributes::Parsed;
use crate::mesh::TriMesh;
use crate::mesh_check::MeshError;
use crate::mesh_io::parser::File;
use glam::{DVec3, Vec3};

const HEADER_BYTES: usize = 80;
/// A normal and three corners of three f32 each, and two bytes of attributes.
const TRIANGLE_BYTES: usize = 50;

pub(super) fn parse(file: &File) -> Result<Parsed, MeshError> {
    let corners = match binary_triangles(file.bytes) {
        Some(triangles) => binary_corners(triangles),
        None => text_corners(file)?,
    };
    let triangles = (0..corners.len() as u32 / 3)
        .map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner))
        .collect();
    let mut mesh = TriMesh { positions: corners, triangles };
    mesh.check(file.name)?;
    mesh.weld();
    Ok(mesh.into())
}

/// The triangles of a binary file; `None` if it is none. Bytes after the last triangle are allowed.
fn binary_triangles(bytes: &[u8]) -> Option<&[u8]> {
    let count: [u8; 4] = bytes.get(HEADER_BYTES..HEADER_BYTES + 4)?.try_into().ok()?;
    let length = (u32::from_le_bytes(count) as usize).checked_mul(TRIANGLE_BYTES)?;
    let triangles = bytes.get(HEADER_BYTES + 4..)?.get(..length)?;
    // Text has no zeros; the number of a binary file's triangles has some, and as a rule its
    // header.
    let has_zeros = bytes[..HEADER_BYTES + 4].contains(&0);
    let is_whole = triangles.len() + HEADER_BYTES + 4 == bytes.len();
    let is_text = bytes.starts_with(b"solid") && !is_whole && !has_zeros;
    (!is_text).then_some(triangles)
}

fn binary_corners(triangles: &[u8]) -> Vec<DVec3> {
    let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let corner = |bytes: &[u8]| {
        Vec3::new(number(bytes), number(&bytes[4..]), number(&bytes[8..])).as_dvec3()
    };
    let corners = |triangle: &[u8]| {
        [corner(&triangle[12..]), corner(&triangle[24..]), corner(&triangle[36..])]
    };
    triangles.chunks_exact(TRIANGLE_BYTES).flat_map(corners).collect()
}

/// The corners of the text form: the lines `vertex x y z`, three in each facet.
fn text_corners(file: &File) -> Result<Vec<DVec3>, MeshError> {
    let text = String::from_utf8_lossy(file.bytes);
    let malformed = |number: usize, reason: &str| {
        file.malformed("STL", format!("line {} {reason}", number + 1))
    };
    if !text.trim_start().to_lowercase().starts_with("solid") {
        let reason = "it has neither the word solid in front, as text has, nor the 84 + 50 n bytes of n binary triangles";
        return Err(file.malformed("STL", reason));
    }
    let mut corners: Vec<DVec3> = Vec::new();
    let mut ended = false;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next().map(str::to_lowercase).as_deref() {
            Some("vertex") => {
                let mut corner = DVec3::ZERO;
                for axis in 0..3 {
                    let word = words.next().unwrap_or("nothing");
                    corner[axis] = word.parse().map_err(|_| {
                        malformed(number, &format!("has {word} for a coordinate, must be a number"))
                    })?;
                }
                corners.push(corner);
            }
            Some("endfacet") if !corners.len().is_multiple_of(3) => {
                return Err(malformed(number, "ends a facet that has not 3 vertices"));
            }
            Some("endsolid") => ended = true,
            Some("solid") => ended = false,
            _ => {}
        }
    }
    if !ended {
        return Err(file.malformed("STL", "it breaks off before the word endsolid"));
    }
    Ok(corners)
}
