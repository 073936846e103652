//! Rules of a mesh, and messages for violations.

use crate::mesh::TriMesh;
use glam::DVec3;

/// File endings readable by [`crate::mesh_io::load`].
pub(crate) const KNOWN_ENDINGS: &str = ".obj, .ply, .stl, .gltf, .glb";

/// Largest coordinate [m]: areas and volumes of larger ones lose their digits, and then overflow.
const MOST_COORDINATE: f64 = 1e12;

/// A number with four digits.
pub(crate) fn short(number: f64) -> String {
    let text = format!("{number:.3e}");
    match text.parse::<f64>() {
        // Not hundreds of zeros.
        Ok(rounded) if rounded == 0.0 || (1e-6..1e12).contains(&rounded.abs()) => {
            format!("{rounded}")
        }
        Ok(rounded) => format!("{rounded:e}"),
        Err(_) => text,
    }
}

/// Why a mesh cannot be used. Each sentence names the mesh (a file, where there is one), the value
/// and the rule.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// There is nothing at the path.
    #[error("{mesh}: no such file")]
    Missing {
        /// Path as given.
        mesh: String,
    },
    /// The path is a folder's.
    #[error("{mesh}: is a folder, must be a mesh file ({KNOWN_ENDINGS})")]
    Folder {
        /// Path as given.
        mesh: String,
    },
    /// The operating system refuses.
    #[error("{mesh}: cannot be read: {reason}")]
    Unreadable {
        /// Path as given.
        mesh: String,
        /// The operating system's words.
        reason: String,
    },
    /// No byte in the file.
    #[error("{mesh}: has 0 bytes, must hold a mesh")]
    Empty {
        /// Path as given.
        mesh: String,
    },
    /// The ending does not say which format it is.
    #[error("{mesh}: ends in \"{ending}\", must end in one of {KNOWN_ENDINGS}")]
    UnknownEnding {
        /// Path as given.
        mesh: String,
        /// With its dot; empty if there is none.
        ending: String,
    },
    /// The content contradicts the ending.
    #[error("{mesh}: is not a valid {format} file: {reason}")]
    Malformed {
        /// Path as given.
        mesh: String,
        /// "OBJ", "PLY", "STL" or "glTF".
        format: &'static str,
        /// Where and what.
        reason: String,
    },
    /// Nothing to make a solid of.
    #[error("{mesh}: has 0 triangles with an area, must have at least 1")]
    NoTriangles {
        /// File or "the mesh".
        mesh: String,
    },
    /// Too much work.
    #[error(
        "{mesh}: has {triangles} triangles, each instance counted, must have at most {}",
        TriMesh::MOST_TRIANGLES
    )]
    TooManyTriangles {
        /// File or "the mesh".
        mesh: String,
        /// Number of triangles.
        triangles: usize,
    },
    /// NaN or infinite.
    #[error(
        "{mesh}: vertex {vertex} is ({}, {}, {}), coordinates must be finite and at most {MOST_COORDINATE:e}",
        short(position.x), short(position.y), short(position.z)
    )]
    NotFinite {
        /// File or "the mesh".
        mesh: String,
        /// Counted from zero.
        vertex: usize,
        /// As read.
        position: DVec3,
    },
    /// A triangle of vertices that do not exist.
    #[error("{mesh}: {place} refers to vertex {index}, must be {first} to {last}")]
    IndexOutOfRange {
        /// File or "the mesh".
        mesh: String,
        /// "triangle 3" or "line 12".
        place: String,
        /// In the file's own count.
        index: i64,
        /// Lowest index allowed.
        first: i64,
        /// Highest index allowed.
        last: i64,
    },
    /// No part is closed, or can be.
    #[error(
        "{mesh}: encloses no volume: it has {parts} open or flat part{} of {} m^2 in all, must have a \
         closed one, or a thickness that makes plates of open ones (--thickness, or a scene's \"thickness\")",
        if *parts == 1 { "" } else { "s" },
        short(*area)
    )]
    NothingClosed {
        /// File or "the mesh".
        mesh: String,
        /// Number of parts.
        parts: usize,
        /// Total area [m^2].
        area: f64,
    },
    /// Of a plate, zero or less, or no number.
    #[error("{mesh}: thickness {thickness} m, must be above 0")]
    Thickness {
        /// File or "the mesh".
        mesh: String,
        /// [m]
        thickness: f64,
    },
}

impl TriMesh {
    /// Maximum number of triangles in a file: cleaning takes about 700 bytes and 7 microseconds for
    /// each, breaking several times as much.
    pub const MOST_TRIANGLES: usize = 3_000_000;

    /// Refuses more triangles than may be worked on. `name` begins the sentence.
    pub(crate) fn check_size(name: &str, triangles: usize) -> Result<(), MeshError> {
        if triangles <= Self::MOST_TRIANGLES {
            return Ok(());
        }
        Err(MeshError::TooManyTriangles { mesh: name.to_owned(), triangles })
    }

    /// Refuses a mesh without triangles, with coordinates that are not finite, or with vertices
    /// that do not exist. `name` begins the sentence.
    pub fn check(&self, name: &str) -> Result<(), MeshError> {
        let mesh = || name.to_owned();
        for (vertex, &position) in self.positions.iter().enumerate() {
            if !position.is_finite() || position.abs().max_element() > MOST_COORDINATE {
                return Err(MeshError::NotFinite { mesh: mesh(), vertex, position });
            }
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&vertex) =
                corners.iter().find(|&&vertex| vertex as usize >= self.positions.len())
            {
                return Err(MeshError::IndexOutOfRange {
                    mesh: mesh(),
                    place: format!("triangle {triangle}"),
                    index: i64::from(vertex),
                    first: 0,
                    last: self.positions.len() as i64 - 1,
                });
            }
        }
        if self.area() > 0.0 { Ok(()) } else { Err(MeshError::NoTriangles { mesh: mesh() }) }
    }
}
