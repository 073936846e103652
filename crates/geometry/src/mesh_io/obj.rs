//! Wavefront OBJ: the statements `v` and `f`.
//!
//! Read here and not with a library, because a sentence about a bad vertex or index needs the file's own numbers, and
//! because nothing about normals, colours, texture coordinates and materials should be able to refuse a shape.

use super::{File, push_polygon};
use crate::{MeshError, TriMesh};
use glam::DVec3;

pub(super) fn parse(file: &File) -> Result<TriMesh, MeshError> {
    let text = String::from_utf8_lossy(file.bytes);
    let mut mesh = TriMesh::default();
    let mut polygon = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        // A backslash joins a line to the next one.
        let place = format!("line {}", number + 1);
        let mut line = line.trim_end().to_owned();
        while line.ends_with('\\') {
            line.pop();
            line.push_str(lines.next().map_or("", |(_, next)| next.trim_end()));
        }

        // A vertex: three coordinates; a weight or a colour may follow.
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut position = DVec3::ZERO;
                for axis in 0..3 {
                    let word = words.next().unwrap_or("nothing");
                    position[axis] = word.parse().map_err(|_| {
                        file.malformed(
                            "OBJ",
                            format!("{place} has {word} for a coordinate, must be a number"),
                        )
                    })?;
                }
                mesh.positions.push(position);
            }
            // A face: three or more corners, each with the vertex before the first slash.
            Some("f") => {
                polygon.clear();
                for word in words {
                    polygon.push(corner(file, &place, word, mesh.positions.len())?);
                }
                push_polygon(&mut mesh, &polygon);
            }
            _ => {}
        }
    }
    if mesh.positions.is_empty() {
        return Err(file.malformed("OBJ", "it has 0 vertices (lines that begin with v)"));
    }
    Ok(mesh)
}

/// The vertex of a face's corner such as `7`, `7/1/3`, `7//3` or, counted back from the last vertex, `-1`.
fn corner(file: &File, place: &str, word: &str, vertices: usize) -> Result<u32, MeshError> {
    let index: i64 = word.split('/').next().and_then(|vertex| vertex.parse().ok()).ok_or_else(|| {
        file.malformed("OBJ", format!("{place} has {word} for a corner, must be the number of a vertex"))
    })?;
    let last = vertices as i64;
    let from_zero = if index < 0 { last + index } else { index - 1 };
    if (0..last).contains(&from_zero) {
        return Ok(from_zero as u32);
    }
    let first = if index < 0 { -last } else { 1 };
    let last = if index < 0 { -1 } else { last };
    Err(MeshError::IndexOutOfRange {
        mesh: file.name.to_owned(),
        place: place.to_owned(),
        index,
        first,
        last,
    })
}
