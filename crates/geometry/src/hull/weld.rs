//! Hulls that fit without a gap.

use super::Hull;
use glam::DVec3;

/// A vertex in the order of a skew direction.
#[derive(Clone, Copy)]
struct Entry {
    /// Place along the direction [m].
    key: f64,
    /// Among those of all hulls.
    vertex: u32,
    /// Which entry it is one with; itself, if it came first.
    one_with: u32,
}

/// Makes one of vertices of different hulls that are less than `close` [m] apart: each becomes the one that comes first along a
/// fixed direction. Neighbours that were cut by the same planes, but one after the other in different orders, differ by rounding,
/// and then share their vertices bit for bit. Vertices of one hull stay apart.
pub fn weld_hulls(hulls: &mut [Hull], close: f64) {
    // No plane of a pattern or of a box is likely to lie across this, so that few keys are close by chance.
    let direction = DVec3::new(0.612_9, 0.538_3, 0.578_1);
    let count = hulls.iter().map(|hull| hull.vertices.len()).sum();
    let mut entries: Vec<Entry> = Vec::with_capacity(count);
    let mut places: Vec<(DVec3, u32, u32)> = Vec::with_capacity(count);
    for (hull, number) in hulls.iter().zip(0..) {
        for (&position, vertex) in hull.vertices.iter().zip(0..) {
            entries.push(Entry { key: direction.dot(position), vertex: places.len() as u32, one_with: 0 });
            places.push((position, number, vertex));
        }
    }
    entries.sort_unstable_by(|a, b| a.key.total_cmp(&b.key).then(a.vertex.cmp(&b.vertex)));
    for at in 0..entries.len() {
        let key = entries[at].key;
        let (position, hull, vertex) = places[entries[at].vertex as usize];
        entries[at].one_with = at as u32;
        // Back through all that may be as close, first the nearest.
        let window = || (0..at).rev().take_while(|&before| key - entries[before].key < close);
        let place = |entry: usize| places[entries[entry].vertex as usize];
        let first = window().find(|&before| {
            let (other_position, other, _) = place(before);
            other != hull
                && entries[before].one_with as usize == before
                && other_position.distance_squared(position) < close * close
        });
        let Some(first) = first else { continue };
        let is_free =
            window().all(|before| place(before).1 != hull || entries[before].one_with != first as u32);
        if is_free {
            hulls[hull as usize].vertices[vertex as usize] = place(first).0;
            entries[at].one_with = first as u32;
        }
    }
}
