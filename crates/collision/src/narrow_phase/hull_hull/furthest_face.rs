//! Face of a hull that separates it furthest from another hull, eight lanes in single precision:
//! see [`feature_scan`](super::feature_scan).

use crate::narrow_phase::hull_hull::feature_scan::{Best, same, three};
use crate::narrow_phase::hull_hull::placement::Placement;
use crate::narrow_phase::hull_hull::scratch::FaceBlock;
use frangible_geometry::Columns;
use frangible_math::{Instructions, Kernel, LANES, Single, Single3, Singles, Three};
use glam::DMat3;

/// Face of `hull` with the largest separation from `other` (the first on ties), and the lowest
/// vertex of `other` above it.
pub(crate) struct FurthestFace<'a> {
    pub(crate) hull: &'a Columns,
    pub(crate) other: &'a Columns,
    pub(crate) hull_from_other: &'a Placement,
    pub(crate) other_from_hull: &'a Placement,
    pub(crate) blocks: &'a mut Vec<FaceBlock>,
    /// Vertices of `other` that were looked at: each the lowest over some face.
    pub(crate) lowest: &'a mut Vec<u32>,
}

/// Largest product of the blocks of eight faces of a hull, and of eight vertices of the other, up
/// to which all are compared [1]. With bounds a pair of hulls of 12 vertices takes 0.8 instead of
/// 0.5 us; from 48 vertices on they are faster. The features are the same.
const FEW_BLOCKS: usize = 64;

impl Kernel for FurthestFace<'_> {
    type Output = [usize; 2];

    fn compute<I: Instructions>(self) -> [usize; 2] {
        let mut found = [0; 2];
        self.lowest.clear();
        let is_small = self.hull.faces().len() * self.other.vertices().len() <= FEW_BLOCKS;
        I::run(
            #[inline(always)]
            || found = if is_small { self.of_all::<I>() } else { self.by_bounds::<I>() },
        );
        found
    }
}

impl FurthestFace<'_> {
    /// Compares all faces with all vertices.
    #[inline(always)]
    pub(crate) fn of_all<I: Instructions>(self) -> [usize; 2] {
        let (axes, between) = self.frame::<I>();
        let (mut best, mut of_best) = (Best::none(), Single3::ZERO);
        for (block, [x, y, z, offset]) in self.hull.faces().iter().enumerate() {
            let normal = three([x, y, z]);
            let up = axes[0] * normal.x + axes[1] * normal.y + axes[2] * normal.z;
            let height = lowest_over(self.other, up);
            let apart = height + between.dot(normal) - Single::of_column(offset);
            of_best = best.look(block, apart).select(up, of_best);
        }
        let lane = best.lane();
        let Three { x, y, z } = of_best;
        let up = [x.to_array()[lane], y.to_array()[lane], z.to_array()[lane]];
        let vertex = lowest_vertex::<I>(self.other, up).0;
        self.lowest.push(vertex as u32);
        [best.at(), vertex]
    }

    /// Looks at the face with the largest bound of its separation, until that is the separation. A
    /// face's bound is the height of the lowest vertex known: those that were lowest over other
    /// faces. The few that are needed make the search linear in both hulls; it finds the same
    /// features, bit for bit, as comparing all.
    #[inline(always)]
    pub(crate) fn by_bounds<I: Instructions>(self) -> [usize; 2] {
        let (axes, between) = self.frame::<I>();
        let Self { hull, other, blocks, lowest, .. } = self;
        // Begin with the face that the other hull's middle is furthest above.
        let mut best = Best::<I>::none();
        blocks.clear();
        for (block, [x, y, z, offset]) in hull.faces().iter().enumerate() {
            let normal = three([x, y, z]);
            let up = axes[0] * normal.x + axes[1] * normal.y + axes[2] * normal.z;
            let middle = between.dot(normal);
            let _ = best.look(block, middle - Single::of_column(offset));
            blocks.push(FaceBlock {
                up: [up.x, up.y, up.z].map(|column| Singles(column.to_array())),
                middle: Singles(middle.to_array()),
                offset: *offset,
                height: Singles([f32::INFINITY; LANES]),
                number: block as f32,
            });
        }
        let (mut face, mut at) = (best.at(), best.at() / LANES);
        let (mut most, mut found) = (f32::NEG_INFINITY, [face, 0]);
        for _ in 0..=LANES * blocks.len() {
            let Some(FaceBlock { up, middle, offset, .. }) = blocks.get(at) else { break };
            let lane = face % LANES;
            let (vertex, height) = lowest_vertex::<I>(other, up.map(|column| column.0[lane]));
            let apart = height + middle.0[lane] - offset.0[lane];
            if apart > most || apart == most && face < found[0] {
                (most, found) = (apart, [face, vertex]);
            }
            lowest.push(vertex as u32);
            (face, at) = bound::<I>(blocks, same(position(other, vertex)), most);
            if face == found[0] {
                break;
            }
        }
        found
    }

    /// Axes of the hull in the other hull's frame, and the way between their middles.
    #[inline(always)]
    fn frame<I: Instructions>(&self) -> ([Single3<I>; 3], Single3<I>) {
        let DMat3 { x_axis, y_axis, z_axis } = self.other_from_hull.matrix;
        let between = self.hull_from_other.point(self.other.middle) - self.hull.middle;
        ([x_axis, y_axis, z_axis].map(Single3::splat), Single3::splat(between))
    }
}

/// Bounds the separations of faces by one more vertex. Drops blocks below `most`, a separation
/// attained. Returns the face with the largest bound, the first on ties, and where its block is.
#[inline(always)]
fn bound<I: Instructions>(
    blocks: &mut Vec<FaceBlock>,
    vertex: Single3<I>,
    most: f32,
) -> (usize, usize) {
    let (mut best, mut kept) = (Best::<I>::none(), 0);
    let least = Single::same(most);
    for at in 0..blocks.len() {
        let mut block = blocks[at];
        let [x, y, z] = &block.up;
        let height = vertex.dot(three([x, y, z])).min(Single::of_column(&block.height));
        let apart = height + Single::of_column(&block.middle) - Single::of_column(&block.offset);
        if least.above(apart).not().any() {
            block.height = Singles(height.to_array());
            let _ = best.look(kept, apart);
            blocks[kept] = block;
            kept += 1;
        }
    }
    blocks.truncate(kept);
    let (at, lane) = (best.at() / LANES, best.at() % LANES);
    (LANES * blocks.get(at).map_or(0, |block| block.number as usize) + lane, at)
}

/// Lowest extent of a hull along eight directions, from its middle [m].
#[inline(always)]
fn lowest_over<I: Instructions>(hull: &Columns, up: Single3<I>) -> Single<I> {
    let mut lowest = Single::same(f32::INFINITY);
    for [x, y, z] in hull.vertices() {
        let mut heights = [Single::ZERO; LANES];
        for lane in 0..LANES {
            heights[lane] = same([x.0[lane], y.0[lane], z.0[lane]]).dot(up);
        }
        // Pairwise reduction shortens the dependency chain.
        for half in [4, 2, 1] {
            for lane in 0..half {
                heights[lane] = heights[lane].min(heights[lane + half]);
            }
        }
        lowest = lowest.min(heights[0]);
    }
    lowest
}

/// Lowest vertex along a direction, the first on ties, and its height from the hull's middle [m].
#[inline(always)]
fn lowest_vertex<I: Instructions>(hull: &Columns, [x, y, z]: [f32; 3]) -> (usize, f32) {
    let down = same::<I>([-x, -y, -z]);
    let mut best = Best::none();
    for (block, [x, y, z]) in hull.vertices().iter().enumerate() {
        let _ = best.look(block, three([x, y, z]).dot(down));
    }
    (best.at(), -best.number.to_array()[best.lane()])
}

/// Position of a vertex from the hull's middle [m].
#[inline(always)]
fn position(hull: &Columns, vertex: usize) -> [f32; 3] {
    hull.vertices()[vertex / LANES].map(|column| column.0[vertex % LANES])
}
