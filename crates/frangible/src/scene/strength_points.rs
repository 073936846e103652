//! Strength that varies over a body, checked.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::strength_points::StrengthPointDesc;
use frangible_fracture::StrengthPoints;
use std::sync::Arc;

/// The least factor, and one over the largest: below, all blows break, and above, none.
const LEAST: f64 = 1e-6;

/// The points of a description; `None` without any.
pub(crate) fn build_strength_points(
    points: &[StrengthPointDesc],
    at: &Checker,
) -> Result<Option<Arc<StrengthPoints>>, BuildError> {
    let mut checked = Vec::with_capacity(points.len());
    for (index, StrengthPointDesc { point, factor }) in points.iter().enumerate() {
        let at = at.field(&format!("strength_points[{index}]"));
        let point = at.field("point").vector(*point, "m")?;
        checked.push((point, at.field("factor").within(*factor, LEAST, 1.0 / LEAST)?));
    }
    Ok(StrengthPoints::new(checked).map(Arc::new))
}
