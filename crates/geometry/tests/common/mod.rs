//! Meshes that the tests share.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a panic is how a test fails")]
#![allow(dead_code, reason = "each test file uses some of them")]

use frangible_geometry::{TriMesh, mesh_io};
use glam::DVec3;
use proptest::prelude::*;
use std::path::PathBuf;

/// Faces of a cube as quads over its eight corners, corner `i` at bit 0 of `i` along x, 1 along y,
/// 2 along z.
pub(crate) const CUBE_FACES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Box without its last `missing` faces.
pub(crate) fn open_box(low: DVec3, high: DVec3, missing: usize) -> TriMesh {
    let corner = |i: u32| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let faces = &CUBE_FACES[..CUBE_FACES.len() - missing];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriMesh { positions: (0..8).map(corner).collect(), triangles }
}

/// Sphere of 20 * 4^levels triangles around the origin, its vertices on the sphere.
pub(crate) fn icosphere(radius: f64, levels: usize) -> TriMesh {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut positions: Vec<DVec3> = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ]
    .map(|p| DVec3::from_array(p).normalize() * radius)
    .to_vec();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
                let middle =
                    (positions[from as usize] + positions[to as usize]).normalize() * radius;
                positions.push(middle);
                positions.len() as u32 - 1
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let mut mesh = TriMesh { positions, triangles };
    mesh.weld();
    mesh
}

/// Both meshes in one.
pub(crate) fn joined(mut first: TriMesh, second: &TriMesh) -> TriMesh {
    let base = first.positions.len() as u32;
    first.positions.extend(&second.positions);
    first
        .triangles
        .extend(second.triangles.iter().map(|triangle| triangle.map(|vertex| base + vertex)));
    first
}

/// The same mesh elsewhere.
pub(crate) fn moved(mut mesh: TriMesh, way: DVec3) -> TriMesh {
    for position in &mut mesh.positions {
        *position += way;
    }
    mesh
}

/// The Stanford bunny of 3674 triangles, closed, from the npm package `bunny` (public domain).
pub(crate) fn bunny() -> TriMesh {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/tools/node_modules/bunny/index.js");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| {
        panic!("{}: {error}; `make test` fetches it, run that", path.display())
    });
    let array = |name: &str| {
        let start = text.find(name).unwrap() + name.len();
        let end = text[start..].find("]]").unwrap() + start + 2;
        &text[start..end]
    };
    let positions: Vec<[f64; 3]> = serde_json::from_str(array("exports.positions=")).unwrap();
    let triangles: Vec<[u32; 3]> = serde_json::from_str(array("exports.cells=")).unwrap();
    TriMesh { positions: positions.into_iter().map(DVec3::from_array).collect(), triangles }
}

/// A folder with one file in it.
pub(crate) struct TestFile {
    pub(crate) folder: tempfile::TempDir,
    pub(crate) path: PathBuf,
}

impl TestFile {
    pub(crate) fn new(name: &str, content: impl AsRef<[u8]>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        Self { folder, path }
    }

    pub(crate) fn load(&self) -> TriMesh {
        mesh_io::load(&self.path).unwrap()
    }

    /// The error's sentence without the folder.
    pub(crate) fn refusal(&self) -> String {
        let sentence = mesh_io::load(&self.path).unwrap_err().to_string();
        sentence.replace(&format!("{}/", self.folder.path().display()), "")
    }
}

/// [`TestFile::refusal`] of a file.
pub(crate) fn refusal(name: &str, content: impl AsRef<[u8]>) -> String {
    TestFile::new(name, content).refusal()
}

/// Bytes to put at places, counted from the start, that wrap around.
pub(crate) fn any_damages() -> impl Strategy<Value = Vec<(usize, u8)>> {
    let digits_and_all =
        prop_oneof![prop::sample::select(b"0123456789-e.".as_slice()), any::<u8>()];
    prop::collection::vec((any::<usize>(), digits_and_all), 1..8)
}

/// Loads a damaged file; the mesh, if there is one, must keep the rules.
pub(crate) fn load_damaged(name: &str, mut bytes: Vec<u8>, damages: &[(usize, u8)]) {
    for &(place, byte) in damages {
        let length = bytes.len();
        bytes[place % length] = byte;
    }
    if let Ok(mesh) = mesh_io::load(&TestFile::new(name, bytes).path) {
        mesh.check(name).unwrap();
    }
}
