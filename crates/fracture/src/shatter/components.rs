//! The connected parts of each region's share of a body [Su09 sec. 4.2].

use super::regions::NONE;
use frangible_geometry::disjoint_sets::DisjointSets;
use frangible_geometry::{Grid, GridSolid};

/// Which connected part each node belongs to.
#[derive(Debug)]
pub(crate) struct Components {
    /// Component of each node whose voxel holds material or that is inside; [`NONE`] elsewhere.
    pub(crate) of_node: Vec<u32>,
    /// Region of each component.
    pub(crate) region: Vec<u32>,
}

/// The up to six nodes that share a face with a node's voxel.
pub(crate) fn neighbours(grid: &Grid, node: usize) -> impl Iterator<Item = usize> {
    let at = grid.coordinates(node);
    let strides = [1, grid.dims[0], grid.dims[0] * grid.dims[1]];
    let dims = grid.dims;
    (0..3).flat_map(move |axis| {
        let below = (at[axis] > 0).then(|| node - strides[axis]);
        let above = (at[axis] + 1 < dims[axis]).then(|| node + strides[axis]);
        [below, above].into_iter().flatten()
    })
}

/// Connects the nodes inside of the body that share a region and a voxel face, then gives each voxel on the surface,
/// whose node lies outside but which holds material, to a component next to it.
pub(crate) fn connected_components(solid: &GridSolid, region_of_node: &[u32]) -> Components {
    let mut components = connect_inside(solid, region_of_node);
    let pending = attach_surface_voxels(solid, region_of_node, &mut components);
    found_islands(solid, region_of_node, &mut components, &pending);
    components
}

/// Consecutive nodes of a row, inside of the body and in one region.
struct Run {
    start: u32,
    /// One past the last.
    end: u32,
    region: u32,
}

/// Components of the nodes inside of the body, numbered in the order of their first nodes.
fn connect_inside(solid: &GridSolid, region_of_node: &[u32]) -> Components {
    let grid = solid.level_set.grid();
    let (runs, first_run_of_row) = find_runs(grid, solid.level_set.phi(), region_of_node);

    // Unite each run with those that it touches in the rows below along y and along z.
    let mut sets = DisjointSets::new(runs.len());
    let rows_of = |row: usize| first_run_of_row[row]..first_run_of_row[row + 1];
    for row in 0..first_run_of_row.len() - 1 {
        let [y, z] = [row % grid.dims[1], row / grid.dims[1]];
        if y > 0 {
            unite_touching(&runs, rows_of(row - 1), rows_of(row), grid.dims[0], &mut sets);
        }
        if z > 0 {
            let below = row - grid.dims[1];
            unite_touching(&runs, rows_of(below), rows_of(row), grid.dims[0] * grid.dims[1], &mut sets);
        }
    }

    // A root is the first run of its set: number the sets in that order and label their nodes.
    let mut components = Components { of_node: vec![NONE; grid.len()], region: Vec::new() };
    let mut number = vec![NONE; runs.len()];
    for (at, run) in runs.iter().enumerate() {
        let root = sets.root(at as u32) as usize;
        if root == at {
            number[at] = components.region.len() as u32;
            components.region.push(run.region);
        }
        components.of_node[run.start as usize..run.end as usize].fill(number[root]);
    }
    components
}

/// All runs in node order, and for each row the number of its first run; one more entry at the end.
fn find_runs(grid: &Grid, phi: &[f32], region_of_node: &[u32]) -> (Vec<Run>, Vec<usize>) {
    let mut runs: Vec<Run> = Vec::new();
    let mut first_run_of_row = Vec::with_capacity(grid.dims[1] * grid.dims[2] + 1);
    for row in 0..grid.dims[1] * grid.dims[2] {
        first_run_of_row.push(runs.len());
        let mut open = NONE;
        for node in row * grid.dims[0]..(row + 1) * grid.dims[0] {
            let region = if phi[node] <= 0.0 { region_of_node[node] } else { NONE };
            if region != NONE {
                match runs.last_mut() {
                    Some(run) if open == region => run.end += 1,
                    _ => runs.push(Run { start: node as u32, end: node as u32 + 1, region }),
                }
            }
            open = region;
        }
    }
    first_run_of_row.push(runs.len());
    (runs, first_run_of_row)
}

/// Unites the runs of two neighbouring rows, `stride` nodes apart, that share a region and a voxel face.
fn unite_touching(
    runs: &[Run],
    lower: std::ops::Range<usize>,
    upper: std::ops::Range<usize>,
    stride: usize,
    sets: &mut DisjointSets,
) {
    let stride = stride as u32;
    let (mut a, mut b) = (lower.start, upper.start);
    while a < lower.end && b < upper.end {
        let (below, above) = (&runs[a], &runs[b]);
        let overlap = below.start + stride < above.end && above.start < below.end + stride;
        if overlap && below.region == above.region {
            sets.unite(a as u32, b as u32);
        }
        if below.end + stride <= above.end {
            a += 1;
        } else {
            b += 1;
        }
    }
}

/// Gives surface voxels to components that they touch, first of their own region, then of any; from the body outwards,
/// one layer at a time. Returns those that touch nothing.
fn attach_surface_voxels(
    solid: &GridSolid,
    region_of_node: &[u32],
    components: &mut Components,
) -> Vec<usize> {
    let grid = solid.level_set.grid();
    let phi = solid.level_set.phi();
    let mut pending: Vec<usize> = (0..grid.len())
        .filter(|&node| solid.coverage[node] > 0.0 && components.of_node[node] == NONE)
        .collect();
    for own_region_only in [true, false] {
        loop {
            // The deepest neighbour that has a component; the first of equals.
            let adopter = |&node: &usize| {
                let fits = |other: &usize| {
                    let component = components.of_node[*other];
                    component != NONE
                        && (!own_region_only || components.region[component as usize] == region_of_node[node])
                };
                let deepest = neighbours(grid, node).filter(fits).min_by(|&a, &b| phi[a].total_cmp(&phi[b]));
                deepest.map(|other| (node, components.of_node[other]))
            };
            let adopted: Vec<(usize, u32)> = pending.iter().filter_map(adopter).collect();
            if adopted.is_empty() {
                break;
            }
            for (node, component) in adopted {
                components.of_node[node] = component;
            }
            pending.retain(|&node| components.of_node[node] == NONE);
        }
    }
    pending
}

/// Material without any node inside, too thin for the grid: each connected part becomes a component of its own.
fn found_islands(solid: &GridSolid, region_of_node: &[u32], components: &mut Components, pending: &[usize]) {
    let grid = solid.level_set.grid();
    for &seed in pending {
        if components.of_node[seed] != NONE {
            continue;
        }
        let island = components.region.len() as u32;
        components.region.push(region_of_node[seed]);
        components.of_node[seed] = island;
        let mut frontier = vec![seed];
        while let Some(node) = frontier.pop() {
            for other in neighbours(grid, node) {
                if solid.coverage[other] > 0.0 && components.of_node[other] == NONE {
                    components.of_node[other] = island;
                    frontier.push(other);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_geometry::LevelSet;
    use glam::DVec3;
    use proptest::prelude::*;

    /// A solid whose inside and coverage are noise.
    fn noise(phi: Vec<f32>, dims: [usize; 3]) -> GridSolid {
        let grid = Grid { origin: DVec3::ZERO, spacing: 1.0, dims };
        let mut solid = GridSolid::from_level_set(LevelSet::new(grid, phi));
        solid.coverage = solid.level_set.phi().iter().map(|&phi| (0.5 - phi).clamp(0.0, 1.0)).collect();
        solid
    }

    /// Reference: flood fill from each node that has no number yet.
    fn flood_fill(solid: &GridSolid, region_of_node: &[u32]) -> Vec<u32> {
        let grid = solid.level_set.grid();
        let inside = |node: usize| solid.level_set.phi()[node] <= 0.0;
        let mut number = vec![NONE; grid.len()];
        let mut next = 0;
        for seed in 0..grid.len() {
            if !inside(seed) || number[seed] != NONE {
                continue;
            }
            let mut frontier = vec![seed];
            number[seed] = next;
            while let Some(node) = frontier.pop() {
                for other in neighbours(grid, node) {
                    if inside(other) && number[other] == NONE && region_of_node[other] == region_of_node[seed]
                    {
                        number[other] = next;
                        frontier.push(other);
                    }
                }
            }
            next += 1;
        }
        number
    }

    fn field() -> impl Strategy<Value = (GridSolid, Vec<u32>)> {
        let dims = (2..9usize, 2..7usize, 2..7usize);
        dims.prop_flat_map(|(x, y, z)| {
            let count = x * y * z;
            let nodes = (prop::collection::vec(-1.0..1.0f32, count), prop::collection::vec(0..3u32, count));
            nodes.prop_map(move |(phi, regions)| (noise(phi, [x, y, z]), regions))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        /// Runs and union-find give what flood fill gives, with the same numbers.
        #[test]
        fn components_are_those_of_flood_fill((solid, regions) in field()) {
            let found = connect_inside(&solid, &regions);
            prop_assert_eq!(found.of_node, flood_fill(&solid, &regions));
        }

        /// All material has a component; surface voxels are in one that they touch, in one of their region if they can.
        #[test]
        fn no_material_is_left_over((solid, regions) in field()) {
            let inside = connect_inside(&solid, &regions);
            let all = connected_components(&solid, &regions);
            for node in 0..solid.coverage.len() {
                if inside.of_node[node] != NONE {
                    prop_assert_eq!(all.of_node[node], inside.of_node[node]);
                    continue;
                }
                prop_assert_eq!(all.of_node[node] != NONE, solid.coverage[node] > 0.0);
                if all.of_node[node] == NONE {
                    continue;
                }
                let around: Vec<usize> = neighbours(solid.level_set.grid(), node).collect();
                let of_own_region = around.iter().any(|&other| {
                    inside.of_node[other] != NONE && regions[other] == regions[node]
                });
                if of_own_region {
                    prop_assert_eq!(all.region[all.of_node[node] as usize], regions[node]);
                }
                let touches = around.iter().any(|&other| all.of_node[other] == all.of_node[node]);
                let alone = around.iter().all(|&other| all.of_node[other] == NONE);
                prop_assert!(touches || alone);
            }
        }
    }
}
