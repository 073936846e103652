//! Fracture of bodies, and glue between pieces.

use crate::scene::desc::defaults;
use crate::scene::desc::strength_points::StrengthPointDesc;
use frangible_fracture::{Bricks, Concrete, Natural, Radial, Slices, Splinters, Voronoi};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Fracture of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BreakingDesc {
    /// Strength of the body.
    pub strength: StrengthDesc,
    /// Pattern of prescored space.
    pub pattern: PatternDesc,
    /// Approximate number of pieces per break, from 2 to 10000: the pattern's number of cells is
    /// chosen for the impact point; a pattern from a file is magnified. By default the pattern is
    /// used as described.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pieces: Option<usize>,
    /// Number of consecutive breaks: 1 means that fragments do not break.
    #[serde(default = "defaults::generations")]
    pub generations: u32,
    /// Minimum longest side of fragments that break again [m].
    #[serde(default)]
    pub smallest: f64,
    /// How far a break reaches from its blow [m]: the rest stays whole, and is broken as before by
    /// the next blow. The pattern is laid on what is in reach; bricks, slices and files are laid on
    /// the whole body, and of them the cells with their centres in reach come loose. By default all
    /// of the body breaks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach: Option<f64>,
    /// Point of the shape at the pattern's centre, in the shape's own frame [m]; by default the
    /// blow's. What breaks again breaks where it is struck.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Turn of the pattern about the blow's direction [rad].
    #[serde(default, skip_serializing_if = "defaults::is_zero")]
    pub twist: f64,
    /// Points at which the body is stronger or weaker; beside them strength is a mean of the eight
    /// nearest, the nearer the more. Not with the paper's method.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strength_points: Vec<StrengthPointDesc>,
    /// Triangles between these points, by their numbers from 0 on, as those of a painted mesh:
    /// strength is then that of the nearest triangle, linear between its corners.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strength_triangles: Vec<[u32; 3]>,
}

/// The strength of a body: an impulse, or its material's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a number in N s, the name of a material (glass, concrete, brick, wood, ice), or its properties: \
    tensile_strength, youngs_modulus and fracture_energy"
)]
pub enum StrengthDesc {
    /// The largest impulse in one collision, from 1e-15 to 1e12 [N s] [Su09 sec. 4.2]. Fragments
    /// have twice their parent's.
    Impulse(f64),
    /// A material of a table.
    Named(MaterialName),
    /// A custom material.
    Material(MaterialDesc),
}

impl From<f64> for StrengthDesc {
    fn from(impulse: f64) -> Self {
        Self::Impulse(impulse)
    }
}

/// Fracture properties of a material. The energy of a blow limits its number of pieces: cracks take
/// their energy from the bodies' relative motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialDesc {
    /// Tensile strength of the whole body; fragments are stronger [Pa].
    pub tensile_strength: f64,
    /// Young's modulus; with the density it gives the speed of sound [Pa].
    pub youngs_modulus: f64,
    /// Fracture energy per crack area [J/m^2].
    pub fracture_energy: f64,
    /// Weibull modulus m, the uniformity of flaws: strength grows as the power -1/m of the volume
    /// [Wei51].
    #[serde(default = "defaults::weibull_modulus")]
    pub weibull_modulus: f64,
}

/// Materials of the table, without densities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MaterialName {
    /// Soda-lime glass.
    Glass,
    /// Plain concrete.
    Concrete,
    /// Fired clay.
    Brick,
    /// Softwood, across the grain.
    Wood,
    /// Of water, at -10 degrees.
    Ice,
}

impl MaterialName {
    /// Usual values of tensile strength, Young's modulus and fracture energy [Ashby11] [CEB90].
    pub fn properties(self) -> MaterialDesc {
        let [tensile_strength, youngs_modulus, fracture_energy] = match self {
            Self::Glass => [45e6, 70e9, 8.0],
            Self::Concrete => [3e6, 30e9, 100.0],
            Self::Brick => [2.5e6, 15e9, 50.0],
            Self::Wood => [4e6, 0.8e9, 200.0],
            Self::Ice => [1e6, 9e9, 1.0],
        };
        let weibull_modulus = defaults::weibull_modulus();
        MaterialDesc { tensile_strength, youngs_modulus, fracture_energy, weibull_modulus }
    }
}

/// A body of glued pieces: a bond at each common face of two pieces. It moves as one body until
/// bonds break.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondsDesc {
    /// Pattern that cuts the body into pieces. Without it, the parts of a compound are the pieces,
    /// or the closed parts of a mesh, as `frangible break` writes them: a file or a folder of OBJ
    /// files.
    #[serde(default)]
    pub pattern: Option<PatternDesc>,
    /// Point of the shape at the pattern's centre, in the shape's own frame [m]; by default the
    /// middle of the shape.
    #[serde(default)]
    pub point: Option<[f64; 3]>,
    /// Direction of the pattern's normal, in the shape's frame; need not be of unit length.
    #[serde(default = "defaults::up")]
    pub normal: [f64; 3],
    /// Tensile strength of a bond, in pulling and bending [Pa].
    pub tensile_strength: f64,
    /// Shear strength of a bond, in shearing and twisting [Pa].
    pub shear_strength: f64,
    /// Pieces with their centre in one of these boxes are fixed to the world. Without any, the body
    /// moves freely.
    #[serde(default)]
    pub anchors: Vec<AnchorDesc>,
    /// Points at which bonds are stronger or weaker, as those of `breaking`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strength_points: Vec<StrengthPointDesc>,
    /// Triangles between these points, as those of `breaking`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strength_triangles: Vec<[u32; 3]>,
}

/// A fixing box along the world's axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnchorDesc {
    /// Lowest corner [m].
    pub low: [f64; 3],
    /// Highest corner [m].
    pub high: [f64; 3],
}

/// Pattern of prescored space [Su09 sec. 4.3]: a generator with its parameters, each of which has a
/// default, or a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum PatternDesc {
    /// Wedges around the line of impact, and rings, as glass breaks.
    Radial(Radial),
    /// Voronoi cells.
    Voronoi(Voronoi),
    /// Rubble, as rock breaks.
    Natural(Natural),
    /// Slices across an axis.
    Slices(Slices),
    /// Bricks and mortar.
    Bricks(Bricks),
    /// Splinters along a grain, as wood breaks.
    Splinters(Splinters),
    /// Voronoi cells with rough faces.
    Concrete(Concrete),
    /// A saved or drawn pattern.
    File(PatternFile),
}

/// File of a pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatternFile {
    /// Input of [`Pattern::load`](frangible_fracture::Pattern::load): a saved pattern, or a mesh
    /// file, in which each closed part is a cell.
    pub path: PathBuf,
}

impl BreakingDesc {
    /// Breaks once.
    pub fn once(strength: impl Into<StrengthDesc>, pattern: PatternDesc) -> Self {
        let generations = defaults::generations();
        Self {
            strength: strength.into(),
            pattern,
            pieces: None,
            generations,
            smallest: 0.0,
            reach: None,
            point: None,
            twist: 0.0,
            strength_points: Vec::new(),
            strength_triangles: Vec::new(),
        }
    }
}
