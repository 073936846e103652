use super::*;
use frangible_geometry::LevelSet;
use proptest::prelude::*;

/// A solid whose inside and coverage are noise.
fn noise(phi: Vec<f32>, dims: [usize; 3]) -> GridSolid {
    let grid = Grid { origin: DVec3::ZERO, spacing: 1.0, dims };
    let coverage: Vec<f32> = phi.iter().map(|&phi| (0.5 - phi).clamp(0.0, 1.0)).collect();
    GridSolid::with_coverage(LevelSet::new(grid, phi), &coverage)
}

/// Shares by a number for each node.
fn shares_of(solid: &GridSolid, region_of_node: &[u32]) -> Shares {
    let mut shares = Shares::default();
    for row in 0..solid.material().rows() {
        shares.first_of_row.push(shares.all.len() as u32);
        for span in solid.material().row(row) {
            for i in span.start..span.end {
                let region = region_of_node[row * solid.grid().dims[0] + i as usize];
                let place = [row % solid.grid().dims[1], row / solid.grid().dims[1]];
                let mut run = Run::empty(place.map(|n| n as u32), i);
                run.add(&Span { start: i, end: i + 1, ..*span }, solid.grid().middle_along_x());
                shares.all.push(Share { run, region });
            }
        }
    }
    shares.first_of_row.push(shares.all.len() as u32);
    shares
}

fn neighbours(grid: &Grid, node: usize) -> impl Iterator<Item = usize> {
    let (row, i) = (node / grid.dims[0], node % grid.dims[0]);
    let width = grid.dims[0];
    let along = [(i > 0).then(|| node - 1), (i + 1 < width).then_some(node + 1)];
    let across = rows_beside(grid, row).map(move |row| row * width + i);
    along.into_iter().flatten().chain(across)
}

/// Reference: flood fill from each node that has no number yet.
fn flood_fill(solid: &GridSolid, region_of_node: &[u32]) -> Vec<u32> {
    let grid = solid.grid();
    let inside = |node: usize| solid.level_set().phi()[node] <= 0.0;
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
                let same = region_of_node[other] == region_of_node[seed];
                if inside(other) && number[other] == NONE && same {
                    number[other] = next;
                    frontier.push(other);
                }
            }
        }
        next += 1;
    }
    number
}

/// Numbers by share, as numbers by node.
fn by_node(solid: &GridSolid, shares: &Shares, of_share: &[u32]) -> Vec<u32> {
    let mut nodes = vec![NONE; solid.grid().len()];
    for row in 0..shares.rows() {
        for at in shares.row(row) {
            for i in shares.all[at].run.start..shares.all[at].run.end {
                nodes[row * solid.grid().dims[0] + i as usize] = of_share[at];
            }
        }
    }
    nodes
}

fn field() -> impl Strategy<Value = (GridSolid, Vec<u32>)> {
    let dims = (2..9usize, 2..7usize, 2..7usize);
    dims.prop_flat_map(|(x, y, z)| {
        let count = x * y * z;
        let nodes =
            (prop::collection::vec(-1.0..1.0f32, count), prop::collection::vec(0..3u32, count));
        nodes.prop_map(move |(phi, regions)| (noise(phi, [x, y, z]), regions))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// Spans and union-find give what flood fill gives, with the same numbers.
    #[test]
    fn components_are_those_of_flood_fill((solid, regions) in field()) {
        let shares = shares_of(&solid, &regions);
        let found = connect_inside(&solid, &shares);
        prop_assert_eq!(by_node(&solid, &shares, &found.of_share), flood_fill(&solid, &regions));
    }

    /// All material has a component; surface voxels belong to a touching component, of their own
    /// region if possible.
    #[test]
    fn no_material_is_left_over((solid, regions) in field()) {
        let mut shares = shares_of(&solid, &regions);
        let inside = connect_inside(&solid, &shares);
        let inside = by_node(&solid, &shares, &inside.of_share);
        let all = label_components(&solid, &mut shares, None);
        let of_node = by_node(&solid, &shares, &all.of_share);
        for (node, &coverage) in solid.coverage().iter().enumerate() {
            if inside[node] != NONE {
                prop_assert_eq!(of_node[node], inside[node]);
                continue;
            }
            prop_assert_eq!(of_node[node] != NONE, coverage > 0.0);
            if of_node[node] == NONE {
                continue;
            }
            let around: Vec<usize> = neighbours(solid.grid(), node).collect();
            let of_own_region = around.iter().any(|&other| {
                inside[other] != NONE && regions[other] == regions[node]
            });
            if of_own_region {
                prop_assert_eq!(all.region[of_node[node] as usize], regions[node]);
            }
            let touches = around.iter().any(|&other| of_node[other] == of_node[node]);
            let alone = around.iter().all(|&other| of_node[other] == NONE);
            prop_assert!(touches || alone);
        }
    }
}
