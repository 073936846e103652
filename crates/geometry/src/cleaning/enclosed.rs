//! Two open sheets that face away from one another, and the solid between them.
//!
//! Game kits cull faces that nobody sees: of a crate's floor two quads are left, whose rims lie in
//! the walls. Where the winding number of all parts together is above a half between two sheets
//! [JKS13], a strip from rim to rim makes one closed surface of both.

use crate::bvh::Bvh;
use crate::cleaning::assembly::{Assembly, CRACK, FLAT_OPEN, Part, SHEET};
use crate::winding_number::{INSIDE, WindingNumber};
use glam::DVec3;

/// Places between two sheets at which the winding number is asked for.
const PLACES: usize = 9;

/// Sheets that are compared, each with each other.
const MOST_SHEETS: usize = 512;

/// One open part with a single rim.
struct Open {
    part: usize,
    /// Corners of the rim, in the order of the triangles that close it.
    rim: Vec<u32>,
    middle: DVec3,
}

/// Joins sheets in pairs, those with the nearest rims first.
pub(super) fn join_sheets(assembly: &mut Assembly, parts: &mut [Part]) {
    let open: Vec<Open> =
        (0..parts.len()).filter_map(|part| open_part(assembly, parts, part)).collect();
    if !(2..=MOST_SHEETS).contains(&open.len()) {
        return;
    }
    let at = |corner: u32| assembly.work.positions[assembly.place(corner) as usize];
    let apart = |a: &Open, b: &Open| {
        let nearest = |&from: &u32| {
            let to = b.rim.iter().map(|&to| at(from).distance(at(to)));
            to.fold(f64::INFINITY, f64::min)
        };
        a.rim.iter().map(nearest).sum::<f64>() / a.rim.len() as f64
    };
    let size = |sheet: &Open| {
        let from = |&corner: &u32| at(corner).distance(sheet.middle);
        sheet.rim.iter().map(from).fold(0.0, f64::max)
    };
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for a in 0..open.len() {
        for b in a + 1..open.len() {
            let away = apart(&open[a], &open[b]).max(apart(&open[b], &open[a]));
            let size = size(&open[a]).min(size(&open[b]));
            // Two sides of one sheet have nothing between them.
            if away < size && away > FLAT_OPEN * size {
                pairs.push((away, a, b));
            }
        }
    }
    if pairs.is_empty() {
        return;
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));

    let corners = |part: &Part| -> Vec<[DVec3; 3]> {
        let corners = |&triangle: &u32| assembly.points(assembly.corners(triangle));
        part.triangles.iter().map(corners).collect()
    };
    let all: Vec<[DVec3; 3]> = parts.iter().flat_map(corners).collect();
    let winding = WindingNumber::new(Bvh::new(&all));
    let surfaces: Vec<Vec<[DVec3; 3]>> =
        open.iter().map(|sheet| corners(&parts[sheet.part])).collect();
    let mut is_joined = vec![false; open.len()];
    let mut strips: Vec<(usize, usize, Vec<[u32; 3]>)> = Vec::new();
    for (_, a, b) in pairs {
        if !is_joined[a] && !is_joined[b] && encloses(&winding, &surfaces[a], &surfaces[b]) {
            (is_joined[a], is_joined[b]) = (true, true);
            let strip = strip(&open[a].rim, &open[b].rim, &at);
            strips.push((open[a].part, open[b].part, strip));
        }
    }
    for (a, b, strip) in strips {
        let other = std::mem::take(&mut parts[b]);
        parts[a].triangles.extend(other.triangles);
        parts[a].triangles.sort_unstable();
        parts[a].holes = vec![assembly.closed.holes.len()];
        assembly.closed.holes.push(strip);
    }
}

/// A part that is flat or hardly closed, and has one rim.
fn open_part(assembly: &Assembly, parts: &[Part], number: usize) -> Option<Open> {
    let part = &parts[number];
    let [hole] = part.holes[..] else { return None };
    let (shell, hole_area) = (assembly.shell(part), assembly.hole_area(hole));
    let own_area = shell.area - hole_area;
    let is_flat = shell.volume.abs() <= FLAT_OPEN * shell.area * shell.diagonal();
    let is_open = hole_area > CRACK * own_area && (is_flat || hole_area > SHEET * own_area);
    if !is_open {
        return None;
    }
    // Edges of the triangles that close the hole, without those between two of them.
    let filled = &assembly.closed.holes[hole];
    let mut edges: Vec<(u32, u32)> =
        filled.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    edges.sort_unstable();
    let is_rim = |&(a, b): &(u32, u32)| edges.binary_search(&(b, a)).is_err();
    let next: Vec<(u32, u32)> = edges.iter().copied().filter(is_rim).collect();
    let first = next.first()?.0;
    let mut rim = vec![first];
    while rim.len() <= next.len() {
        let here = *rim.last()?;
        let (_, to) = next[next.binary_search_by_key(&here, |edge| edge.0).ok()?];
        if to == first {
            break;
        }
        rim.push(to);
    }
    if rim.len() != next.len() || rim.len() < 3 {
        return None;
    }
    let at = |&corner: &u32| assembly.work.positions[assembly.place(corner) as usize];
    let middle = rim.iter().map(at).sum::<DVec3>() / rim.len() as f64;
    Some(Open { part: number, rim, middle })
}

/// True if the places halfway between two sheets lie inside, most of them.
fn encloses(winding: &WindingNumber, a: &[[DVec3; 3]], b: &[[DVec3; 3]]) -> bool {
    let tree = Bvh::new(b);
    let step = a.len().div_ceil(PLACES);
    let (mut inside, mut all) = (0, 0);
    for &[p, q, r] in a.iter().step_by(step) {
        let from = (p + q + r) / 3.0;
        let Some(to) = tree.closest(from, f64::INFINITY) else { continue };
        all += 1;
        inside += usize::from(winding.at(0.5 * (from + to.point)) > INSIDE);
    }
    2 * inside > all
}

/// Triangles between two rims, each in the order of the triangles that would close it: step by
/// step along the one where the other is nearer.
fn strip(a: &[u32], b: &[u32], at: &impl Fn(u32) -> DVec3) -> Vec<[u32; 3]> {
    let start = at(a[0]);
    let nearest = (0..b.len())
        .min_by(|&i, &j| {
            at(b[i]).distance_squared(start).total_cmp(&at(b[j]).distance_squared(start))
        })
        .unwrap_or(0);
    // The rims run against one another.
    let along_a = |step: usize| a[step % a.len()];
    let along_b = |step: usize| b[(nearest + 2 * b.len() - step) % b.len()];
    let (mut i, mut j) = (0, 0);
    let mut triangles = Vec::with_capacity(a.len() + b.len());
    while i < a.len() || j < b.len() {
        let (here, there) = (along_a(i), along_b(j));
        let (next_a, next_b) = (along_a(i + 1), along_b(j + 1));
        let by_a = at(next_a).distance_squared(at(there));
        let by_b = at(next_b).distance_squared(at(here));
        if j == b.len() || i < a.len() && by_a <= by_b {
            triangles.push([here, next_a, there]);
            i += 1;
        } else {
            triangles.push([next_b, there, here]);
            j += 1;
        }
    }
    triangles
}
