//! Separation of a body of revolution from its partner, and the normal of their contact.

use crate::narrow_phase::revolved::closest::{COARSE, PRECISE, closest_points};
use crate::narrow_phase::revolved::partner::Partner;
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use crate::narrow_phase::revolved::search::Search;
use glam::DVec3;

/// Separation of two shapes, in the partner's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Separation {
    /// Of the surfaces [m]; negative for overlap: the least way apart.
    pub(crate) gap: f64,
    /// Unit, from the partner to the body of revolution.
    pub(crate) normal: DVec3,
    /// The closest points of both cores [m], on the body of revolution and on the partner; `None`
    /// for cores that touch or overlap.
    pub(crate) on: Option<[DVec3; 2]>,
}

/// Exact separation. `size` [m] is the smaller body's.
pub(crate) fn separation(
    round: &PlacedRevolved,
    partner: &Partner,
    size: f64,
    guess: DVec3,
) -> Separation {
    if let Some(apart) = apart(round, partner, (size, PRECISE, f64::INFINITY), guess) {
        return apart;
    }
    let mut search = Search::new(round, partner, 0.0);
    search.flat();
    search.pointed(size);
    overlapping(&search)
}

/// Separation with the normal for a contact: of a flat face or a round side where it is as good as
/// the best within `close` [m].
pub(crate) fn contact_separation(
    round: &PlacedRevolved,
    partner: &Partner,
    (size, close): (f64, f64),
    guess: DVec3,
) -> Separation {
    if let Some(apart) = apart(round, partner, (size, PRECISE, f64::INFINITY), guess) {
        return preferred(round, partner, &apart, close).unwrap_or(apart);
    }
    let mut search = Search::new(round, partner, close);
    search.flat();
    // Overlap this small needs no better normal.
    if search.depth <= close {
        return overlapping(&search);
    }
    let peeled = peeled(&search, size);
    match peeled {
        Some(peeled) if peeled.depth <= SHALLOW * close => {
            return Separation {
                gap: -peeled.depth - round.rounding - partner.rounding(),
                normal: peeled.normal,
                on: Some(peeled.on),
            };
        }
        Some(peeled) => search.offer(peeled.normal),
        None if search.depth <= SHALLOW * close => return overlapping(&search),
        None => {}
    }
    search.pointed(size);
    overlapping(&search)
}

/// Bodies that overlap by more than this multiple of `close` may have a better normal far from the
/// present one [1].
const SHALLOW: f64 = 40.0;

/// Steps of [`peeled`]: each leaves about the overlap, relative to the bodies' curvature, of the
/// error.
const PEELINGS: usize = 5;

/// Precision of the closest points for [`peeled`], relative to the size [1].
const PEELS: f64 = 1e-8;

/// A normal found by moving one body out of the other.
struct Peeled {
    depth: f64,
    normal: DVec3,
    on: [DVec3; 2],
}

/// Least overlap near the best flat normal: moved apart along a normal by little more than they
/// overlap, the bodies are closest along a better one. `None` if no normal is better.
fn peeled(search: &Search, size: f64) -> Option<Peeled> {
    const MORE: f64 = 1.1;
    const LEAST: f64 = 1e-4;
    const GAINS: f64 = 1e-6;
    let (mut depth, mut normal) = (search.depth, search.normal);
    let mut best = None;
    for _ in 0..PEELINGS {
        let shift = (MORE * depth + LEAST * size) * normal;
        let moved = PlacedRevolved { middle: search.round.middle + shift, ..*search.round };
        let closest = closest_points(&moved, search.partner, (size, PEELS, f64::INFINITY), normal)?;
        let next = search.overlap(closest.normal);
        let gain = depth - next;
        if gain <= GAINS * size {
            break;
        }
        (depth, normal) = (next, closest.normal);
        let on = [closest.on[0] - shift, closest.on[1]];
        best = (depth < search.depth - search.margin).then_some(Peeled { depth, normal, on });
    }
    best
}

/// Separation for the time of a touch, without search for the least overlap: cores that overlap
/// have a gap of minus both roundings, and the guess as their normal. Beyond `most` [m] the gap is
/// only known to be larger.
pub(crate) fn quick_separation(
    round: &PlacedRevolved,
    partner: &Partner,
    (size, most): (f64, f64),
    guess: DVec3,
) -> Separation {
    apart(round, partner, (size, COARSE, most), guess).unwrap_or_else(|| Separation {
        gap: -round.rounding - partner.rounding(),
        normal: guess.normalize_or(DVec3::Y),
        on: None,
    })
}

/// Separation for the time of closest approach of bodies that may overlap a little: of flat faces
/// and round sides where they do.
pub(crate) fn flat_separation(
    round: &PlacedRevolved,
    partner: &Partner,
    (size, close): (f64, f64),
    guess: DVec3,
) -> Separation {
    if let Some(apart) = apart(round, partner, (size, COARSE, f64::INFINITY), guess) {
        return preferred(round, partner, &apart, close).unwrap_or(apart);
    }
    let mut search = Search::new(round, partner, close);
    search.flat();
    overlapping(&search)
}

fn overlapping(search: &Search) -> Separation {
    let rounding = search.round.rounding + search.partner.rounding();
    Separation { gap: -search.depth - rounding, normal: search.normal, on: None }
}

/// Separated cores, and all that meets a plane.
fn apart(
    round: &PlacedRevolved,
    partner: &Partner,
    (size, precise, most): (f64, f64, f64),
    guess: DVec3,
) -> Option<Separation> {
    let rounding = round.rounding + partner.rounding();
    if let Partner::Plane(plane) = partner {
        let normal = plane.normal;
        let gap = -round.reach(-normal) - plane.offset - rounding;
        let on_round = round.support(-normal);
        let on_plane = on_round - plane.distance(on_round) * normal;
        return Some(Separation { gap, normal, on: Some([on_round, on_plane]) });
    }
    let closest = closest_points(round, partner, (size, precise, most + rounding), guess)?;
    let gap = closest.distance - rounding;
    Some(Separation { gap, normal: closest.normal, on: Some(closest.on) })
}

/// The normal of a face or side near the normal of separated cores, if as good within `close`.
fn preferred(
    round: &PlacedRevolved,
    partner: &Partner,
    apart: &Separation,
    close: f64,
) -> Option<Separation> {
    let normal = apart.normal;
    let nearer_end = |body: &PlacedRevolved| body.axis * normal.dot(body.axis).signum();
    let of_partner = match partner {
        Partner::Hull(hull) => {
            let planes = hull.planes().iter();
            let nearest =
                planes.max_by(|a, b| a.normal.dot(normal).total_cmp(&b.normal.dot(normal)));
            [nearest.map(|plane| plane.normal), None]
        }
        Partner::Revolved(other) => {
            [Some(nearer_end(other)), Some(other.side_normal(other.radial(normal)))]
        }
        Partner::Plane(_) => return None,
    };
    let side = -round.side_normal(round.radial(-normal));
    let rounding = round.rounding + partner.rounding();
    let candidates = [of_partner[0], Some(nearer_end(round)), Some(side), of_partner[1]];
    candidates.into_iter().flatten().find_map(|normal| {
        let gap = -round.reach(-normal) - partner.reach(normal) - rounding;
        (gap >= apart.gap - close).then_some(Separation { gap, normal, on: apart.on })
    })
}

#[cfg(test)]
mod tests;
