//! Shots: named scenes with options.

use frangible::geometry::MeshError;
use frangible::{Method, SceneDesc};
use std::path::PathBuf;
use thiserror::Error;

/// A scene that can be run by its name.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// On the command line.
    pub name: &'static str,
    /// Caption of one line.
    pub caption: &'static str,
    /// Default number of frames at 30 frames per second.
    pub frames: u32,
    /// True for shots that break a user's mesh.
    pub takes_mesh: bool,
    /// True for shots with hundreds of bodies, which take minutes with the paper's method.
    pub is_large: bool,
    pub(crate) build: fn(&ShotOptions) -> Result<SceneDesc, ShotError>,
}

/// Options of any shot.
#[derive(Clone, Debug, PartialEq)]
pub struct ShotOptions {
    /// For shots that break a mesh: its file.
    pub mesh: Option<PathBuf>,
    /// Of plates that its open parts become, in the file's unit.
    pub thickness: Option<f64>,
    /// One step each.
    pub frames_per_second: f64,
    /// Which step.
    pub method: Method,
    /// Of everything random.
    pub seed: u64,
}

impl Default for ShotOptions {
    fn default() -> Self {
        Self {
            mesh: None,
            thickness: None,
            frames_per_second: 30.0,
            method: Method::default(),
            seed: 0,
        }
    }
}

/// Why a shot cannot be set up.
#[derive(Debug, Error)]
pub enum ShotError {
    /// No shot has that name.
    #[error("unknown shot '{name}', must be one of: {known}")]
    Unknown {
        /// As given.
        name: String,
        /// All there are.
        known: String,
    },
    /// The shot breaks a mesh and has none.
    #[error("shot '{0}' needs a mesh file (--mesh FILE)")]
    NeedsMesh(&'static str),
    /// The shot has no use for a mesh.
    #[error("shot '{0}' takes no mesh file, remove --mesh")]
    TakesNoMesh(&'static str),
    /// The shot has no mesh that could be a sheet.
    #[error("shot '{0}' takes no mesh file, remove --thickness")]
    TakesNoThickness(&'static str),
    /// The mesh cannot be used.
    #[error("{0}")]
    Mesh(#[from] MeshError),
}

impl Shot {
    /// Number of frames at a rate [1/s].
    pub fn frames_at(&self, frames_per_second: f64) -> u32 {
        (f64::from(self.frames) * frames_per_second / ShotOptions::default().frames_per_second)
            .ceil() as u32
    }

    /// Its scene.
    ///
    /// # Errors
    /// If it needs a mesh and has none, or the mesh cannot be read.
    pub fn scene(&self, options: &ShotOptions) -> Result<SceneDesc, ShotError> {
        if options.mesh.is_some() && !self.takes_mesh {
            return Err(ShotError::TakesNoMesh(self.name));
        }
        if options.thickness.is_some() && !self.takes_mesh {
            return Err(ShotError::TakesNoThickness(self.name));
        }
        let mut scene = (self.build)(options)?;
        scene.name = self.name.into();
        scene.frames_per_second = options.frames_per_second;
        scene.method = options.method;
        scene.frames = Some(self.frames_at(options.frames_per_second));
        Ok(scene)
    }
}
