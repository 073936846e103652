//! Fragments too small for the grid join a neighbour. Nothing vanishes.

use super::{
    components::{Components, rows_beside},
    regions::NONE,
};
use frangible_geometry::disjoint_sets::DisjointSets;
use frangible_geometry::{Grid, GridSolid, Portion, Run};

/// The fragments, as sets of components.
#[derive(Debug)]
pub(crate) struct Pieces {
    /// Fragment of each component; [`NONE`] for one without mass.
    pub(crate) of_component: Vec<u32>,
    /// Components of each fragment, the heaviest first.
    pub(crate) components: Vec<Vec<u32>>,
}

/// Merges each component of less than `smallest` voxels of material with the neighbour with which it shares the most
/// voxel faces, the lightest first. One that touches no other stays as it is.
pub(crate) fn merge_slivers(solid: &GridSolid, components: &Components, smallest: f64) -> Pieces {
    let material = &components.material;
    let count = components.region.len();
    let mut sets = DisjointSets::new(count);
    let mut slivers: Vec<u32> = (0..count as u32).filter(|&c| material[c as usize] < smallest).collect();
    if slivers.is_empty() {
        return number_pieces(&mut sets, material);
    }
    let rows = Rows::around(solid.grid(), components, &slivers);
    let mut members: Vec<Vec<u32>> = (0..count as u32).map(|component| vec![component]).collect();
    let mut of_set = material.clone();

    // Merge the lightest sliver until each has grown up or stands alone.
    while let Some(at) = lightest(&slivers, &of_set) {
        let sliver = slivers.swap_remove(at);
        let own = std::mem::take(&mut members[sliver as usize]);
        let Some(host) = closest_neighbour(solid.grid(), components, &rows, &mut sets, &own) else {
            continue;
        };
        sets.unite(sliver, host);
        let merged = sets.root(host);
        let sum = of_set[sliver as usize] + of_set[host as usize];
        slivers.retain(|&other| other != host);
        if sum < smallest {
            let mut all = std::mem::take(&mut members[host as usize]);
            all.extend(own);
            members[merged as usize] = all;
            slivers.push(merged);
        }
        of_set[merged as usize] = sum;
    }
    number_pieces(&mut sets, material)
}

/// Whose the nodes of some neighbouring rows are.
struct Rows {
    first: usize,
    /// Where each row begins in `stretches`, and one more entry at the end.
    first_of_row: Vec<u32>,
    stretches: Vec<Stretch>,
}

/// Consecutive nodes of a row in one component.
#[derive(Clone, Copy, Default)]
struct Stretch {
    component: u32,
    start: u32,
    end: u32,
}

impl Rows {
    /// The rows that some components lie in and those beside them, and all between.
    fn around(grid: &Grid, components: &Components, some: &[u32]) -> Self {
        let rows_y = grid.dims[1];
        let number = |run: &Run| run.number(rows_y);
        let runs = || some.iter().map(|&component| &components.portions[component as usize].runs);
        let lowest = runs().filter_map(|runs| runs.first().map(number)).min().unwrap_or(0);
        let highest = runs().filter_map(|runs| runs.last().map(number)).max().unwrap_or(0);
        let (first, behind) = (lowest.saturating_sub(rows_y), highest + rows_y + 1);
        let within = |runs: &[Run]| {
            runs.partition_point(|run| number(run) < first)..runs.partition_point(|run| number(run) < behind)
        };

        // One more row makes room for where each begins.
        let mut first_of_row = vec![0_u32; behind - first + 2];
        for Portion { runs, .. } in &components.portions {
            for run in &runs[within(runs)] {
                first_of_row[number(run) - first + 2] += 1;
            }
        }
        let mut sum = 0;
        for first in &mut first_of_row {
            sum += *first;
            *first = sum;
        }
        let mut stretches = vec![Stretch::default(); sum as usize];
        for (Portion { runs, .. }, component) in components.portions.iter().zip(0..) {
            for run in &runs[within(runs)] {
                let place = &mut first_of_row[number(run) - first + 1];
                stretches[*place as usize] = Stretch { component, start: run.start, end: run.end };
                *place += 1;
            }
        }
        Self { first, first_of_row, stretches }
    }

    /// In no order.
    fn row(&self, row: usize) -> &[Stretch] {
        let row = row - self.first;
        &self.stretches[self.first_of_row[row] as usize..self.first_of_row[row + 1] as usize]
    }
}

/// Where in the list the lightest sliver is; the least number of equals.
fn lightest(slivers: &[u32], material: &[f64]) -> Option<usize> {
    let weight = |at: usize| material[slivers[at] as usize];
    (0..slivers.len()).min_by(|&a, &b| weight(a).total_cmp(&weight(b)).then(slivers[a].cmp(&slivers[b])))
}

/// The set that shares the most voxel faces with a sliver's components, the least number of equals.
fn closest_neighbour(
    grid: &Grid,
    components: &Components,
    rows: &Rows,
    sets: &mut DisjointSets,
    sliver: &[u32],
) -> Option<u32> {
    let own = sets.root(*sliver.first()?);
    let mut faces: Vec<(u32, u32)> = Vec::new();
    let mut count = |other: &Stretch, touching: u32| {
        let set = sets.root(other.component);
        if set != own && touching > 0 {
            match faces.iter_mut().find(|(known, _)| *known == set) {
                Some((_, count)) => *count += touching,
                None => faces.push((set, touching)),
            }
        }
    };
    for run in sliver.iter().flat_map(|&component| &components.portions[component as usize].runs) {
        let row = run.number(grid.dims[1]);
        for there in rows.row(row) {
            count(there, u32::from(there.end == run.start || run.end == there.start));
        }
        for beside in rows_beside(grid, row) {
            for there in rows.row(beside) {
                count(there, there.end.min(run.end).saturating_sub(there.start.max(run.start)));
            }
        }
    }
    faces.into_iter().max_by(|a, b| a.1.cmp(&b.1).then(b.0.cmp(&a.0))).map(|(set, _)| set)
}

/// Numbers the sets that have mass, in the order of their first components.
fn number_pieces(sets: &mut DisjointSets, material: &[f64]) -> Pieces {
    let count = material.len();
    let mut of_set = vec![0.0; count];
    for component in 0..count {
        of_set[sets.root(component as u32) as usize] += material[component];
    }
    let mut of_component = vec![NONE; count];
    let mut members: Vec<Vec<u32>> = Vec::new();
    for component in 0..count as u32 {
        let root = sets.root(component) as usize;
        if of_set[root] <= 0.0 {
            continue;
        }
        if of_component[root] == NONE {
            of_component[root] = members.len() as u32;
            members.push(Vec::new());
        }
        let piece = of_component[root];
        of_component[component as usize] = piece;
        members[piece as usize].push(component);
    }
    for piece in &mut members {
        piece.sort_by(|&a, &b| material[b as usize].total_cmp(&material[a as usize]).then(a.cmp(&b)));
    }
    Pieces { of_component, components: members }
}
