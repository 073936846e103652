//! Points of the solid in a closed surface.

use crate::filling::lots::Lots;
use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Columns through a mesh: the distance between them is below a hundredth of its size.
const COLUMNS: f64 = 16_384.0;

/// Points of the solid in a closed surface: on columns through it.
pub(super) fn points_of_triangles(
    triangles: &[[DVec3; 3]],
    (low, high): (DVec3, DVec3),
    count: usize,
    random: &mut Pcg64Mcg,
) -> Vec<DVec3> {
    let size = high - low;
    let axis = (0..3).min_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
    let across = [(axis + 1) % 3, (axis + 2) % 3];
    let sides = across.map(|side| size[side].max(f64::MIN_POSITIVE));
    let step = (sides[0] * sides[1] / COLUMNS).sqrt();
    let number = sides.map(|side| ((side / step).ceil() as usize).clamp(1, COLUMNS as usize));
    let width = [sides[0] / number[0] as f64, sides[1] / number[1] as f64];
    let places: Vec<[f64; 2]> = (0..number[0] * number[1])
        .map(|column| {
            let cell = [column % number[0], column / number[0]];
            std::array::from_fn(|side| {
                low[across[side]] + width[side] * (cell[side] as f64 + random.random::<f64>())
            })
        })
        .collect();

    // Where each column crosses the surface, and whether inward.
    let mut crossings: Vec<(usize, f64, i32)> = Vec::new();
    for corners in triangles {
        let flat = corners.map(|corner| across.map(|side| corner[side]));
        let cells: [[usize; 2]; 2] = std::array::from_fn(|side| {
            let at = |place: f64| ((place - low[across[side]]) / width[side]).max(0.0) as usize;
            let least = flat.iter().map(|corner| corner[side]).fold(f64::INFINITY, f64::min);
            let most = flat.iter().map(|corner| corner[side]).fold(f64::NEG_INFINITY, f64::max);
            [at(least).min(number[side] - 1), at(most).min(number[side] - 1)]
        });
        for j in cells[1][0]..=cells[1][1] {
            for i in cells[0][0]..=cells[0][1] {
                let column = i + number[0] * j;
                if let Some((parts, turn)) = parts_at(&flat, places[column]) {
                    let height = (0..3).map(|corner| parts[corner] * corners[corner][axis]).sum();
                    crossings.push((column, height, turn));
                }
            }
        }
    }
    crossings.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut spans: Vec<(usize, f64, f64)> = Vec::new();
    let mut winding = 0;
    for pair in crossings.windows(2) {
        winding += pair[0].2;
        if pair[0].0 != pair[1].0 {
            winding = 0;
        } else if winding > 0 {
            spans.push((pair[0].0, pair[0].1, pair[1].1 - pair[0].1));
        }
    }

    let lots = Lots::new(spans.iter().map(|span| span.2));
    if lots.sum() <= 0.0 {
        return Vec::new();
    }
    let point = |_| {
        let (column, start, length) = spans[lots.draw(random)];
        let mut point = DVec3::ZERO;
        point[axis] = start + length * random.random::<f64>();
        (0..2).for_each(|side| point[across[side]] = places[column][side]);
        point
    };
    (0..count).map(point).collect()
}

/// Barycentric coordinates of a place in a triangle, and 1 where the triangle faces down the third
/// axis, so that a column enters there, or -1; `None` beside it.
fn parts_at(flat: &[[f64; 2]; 3], place: [f64; 2]) -> Option<([f64; 3], i32)> {
    let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let [a, b, c] = *flat;
    let area = cross(a, b, c);
    if area == 0.0 {
        return None;
    }
    let parts =
        [cross(place, b, c), cross(place, c, a), cross(place, a, b)].map(|part| part / area);
    let is_inside = parts.iter().all(|&part| part >= 0.0);
    is_inside.then_some((parts, if area < 0.0 { 1 } else { -1 }))
}
