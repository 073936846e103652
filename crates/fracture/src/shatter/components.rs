//! The connected parts of each region's share of a body [Su09 sec. 4.2].

use crate::shatter::regions::intervals::NONE;
use crate::shatter::regions::shares::{Share, Shares};
use frangible_geometry::{Grid, GridSolid, Portion, Run, Span};
use frangible_math::DisjointSets;
use glam::DVec3;

/// The connected parts.
#[derive(Debug, Default)]
pub(crate) struct Components {
    /// Region of each component.
    pub(crate) region: Vec<u32>,
    /// True if the component has inside nodes; false for films of surface voxels.
    pub(crate) has_inside: Vec<bool>,
    /// Its material [voxels].
    pub(crate) material: Vec<f64>,
    /// The same in runs.
    pub(crate) portions: Vec<Portion>,
}

/// Which connected part each share belongs to.
#[derive(Debug)]
struct Labels {
    of_share: Vec<u32>,
    /// Region of each component.
    region: Vec<u32>,
    /// Its material [voxels]; known in the end.
    material: Vec<f64>,
}

/// The rows next to a row, which share voxel faces with it: their numbers and how much their nodes'
/// follow on.
pub(crate) fn rows_beside(grid: &Grid, row: usize) -> impl Iterator<Item = usize> {
    let [_, rows_y, rows_z] = grid.dims;
    let [j, k] = [row % rows_y, row / rows_y];
    let beside = [
        (j > 0).then(|| row - 1),
        (j + 1 < rows_y).then_some(row + 1),
        (k > 0).then(|| row - rows_y),
        (k + 1 < rows_z).then_some(row + rows_y),
    ];
    beside.into_iter().flatten()
}

/// Components of a convex body: one per region with content, as convexity implies connectivity at
/// any resolution. Numbered in the order of their first runs.
pub(crate) fn of_convex(portions_of_regions: Vec<Portion>) -> Components {
    let held =
        portions_of_regions.into_iter().zip(0..).filter(|(portion, _)| !portion.runs.is_empty());
    let mut held: Vec<(Portion, u32)> = held.collect();
    held.sort_by_key(|(portion, _)| portion.runs[0].place());
    let mut components = Components::default();
    for (portion, region) in held {
        components.add(region, portion);
    }
    components
}

/// Connects what is inside of the body, shares a region and a voxel face; then gives each voxel on
/// the surface, whose node lies outside but which holds material, to a component next to it.
///
/// Shares of surface voxels are cut into single nodes where it matters whom they touch.
///
/// `convex_slivers`: the regions are convex, and a part of less material [voxels] may be a tip of
/// another.
pub(crate) fn connected_components(
    solid: &GridSolid,
    mut shares: Shares,
    convex_slivers: Option<f64>,
) -> Components {
    let labels = label_components(solid, &mut shares, convex_slivers);
    let mut counts = vec![0; labels.region.len()];
    for &component in &labels.of_share {
        counts[component as usize] += 1;
    }
    let portion = |runs: usize| Portion::with_capacity(solid.grid(), runs);
    let mut portions: Vec<Portion> = counts.into_iter().map(portion).collect();
    for (share, &component) in shares.all.iter().zip(&labels.of_share) {
        portions[component as usize].push(share.run);
    }
    let mut components = Components::default();
    for (region, portion) in labels.region.into_iter().zip(portions) {
        components.add(region, portion);
    }
    components
}

/// The same for each share.
fn label_components(solid: &GridSolid, shares: &mut Shares, convex_slivers: Option<f64>) -> Labels {
    split_surface(solid, shares);
    let mut labels = connect_inside(solid, shares);
    let pending = attach_surface_voxels(solid, shares, &mut labels);
    found_islands(solid, shares, &mut labels, &pending);
    labels.weigh(shares);
    if let Some(smallest) = convex_slivers {
        rejoin_tips(solid, shares, &mut labels, smallest);
    }
    labels
}

impl Components {
    /// Adds a part of a region.
    fn add(&mut self, region: u32, portion: Portion) {
        self.region.push(region);
        self.has_inside.push(portion.sums.has_inside());
        self.material.push(portion.sums.material());
        self.portions.push(portion);
    }
}

impl Labels {
    fn empty(shares: &Shares) -> Self {
        Self { of_share: vec![NONE; shares.all.len()], region: Vec::new(), material: Vec::new() }
    }

    /// Sums up the components' material.
    fn weigh(&mut self, shares: &Shares) {
        self.material = vec![0.0; self.region.len()];
        for (Share { run, .. }, &component) in shares.all.iter().zip(&self.of_share) {
            self.material[component as usize] += run.moments[0];
        }
    }
}

/// Cuts the shares of surface voxels, each filled alike, into single nodes.
fn split_surface(solid: &GridSolid, shares: &mut Shares) {
    let middle = solid.grid().middle_along_x();
    let mut split = Shares::default();
    for row in 0..shares.rows() {
        split.first_of_row.push(split.all.len() as u32);
        for share in &shares.all[shares.row(row)] {
            let whole = share.run;
            if whole.inside > 0 {
                split.all.push(*share);
                continue;
            }
            let span =
                Span { start: whole.start, end: whole.end, coverage: fill(&whole), inside: false };
            split.all.extend((whole.start..whole.end).map(|start| {
                let mut run = Run::empty(whole.row, start);
                run.add(&Span { start, end: start + 1, ..span }, middle);
                Share { run, ..*share }
            }));
        }
    }
    split.first_of_row.push(split.all.len() as u32);
    *shares = split;
}

/// Fraction of each voxel of a run that is material, where they are filled alike.
fn fill(run: &Run) -> f32 {
    (run.moments[0] / f64::from(run.end - run.start)) as f32
}

/// Components of what is inside, numbered in the order of their first nodes.
fn connect_inside(solid: &GridSolid, shares: &Shares) -> Labels {
    let grid = solid.grid();
    let mut sets = DisjointSets::new(shares.all.len());
    for row in 0..shares.rows() {
        for at in shares.row(row).skip(1) {
            let (before, here) = (&shares.all[at - 1], &shares.all[at]);
            let touch = before.run.end == here.run.start && before.region == here.region;
            if touch && before.run.inside > 0 && here.run.inside > 0 {
                sets.unite(at as u32 - 1, at as u32);
            }
        }
        if row % grid.dims[1] > 0 {
            unite_touching(shares, row - 1, row, &mut sets);
        }
        if row >= grid.dims[1] {
            unite_touching(shares, row - grid.dims[1], row, &mut sets);
        }
    }

    // A root is the first share of its set: number the sets in that order.
    let mut labels = Labels::empty(shares);
    for (at, share) in shares.all.iter().enumerate().filter(|(_, share)| share.run.inside > 0) {
        let root = sets.root(at as u32) as usize;
        if root == at {
            labels.of_share[at] = labels.region.len() as u32;
            labels.region.push(share.region);
        }
        labels.of_share[at] = labels.of_share[root];
    }
    labels
}

/// Unites what is inside in two neighbouring rows, shares a region and a voxel face.
fn unite_touching(shares: &Shares, lower: usize, upper: usize, sets: &mut DisjointSets) {
    let (lower, upper) = (shares.row(lower), shares.row(upper));
    let (mut a, mut b) = (lower.start, upper.start);
    while a < lower.end && b < upper.end {
        let (below, above) = (&shares.all[a], &shares.all[b]);
        let overlap = below.run.start < above.run.end && above.run.start < below.run.end;
        if overlap && below.region == above.region && below.run.inside > 0 && above.run.inside > 0 {
            sets.unite(a as u32, b as u32);
        }
        if below.run.end <= above.run.end {
            a += 1;
        } else {
            b += 1;
        }
    }
}

/// The share of a row that holds a node.
fn share_at(shares: &Shares, row: usize, i: u32) -> Option<usize> {
    let range = shares.row(row);
    let in_row = &shares.all[range.clone()];
    let at = in_row.partition_point(|share| share.run.end <= i);
    (at < in_row.len() && in_row[at].run.start <= i).then_some(range.start + at)
}

/// The shares that share a face with a single voxel's.
fn shares_beside(
    grid: &Grid,
    shares: &Shares,
    row: usize,
    at: usize,
) -> impl Iterator<Item = usize> {
    let run = shares.all[at].run;
    let range = shares.row(row);
    let before = (at > range.start && shares.all[at - 1].run.end == run.start).then(|| at - 1);
    let behind = (at + 1 < range.end && shares.all[at + 1].run.start == run.end).then_some(at + 1);
    let across = rows_beside(grid, row).filter_map(move |row| share_at(shares, row, run.start));
    [before, behind].into_iter().flatten().chain(across)
}

/// A surface voxel: its row and its share.
type SurfaceVoxel = (usize, usize);

/// Assigns surface voxels to components in contact, first of their own region, then of any, layer
/// by layer from the body outwards. Returns the isolated voxels.
fn attach_surface_voxels(
    solid: &GridSolid,
    shares: &Shares,
    labels: &mut Labels,
) -> Vec<SurfaceVoxel> {
    let grid = solid.grid();
    let mut pending: Vec<SurfaceVoxel> = (0..shares.rows())
        .flat_map(|row| shares.row(row).map(move |at| (row, at)))
        .filter(|&(_, at)| shares.all[at].run.inside == 0)
        .collect();
    for own_region_only in [true, false] {
        loop {
            // The neighbour that holds the most and has a component; the first of equals.
            let adopter = |&(row, at): &SurfaceVoxel| {
                let fits = |other: &usize| {
                    let component = labels.of_share[*other];
                    let region = shares.all[at].region;
                    component != NONE
                        && (!own_region_only || labels.region[component as usize] == region)
                };
                let mut fullest: Option<usize> = None;
                for other in shares_beside(grid, shares, row, at).filter(fits) {
                    let holds = |at: usize| fill(&shares.all[at].run);
                    if fullest.is_none_or(|best| holds(other) > holds(best)) {
                        fullest = Some(other);
                    }
                }
                fullest.map(|other| (at, labels.of_share[other]))
            };
            let adopted: Vec<(usize, u32)> = pending.iter().filter_map(adopter).collect();
            if adopted.is_empty() {
                break;
            }
            for (at, component) in adopted {
                labels.of_share[at] = component;
            }
            pending.retain(|&(_, at)| labels.of_share[at] == NONE);
        }
    }
    pending
}

/// Material without any node inside, too thin for the grid: each connected part becomes a component
/// of its own.
fn found_islands(
    solid: &GridSolid,
    shares: &Shares,
    labels: &mut Labels,
    pending: &[SurfaceVoxel],
) {
    let row_of = |at: usize| shares.first_of_row.partition_point(|&first| first as usize <= at) - 1;
    for &(row, seed) in pending {
        if labels.of_share[seed] != NONE {
            continue;
        }
        let island = labels.region.len() as u32;
        labels.region.push(shares.all[seed].region);
        labels.of_share[seed] = island;
        let mut frontier = vec![(row, seed)];
        while let Some((row, at)) = frontier.pop() {
            for other in shares_beside(solid.grid(), shares, row, at) {
                if labels.of_share[other] == NONE {
                    labels.of_share[other] = island;
                    frontier.push((row_of(other), other));
                }
            }
        }
    }
}

/// Search radius around a sliver's nodes for the rest of its tip [nodes].
const TIP: usize = 3;

/// Thin tips fall apart between the nodes. A sliver rejoins a larger component of its region if a
/// straight line through the solid leads there: the region is convex, so that the line lies within
/// it.
fn rejoin_tips(solid: &GridSolid, shares: &Shares, labels: &mut Labels, smallest: f64) {
    let count = labels.region.len();
    let mut sets = DisjointSets::new(count);
    for row in 0..shares.rows() {
        for at in shares.row(row) {
            let sliver = labels.of_share[at];
            let known = sets.root(sliver) != sliver;
            let is_sliver =
                labels.material[sliver as usize] < smallest && shares.all[at].run.inside > 0;
            if is_sliver
                && !known
                && let Some(host) = rest_of_tip(solid, shares, labels, (row, at))
            {
                sets.unite(sliver, host);
            }
        }
    }
    let roots: Vec<u32> = (0..count as u32).map(|component| sets.root(component)).collect();
    if roots.iter().zip(0..).all(|(&root, component)| root == component) {
        return;
    }
    for component in &mut labels.of_share {
        *component = roots[*component as usize];
    }
    labels.weigh(shares);
}

/// A heavier component of a sliver's region that a straight line through the solid leads to.
fn rest_of_tip(
    solid: &GridSolid,
    shares: &Shares,
    labels: &Labels,
    (row, at): (usize, usize),
) -> Option<u32> {
    let grid = solid.grid();
    let Share { run, region } = shares.all[at];
    let sliver = labels.of_share[at];
    let [j, k] = [row % grid.dims[1], row / grid.dims[1]];
    let from = grid.node(run.start as usize, j, k);
    for to_k in k.saturating_sub(TIP)..(k + TIP + 1).min(grid.dims[2]) {
        for to_j in j.saturating_sub(TIP)..(j + TIP + 1).min(grid.dims[1]) {
            for other in shares.row(to_j + grid.dims[1] * to_k) {
                let there = &shares.all[other];
                let component = labels.of_share[other];
                let heavier =
                    labels.material[component as usize] > labels.material[sliver as usize];
                if there.region != region
                    || there.run.inside == 0
                    || component == sliver
                    || !heavier
                {
                    continue;
                }
                let i = run.start.clamp(there.run.start, there.run.end - 1);
                if i.abs_diff(run.start) as usize > TIP {
                    continue;
                }
                if is_inside_all_along(solid, from, grid.node(i as usize, to_j, to_k)) {
                    return Some(component);
                }
            }
        }
    }
    None
}

/// True if a line between two nodes lies inside a solid.
fn is_inside_all_along(solid: &GridSolid, from: DVec3, to: DVec3) -> bool {
    // Between two nodes the samples have few features.
    let steps = (2.0 * from.distance(to) / solid.grid().spacing) as usize + 2;
    (1..steps).all(|step| solid.value(from.lerp(to, step as f64 / steps as f64)) <= 0.0)
}

#[cfg(test)]
mod tests;
