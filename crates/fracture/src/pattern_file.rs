//! A pattern in one file: JSON with a name and a version.

use crate::pattern::error::PatternError;
use crate::pattern::region::Region;
use crate::pattern::{Cells, Pattern};
use crate::rough::Rough;
use frangible_geometry::{TriMesh, mesh_io, read_file};
use serde::Serialize;
use std::path::Path;

/// Format name of a pattern file.
const FORMAT: &str = "frangible-pattern";

/// Version of written files, and the newest readable version.
const VERSION: u32 = 1;

/// Volumes of the cells in a file may miss the box's by this part of it: digits that a program cut
/// off, no cell.
const MOST_DEFECT: f64 = 1e-6;

/// Record of a written file.
#[derive(Serialize)]
struct Written<'a> {
    format: &'static str,
    version: u32,
    #[serde(flatten)]
    pattern: &'a Pattern,
}

impl Pattern {
    /// Saves to a file, from which [`Pattern::load`] makes an equal pattern.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), PatternError> {
        let written = Written { format: FORMAT, version: VERSION, pattern: self };
        let text = serde_json::to_string(&written).map_err(|error| error.to_string());
        let saved =
            text.and_then(|text| std::fs::write(path, text).map_err(|error| error.to_string()));
        saved.map_err(|reason| PatternError::File {
            path: path.display().to_string(),
            reason: format!("cannot be written: {reason}"),
        })
    }

    /// Reads a file that [`Pattern::save`] wrote, or another program: everything is checked. A mesh
    /// file (.obj, .ply, .stl, .gltf, .glb) is a drawn pattern, see [`Pattern::of_parts`].
    ///
    /// # Errors
    /// If the file cannot be read, is not a pattern, or its cells do not tile its box.
    pub fn load(path: &Path) -> Result<Self, PatternError> {
        let name = path.display().to_string();
        if path.extension().is_none_or(|ending| ending != "json") {
            let mesh = mesh_io::load(path);
            // The sentence about a mesh begins with its name, too.
            let mesh =
                mesh.map_err(|error| error.to_string().replacen(&format!("{name}: "), "", 1));
            let mesh = mesh.map_err(|reason| PatternError::File { path: name.clone(), reason })?;
            return Self::of_parts(&mesh, &name);
        }
        let text = read_file(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => "no such file".to_owned(),
            _ => format!("cannot be read: {error}"),
        });
        let text = text.and_then(|bytes| {
            String::from_utf8(bytes)
                .map_err(|_| "is not a pattern: it is not UTF-8 text".to_owned())
        });
        let pattern = text.and_then(|text| parse(&text));
        pattern.map_err(|reason| PatternError::File { path: name, reason })
    }

    /// A pattern as [serde](serde_json) writes it, checked as a file's.
    ///
    /// # Errors
    /// If it is none, or its cells do not tile its box.
    pub fn of_json(text: &str) -> Result<Self, String> {
        let pattern: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        pattern.check()?;
        Ok(pattern)
    }

    /// Checks what no generator gets wrong; the error completes the sentence that begins with the
    /// file.
    fn check(&self) -> Result<(), String> {
        let e = self.half_extent;
        if !(e.is_finite() && e.min_element() > 0.0) {
            return Err(format!("half_extent: {e}, must be positive and finite"));
        }
        if !(self.center.is_finite() && self.center.abs().cmplt(e).all()) {
            return Err(format!(
                "center: {}, must lie inside of the box of half_extent {e}",
                self.center
            ));
        }
        if !(self.magnification.is_finite() && self.magnification >= 1.0) {
            return Err(format!(
                "magnification: {}, must be finite and at least 1",
                self.magnification
            ));
        }
        if self.is_empty() {
            return Err("has no cells, must have at least 1".to_owned());
        }
        if let Some(&joint) = self.joints.iter().find(|&&joint| joint >= self.len()) {
            return Err(format!("joints: {joint}, must be numbers of cells, below {}", self.len()));
        }
        if !self.joints.is_sorted() {
            return Err("joints: must be in ascending order".to_owned());
        }
        match &self.cells {
            Cells::Planar(regions) => self.check_regions(regions),
            Cells::Rough(Rough { regions, noise, .. }) => {
                if !(noise.wavelength.is_finite() && noise.wavelength > 0.0) {
                    return Err(format!(
                        "noise.wavelength: {}, must be positive and finite",
                        noise.wavelength
                    ));
                }
                if !(0.0..1.0).contains(&noise.steepness) {
                    return Err(format!(
                        "noise.steepness: {}, must be at least 0 and below 1",
                        noise.steepness
                    ));
                }
                self.check_regions(regions)
            }
            Cells::Drawn(drawn) => {
                let e = self.half_extent;
                let beyond = drawn.meshes().iter().map(TriMesh::bounds);
                let beyond = beyond
                    .map(|(low, high)| (high.max(-low) / e).max_element())
                    .fold(0.0, f64::max);
                let fits = (beyond - 1.0).abs() < MOST_DEFECT;
                if fits {
                    Ok(())
                } else {
                    Err(format!("half_extent: {e}, must be that of the meshes' box"))
                }
            }
        }
    }

    fn check_regions(&self, regions: &[Region]) -> Result<(), String> {
        // A face that lies off its plane, or a plane that is none.
        let close = MOST_DEFECT * self.half_extent.max_element();
        for (cell, region) in regions.iter().enumerate() {
            for cut in &region.cuts {
                let length = cut.half_space.normal.length();
                if !((length - 1.0).abs() < MOST_DEFECT && cut.half_space.offset.is_finite()) {
                    return Err(format!("cell {cell}: a normal of length {length}, must be 1"));
                }
                let off = cut.face.iter().map(|&corner| cut.half_space.distance(corner).abs());
                let off = off.fold(0.0, f64::max);
                if off >= close
                    || !cut.face.iter().all(|corner| corner.is_finite())
                    || cut.face.len() < 3
                {
                    return Err(format!(
                        "cell {cell}: a face that does not lie on its plane (it is {off} away)"
                    ));
                }
            }
        }
        let defect = self.tiling_defect();
        if defect >= MOST_DEFECT || defect.is_nan() {
            let percent = 100.0 * defect;
            return Err(format!(
                "the cells' volumes miss the box's by {percent} %, must add up to it"
            ));
        }
        Ok(())
    }
}

fn parse(text: &str) -> Result<Pattern, String> {
    // Detect the kind of file.
    let mut fields: serde_json::Map<String, serde_json::Value> =
        serde_json::from_str(text).map_err(|error| format!("is not a pattern: {error}"))?;
    let format = fields.remove("format");
    if format.as_ref().and_then(|format| format.as_str()) != Some(FORMAT) {
        return Err(format!("is not a pattern: must say \"format\": \"{FORMAT}\""));
    }
    let version = fields.remove("version");
    match version.as_ref().and_then(serde_json::Value::as_u64) {
        Some(version) if version == u64::from(VERSION) => {}
        Some(version) => {
            return Err(format!("is a pattern of version {version}, must be {VERSION}"));
        }
        None => {
            return Err(format!("is a pattern without a version, must say \"version\": {VERSION}"));
        }
    }

    // Parse and validate it.
    let pattern: Pattern = serde_json::from_value(fields.into())
        .map_err(|error| format!("is not a pattern: {error}"))?;
    pattern.check()?;
    Ok(pattern)
}
