//! Fragments too small for the grid join a neighbour. Nothing vanishes.

use super::components::{Components, rows_beside};
use crate::shatter::regions::intervals::NONE;
use crate::slivers::{Contact, Groups, Smallest};
use frangible_geometry::{Grid, GridSolid, Portion, Run};
use std::collections::BTreeMap;

/// A contact with what stays whole counts as so much of one with a piece.
const TO_REST: f64 = 1e-6;

/// The fragments, as sets of components.
#[derive(Debug)]
pub(crate) struct Pieces {
    /// Fragment of each component; [`NONE`] for one without mass.
    pub(crate) of_component: Vec<u32>,
    /// Components of each fragment, the heaviest first.
    pub(crate) components: Vec<Vec<u32>>,
}

/// Merges each component of less than `voxels` of material, or smaller than the smallest piece,
/// with the neighbour with which it shares the most voxel faces, the lightest first. One that
/// touches no other stays as it is, unless it is smaller than the smallest volume. What a break
/// leaves whole, the region `rest`, takes up what has no other neighbour.
pub(crate) fn merge_slivers(
    solid: &GridSolid,
    components: &Components,
    voxels: f64,
    smallest: &Smallest,
    rest: Option<u32>,
) -> Pieces {
    let material = &components.material;
    let spacing = solid.grid().spacing;
    let in_voxels =
        Smallest { volume: smallest.volume / (spacing * spacing * spacing), ..*smallest };
    let least = voxels.max(in_voxels.least(material));
    let too_small: Vec<bool> = material.iter().map(|&material| material < least).collect();
    let mut groups = Groups::new(material, &too_small);
    if too_small.contains(&true) {
        let mut contacts = contacts(solid.grid(), components, &too_small);
        let is_rest = |part: usize| Some(components.region[part]) == rest;
        for (_, faces) in contacts.iter_mut().filter(|(pair, _)| pair.iter().any(|&at| is_rest(at)))
        {
            *faces *= TO_REST;
        }
        groups.join(&contacts, |_, _, material| Some(material < least));
        groups.join_loose(|sliver, _| material[sliver] < in_voxels.volume);
    }
    number_pieces(&groups.of_piece(), material)
}

/// Owners of the nodes in neighbouring rows.
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
    /// Rows of the components, their neighbours, and all rows between.
    fn around(grid: &Grid, components: &Components, some: &[u32]) -> Self {
        let rows_y = grid.dims[1];
        let number = |run: &Run| run.number(rows_y);
        let runs = || some.iter().map(|&component| &components.portions[component as usize].runs);
        let lowest = runs().filter_map(|runs| runs.first().map(number)).min().unwrap_or(0);
        let highest = runs().filter_map(|runs| runs.last().map(number)).max().unwrap_or(0);
        let (first, behind) = (lowest.saturating_sub(rows_y), highest + rows_y + 1);
        let within = |runs: &[Run]| {
            runs.partition_point(|run| number(run) < first)
                ..runs.partition_point(|run| number(run) < behind)
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

/// Number of common voxel faces of each sliver with other components; each pair once.
fn contacts(grid: &Grid, components: &Components, too_small: &[bool]) -> Vec<Contact> {
    let slivers: Vec<u32> =
        (0..).zip(too_small).filter(|&(_, &small)| small).map(|(at, _)| at).collect();
    let rows = Rows::around(grid, components, &slivers);
    let mut contacts = Vec::new();
    for &sliver in &slivers {
        let mut faces: BTreeMap<u32, u32> = BTreeMap::new();
        let mut count = |other: &Stretch, touching: u32| {
            // A pair of slivers is counted by its first.
            let is_counted = other.component < sliver && too_small[other.component as usize];
            if other.component != sliver && touching > 0 && !is_counted {
                *faces.entry(other.component).or_default() += touching;
            }
        };
        for run in &components.portions[sliver as usize].runs {
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
        let contact = |(other, count)| ([sliver as usize, other as usize], f64::from(count));
        contacts.extend(faces.into_iter().map(contact));
    }
    contacts
}

/// Numbers the groups that have mass, in the order of their first components.
fn number_pieces(of_group: &[usize], material: &[f64]) -> Pieces {
    let count = material.len();
    let mut sums = vec![0.0; count];
    for (&group, &material) in of_group.iter().zip(material) {
        sums[group] += material;
    }
    let mut piece_of = vec![NONE; count];
    let mut of_component = vec![NONE; count];
    let mut members: Vec<Vec<u32>> = Vec::new();
    for (component, &group) in of_group.iter().enumerate() {
        if sums[group] <= 0.0 {
            continue;
        }
        if piece_of[group] == NONE {
            piece_of[group] = members.len() as u32;
            members.push(Vec::new());
        }
        of_component[component] = piece_of[group];
        members[piece_of[group] as usize].push(component as u32);
    }
    for piece in &mut members {
        piece.sort_by(|&a, &b| {
            material[b as usize].total_cmp(&material[a as usize]).then(a.cmp(&b))
        });
    }
    Pieces { of_component, components: members }
}
