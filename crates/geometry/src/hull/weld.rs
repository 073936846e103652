//! Gap-free hulls.

use super::Hull;
use glam::DVec3;

/// Vertices in a bucket that are sorted by themselves.
const CROWD: usize = 16;

/// A vertex of a hull.
#[derive(Clone, Copy)]
struct Place {
    position: DVec3,
    hull: u32,
    vertex: u32,
}

/// A vertex in the order of a skew direction.
#[derive(Clone, Copy, Default)]
struct Entry {
    /// Place along the direction [m].
    key: f64,
    /// Index among all hulls' vertices.
    place: u32,
    /// Representative entry; the first of a group represents itself.
    one_with: u32,
}

/// Makes one of vertices on cracks of different hulls that are less than `close` [m] apart: each
/// becomes the one that comes first along a fixed direction. Neighbours that were cut by the same
/// planes, but one after the other in different orders, differ by rounding, and then share their
/// vertices bit for bit. Vertices of one hull stay apart.
pub fn weld_hulls(hulls: &mut [Hull], close: f64) {
    let places = places(hulls);
    let mut entries = sorted(&places);
    for at in 1..entries.len() {
        let key = entries[at].key;
        entries[at].one_with = at as u32;
        if key - entries[at - 1].key >= close {
            continue;
        }

        // Back through all that may be as close, first the nearest.
        let Place { position, hull, vertex } = places[entries[at].place as usize];
        let mut first = None;
        let mut before = at;
        while before > 0 && key - entries[before - 1].key < close {
            before -= 1;
            let Entry { place, one_with, .. } = entries[before];
            let other = &places[place as usize];
            let is_first = one_with as usize == before && other.hull != hull;
            if is_first && other.position.distance_squared(position) < close * close {
                first = Some((before as u32, other.position));
                break;
            }
        }
        let Some((first, position)) = first else { continue };
        let as_close = entries[..at].iter().rev().take_while(|entry| key - entry.key < close);
        let mut others = as_close.filter(|entry| places[entry.place as usize].hull == hull);
        if others.all(|entry| entry.one_with != first) {
            hulls[hull as usize].vertices[vertex as usize] = position;
            entries[at].one_with = first;
        }
    }
}

/// The vertices on cracks of all hulls: no other has a neighbour's beside it.
fn places(hulls: &[Hull]) -> Vec<Place> {
    let mut places = Vec::with_capacity(hulls.iter().map(|hull| hull.vertices.len()).sum());
    let mut on_crack = Vec::new();
    for (hull, number) in hulls.iter().zip(0..) {
        on_crack.clear();
        on_crack.resize(hull.vertices.len(), false);
        for face in (0..hull.planes.len()).filter(|&face| hull.net.is_inner(face)) {
            for &vertex in hull.net.corners(face) {
                on_crack[vertex as usize] = true;
            }
        }
        for ((&position, &on_crack), vertex) in hull.vertices.iter().zip(&on_crack).zip(0..) {
            if on_crack {
                places.push(Place { position, hull: number, vertex });
            }
        }
    }
    places
}

/// In the order of their keys, and of their numbers where those are equal: as many buckets as there
/// are vertices put them nearly in order.
fn sorted(places: &[Place]) -> Vec<Entry> {
    // No plane of a pattern or of a box is likely to lie across this, so that few keys are close by
    // chance.
    let direction = DVec3::new(0.612_9, 0.538_3, 0.578_1);
    let keys: Vec<f64> = places.iter().map(|place| direction.dot(place.position)).collect();
    let low = keys.iter().fold(f64::INFINITY, |low, &key| if key < low { key } else { low });
    let high =
        keys.iter().fold(f64::NEG_INFINITY, |high, &key| if key > high { key } else { high });
    let scale = keys.len() as f64 / (high - low).max(f64::MIN_POSITIVE);
    let buckets: Vec<i32> = keys.iter().map(|&key| ((key - low) * scale) as i32).collect();

    // The highest keys have a bucket of their own, and one more entry makes room for where each
    // begins.
    let mut starts = vec![0_u32; keys.len() + 2];
    for &bucket in &buckets {
        starts[bucket as usize + 1] += 1;
    }
    let mut sum = 0;
    for start in &mut starts {
        sum += *start;
        *start = sum;
    }
    let mut entries = vec![Entry::default(); keys.len()];
    for ((&key, &bucket), place) in keys.iter().zip(&buckets).zip(0..) {
        let start = &mut starts[bucket as usize];
        entries[*start as usize] = Entry { key, place, one_with: 0 };
        *start += 1;
    }
    // Each bucket's start has become its end. In crowded places a linear search would be slow.
    let mut first = 0;
    for end in starts.into_iter().map(|end| end as usize) {
        let bucket = &mut entries[first..end];
        if bucket.len() > CROWD {
            bucket.sort_unstable_by(|a, b| a.key.total_cmp(&b.key).then(a.place.cmp(&b.place)));
        }
        first = end;
    }
    for at in 1..entries.len() {
        let entry = entries[at];
        let mut to = at;
        while to > 0 && entry.key < entries[to - 1].key {
            entries[to] = entries[to - 1];
            to -= 1;
        }
        entries[to] = entry;
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Spread out, crowded together a thousand times as close, and at the same place.
        #[test]
        fn entries_are_all_places_in_order(
            spread in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 0..40),
            crowd in prop::collection::vec(prop::array::uniform3(-1e-3..1e-3f64), 0..200),
            copies in 1..4_usize,
        ) {
            let points = spread.into_iter().chain(crowd).map(DVec3::from_array);
            let copied = points.flat_map(|position| std::iter::repeat_n(position, copies));
            let places: Vec<Place> =
                copied.map(|position| Place { position, hull: 0, vertex: 0 }).collect();
            let entries = sorted(&places);
            prop_assert!(entries.windows(2).all(|pair| (pair[0].key, pair[0].place) < (pair[1].key, pair[1].place)));
            let mut numbers: Vec<u32> = entries.iter().map(|entry| entry.place).collect();
            numbers.sort_unstable();
            prop_assert!(numbers.into_iter().eq(0..places.len() as u32));
        }
    }
}
