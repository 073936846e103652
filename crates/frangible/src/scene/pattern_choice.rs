//! The patterns that a body may break by, and what a snapshot needs to make them again.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::breaking::{PatternDesc, PatternFile};
use crate::scene::fineness::{Fineness, Found};
use crate::scene::patterns::build_pattern;
use frangible_fracture::{Fragment, MOST_CELLS, Pattern};
use frangible_math::check::{Check, Checked};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// A break need not meet the number of pieces that is asked for more closely: each try costs a
/// break.
const PIECES_WITHIN: f64 = 0.1;

/// Most rough patterns that are laid for a break.
const MOST_ROUGH: usize = 3;

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

    /// Steps with a pattern: at first as fine as described, then ever coarser.
    pub(crate) fn steps(&self) -> usize {
        match &self.pieces {
            // Halved down to two or three pieces.
            Some((pieces, _)) => pieces.checked_ilog2().map_or(0, |halvings| halvings as usize),
            None => self.patterns.len(),
        }
    }

    /// The break of a step, in plain faces where a number of pieces is sought among rough ones.
    pub(crate) fn draft(
        &self,
        step: usize,
        shatter: impl Fn(&Pattern) -> Vec<Fragment>,
    ) -> Option<Draft> {
        let Some((pieces, fineness)) = &self.pieces else {
            let pattern = self.patterns.get(step)?.clone();
            let fragments = shatter(&pattern);
            return Some(Draft { pattern, fragments, wanted: None });
        };
        let wanted = Some(pieces >> step).filter(|&wanted| wanted >= 2)?;
        let found = search(fineness, wanted, shatter)?;
        let is_rough = found.pattern.without_roughness().is_some();
        let wanted = is_rough.then_some(wanted);
        Some(Draft { pattern: found.pattern, fragments: found.made, wanted })
    }

    /// The break of a draft with its own faces: rough ones are laid once or a few times, as slivers
    /// may join in another way than between plain ones.
    pub(crate) fn finish(
        &self,
        draft: Draft,
        shatter: impl Fn(&Pattern) -> Vec<Fragment>,
    ) -> (Arc<Pattern>, Vec<Fragment>) {
        let (Some(wanted), Some((_, fineness))) = (draft.wanted, &self.pieces) else {
            return (draft.pattern, draft.fragments);
        };
        let off = |count: usize| count.abs_diff(wanted);
        let mut best = (draft.pattern.clone(), shatter(&draft.pattern));
        let (mut target, mut count) = (wanted, best.1.len());
        for _ in 1..MOST_ROUGH {
            if off(best.1.len()) as f64 <= PIECES_WITHIN * wanted as f64 {
                break;
            }
            target = (target * wanted).div_ceil(count.max(1));
            let Some(found) = search(fineness, target, &shatter) else { break };
            let fragments = shatter(&found.pattern);
            count = fragments.len();
            if off(count) < off(best.1.len()) {
                best = (found.pattern, fragments);
            }
        }
        best
    }
}

/// A break before it is known whether the blow has energy for its cracks.
pub(crate) struct Draft {
    pattern: Arc<Pattern>,
    /// In plain faces.
    pub(crate) fragments: Vec<Fragment>,
    /// Number of pieces, if the faces are rough in the end.
    wanted: Option<usize>,
}

impl Draft {
    /// True if the faces are rough in the end.
    pub(crate) fn is_plain(&self) -> bool {
        self.wanted.is_some()
    }
}

/// Searches the pattern for a number of pieces. Rough cells make about as many with plain faces,
/// without the noise that each pattern of the search would have to sample: 30 pieces of concrete in
/// 64 voxels took 0.4 s, and 2 s where the blow had no energy for them.
fn search(
    fineness: &Fineness,
    wanted: usize,
    shatter: impl Fn(&Pattern) -> Vec<Fragment>,
) -> Option<Found<Vec<Fragment>>> {
    fineness.search(wanted, PIECES_WITHIN, |pattern| {
        let plain = pattern.without_roughness();
        let fragments = shatter(plain.as_ref().unwrap_or(pattern));
        (fragments.len(), fragments)
    })
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

impl Check for PatternChoice {
    fn check(&self) -> Checked {
        // Its description is checked before the patterns are made.
        Ok(())
    }
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
        let pieces = record.pieces.map(|pieces| at.field("pieces").count(pieces, 2, MOST_CELLS));
        let pieces = pieces.transpose().map_err(|error| error.to_string())?;
        let pattern = match &record.loaded {
            Some(text) => Pattern::of_json(text)?,
            None => build_pattern(&desc, &at).map_err(|error| error.to_string())?,
        };
        Self::of_pattern(&desc, pattern, (pieces, record.has_coarser), &at)
            .map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_fracture::{Concrete, Impact, ShatterSettings, shatter};
    use frangible_geometry::{ClosedForm, GridSolid, Shape};
    use glam::DVec3;
    use std::cell::Cell;

    /// A number of pieces of concrete is found among plain faces; rough ones are laid a few times
    /// at most, and only where a draft is to be finished.
    #[test]
    fn rough_pieces_are_counted_in_plain_faces() {
        let form = ClosedForm::Box { half: DVec3::new(0.5, 0.3, 0.2) };
        let solid = GridSolid::from_closed_form(form, [30, 18, 12], 2).unwrap();
        let body = Shape::from_grid_solid(solid, Vec::new()).unwrap();
        let impact = Impact { point_body: DVec3::new(0.1, 0.1, 0.2), normal_body: DVec3::Z };
        let laid = Cell::new(0);
        let cut = |pattern: &Pattern| {
            laid.set(laid.get() + usize::from(pattern.without_roughness().is_some()));
            shatter(&body, pattern, &impact, &ShatterSettings::default())
        };
        for pieces in [8, 20, 40] {
            let concrete = PatternDesc::Concrete(Concrete::default());
            let at = Checker::root().field("pattern");
            let choice = PatternChoice::new(&concrete, Some(pieces), true, &at).unwrap();
            laid.set(0);
            let draft = choice.draft(0, cut).unwrap();
            assert!(draft.is_plain() && laid.get() == 0, "{pieces}: {}", laid.get());
            let (pattern, fragments) = choice.finish(draft, cut);
            assert!((1..=MOST_ROUGH).contains(&laid.get()), "{pieces}: {}", laid.get());
            let off = fragments.len().abs_diff(pieces) as f64;
            assert!(off <= PIECES_WITHIN * pieces as f64, "{} of {pieces}", fragments.len());
            assert!(pattern.without_roughness().is_some());
            let steps = choice.steps();
            assert!(choice.draft(steps - 1, cut).is_some() && choice.draft(steps, cut).is_none());
        }
    }
}
