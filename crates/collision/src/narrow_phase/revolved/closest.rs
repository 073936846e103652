//! Closest points of two separated cores, by support points: the method of Gilbert, Johnson and
//! Keerthi [GJK88].

use crate::narrow_phase::hull_hull::hull_pair::PREFERENCE;
use crate::narrow_phase::revolved::partner::Partner;
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use crate::narrow_phase::revolved::simplex::{Difference, Simplex};
use glam::DVec3;

/// Steps of the search [1]. Round bodies take 5 to 20, flat ones fewer.
const MOST_STEPS: usize = 64;

/// Steps that may prove no larger distance once rounding hides that it shrinks: on rims a thousand
/// times as large as the other body the proof comes and goes.
const MOST_TRIES: usize = 6;

/// The distance is known to this part of the smaller body's size: for contacts, whose normal is
/// then known to its root where it is unique, and for times.
pub(crate) const PRECISE: f64 = 1e-10;
pub(crate) const COARSE: f64 = 1e-6;

/// Cores nearer than this part of the smaller body's size are taken as touching: the way between
/// them has no direction that rounding leaves alone.
const TOUCHING: f64 = 1e-8;

/// Cores whose closest points are nearer than this part of the smaller body's size must be proved
/// apart by a normal: of bodies ten thousand times as large as the other, and of slivers, rounding
/// leaves touching ones up to 2e-4 of the size apart.
const NEARLY: f64 = 1e-3;

/// Closest points of two cores.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closest {
    /// [m]
    pub(crate) distance: f64,
    /// Unit, from the second body to the first.
    pub(crate) normal: DVec3,
    /// On both [m].
    pub(crate) on: [DVec3; 2],
}

/// `None` for cores that touch or overlap. `guess` is a direction from the partner. Beyond `most`
/// [m] the distance is only known to be larger; `precise` is relative to `size` [m].
pub(crate) fn closest_points(
    round: &PlacedRevolved,
    partner: &Partner,
    limits: (f64, f64, f64),
    guess: DVec3,
) -> Option<Closest> {
    let support = |normal: DVec3| {
        let on = [round.support(-normal), partner.support(normal)];
        Difference { on, between: on[0] - on[1] }
    };
    closest(&support, limits, guess)
}

/// The closest points of overlapping cores once they are moved apart along a normal, moved back: the
/// corner or edge that is deepest, wherever edges nearly as high lead away from it. Lengths are the
/// same within `close` [m].
pub(crate) fn deepest_points(
    round: &PlacedRevolved,
    partner: &Partner,
    (normal, close): (DVec3, f64),
) -> Option<[DVec3; 2]> {
    let depth = round.reach(-normal) + partner.reach(normal);
    let shift = (depth + close) * normal;
    let moved = PlacedRevolved { middle: round.middle + shift, ..*round };
    let limits = (close / PREFERENCE, PRECISE, f64::INFINITY);
    let Closest { on, .. } = closest_points(&moved, partner, limits, normal)?;
    Some([on[0] - shift, on[1]])
}

/// The closest points of any two bodies, by their points furthest against a normal from the second to the
/// first, and along it.
pub(crate) fn closest(
    support: &impl Fn(DVec3) -> Difference,
    (size, precise, most): (f64, f64, f64),
    guess: DVec3,
) -> Option<Closest> {
    let mut simplex = Simplex::new(support(guess));
    let mut way = simplex.nearest();
    // The way that proves the largest distance.
    let mut best = (f64::NEG_INFINITY, simplex, way);
    let (mut is_longest, mut tries) = (false, MOST_TRIES);
    for _ in 0..MOST_STEPS {
        let distance = way.length();
        if distance <= TOUCHING * size {
            return None;
        }
        let next = support(way);
        let least = next.between.dot(way) / distance;
        if least <= best.0 && is_longest {
            tries -= 1;
            if tries == 0 {
                break;
            }
        }
        if least > best.0 {
            best = (least, simplex, way);
        }
        if distance - least <= precise * size || least > most || simplex.contains(&next) {
            best = (least, simplex, way);
            break;
        }
        let better = simplex.with(next, best.0 > 0.0)?;
        let nearest = better.nearest();
        // Rounding ends the progress of the distance first: a turn of the way changes it by the
        // square, and by its first power what the bodies' far ends leave of it.
        is_longest = nearest.length_squared() >= way.length_squared();
        (simplex, way) = (better, nearest);
    }
    let (least, simplex, way) = best;
    let is_proved = least > 0.0;
    let length = way.length();
    // Where rounding has ended the search far too early the way separates less than its length.
    let distance = if length - least > NEARLY * size { least } else { length };
    let touching = if is_proved { TOUCHING } else { NEARLY };
    if distance <= touching * size {
        return None;
    }
    Some(Closest { distance, normal: way / length, on: simplex.on_bodies() })
}
