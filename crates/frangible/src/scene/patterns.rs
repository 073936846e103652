//! Patterns by description, by name and from files.

use crate::scene::check::{BuildError, Checker, nearest};
use crate::scene::desc::breaking::{PatternDesc, PatternFile};
use frangible_fracture::{
    Bricks, Concrete, Filling, MOST_CELLS, Natural, Pattern, Radial, Slices, Splinters, Voronoi,
};

/// A generator known to [`PatternDesc::named`].
struct Kind {
    name: &'static str,
    caption: &'static str,
    /// Makes a pattern with a number of cells, and a seed.
    make: fn(Option<usize>, Option<u64>) -> PatternDesc,
}

/// Fills in what was given over the default.
macro_rules! with_cells {
    ($kind:ident) => {
        |cells, seed| {
            let default = $kind::default();
            let (cells, seed) = (cells.unwrap_or(default.cells), seed.unwrap_or(default.seed));
            PatternDesc::$kind($kind { cells, seed, ..default })
        }
    };
}

const KINDS: &[Kind] = &[
    Kind { name: "radial", caption: "spokes and rings around the blow: glass", make: radial },
    Kind { name: "voronoi", caption: "cells of random points: stone", make: with_cells!(Voronoi) },
    Kind {
        name: "natural",
        caption: "rock that cracked again and again: rubble",
        make: with_cells!(Natural),
    },
    Kind { name: "slices", caption: "parallel cracks: slate", make: with_cells!(Slices) },
    Kind { name: "bricks", caption: "running bond with mortar: masonry", make: bricks },
    Kind { name: "splinters", caption: "long pointed pieces along a grain: wood", make: splinters },
    Kind {
        name: "concrete",
        caption: "cells with rough faces: concrete",
        make: with_cells!(Concrete),
    },
];

impl PatternDesc {
    /// Name and one line for each generator.
    pub fn names() -> impl Iterator<Item = (&'static str, &'static str)> {
        KINDS.iter().map(|kind| (kind.name, kind.caption))
    }

    /// A generator by its name, with about so many cells.
    ///
    /// # Errors
    /// If there is none of this name; the sentence lists those that there are.
    pub fn named(name: &str, cells: Option<usize>, seed: Option<u64>) -> Result<Self, BuildError> {
        let Some(kind) = KINDS.iter().find(|kind| kind.name == name) else {
            let names: Vec<&str> = Self::names().map(|(name, _)| name).collect();
            let near = nearest(name, &names);
            let rule = format!(
                "one of {} (or a file: .json, .obj, .gltf or .glb){near}",
                names.join(", ")
            );
            return Err(Checker::root().field("pattern").broken(name, &rule));
        };
        if cells == Some(0) {
            return Err(Checker::root().field("cells").broken("0", "at least 1"));
        }
        Ok((kind.make)(cells, seed))
    }

    /// Makes the pattern, or loads it.
    ///
    /// # Errors
    /// The first rule that is broken.
    pub fn pattern(&self) -> Result<Pattern, BuildError> {
        build_pattern(self, &Checker::root())
    }
}

impl PatternDesc {
    /// The same pattern with about `cells` cells and its other parameters; `None` for a file.
    pub fn with_cells(&self, cells: usize) -> Option<Self> {
        Some(match self {
            Self::Radial(radial) => {
                // Keep the number of spokes, and scale the rings.
                let rings = (cells as f64 / radial.spokes.max(3) as f64).round().max(1.0);
                let spokes = ((cells as f64 / rings).round() as usize).max(3);
                Self::Radial(Radial { spokes, rings: rings as usize - 1, ..radial.clone() })
            }
            Self::Voronoi(voronoi) => Self::Voronoi(Voronoi { cells, ..voronoi.clone() }),
            Self::Natural(natural) => Self::Natural(Natural { cells, ..natural.clone() }),
            Self::Slices(slices) => Self::Slices(Slices { cells, ..slices.clone() }),
            Self::Bricks(bricks) => Self::Bricks(more_bricks(bricks, cells)),
            Self::Splinters(splinters) => {
                let fibres = cells.div_ceil(splinters.pieces.max(1));
                Self::Splinters(Splinters { fibres, ..splinters.clone() })
            }
            Self::Concrete(concrete) => Self::Concrete(Concrete { cells, ..concrete.clone() }),
            Self::File(_) => return None,
        })
    }

    /// The same pattern made for a solid, with about `cells` cells that meet it; `None` for a file.
    pub fn in_solid(&self, cells: usize, filling: &Filling) -> Option<Pattern> {
        Some(match self {
            Self::Radial(radial) => Pattern::radial_in(radial, cells, filling),
            Self::Voronoi(voronoi) => {
                Pattern::voronoi_in(&Voronoi { cells, ..voronoi.clone() }, filling)
            }
            Self::Natural(natural) => {
                Pattern::natural_in(&Natural { cells, ..natural.clone() }, filling)
            }
            Self::Slices(slices) => {
                Pattern::slices_in(&Slices { cells, ..slices.clone() }, filling)
            }
            Self::Bricks(bricks) => Pattern::bricks_in(bricks, cells, filling),
            Self::Splinters(splinters) => Pattern::splinters_in(splinters, cells, filling),
            Self::Concrete(concrete) => {
                Pattern::concrete_in(&Concrete { cells, ..concrete.clone() }, filling)
            }
            Self::File(_) => return None,
        })
    }

    /// Of its random numbers; `None` for a file.
    pub fn seed(&self) -> Option<u64> {
        match self {
            Self::Radial(radial) => Some(radial.seed),
            Self::Voronoi(voronoi) => Some(voronoi.seed),
            Self::Natural(natural) => Some(natural.seed),
            Self::Slices(slices) => Some(slices.seed),
            Self::Bricks(bricks) => Some(bricks.seed),
            Self::Splinters(splinters) => Some(splinters.seed),
            Self::Concrete(concrete) => Some(concrete.seed),
            Self::File(_) => None,
        }
    }

    /// True for patterns whose cells keep their form and their place on a body: blows with a reach
    /// take whole cells out.
    pub(crate) fn has_cells_of_its_own(&self) -> bool {
        matches!(self, Self::Bricks(_) | Self::Slices(_) | Self::File(_))
    }

    /// The same pattern with half as many cells; `None` for patterns without coarser versions:
    /// masonry breaks along its joints, and a file is fixed.
    pub(crate) fn coarser(&self) -> Option<Self> {
        let halved = |cells: usize, least: usize| (cells > least).then_some((cells / 2).max(least));
        match self {
            Self::Radial(radial) if radial.rings > 0 => {
                Some(Self::Radial(Radial { rings: radial.rings / 2, ..radial.clone() }))
            }
            Self::Radial(radial) => halved(radial.spokes, 3)
                .map(|spokes| Self::Radial(Radial { spokes, ..radial.clone() })),
            Self::Voronoi(voronoi) => halved(voronoi.cells, 2)
                .map(|cells| Self::Voronoi(Voronoi { cells, ..voronoi.clone() })),
            Self::Natural(natural) => halved(natural.cells, 2)
                .map(|cells| Self::Natural(Natural { cells, ..natural.clone() })),
            Self::Slices(slices) => halved(slices.cells, 2)
                .map(|cells| Self::Slices(Slices { cells, ..slices.clone() })),
            Self::Splinters(splinters) => halved(splinters.fibres, 2)
                .map(|fibres| Self::Splinters(Splinters { fibres, ..splinters.clone() })),
            Self::Concrete(concrete) => halved(concrete.cells, 2)
                .map(|cells| Self::Concrete(Concrete { cells, ..concrete.clone() })),
            Self::Bricks(_) | Self::File(_) => None,
        }
    }
}

/// Twelve spokes and as many rings as needed; fewer spokes for few cells.
fn radial(cells: Option<usize>, seed: Option<u64>) -> PatternDesc {
    let default = Radial::default();
    let seed = seed.unwrap_or(default.seed);
    let Some(cells) = cells else { return PatternDesc::Radial(Radial { seed, ..default }) };
    let spokes = cells.clamp(3, default.spokes);
    let rings = (cells as f64 / spokes as f64).round().max(1.0) as usize - 1;
    PatternDesc::Radial(Radial { spokes, rings, seed, ..default })
}

/// Bricks of the usual proportions.
fn bricks(cells: Option<usize>, seed: Option<u64>) -> PatternDesc {
    let default = Bricks::default();
    let seed = seed.unwrap_or(default.seed);
    let usual = Bricks { seed, ..default };
    PatternDesc::Bricks(cells.map_or(usual.clone(), |cells| more_bricks(&usual, cells)))
}

/// Bricks with about `cells` cells, or slightly more in better proportions: the same number of
/// courses per column.
fn more_bricks(bricks: &Bricks, cells: usize) -> Bricks {
    // Weight of proportions: twice the courses per column count like this relative error in cells.
    const PROPORTIONS: f64 = 0.05;
    let wanted = cells.max(1) as f64;
    let proportions = bricks.courses.max(1) as f64 / bricks.columns.max(1) as f64;
    let off = |columns: usize, courses: usize| {
        let laid = courses * columns + courses / 2;
        // Each brick has a joint above it, and beside it if another follows.
        let made = if bricks.mortar > 0.0 { 3 * laid - courses } else { laid };
        let turned = libm::log2(courses as f64 / columns as f64 / proportions).abs();
        (made as f64 / wanted - 1.0).abs() + PROPORTIONS * turned
    };
    let most_columns = (wanted.sqrt() as usize + 1).min(MOST_CELLS);
    let (columns, courses) = (1..=most_columns)
        .flat_map(|columns| {
            let of_course = if bricks.mortar > 0.0 { 3 * columns } else { columns };
            let near = cells / of_course;
            [near.max(1), near + 1].map(|courses| (columns, courses))
        })
        .chain((1..=most_columns).map(|columns| (columns, (cells / (3 * columns + 1)).max(1))))
        .min_by(|a, b| off(a.0, a.1).total_cmp(&off(b.0, b.1)))
        .unwrap_or((1, 1));
    Bricks { columns, courses, ..bricks.clone() }
}

/// Each splinter in two pieces.
fn splinters(cells: Option<usize>, seed: Option<u64>) -> PatternDesc {
    let default = Splinters::default();
    let seed = seed.unwrap_or(default.seed);
    let fibres = cells.map_or(default.fibres, |cells| cells.div_ceil(default.pieces));
    PatternDesc::Splinters(Splinters { fibres, seed, ..default })
}

pub(crate) fn build_pattern(desc: &PatternDesc, at: &Checker) -> Result<Pattern, BuildError> {
    let made = match desc {
        PatternDesc::Radial(radial) => Pattern::radial(radial),
        PatternDesc::Voronoi(voronoi) => Pattern::voronoi(voronoi),
        PatternDesc::Natural(natural) => Pattern::natural(natural),
        PatternDesc::Slices(slices) => Pattern::slices(slices),
        PatternDesc::Bricks(bricks) => Pattern::bricks(bricks),
        PatternDesc::Splinters(splinters) => Pattern::splinters(splinters),
        PatternDesc::Concrete(concrete) => Pattern::concrete(concrete),
        PatternDesc::File(PatternFile { path }) => Pattern::load(path),
    };
    made.map_err(|error| at.pattern(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every name makes a pattern with about as many cells as asked for, and itself from JSON with
    /// the kind alone.
    #[test]
    fn names_make_patterns_of_the_size_that_is_asked_for() {
        for (name, _) in PatternDesc::names() {
            for cells in [12, 50, 200] {
                let desc = PatternDesc::named(name, Some(cells), Some(3)).unwrap();
                let made = desc.pattern().unwrap().len() as f64 / cells as f64;
                assert!((0.7..1.4).contains(&made), "{name}: {made} of {cells}");
            }
            let plain: PatternDesc =
                serde_json::from_str(&format!("{{\"kind\": \"{name}\"}}")).unwrap();
            assert_eq!(plain, PatternDesc::named(name, None, None).unwrap());
        }
    }

    #[test]
    fn sentences_name_the_field_the_value_and_the_rule() {
        let sentence = |json: &str| {
            let desc: Result<PatternDesc, _> =
                crate::scene::desc::read::read(serde_json::from_str(json).unwrap(), "");
            desc.map_or_else(
                |error| error.to_string(),
                |desc| desc.pattern().unwrap_err().to_string(),
            )
        };
        assert_eq!(
            sentence(r#"{"kind": "natural", "spread": 2}"#),
            "spread: 2, must be from 0 to 1"
        );
        assert_eq!(sentence(r#"{"kind": "file", "path": "no.json"}"#), "no.json: no such file");
        let unknown = sentence(r#"{"kind": "bricks", "course": 2}"#);
        assert!(unknown.starts_with("course: an unknown field, must be one of "), "{unknown}");
        assert!(unknown.ends_with("(did you mean 'courses'?)"), "{unknown}");
        assert_eq!(
            sentence(r#"{"kind": "radail"}"#),
            "kind: \"radail\", must be one of radial, voronoi, natural, slices, bricks, splinters, concrete, file \
             (did you mean 'radial'?)"
        );
        assert_eq!(
            PatternDesc::named("bubbles", None, None).unwrap_err().to_string(),
            "pattern: bubbles, must be one of radial, voronoi, natural, slices, bricks, splinters, concrete \
             (or a file: .json, .obj, .gltf or .glb)"
        );
    }

    /// Halving comes to an end, with fewer cells each time.
    #[test]
    fn coarser_patterns_have_fewer_cells() {
        for (name, _) in PatternDesc::names() {
            let mut desc = PatternDesc::named(name, Some(60), None).unwrap();
            let mut cells = desc.pattern().unwrap().len();
            while let Some(coarser) = desc.coarser() {
                let fewer = coarser.pattern().unwrap().len();
                assert!(fewer < cells, "{name}: {fewer} after {cells}");
                (desc, cells) = (coarser, fewer);
            }
        }
    }
}
