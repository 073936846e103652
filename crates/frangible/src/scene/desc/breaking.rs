//! How bodies break, and what holds glued pieces together.

use crate::scene::desc::defaults;
use frangible_fracture::{Bricks, Concrete, Natural, Radial, Slices, Splinters, Voronoi};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How a body breaks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BreakingDesc {
    /// What it bears.
    pub strength: StrengthDesc,
    /// How space is prescored.
    pub pattern: PatternDesc,
    /// Into about how many pieces each break cuts what is struck, from 2 to 10000: the pattern gets as many cells as that takes where
    /// the blow lands, or, from a file, is magnified. Unless told otherwise the pattern is as it is described.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pieces: Option<usize>,
    /// How many times in a row: 1 means that fragments do not break.
    #[serde(default = "defaults::generations")]
    pub generations: u32,
    /// Fragments whose longest side is shorter do not break again [m].
    #[serde(default)]
    pub smallest: f64,
}

/// The strength of a body: an impulse, or its material's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a number in N s, the name of a material (glass, concrete, brick, wood, ice), or its properties: \
    tensile_strength, youngs_modulus and fracture_energy"
)]
pub enum StrengthDesc {
    /// The largest impulse in one collision, from 1e-15 to 1e12 [N s] [Su09 sec. 4.2]. Fragments bear
    /// twice their parent's.
    Impulse(f64),
    /// A material of a table.
    Named(MaterialName),
    /// A material of one's own.
    Material(MaterialDesc),
}

impl From<f64> for StrengthDesc {
    fn from(impulse: f64) -> Self {
        Self::Impulse(impulse)
    }
}

/// The numbers that decide how a material breaks. The pieces that a blow can make are bounded by its energy: cracks take it from the bodies'
/// relative motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialDesc {
    /// Of a body as it is described; its fragments are stronger [Pa].
    pub tensile_strength: f64,
    /// With the density it decides the speed of sound [Pa].
    pub youngs_modulus: f64,
    /// For each square metre of crack [J/m^2].
    pub fracture_energy: f64,
    /// How alike its flaws are: strength grows as the power -1/m of the volume [Wei51].
    #[serde(default = "defaults::weibull_modulus")]
    pub weibull_modulus: f64,
}

/// Materials of the table. Densities are the body's own business.
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

/// A body of glued pieces: a bond for each face that two of them share. It moves as one body until bonds break.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondsDesc {
    /// How a box, a hull or a compound is cut into pieces; without it, a compound's parts are the pieces.
    #[serde(default)]
    pub pattern: Option<PatternDesc>,
    /// What the pattern's centre is laid on, in the shape's own frame [m]; the middle of the shape, unless told otherwise.
    #[serde(default)]
    pub point: Option<[f64; 3]>,
    /// Along which the pattern's own normal is laid, in the shape's frame; need not be of unit length.
    #[serde(default = "defaults::up")]
    pub normal: [f64; 3],
    /// The stress across a bond, by pulling and bending, that it bears [Pa].
    pub tensile_strength: f64,
    /// The stress along a bond, by shearing and twisting, that it bears [Pa].
    pub shear_strength: f64,
    /// Pieces whose centre lies in one of these boxes are fixed to the world. Without any, the body moves freely.
    #[serde(default)]
    pub anchors: Vec<AnchorDesc>,
}

/// A box along the world's axes, where things are fixed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnchorDesc {
    /// Lowest corner [m].
    pub low: [f64; 3],
    /// Highest corner [m].
    pub high: [f64; 3],
}

/// How space is prescored [Su09 sec. 4.3]: a generator with its parameters, each of which has a default, or a file.
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
    /// A pattern that was saved, or drawn.
    File(PatternFile),
}

/// Where a pattern is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatternFile {
    /// What [`Pattern::load`](frangible_fracture::Pattern::load) reads: a pattern that was saved, or a mesh file, each closed part of
    /// which is a cell.
    pub path: PathBuf,
}

impl BreakingDesc {
    /// Breaks once.
    pub fn once(strength: impl Into<StrengthDesc>, pattern: PatternDesc) -> Self {
        let generations = defaults::generations();
        Self { strength: strength.into(), pattern, pieces: None, generations, smallest: 0.0 }
    }
}
