//! Hulls that fit without a gap.

use super::Hull;
use glam::DVec3;

/// A vertex in the order of a skew direction.
#[derive(Clone, Copy)]
struct Entry {
    /// Place along the direction [m].
    key: f64,
    hull: u32,
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
    let mut entries: Vec<Entry> = Vec::with_capacity(hulls.iter().map(|hull| hull.vertices.len()).sum());
    for (hull, number) in hulls.iter().zip(0..) {
        for (position, vertex) in hull.vertices.iter().zip(0..) {
            entries.push(Entry { key: direction.dot(*position), hull: number, vertex, one_with: 0 });
        }
    }
    entries.sort_unstable_by(|a, b| {
        a.key.total_cmp(&b.key).then(a.hull.cmp(&b.hull)).then(a.vertex.cmp(&b.vertex))
    });
    for at in 0..entries.len() {
        let Entry { key, hull, vertex, .. } = entries[at];
        let position = hulls[hull as usize].vertices[vertex as usize];
        entries[at].one_with = at as u32;
        // Back through all that may be as close, first the nearest.
        let window = || (0..at).rev().take_while(|&before| key - entries[before].key < close);
        let first = window().find(|&before| {
            let Entry { hull: other, vertex, one_with, .. } = entries[before];
            other != hull
                && one_with as usize == before
                && hulls[other as usize].vertices[vertex as usize].distance_squared(position) < close * close
        });
        let Some(first) = first else { continue };
        let is_free =
            window().all(|before| entries[before].hull != hull || entries[before].one_with != first as u32);
        if is_free {
            let Entry { hull: of, vertex: there, .. } = entries[first];
            hulls[hull as usize].vertices[vertex as usize] = hulls[of as usize].vertices[there as usize];
            entries[at].one_with = first as u32;
        }
    }
}
