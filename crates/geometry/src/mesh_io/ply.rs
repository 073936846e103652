//! PLY, text and binary: the elements `vertex`, `face` and `tristrips`.
//!
//! A library reads the header. The numbers after it are read here, because its text form knows
//! neither `nan` nor `1.`.

use super::attributes::{CornerAttributes, Parsed, colour_from_srgb, unit};
use crate::mesh_check::MeshError;
use crate::mesh_io::parser::{File, push_polygon, strip};
use glam::{DVec3, Vec2};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, PropertyType, ScalarType};
use std::io::Read;
use std::path::Path;
use std::str::SplitWhitespace;

/// Characters of a line that a sentence shows.
const MOST_SHOWN: usize = 60;
/// Bytes before the first element that are looked through for lines without a keyword.
const MOST_PREAMBLE: usize = 1 << 16;

pub(super) fn parse(file: &File) -> Result<Parsed, MeshError> {
    // Read the header.
    let (preamble, rest) = preamble(file.bytes);
    let mut reader = Reader::new(preamble.chain(rest));
    let header = Parser::<DefaultElement>::new().read_header(&mut reader);
    let header = header
        .map_err(|error| file.malformed("PLY", header_fault(file.bytes, &error.to_string())))?;
    let body = reader.into_inner().into_inner().1;
    let text = String::from_utf8_lossy(body);
    let mut numbers = match header.encoding {
        Encoding::Ascii => Numbers::Text(text.split_whitespace()),
        Encoding::BinaryLittleEndian => Numbers::LittleEndian(body),
        Encoding::BinaryBigEndian => Numbers::BigEndian(body),
    };

    // Read the elements in the order of the header; others than vertices and faces only to get past
    // them.
    let mut elements = Elements::default();
    for element in header.elements.values() {
        if element.properties.is_empty() || element.count > body.len() {
            let reason = format!(
                "its {} bytes cannot hold {} elements \"{}\"",
                body.len(),
                element.count,
                element.name
            );
            return Err(file.malformed("PLY", reason));
        }
        elements.read(file, element, &mut numbers)?;
    }

    let Elements { mut parsed, corners_of_vertices, faces } = elements;
    parsed.attributes.materials = images(&header.comments, file.path);
    faces.add_triangles(file, &corners_of_vertices, &mut parsed)?;
    Ok(parsed)
}

/// Vertices and faces as far as they are read.
#[derive(Default)]
struct Elements {
    parsed: Parsed,
    /// The attributes of each vertex, where they are wanted.
    corners_of_vertices: Vec<CornerAttributes>,
    faces: Faces,
}

impl Elements {
    /// Reads all elements of one kind.
    fn read(
        &mut self,
        file: &File,
        element: &ElementDef,
        numbers: &mut Numbers,
    ) -> Result<(), MeshError> {
        let name = &element.name;
        let axes = ["x", "y", "z"].map(|axis| element.properties.get_index_of(axis));
        let corners = ["vertex_indices", "vertex_index"]
            .iter()
            .find_map(|list| element.properties.get_index_of(*list));
        let besides = Besides::of(element);
        for count in 0..element.count {
            let values = numbers.element(element).ok_or_else(|| {
                file.malformed(
                    "PLY",
                    format!("element \"{name}\" {count} has a number missing or misspelt"),
                )
            })?;
            match (name.as_str(), axes, corners) {
                ("vertex", [Some(x), Some(y), Some(z)], _) => {
                    let coordinate = |at: usize| values[at].first().copied().unwrap_or(f64::NAN);
                    let position = DVec3::new(coordinate(x), coordinate(y), coordinate(z));
                    self.parsed.mesh.positions.push(position);
                    if file.wanted {
                        self.corners_of_vertices.push(besides.corner(&values));
                    }
                }
                ("vertex", _, _) => {
                    return Err(file.malformed("PLY", "its vertices have no x, y and z"));
                }
                ("face", _, Some(corners)) => {
                    self.faces.add(&values[corners]);
                    if file.wanted {
                        self.faces.own.push(besides.face(&values));
                    }
                }
                ("tristrips", _, Some(corners)) => self.faces.strips.push(values[corners].clone()),
                ("face", _, None) => {
                    return Err(file.malformed("PLY", "its faces have no vertex_indices"));
                }
                ("tristrips", _, None) => {
                    return Err(file.malformed("PLY", "its strips have no vertex_indices"));
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// The corners of all faces, one after the other.
#[derive(Default)]
struct Faces {
    corners: Vec<f64>,
    /// For each face the place behind its last corner.
    ends: Vec<usize>,
    /// Its attributes, where they are wanted.
    own: Vec<OfFace>,
    /// Corners of strips.
    strips: Vec<Vec<f64>>,
}

impl Faces {
    fn add(&mut self, corners: &[f64]) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    /// Makes triangles of the faces and strips, with each index checked. `attributes` are those of
    /// the vertices, where they are wanted.
    fn add_triangles(
        &self,
        file: &File,
        attributes: &[CornerAttributes],
        parsed: &mut Parsed,
    ) -> Result<(), MeshError> {
        let last = parsed.mesh.positions.len() as i64 - 1;
        let vertices = |what: &str, number: usize, corners: &[f64]| {
            if let Some(&index) =
                corners.iter().find(|&&index| !(index >= 0.0 && index <= last as f64))
            {
                let (mesh, place) = (file.name.to_owned(), format!("{what} {number}"));
                return Err(MeshError::IndexOutOfRange {
                    mesh,
                    place,
                    index: index as i64,
                    first: 0,
                    last,
                });
            }
            Ok(corners.iter().map(|&index| index as u32).collect::<Vec<u32>>())
        };
        let images = parsed.attributes.materials.len();
        let mut first = 0;
        for (face, &end) in self.ends.iter().enumerate() {
            let polygon = vertices("face", face, &self.corners[first..end])?;
            first = end;
            push_polygon(&mut parsed.mesh, &polygon);
            let Some(own) = self.own.get(face) else { continue };
            let corners = polygon.iter().zip(0..).map(|(&vertex, at)| {
                let corner = attributes[vertex as usize];
                let coordinates = own.coordinates.get(at).copied().or(corner.coordinates);
                CornerAttributes { coordinates, colour: corner.colour.or(own.colour), ..corner }
            });
            let corners: Vec<CornerAttributes> = corners.collect();
            let material = own.image.filter(|&image| (image as usize) < images);
            parsed.describe(None, material, &polygon, &corners);
        }

        // In a strip a negative number begins another one.
        for (number, corners) in self.strips.iter().enumerate() {
            for part in corners.split(|&index| index < 0.0) {
                let corners = vertices("strip", number, part)?;
                parsed.mesh.triangles.extend(strip(&corners));
                if file.wanted {
                    let of = corners.iter().map(|&vertex| attributes[vertex as usize]);
                    parsed.describe(
                        None,
                        (images > 0).then_some(0),
                        &corners,
                        &of.collect::<Vec<_>>(),
                    );
                }
            }
        }
        Ok(())
    }
}

/// The lines before a file's first element, with comments for lines that no keyword begins, as some
/// exporters write them; and the rest of the file.
fn preamble(bytes: &[u8]) -> (Vec<u8>, &[u8]) {
    const KEYWORDS: [&[u8]; 7] =
        [b"ply", b"format", b"comment", b"obj_info", b"element", b"property", b"end_header"];
    let (mut known, mut rest) = (Vec::new(), bytes);
    while let Some(end) = rest.iter().position(|&byte| byte == b'\n') {
        let (line, later) = rest.split_at(end + 1);
        let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        // The first line says what the file is.
        let is_known = known.is_empty() || word.is_empty() || KEYWORDS.contains(&word);
        if [&b"element"[..], b"property", b"end_header"].contains(&word)
            || known.len() > MOST_PREAMBLE
        {
            break;
        }
        known.extend(if is_known { &b""[..] } else { b"comment " });
        known.extend(line);
        rest = later;
    }
    (known, rest)
}

/// The images that comments name, in the order of their numbers: `<this>` stands for the file's own
/// name.
fn images(comments: &[String], path: &Path) -> Vec<String> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let named = comments.iter().filter_map(|comment| comment.trim().strip_prefix("TextureFile "));
    named.map(|name| name.trim().replace("<this>", &stem)).collect()
}

/// Where an element has colours, normals and texture coordinates, if it has any.
struct Besides {
    /// Red, green, blue and alpha, and the number that stands for all of a channel.
    colour: Option<([usize; 3], Option<usize>, f64)>,
    normal: Option<[usize; 3]>,
    coordinates: Option<[usize; 2]>,
    /// Texture coordinates of a face's corners, one after the other.
    list: Option<usize>,
    /// The number of a face's image.
    image: Option<usize>,
}

/// The attributes of a face.
struct OfFace {
    colour: Option<[f32; 4]>,
    coordinates: Vec<Vec2>,
    image: Option<u32>,
}

impl Besides {
    fn of(element: &ElementDef) -> Self {
        let index = |name: &str| element.properties.get_index_of(name);
        let all = |names: [&str; 3]| Some([index(names[0])?, index(names[1])?, index(names[2])?]);
        let rgb = all(["red", "green", "blue"])
            .or_else(|| all(["diffuse_red", "diffuse_green", "diffuse_blue"]));
        let full = |channel: usize| match element.properties[channel].data_type {
            PropertyType::Scalar(ScalarType::Float | ScalarType::Double) => 1.0,
            PropertyType::Scalar(ScalarType::Short | ScalarType::UShort) => f64::from(u16::MAX),
            _ => f64::from(u8::MAX),
        };
        let pairs =
            [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];
        Self {
            colour: rgb.map(|rgb| (rgb, index("alpha"), full(rgb[0]))),
            normal: all(["nx", "ny", "nz"]),
            coordinates: pairs.iter().find_map(|[u, v]| Some([index(u)?, index(v)?])),
            list: index("texcoord"),
            image: index("texnumber"),
        }
    }

    fn colour(&self, values: &[Vec<f64>]) -> Option<[f32; 4]> {
        let (rgb, alpha, full) = self.colour?;
        let alpha = alpha.map_or(1.0, |channel| number(values, channel) / full);
        colour_from_srgb(rgb.map(|channel| number(values, channel) / full), alpha)
    }

    fn corner(&self, values: &[Vec<f64>]) -> CornerAttributes {
        let [normal, coordinates] = [self.normal.map(Vec::from), self.coordinates.map(Vec::from)]
            .map(|places| {
                places.map(|places| places.iter().map(|&at| number(values, at)).collect::<Vec<_>>())
            });
        CornerAttributes {
            coordinates: coordinates
                .map(|place| Vec2::new(place[0] as f32, place[1] as f32))
                .filter(|p| p.is_finite()),
            normal: normal.and_then(|normal| unit(DVec3::from_slice(&normal))),
            colour: self.colour(values),
        }
    }

    fn face(&self, values: &[Vec<f64>]) -> OfFace {
        let places = self.list.map_or(&[][..], |list| &values[list][..]);
        let place = |pair: &[f64]| Vec2::new(pair[0] as f32, pair[1] as f32);
        // Without a number it is the first one; a negative number is none.
        let image = self.image.map_or(0.0, |image| number(values, image));
        OfFace {
            colour: self.colour(values),
            coordinates: places.chunks_exact(2).map(place).collect(),
            image: (image >= 0.0).then_some(image as u32),
        }
    }
}

/// A scalar of an element.
fn number(values: &[Vec<f64>], at: usize) -> f64 {
    values[at].first().copied().unwrap_or(f64::NAN)
}

/// The fault of a header, by the line that the library's words begin with.
fn header_fault(bytes: &[u8], words: &str) -> String {
    let line = |number: usize| {
        let line = bytes.split(|&byte| byte == b'\n').nth(number)?;
        let text = String::from_utf8_lossy(line);
        let shown =
            text.trim().chars().take(MOST_SHOWN).filter(|character| !character.is_control());
        Some(shown.collect::<String>())
    };
    let first = line(0).unwrap_or_default();
    if first != "ply" {
        return format!("its first line is \"{first}\", must be \"ply\"");
    }
    let digits = words.trim_start_matches("Line ").split(':').next();
    let number = digits.and_then(|digits| digits.parse::<usize>().ok()).unwrap_or(0);
    match number.checked_sub(1).and_then(line) {
        Some(text) if !text.is_empty() => {
            format!(
                "line {number} of its header is \"{text}\", must be a statement of PLY in its place"
            )
        }
        _ => "its header breaks off before the line \"end_header\"".to_owned(),
    }
}

/// The numbers of a file, one after the other.
enum Numbers<'a> {
    Text(SplitWhitespace<'a>),
    LittleEndian(&'a [u8]),
    BigEndian(&'a [u8]),
}

impl Numbers<'_> {
    /// The values of each property of an element, one for a scalar; `None` where the file breaks
    /// off.
    fn element(&mut self, element: &ElementDef) -> Option<Vec<Vec<f64>>> {
        let mut values = Vec::with_capacity(element.properties.len());
        for property in element.properties.values() {
            values.push(match &property.data_type {
                PropertyType::Scalar(scalar) => vec![self.next(scalar)?],
                PropertyType::List(length, scalar) => {
                    let length = self.next(length).filter(|&length| length >= 0.0)?;
                    (0..length as usize).map(|_| self.next(scalar)).collect::<Option<Vec<f64>>>()?
                }
            });
        }
        Some(values)
    }

    /// The next number; each type of PLY fits into f64 exactly.
    fn next(&mut self, scalar: &ScalarType) -> Option<f64> {
        let little = matches!(self, Self::LittleEndian(_));
        let bytes = match self {
            Self::Text(words) => return words.next()?.parse().ok(),
            Self::LittleEndian(bytes) | Self::BigEndian(bytes) => bytes,
        };
        Some(match scalar {
            ScalarType::Char => f64::from(i8::from_ne_bytes(take(bytes, little)?)),
            ScalarType::UChar => f64::from(u8::from_ne_bytes(take(bytes, little)?)),
            ScalarType::Short => f64::from(i16::from_le_bytes(take(bytes, little)?)),
            ScalarType::UShort => f64::from(u16::from_le_bytes(take(bytes, little)?)),
            ScalarType::Int => f64::from(i32::from_le_bytes(take(bytes, little)?)),
            ScalarType::UInt => f64::from(u32::from_le_bytes(take(bytes, little)?)),
            ScalarType::Float => f64::from(f32::from_le_bytes(take(bytes, little)?)),
            ScalarType::Double => f64::from_le_bytes(take(bytes, little)?),
        })
    }
}

/// Takes the next bytes, turned to little-endian order.
fn take<const N: usize>(bytes: &mut &[u8], little: bool) -> Option<[u8; N]> {
    let (taken, rest) = bytes.split_first_chunk::<N>()?;
    *bytes = rest;
    let mut taken = *taken;
    if !little {
        taken.reverse();
    }
    Some(taken)
}
