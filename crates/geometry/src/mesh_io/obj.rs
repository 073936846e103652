//! Wavefront OBJ: the statements `v`, `vt`, `vn`, `f`, `o`, `g` and `usemtl`.
//!
//! Read here and not with a library, because a sentence about a bad vertex or index needs the
//! file's own numbers, and because nothing about normals, colours, texture coordinates and
//! materials should be able to refuse a shape.

use super::attributes::{CornerAttributes, Parsed, colour_from_srgb, number_of, unit};
use crate::mesh_check::MeshError;
use crate::mesh_io::parser::{File, push_polygon};
use glam::{DVec3, Vec2, Vec3};

/// The attributes of vertices and corners.
#[derive(Default)]
struct Lists {
    colours: Vec<Option<[f32; 4]>>,
    coordinates: Vec<Option<Vec2>>,
    normals: Vec<Option<Vec3>>,
}

pub(super) fn parse(file: &File) -> Result<Parsed, MeshError> {
    // Lines end as on any system: with a line feed, a carriage return, or both.
    let text = String::from_utf8_lossy(file.bytes);
    let text = match text.contains('\r') {
        true => text.replace("\r\n", "\n").replace('\r', "\n").into(),
        false => text,
    };
    let mut reader = Reader::default();
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        // A backslash joins a line to the next one.
        let place = format!("line {}", number + 1);
        let mut line = line.trim_end().to_owned();
        while line.ends_with('\\') {
            line.pop();
            line.push_str(lines.next().map_or("", |(_, next)| next.trim_end()));
        }
        reader.statement(file, &place, &line)?;
    }
    if reader.parsed.mesh.positions.is_empty() {
        return Err(file.malformed("OBJ", "it has 0 vertices (lines that begin with v)"));
    }
    Ok(reader.parsed)
}

/// State between two lines of a file.
#[derive(Default)]
struct Reader {
    parsed: Parsed,
    lists: Lists,
    /// Names of the present object and group, and the number of both together.
    object: Option<String>,
    group: Option<String>,
    owner: Option<u32>,
    material: Option<u32>,
}

impl Reader {
    fn statement(&mut self, file: &File, place: &str, line: &str) -> Result<(), MeshError> {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => self.vertex(file, place, words)?,
            Some("vt") => self.lists.coordinates.push(numbers(words).map(|[u, v]| Vec2::new(u, v))),
            Some("vn") => {
                let normal =
                    numbers(words).and_then(|normal| unit(Vec3::from_array(normal).as_dvec3()));
                self.lists.normals.push(normal);
            }
            // Names reach to the end of the line.
            Some(word @ ("o" | "g" | "usemtl")) => {
                let name = line.trim_start()[word.len()..].trim();
                self.set_name(word, (!name.is_empty()).then(|| name.to_owned()));
            }
            Some("f") => self.face(file, place, words)?,
            _ => {}
        }
        Ok(())
    }

    /// Three coordinates; a weight or a colour may follow.
    fn vertex<'a>(
        &mut self,
        file: &File,
        place: &str,
        mut words: impl Iterator<Item = &'a str>,
    ) -> Result<(), MeshError> {
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
        self.parsed.mesh.positions.push(position);
        self.lists.colours.push(colour(words));
        Ok(())
    }

    /// The object, group or material of the faces that follow.
    fn set_name(&mut self, statement: &str, name: Option<String>) {
        let attributes = &mut self.parsed.attributes;
        match statement {
            "usemtl" => {
                self.material = name.map(|name| number_of(&mut attributes.materials, name));
            }
            "o" => (self.object, self.group) = (name, None),
            _ => self.group = name.filter(|name| name != "default"),
        }
        let names: Vec<String> = self.object.iter().chain(&self.group).cloned().collect();
        self.owner = (!names.is_empty()).then(|| number_of(&mut attributes.objects, names));
    }

    /// Three or more corners, each with the vertex before the first slash.
    fn face<'a>(
        &mut self,
        file: &File,
        place: &str,
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), MeshError> {
        let (mut polygon, mut corners) = (Vec::new(), Vec::new());
        for word in words {
            let vertex = corner(file, place, word, self.parsed.mesh.positions.len())?;
            polygon.push(vertex);
            if file.wanted {
                corners.push(self.lists.corner(word, vertex));
            }
        }
        push_polygon(&mut self.parsed.mesh, &polygon);
        if file.wanted {
            self.parsed.describe(self.owner, self.material, &polygon, &corners);
        }
        Ok(())
    }
}

/// First `N` numbers of a line; `None` if fewer.
fn numbers<'a, const N: usize>(words: impl Iterator<Item = &'a str>) -> Option<[f32; N]> {
    let found: Vec<f32> = words.map_while(|word| word.parse().ok()).take(N).collect();
    found
        .try_into()
        .ok()
        .filter(|numbers: &[f32; N]| numbers.iter().all(|number| number.is_finite()))
}

/// Three numbers behind a vertex's place; one alone is a weight.
fn colour<'a>(words: impl Iterator<Item = &'a str>) -> Option<[f32; 4]> {
    let srgb: [f32; 3] = numbers(words)?;
    colour_from_srgb(srgb.map(f64::from), 1.0)
}

impl Lists {
    /// The attributes of a corner such as `7/1/3`; nothing where a number is missing or out of
    /// range.
    fn corner(&self, word: &str, vertex: u32) -> CornerAttributes {
        let mut parts = word.split('/').skip(1).map(|number| number.parse::<i64>().ok());
        let index = |number: Option<i64>, count: usize| {
            let number = number?;
            usize::try_from(if number < 0 { count as i64 + number } else { number - 1 }).ok()
        };
        let coordinates = index(parts.next().flatten(), self.coordinates.len());
        let normal = index(parts.next().flatten(), self.normals.len());
        CornerAttributes {
            coordinates: coordinates.and_then(|index| *self.coordinates.get(index)?),
            normal: normal.and_then(|index| *self.normals.get(index)?),
            colour: self.colours.get(vertex as usize).copied().flatten(),
        }
    }
}

/// The vertex of a face's corner such as `7`, `7/1/3`, `7//3` or, counted back from the last
/// vertex, `-1`.
fn corner(file: &File, place: &str, word: &str, vertices: usize) -> Result<u32, MeshError> {
    let index: i64 =
        word.split('/').next().and_then(|vertex| vertex.parse().ok()).ok_or_else(|| {
            file.malformed(
                "OBJ",
                format!("{place} has {word} for a corner, must be the number of a vertex"),
            )
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
