//! Checks that drawn cells fill their box, and locates misfits.

use super::parts::place;

use glam::DVec3;

/// A gap is small if it is nowhere farther from the cells than this part of the box's longest edge,
/// and an overlap if it is nowhere deeper: a hundredth, a line that an artist does not see.
const SMALL: f64 = 0.01;

/// A node's volume belongs to one of these.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Filled,
    Gap,
    Overlap,
}

/// A connected gap or overlap.
struct Misfit {
    kind: Kind,
    nodes: Vec<usize>,
    deepest: f64,
}

impl Misfit {
    /// The middle of a misfit, or its nearest node if the middle lies outside (as for a shell).
    fn around(&self, node: impl Fn(usize) -> DVec3) -> DVec3 {
        let middle = self.nodes.iter().map(|&at| node(at)).sum::<DVec3>() / self.nodes.len() as f64;
        let away = |&at: &usize| node(at).distance_squared(middle);
        let nearest = self.nodes.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b)));
        let size = (node(1) - node(0)).length();
        nearest.map(node).filter(|nearest| nearest.distance(middle) > size).unwrap_or(middle)
    }
}

/// Refuses cells that leave a gap, or overlap, where it is not small. The error completes a
/// sentence.
pub(super) fn check(
    nearest: &dyn Fn(DVec3) -> [(f64, usize); 2],
    (low, high): (DVec3, DVec3),
    spacing: f64,
    origin: DVec3,
) -> Result<(), String> {
    // Look at the middles of boxes, cubes but for rounding, that fill the box.
    let dims =
        ((high - low) / spacing).to_array().map(|count| (libm::round(count) as usize).max(1));
    let step = (high - low) / DVec3::from(dims.map(|count| count as f64));
    let node = |index: usize| {
        let [i, j, k] = [index % dims[0], index / dims[0] % dims[1], index / dims[0] / dims[1]];
        low + step * (DVec3::new(i as f64, j as f64, k as f64) + 0.5)
    };
    let nodes: Vec<(Kind, f64)> = (0..dims[0] * dims[1] * dims[2])
        .map(|index| {
            let [(first, _), (second, _)] = nearest(node(index));
            if first > 0.0 {
                (Kind::Gap, first)
            } else if second < 0.0 {
                (Kind::Overlap, -second)
            } else {
                (Kind::Filled, 0.0)
            }
        })
        .collect();

    // The worst of the connected ones.
    let misfits = connected(&nodes, dims);
    let large = misfits.iter().filter(|misfit| misfit.deepest > SMALL * (high - low).max_element());
    let Some(worst) = large.clone().max_by_key(|misfit| misfit.nodes.len()) else { return Ok(()) };
    let volume = worst.nodes.len() as f64 * step.element_product();
    let percent = 100.0 * volume / (high - low).element_product();
    let what = if worst.kind == Kind::Gap { "a gap" } else { "an overlap" };
    let more = match large.count() - 1 {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    let (volume, percent) = (significant(volume), significant(percent));
    let around = place(worst.around(node) + origin);
    Err(format!(
        "{what} of {volume} m^3 ({percent} % of the box) around {around}{more}; cells must fill their box"
    ))
}

/// Two digits.
fn significant(number: f64) -> String {
    let place = libm::floor(libm::log10(number)) as i32 - 1;
    if place < 0 {
        return format!("{number:.*}", place.unsigned_abs() as usize);
    }
    let digit = libm::pow(10.0, f64::from(place));
    format!("{}", libm::round(number / digit) * digit)
}

/// Gaps and overlaps, flooded over the faces of the boxes.
fn connected(nodes: &[(Kind, f64)], dims: [usize; 3]) -> Vec<Misfit> {
    let steps = [1, dims[0], dims[0] * dims[1]];
    let mut seen = vec![false; nodes.len()];
    let mut misfits = Vec::new();
    for start in 0..nodes.len() {
        let kind = nodes[start].0;
        if kind == Kind::Filled || seen[start] {
            continue;
        }
        let mut misfit = Misfit { kind, nodes: Vec::new(), deepest: 0.0 };
        let mut waiting = vec![start];
        seen[start] = true;
        while let Some(at) = waiting.pop() {
            misfit.nodes.push(at);
            misfit.deepest = misfit.deepest.max(nodes[at].1);
            for axis in 0..3 {
                let place = at / steps[axis] % dims[axis];
                let below = (place > 0).then(|| at - steps[axis]);
                let above = (place + 1 < dims[axis]).then(|| at + steps[axis]);
                for beside in below.into_iter().chain(above) {
                    if nodes[beside].0 == kind && !seen[beside] {
                        seen[beside] = true;
                        waiting.push(beside);
                    }
                }
            }
        }
        misfits.push(misfit);
    }
    misfits
}
