//! Fragments too small for the grid join a neighbour. Nothing vanishes.

use super::{
    components::{Components, neighbours},
    regions::NONE,
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

/// Merges each component of less than `smallest` voxels of material with the neighbour with which it shares the most
/// voxel faces, the lightest first. One that touches no other stays as it is.
pub(crate) fn merge_slivers(solid: &GridSolid, components: &Components, smallest: f64) -> Pieces {
    // Material of each component, in voxels.
    let count = components.region.len();
    let mut material = vec![0.0; count];
    for (&component, &coverage) in components.of_node.iter().zip(&solid.coverage) {
        if component != NONE {
            material[component as usize] += f64::from(coverage);
        }
    }
    let mut sets = DisjointSets::new(count);
    let mut nodes = sliver_nodes(components, &material, smallest);
    let mut of_set = material.clone();

    // Merge the lightest sliver until each has grown up or stands alone.
    let mut slivers: Vec<u32> = (0..count as u32).filter(|&c| material[c as usize] < smallest).collect();
    while let Some(at) = lightest(&slivers, &of_set) {
        let sliver = slivers.swap_remove(at);
        let own_nodes = std::mem::take(&mut nodes[sliver as usize]);
        let Some(host) = closest_neighbour(solid, components, &mut sets, sliver, &own_nodes) else {
            continue;
        };
        sets.unite(sliver, host);
        let merged = sets.root(host);
        let sum = of_set[sliver as usize] + of_set[host as usize];
        slivers.retain(|&other| other != host);
        if sum < smallest {
            let mut all = std::mem::take(&mut nodes[host as usize]);
            all.extend(own_nodes);
            nodes[merged as usize] = all;
            slivers.push(merged);
        }
        of_set[merged as usize] = sum;
    }
    number_pieces(&mut sets, &material)
}

/// The nodes of each component that is a sliver; none for the others.
fn sliver_nodes(components: &Components, material: &[f64], smallest: f64) -> Vec<Vec<usize>> {
    let mut nodes = vec![Vec::new(); material.len()];
    for (node, &component) in components.of_node.iter().enumerate() {
        if component != NONE && material[component as usize] < smallest {
            nodes[component as usize].push(node);
        }
    }
    nodes
}

/// Where in the list the lightest sliver is; the least number of equals.
fn lightest(slivers: &[u32], material: &[f64]) -> Option<usize> {
    let weight = |at: usize| material[slivers[at] as usize];
    (0..slivers.len()).min_by(|&a, &b| weight(a).total_cmp(&weight(b)).then(slivers[a].cmp(&slivers[b])))
}

/// The set that shares the most voxel faces with a sliver's nodes, the least number of equals.
fn closest_neighbour(
    solid: &GridSolid,
    components: &Components,
    sets: &mut DisjointSets,
    sliver: u32,
    nodes: &[usize],
) -> Option<u32> {
    let mut faces: Vec<(u32, usize)> = Vec::new();
    for &node in nodes {
        for other in neighbours(solid.level_set.grid(), node) {
            let component = components.of_node[other];
            if component == NONE {
                continue;
            }
            let set = sets.root(component);
            if set != sliver {
                match faces.iter_mut().find(|(known, _)| *known == set) {
                    Some((_, count)) => *count += 1,
                    None => faces.push((set, 1)),
                }
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
