//! A clean mesh whose triangles bound solids, and a record of the cleaning.

use crate::mesh::TriMesh;
use crate::mesh_check::short;
use glam::DVec3;

/// A mesh whose triangles bound solids, and where they come from.
#[derive(Clone, Debug, PartialEq)]
pub struct CleanMesh {
    /// Closed surfaces, each with vertices of its own: the outer ones of solids face outward, those
    /// of cavities inward. Solids may still cross or touch one another, and a surface itself.
    pub mesh: TriMesh,
    /// Raw triangle of each triangle, or of which it is a part; `None` for triangles that close
    /// holes. Whole triangles keep their first corner; reversed triangles swap the last two.
    pub source: Vec<Option<u32>>,
    /// Solid of each triangle, counted from zero.
    pub solid: Vec<u32>,
    /// Enclosing solid of each solid, if any.
    pub nested: Vec<Option<u32>>,
    /// The repairs.
    pub changes: MeshChanges,
}

/// The changes that cleaning made to a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshChanges {
    /// Repeated triangles, triangles with two equal corners, and triangles of repeated surfaces.
    pub repeated: usize,
    /// Triangles that were turned round to agree with their neighbours.
    pub turned: usize,
    /// Holes that were closed, cracks without an area not counted.
    pub holes: usize,
    /// Open flat parts, which enclose nothing.
    pub sheets: Vec<Sheet>,
    /// Number of triangles of the raw mesh, if these parts had most of them.
    pub mostly_left_out: Option<usize>,
}

/// An omitted part.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Its first triangle in the raw mesh.
    pub first: u32,
    /// Number of its triangles.
    pub triangles: usize,
    /// [m^2]
    pub area: f64,
    /// Lowest and highest corner of its bounding box [m].
    pub bounds: (DVec3, DVec3),
}

impl MeshChanges {
    /// Maximum number of parts in a message.
    const MOST_NAMED: usize = 3;

    /// A sentence for each kind of change.
    pub fn sentences(&self) -> Vec<String> {
        let plural = |count: usize, one: &str, many: &str| {
            if count == 1 { format!("1 {one}") } else { format!("{count} {many}") }
        };
        let mut sentences = Vec::new();
        if self.repeated > 0 {
            let what = plural(self.repeated, "triangle that is", "triangles that are");
            sentences.push(format!("{what} repeated or without area left out"));
        }
        if self.turned > 0 {
            let what = plural(self.turned, "triangle", "triangles");
            sentences.push(format!("{what} turned round to agree with their neighbours"));
        }
        if self.holes > 0 {
            let what = plural(self.holes, "hole", "holes");
            sentences.push(format!("{what} closed by triangles between the rim's vertices"));
        }
        if !self.sheets.is_empty() {
            let named = self.sheets.iter().take(Self::MOST_NAMED).map(ToString::to_string);
            let mut named: Vec<String> = named.collect();
            let rest = self.sheets.len() - named.len();
            if rest > 0 {
                named.push(format!("{rest} more"));
            }
            let what =
                plural(self.sheets.len(), "open part that encloses", "open parts that enclose");
            let left_out: usize = self.sheets.iter().map(|sheet| sheet.triangles).sum();
            // A thickness would make solids of them.
            let mostly = self.mostly_left_out.map_or_else(String::new, |all| {
                format!(
                    "; these are {left_out} of {all} triangles, and a thickness makes plates of \
                     open parts (--thickness, or a scene's \"thickness\")"
                )
            });
            sentences.push(format!("{what} nothing left out: {}{mostly}", named.join(", ")));
        }
        sentences
    }
}

impl std::fmt::Display for Sheet {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let point = |point: DVec3| format!("({})", point.to_array().map(short).join(", "));
        let (low, high) = self.bounds;
        let s = if self.triangles == 1 { "" } else { "s" };
        write!(formatter, "{} triangle{s} from {} to {}", self.triangles, point(low), point(high))
    }
}
