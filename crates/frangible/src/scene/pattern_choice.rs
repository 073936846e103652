//! The patterns that a body may break by, and what a snapshot needs to make them again.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::breaking::{PatternDesc, PatternFile};
use crate::scene::fineness::{Fineness, Found};
use crate::scene::patterns::build_pattern;
use frangible_fracture::{
    Filling, Fragment, Impact, MOST_CELLS, Pattern, ShatterSettings, shatter,
};
use frangible_geometry::Shape;
use frangible_math::check::{Check, Checked};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// A break need not meet the number of pieces that is asked for more closely: each try costs a
/// break.
const PIECES_WITHIN: f64 = 0.1;

/// Of the mean piece where a number of pieces is asked for: smaller ones join a neighbour, and are
/// not counted where they lie loose.
pub(crate) const LEAST_PIECE: f64 = 0.01;

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
    pub(crate) fn draft(&self, step: usize, struck: &Struck<'_>) -> Option<Draft> {
        let shatter = |pattern: &Pattern| struck.broken_by(pattern);
        let Some((pieces, fineness)) = &self.pieces else {
            let pattern = self.patterns.get(step)?.clone();
            let fragments = shatter(&pattern);
            return Some(Draft { pattern, fragments, wanted: None, filling: None });
        };
        let wanted = Some(pieces >> step).filter(|&wanted| wanted >= 2)?;
        let filling = struck.filling(wanted, &self.desc);
        let found = search(fineness, filling.as_ref(), wanted, shatter)?;
        let is_rough = found.pattern.without_roughness().is_some();
        let wanted = is_rough.then_some(wanted);
        Some(Draft { pattern: found.pattern, fragments: found.made, wanted, filling })
    }

    /// The break of a draft with its own faces: rough ones are laid once or a few times, as slivers
    /// may join in another way than between plain ones.
    pub(crate) fn finish(
        &self,
        draft: Draft,
        struck: &Struck<'_>,
    ) -> (Arc<Pattern>, Vec<Fragment>) {
        let shatter = |pattern: &Pattern| struck.broken_by(pattern);
        let (Some(wanted), Some((_, fineness))) = (draft.wanted, &self.pieces) else {
            return (draft.pattern, draft.fragments);
        };
        let off = |count: usize| count.abs_diff(wanted);
        let mut best = (draft.pattern.clone(), shatter(&draft.pattern));
        let mut best_count = counted(&best.1, wanted);
        let (mut target, mut count) = (wanted, best_count);
        for _ in 1..MOST_ROUGH {
            if off(best_count) as f64 <= PIECES_WITHIN * wanted as f64 {
                break;
            }
            target = (target * wanted).div_ceil(count.max(1));
            let filling = draft.filling.as_ref();
            let Some(found) = search(fineness, filling, target, shatter) else { break };
            let fragments = shatter(&found.pattern);
            count = counted(&fragments, wanted);
            if off(count) < off(best_count) {
                best = (found.pattern, fragments);
                best_count = count;
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
    /// What the pattern was made for.
    filling: Option<Filling>,
}

/// A body that is to break, and the blow.
pub(crate) struct Struck<'a> {
    pub(crate) shape: &'a Shape,
    pub(crate) impact: Impact,
    pub(crate) settings: &'a ShatterSettings,
}

impl Struck<'_> {
    fn broken_by(&self, pattern: &Pattern) -> Vec<Fragment> {
        shatter(self.shape, pattern, &self.impact, self.settings)
    }

    /// What a pattern for so many pieces is made for; `None` for one from a file.
    fn filling(&self, wanted: usize, desc: &PatternDesc) -> Option<Filling> {
        Filling::of_body(self.shape, &self.impact, self.settings, (wanted, desc.seed()?))
    }
}

/// Number of pieces without slivers and crumbs: of what comes loose and of what a reach leaves.
pub(crate) fn counted(fragments: &[Fragment], wanted: usize) -> usize {
    let loose = || fragments.iter().filter(|fragment| !fragment.is_rest());
    let volume: f64 = loose().map(|fragment| fragment.shape.volume).sum();
    let least = LEAST_PIECE * volume / wanted as f64;
    let slivers = loose().filter(|fragment| fragment.shape.volume < least).count();
    fragments.len() - slivers
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
    filling: Option<&Filling>,
    wanted: usize,
    shatter: impl Fn(&Pattern) -> Vec<Fragment>,
) -> Option<Found<Vec<Fragment>>> {
    fineness.search_in(filling, (wanted, PIECES_WITHIN), |pattern| {
        let plain = pattern.without_roughness();
        let fragments = shatter(plain.as_ref().unwrap_or(pattern));
        (counted(&fragments, wanted), fragments)
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
    use frangible_fracture::Concrete;
    use frangible_geometry::{ClosedForm, GridSolid};
    use glam::DVec3;

    /// A number of pieces of concrete is found among plain faces; rough ones are laid a few times
    /// at most, and only where a draft is to be finished.
    #[test]
    fn rough_pieces_are_counted_in_plain_faces() {
        let form = ClosedForm::Box { half: DVec3::new(0.5, 0.3, 0.2) };
        let solid = GridSolid::from_closed_form(form, [30, 18, 12], 2).unwrap();
        let body = Shape::from_grid_solid(solid, Vec::new()).unwrap();
        let impact = Impact { point_body: DVec3::new(0.1, 0.1, 0.2), normal_body: DVec3::Z };
        let settings = ShatterSettings::default();
        let struck = Struck { shape: &body, impact, settings: &settings };
        for pieces in [8, 20, 40] {
            let concrete = PatternDesc::Concrete(Concrete::default());
            let at = Checker::root().field("pattern");
            let choice = PatternChoice::new(&concrete, Some(pieces), true, &at).unwrap();
            let draft = choice.draft(0, &struck).unwrap();
            assert!(draft.is_plain());
            let (pattern, fragments) = choice.finish(draft, &struck);
            let off = fragments.len().abs_diff(pieces) as f64;
            assert!(off <= PIECES_WITHIN * pieces as f64, "{} of {pieces}", fragments.len());
            assert!(pattern.without_roughness().is_some());
            let steps = choice.steps();
            assert!(choice.draft(steps - 1, &struck).is_some());
            assert!(choice.draft(steps, &struck).is_none());
        }
    }
}
