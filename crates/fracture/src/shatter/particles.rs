//! Which fragment each surface sample goes to [Su09 sec. 4.2 "Surface Particles"].

use super::{
    ShatterSettings,
    components::{Components, neighbours},
    crack_samples::crack_samples,
    regions::NONE,
    slivers::Pieces,
};
use crate::pattern::Region;
use frangible_geometry::{GridSolid, Shape};
use glam::{DVec3, Vec3};
use std::collections::BTreeSet;

/// A body with fewer samples cannot stand on anything.
const FEWEST_SAMPLES: usize = 4;

/// Samples closer than this are one, in units of the distance between samples.
const SAME: f64 = 0.25;

/// Layers of nodes around a point's cell in which its fragment is looked for, one after the other. A circle around a cell
/// fits into a wedge of 20 degrees four spacings from its tip: that far can be the first node inside.
const REACHES: [i64; 4] = [0, 1, 2, 4];

/// What a sample's fragment is looked up in.
struct Lookup<'a> {
    parent: &'a GridSolid,
    regions: &'a [Region],
    components: &'a Components,
    pieces: &'a Pieces,
    solids: &'a [GridSolid],
}

/// Samples of each fragment in the grid frame [m]: those of the parent, each given to one fragment, and those of the
/// cracks, given to the fragments on both sides.
pub(crate) fn assign_particles(
    parent: (&Shape, &GridSolid),
    regions: &[Region],
    components: &Components,
    pieces: &Pieces,
    solids: &[GridSolid],
    settings: &ShatterSettings,
) -> Vec<Vec<Vec3>> {
    let (shape, parent) = parent;
    let spacing = settings.sample_spacing_voxels * parent.level_set.grid().spacing;
    let lookup = Lookup { parent, regions, components, pieces, solids };
    let mut fragments: Vec<Collector> = solids.iter().map(|_| Collector::new(SAME * spacing)).collect();

    // Cracks first: their corners and rims are what a fragment stands on.
    for (region, number) in regions.iter().zip(0..) {
        for point in crack_samples(parent, region, spacing) {
            if let Some(piece) = lookup.piece_beside_crack(point, number) {
                fragments[piece].add(point);
            }
        }
    }
    let grid_from_body = shape.body_from_grid.inverse();
    for sample in shape.samples() {
        let point = grid_from_body.point(sample.as_dvec3());
        match lookup.piece_at(point) {
            Some((piece, true)) => fragments[piece].add(point),
            // Far from all cracks no sample of one is in its place.
            Some((piece, false)) => fragments[piece].samples.push(point.as_vec3()),
            None => {}
        }
    }
    for (fragment, solid) in fragments.iter_mut().zip(solids) {
        if fragment.samples.len() < FEWEST_SAMPLES {
            project_surface_voxels(solid).into_iter().for_each(|point| fragment.add(point));
        }
    }
    fragments.into_iter().map(|fragment| fragment.samples).collect()
}

impl Lookup<'_> {
    /// The fragment that a point on the parent's surface belongs to, and whether others are near: of the components
    /// around it the one in whose region it lies deepest, then the one with the least level set.
    fn piece_at(&self, point: DVec3) -> Option<(usize, bool)> {
        for reach in REACHES {
            let around = self.components_around(point, reach);
            let depth = |component: u32| {
                let region = &self.regions[self.components.region[component as usize] as usize];
                (region.distance(point), self.value(component, point))
            };
            match around.as_slice() {
                [] => {}
                [only] => return Some((self.piece(*only), false)),
                [first, others @ ..] => {
                    let mut nearest = (*first, depth(*first));
                    for &other in others {
                        let at_other = depth(other);
                        if at_other < nearest.1 {
                            nearest = (other, at_other);
                        }
                    }
                    return Some((self.piece(nearest.0), true));
                }
            }
        }
        // Far from any material, as a sample of a coarser surface may be: the fragment with the least level set.
        let value = |piece: usize| self.solids[piece].level_set.value(point);
        let nearest = (0..self.solids.len()).min_by(|&a, &b| value(a).total_cmp(&value(b)))?;
        Some((nearest, true))
    }

    /// The fragment of `region` that a point on one of the region's cracks belongs to; none where the region has no
    /// material, or where the crack is healed because a sliver joined the fragment across.
    fn piece_beside_crack(&self, point: DVec3, region: u32) -> Option<usize> {
        for reach in REACHES {
            let around = self.components_around(point, reach);
            let own =
                around.iter().filter(|&&component| self.components.region[component as usize] == region);
            let nearer = |a: &&u32, b: &&u32| self.value(**a, point).total_cmp(&self.value(**b, point));
            if let Some(&nearest) = own.min_by(nearer) {
                let piece = self.piece(nearest);
                let healed = reach == 0 && self.is_inside(point, piece);
                return (!healed).then_some(piece);
            }
        }
        None
    }

    fn piece(&self, component: u32) -> usize {
        self.pieces.of_component[component as usize] as usize
    }

    /// Level set of a component's fragment at a point.
    fn value(&self, component: u32, point: DVec3) -> f32 {
        self.solids[self.piece(component)].level_set.value(point)
    }

    /// The parent's nodes at the corners of the cell that holds a point, and `reach` further on each side: lowest and
    /// highest.
    fn nodes_around(&self, point: DVec3, reach: i64) -> ([usize; 3], [usize; 3]) {
        let grid = self.parent.level_set.grid();
        let corner = grid.lattice_from_point(point).to_array().map(floor);
        let within = |axis: usize, n: i64| n.clamp(0, grid.dims[axis] as i64 - 1) as usize;
        let low = std::array::from_fn(|axis| within(axis, corner[axis] - reach));
        let high = std::array::from_fn(|axis| within(axis, corner[axis] + 1 + reach));
        (low, high)
    }

    /// The components with mass among those nodes, each once.
    fn components_around(&self, point: DVec3, reach: i64) -> Vec<u32> {
        let grid = self.parent.level_set.grid();
        let (low, high) = self.nodes_around(point, reach);
        let mut found = Vec::new();
        let mut last = NONE;
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                let row = grid.index(0, j, k);
                for &component in &self.components.of_node[row + low[0]..=row + high[0]] {
                    if component == NONE || component == last {
                        continue;
                    }
                    last = component;
                    let has_mass = self.pieces.of_component[component as usize] != NONE;
                    if has_mass && !found.contains(&component) {
                        found.push(component);
                    }
                }
            }
        }
        found
    }

    /// Whether all material around a point, and there is no gap in it, is of one piece.
    fn is_inside(&self, point: DVec3, piece: usize) -> bool {
        let grid = self.parent.level_set.grid();
        let (low, high) = self.nodes_around(point, 0);
        let is_own = |node: usize| {
            let component = self.components.of_node[node];
            component != NONE && self.pieces.of_component[component as usize] as usize == piece
        };
        (low[2]..=high[2])
            .all(|k| (low[1]..=high[1]).all(|j| (low[0]..=high[0]).all(|i| is_own(grid.index(i, j, k)))))
    }
}

/// The largest whole number that is not above `x`, without a call into the platform's library.
#[inline]
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero - i64::from(x < towards_zero as f64)
}

/// The samples of one fragment, none of them twice.
struct Collector {
    samples: Vec<Vec3>,
    /// The cubes that have one.
    taken: BTreeSet<u64>,
    /// Edge of these cubes, inverse [1/m].
    per_cube: f64,
}

impl Collector {
    fn new(same: f64) -> Self {
        Self { samples: Vec::new(), taken: BTreeSet::new(), per_cube: 1.0 / same }
    }

    /// Takes a point in, unless its place is taken.
    fn add(&mut self, point: DVec3) {
        // 21 bits an axis: two million cubes across, or round and round.
        let [x, y, z] = (point * self.per_cube).to_array().map(|x| floor(x + 0.5) as u64 & 0x1f_ffff);
        if self.taken.insert(x | y << 21 | z << 42) {
            self.samples.push(point.as_vec3());
        }
    }
}

/// The nodes of a solid's outermost voxels, moved onto its surface.
fn project_surface_voxels(solid: &GridSolid) -> Vec<DVec3> {
    let grid = solid.level_set.grid();
    let owned = |&node: &usize| solid.coverage[node] > 0.0;
    let at_surface = |node: &usize| neighbours(grid, *node).any(|other| !owned(&other));
    (0..grid.len())
        .filter(owned)
        .filter(at_surface)
        .map(|node| {
            let [i, j, k] = grid.coordinates(node);
            let point = grid.node(i, j, k);
            let (distance, gradient) = solid.level_set.value_and_gradient(point);
            let outward = gradient.as_dvec3().try_normalize().unwrap_or(DVec3::ZERO);
            // The distance of a sliver is rough: stay within the voxel.
            point - outward * f64::from(distance).clamp(-0.5 * grid.spacing, 0.5 * grid.spacing)
        })
        .collect()
}
