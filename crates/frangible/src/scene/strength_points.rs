//! Strength that varies over a body, checked.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::strength_points::StrengthPointDesc;
use frangible_fracture::StrengthPoints;
use std::sync::Arc;

/// The least factor, and one over the largest: below, all blows break, and above, none.
const LEAST: f64 = 1e-6;

/// The points of a description, and the triangles between them; `None` without any.
pub(crate) fn build_strength_points(
    (points, triangles): (&[StrengthPointDesc], &[[u32; 3]]),
    at: &Checker,
) -> Result<Option<Arc<StrengthPoints>>, BuildError> {
    let mut checked = Vec::with_capacity(points.len());
    for (index, StrengthPointDesc { point, factor }) in points.iter().enumerate() {
        let at = at.field(&format!("strength_points[{index}]"));
        let point = at.field("point").vector(*point, "m")?;
        checked.push((point, at.field("factor").within(*factor, LEAST, 1.0 / LEAST)?));
    }
    for (index, corners) in triangles.iter().enumerate() {
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= points.len()) {
            let at = at.field(&format!("strength_triangles[{index}]"));
            let rule = format!("a number below that of the strength_points, {}", points.len());
            return Err(at.broken(&corner.to_string(), &rule));
        }
    }
    Ok(StrengthPoints::new(checked, triangles.to_vec()).map(Arc::new))
}
