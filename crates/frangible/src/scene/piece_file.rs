//! Pieces of a broken mesh, as `frangible break` writes them: each a closed part of a mesh file, or
//! a file of a folder; what is known of their contacts stands beside them.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::shape::ShapeDesc;
use frangible_fracture::{CrossSection, Interface, closed_parts};
use frangible_geometry::{MassProperties, TriMesh, mesh_io, read_file};
use glam::DVec3;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Pieces in the frame of a mesh shape.
pub(crate) struct PieceFile {
    pub(crate) meshes: Vec<TriMesh>,
    /// If the file that stands beside them is of as many pieces.
    pub(crate) contacts: Option<Vec<Interface>>,
}

/// Pieces in the report of `frangible break`; other fields are for people.
#[derive(Deserialize)]
struct Report {
    pieces: Vec<PieceRecord>,
}

#[derive(Deserialize)]
struct PieceRecord {
    name: String,
    volume_m3: f64,
    center_m: [f64; 3],
    neighbours: Vec<NeighbourRecord>,
}

#[derive(Deserialize)]
struct NeighbourRecord {
    name: String,
    area_m2: f64,
    centroid_m: [f64; 3],
    normal: [f64; 3],
}

/// Volumes of a piece and of what the report says of it may differ by this part: files have single
/// precision.
const SAME_VOLUME: f64 = 1e-3;

/// So may their centres, relative to their size.
const SAME_PLACE: f64 = 1e-2;

/// The closed parts of a mesh shape, if it has more than one; `None` for other shapes.
pub(crate) fn parts_of_mesh(
    shape: &ShapeDesc,
    at: &Checker,
) -> Result<Option<PieceFile>, BuildError> {
    let (meshes, contacts) = match shape {
        ShapeDesc::Mesh { path, scale, thickness: None, .. } => {
            let path = Path::new(path);
            let load = |path: &Path| {
                let mesh = mesh_io::load(path).map_err(|error| at.file(&error.to_string()))?;
                closed_parts(&mesh).map_err(|error| at.file(&named(path, &error)))
            };
            let mut meshes = Vec::new();
            for file in files_of(path) {
                meshes.extend(load(&file)?);
            }
            for mesh in &mut meshes {
                mesh.positions.iter_mut().for_each(|position| *position *= *scale);
            }
            let contacts = contacts_beside(path, &meshes, *scale);
            (meshes, contacts)
        }
        ShapeDesc::Triangles { positions, triangles, thickness: None, .. } => {
            let positions = positions.iter().copied().map(DVec3::from_array).collect();
            let mesh = TriMesh { positions, triangles: triangles.clone() };
            (closed_parts(&mesh).map_err(|error| at.file(&error))?, None)
        }
        _ => return Ok(None),
    };
    Ok((meshes.len() > 1).then_some(PieceFile { meshes, contacts }))
}

/// A mesh from a file, or from the OBJ files of a folder, in the order of their names.
pub(crate) fn load_mesh(path: &Path) -> Result<TriMesh, String> {
    let mut all = TriMesh::default();
    for file in files_of(path) {
        let mesh = mesh_io::load(&file).map_err(|error| error.to_string())?;
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|corners| corners.map(|at| at + first)));
    }
    Ok(all)
}

/// The OBJ files of a folder; the file itself for what is none, or has none.
fn files_of(path: &Path) -> Vec<PathBuf> {
    let is_obj = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "obj");
    let mut files: Vec<PathBuf> = path.read_dir().map_or_else(
        |_| Vec::new(),
        |entries| entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_obj).collect(),
    );
    files.sort();
    if files.is_empty() { vec![path.to_path_buf()] } else { files }
}

/// The contacts that a report beside the pieces tells of, if it is of these pieces.
fn contacts_beside(path: &Path, meshes: &[TriMesh], scale: f64) -> Option<Vec<Interface>> {
    let report = if path.is_dir() { path.join("pieces.json") } else { path.with_extension("json") };
    let report: Report = serde_json::from_slice(&read_file(&report).ok()?).ok()?;
    // Files keep pieces in orders of their own.
    let mut number: Vec<Option<usize>> = vec![None; report.pieces.len()];
    for (at, mesh) in meshes.iter().enumerate() {
        let MassProperties { volume, center, .. } = mesh.mass_properties();
        let near = SAME_PLACE * libm::cbrt(volume.abs());
        let is_same = |piece: &PieceRecord| {
            let away = scale * DVec3::from_array(piece.center_m) - center;
            let differs = scale * scale * scale * piece.volume_m3 - volume;
            away.length() <= near && differs.abs() <= SAME_VOLUME * volume
        };
        let found = report.pieces.iter().position(is_same)?;
        if number[found].replace(at).is_some() {
            return None;
        }
    }
    let mut contacts = Vec::new();
    for (piece, &a) in report.pieces.iter().zip(&number) {
        for beside in &piece.neighbours {
            let b = report.pieces.iter().position(|other| other.name == beside.name)?;
            let (a, b) = (a?, number[b]?);
            if a < b {
                let area = scale * scale * beside.area_m2;
                let normal = DVec3::from_array(beside.normal);
                contacts.push(Interface {
                    a,
                    b,
                    area,
                    centroid: scale * DVec3::from_array(beside.centroid_m),
                    normal,
                    section: Arc::new(CrossSection::square(area, normal)),
                });
            }
        }
    }
    Some(contacts)
}

fn named(path: &Path, error: &str) -> String {
    format!("{}: {error}", path.display())
}
