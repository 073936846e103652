//! Fragments too small for the grid join a neighbour. Nothing vanishes.

use super::{
    components::{Components, rows_beside},
    regions::{NONE, Shares},
};
use frangible_geometry::GridSolid;
use frangible_geometry::disjoint_sets::DisjointSets;

/// The fragments, as sets of components.
#[derive(Debug)]
pub(crate) struct Pieces {
    /// Fragment of each component; [`NONE`] for one without mass.
    pub(crate) of_component: Vec<u32>,
    /// Components of each fragment, the heaviest first.
    pub(crate) components: Vec<Vec<u32>>,
}

/// A share: its row and its index.
type Place = (usize, usize);

/// Merges each component of less than `smallest` voxels of material with the neighbour with which it shares the most
/// voxel faces, the lightest first. One that touches no other stays as it is.
pub(crate) fn merge_slivers(
    solid: &GridSolid,
    shares: &Shares,
    components: &Components,
    smallest: f64,
) -> Pieces {
    let material = &components.material;
    let count = components.region.len();
    let mut sets = DisjointSets::new(count);
    let mut slivers: Vec<u32> = (0..count as u32).filter(|&c| material[c as usize] < smallest).collect();
    if slivers.is_empty() {
        return number_pieces(&mut sets, material);
    }
    let mut places = sliver_places(shares, components, smallest);
    let mut of_set = material.clone();

    // Merge the lightest sliver until each has grown up or stands alone.
    while let Some(at) = lightest(&slivers, &of_set) {
        let sliver = slivers.swap_remove(at);
        let own = std::mem::take(&mut places[sliver as usize]);
        let Some(host) = closest_neighbour(solid, shares, components, &mut sets, &own) else {
            continue;
        };
        sets.unite(sliver, host);
        let merged = sets.root(host);
        let sum = of_set[sliver as usize] + of_set[host as usize];
        slivers.retain(|&other| other != host);
        if sum < smallest {
            let mut all = std::mem::take(&mut places[host as usize]);
            all.extend(own);
            places[merged as usize] = all;
            slivers.push(merged);
        }
        of_set[merged as usize] = sum;
    }
    number_pieces(&mut sets, material)
}

/// The shares of each component that is a sliver; none for the others.
fn sliver_places(shares: &Shares, components: &Components, smallest: f64) -> Vec<Vec<Place>> {
    let mut places = vec![Vec::new(); components.region.len()];
    for row in 0..shares.rows() {
        for at in shares.row(row) {
            let component = components.of_share[at] as usize;
            if components.material[component] < smallest {
                places[component].push((row, at));
            }
        }
    }
    places
}

/// Where in the list the lightest sliver is; the least number of equals.
fn lightest(slivers: &[u32], material: &[f64]) -> Option<usize> {
    let weight = |at: usize| material[slivers[at] as usize];
    (0..slivers.len()).min_by(|&a, &b| weight(a).total_cmp(&weight(b)).then(slivers[a].cmp(&slivers[b])))
}

/// The set that shares the most voxel faces with a sliver's shares, the least number of equals.
fn closest_neighbour(
    solid: &GridSolid,
    shares: &Shares,
    components: &Components,
    sets: &mut DisjointSets,
    sliver: &[Place],
) -> Option<u32> {
    let own = sets.root(components.of_share[sliver.first()?.1]);
    let mut faces: Vec<(u32, u32)> = Vec::new();
    let mut count = |other: usize, touching: u32| {
        let set = sets.root(components.of_share[other]);
        if set != own && touching > 0 {
            match faces.iter_mut().find(|(known, _)| *known == set) {
                Some((_, count)) => *count += touching,
                None => faces.push((set, touching)),
            }
        }
    };
    for &(row, at) in sliver {
        let span = shares.all[at].run;
        for other in shares.row(row) {
            let there = shares.all[other].run;
            count(other, u32::from(there.end == span.start || span.end == there.start));
        }
        for beside in rows_beside(solid.grid(), row) {
            for other in shares.row(beside) {
                let there = shares.all[other].run;
                count(other, there.end.min(span.end).saturating_sub(there.start.max(span.start)));
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
