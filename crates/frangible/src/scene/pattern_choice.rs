//! The patterns that a body may break by, and what a snapshot needs to make them again.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::breaking::{PatternDesc, PatternFile};
use crate::scene::fineness::Fineness;
use crate::scene::patterns::build_pattern;
use frangible_fracture::{Fragment, Pattern};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// A break need not meet the number of pieces that is asked for more closely: each try costs a
/// break.
const PIECES_WITHIN: f64 = 0.1;

/// Patterns of prescored space, shared by a body and its fragments.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "ChoiceRecord", into = "ChoiceRecord")]
pub struct PatternChoice {
    desc: PatternDesc,
    /// First as described, then ever coarser, for blows with less energy than all cracks need.
    patterns: Vec<Arc<Pattern>>,
    /// Number of pieces, if given, and the patterns to choose from.
    pieces: Option<(usize, Arc<Fineness>)>,
    has_coarser: bool,
}

impl PatternChoice {
    /// Makes or loads what is described: with `pieces` for a number of pieces, with `has_coarser`
    /// coarser patterns too.
    ///
    /// # Errors
    /// The first rule that a parameter breaks.
    pub(crate) fn new(
        desc: &PatternDesc,
        pieces: Option<usize>,
        has_coarser: bool,
        at: &Checker,
    ) -> Result<Self, BuildError> {
        Self::of_pattern(desc, build_pattern(desc, at)?, (pieces, has_coarser), at)
    }

    fn of_pattern(
        desc: &PatternDesc,
        pattern: Pattern,
        (pieces, has_coarser): (Option<usize>, bool),
        at: &Checker,
    ) -> Result<Self, BuildError> {
        let mut patterns = vec![Arc::new(pattern)];
        let fineness = || Arc::new(Fineness::new(desc.clone(), patterns[0].clone()));
        let pieces = pieces.map(|pieces| (pieces, fineness()));
        if has_coarser {
            let mut coarser = desc.coarser();
            while let Some(pattern) = coarser {
                patterns.push(Arc::new(build_pattern(&pattern, at)?));
                coarser = pattern.coarser();
            }
        }
        patterns.iter().for_each(|pattern| pattern.prepare());
        Ok(Self { desc: desc.clone(), patterns, pieces, has_coarser })
    }

    /// True if all cracks are planes.
    pub(crate) fn is_planar(&self) -> bool {
        self.patterns.iter().all(|pattern| pattern.planar().is_some())
    }

    /// Number of pieces, if given.
    pub fn wanted(&self) -> Option<usize> {
        self.pieces.as_ref().map(|(wanted, _)| *wanted)
    }

    /// The pattern of a step, at first as fine as described, then ever coarser, and the fragments
    /// that it makes; `None` beyond the coarsest.
    pub(crate) fn cut(
        &self,
        step: usize,
        shatter: impl Fn(&Pattern) -> Vec<Fragment>,
    ) -> Option<(Arc<Pattern>, Vec<Fragment>)> {
        let Some((pieces, fineness)) = &self.pieces else {
            return self.patterns.get(step).map(|pattern| (pattern.clone(), shatter(pattern)));
        };
        let wanted = pieces >> step.min(usize::BITS as usize - 1);
        if wanted < 2 {
            return None;
        }
        let attempt = |pattern: &Pattern| {
            let fragments = shatter(pattern);
            (fragments.len(), fragments)
        };
        let found = fineness.search(wanted, PIECES_WITHIN, attempt)?;
        Some((found.pattern, found.made))
    }
}

/// Form of the choice in a snapshot: the description, for a generator makes the same pattern again, and a
/// pattern that came from a file.
#[derive(Clone, Serialize, Deserialize)]
struct ChoiceRecord {
    /// JSON.
    desc: String,
    /// JSON.
    loaded: Option<String>,
    pieces: Option<usize>,
    has_coarser: bool,
}

impl From<PatternChoice> for ChoiceRecord {
    fn from(choice: PatternChoice) -> Self {
        let text = |value: &PatternDesc| serde_json::to_string(value).unwrap_or_default();
        let (desc, loaded) = match &choice.desc {
            // The file may be gone by then.
            PatternDesc::File(_) => (
                text(&PatternDesc::File(PatternFile { path: PathBuf::new() })),
                serde_json::to_string(&*choice.patterns[0]).ok(),
            ),
            desc => (text(desc), None),
        };
        Self { desc, loaded, pieces: choice.wanted(), has_coarser: choice.has_coarser }
    }
}

impl TryFrom<ChoiceRecord> for PatternChoice {
    type Error = String;

    fn try_from(record: ChoiceRecord) -> Result<Self, String> {
        let desc: PatternDesc =
            serde_json::from_str(&record.desc).map_err(|error| error.to_string())?;
        let at = Checker::root().field("pattern");
        let pattern = match &record.loaded {
            Some(text) => serde_json::from_str(text).map_err(|error| error.to_string())?,
            None => build_pattern(&desc, &at).map_err(|error| error.to_string())?,
        };
        Self::of_pattern(&desc, pattern, (record.pieces, record.has_coarser), &at)
            .map_err(|error| error.to_string())
    }
}
