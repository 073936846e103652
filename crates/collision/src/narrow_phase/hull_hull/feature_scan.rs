//! Scans over faces, vertices and edges of hulls, eight lanes in single precision. The scan only
//! selects features, with an error of 1e-7 of the larger hull's size (for edges divided by the sine
//! between them); separations are then computed in double precision.

use crate::narrow_phase::hull_hull::placement::Ridge;
use crate::narrow_phase::hull_hull::scratch::RidgeColumns;
use frangible_geometry::{Columns, HalfSpace};
use frangible_math::{Instructions, Kernel, LANES, Mask, Single, Single3, Singles, Three};
use glam::DVec3;

/// Sine of the angle below which edges count as parallel [1]: a face normal then serves as well.
/// With a hundredth of it eleven shots end in the same bits.
pub(crate) const PARALLEL: f64 = 1e-3;

/// Depth of a point inside a hull, negative outside [m].
pub(crate) struct Inside<'a> {
    pub(crate) hull: &'a Columns,
    pub(crate) point: DVec3,
}

impl Kernel for Inside<'_> {
    type Output = f64;

    fn compute<I: Instructions>(self) -> f64 {
        let Self { hull, point } = self;
        let lever = point - hull.middle;
        let mut highest = f32::NEG_INFINITY;
        I::run(
            #[inline(always)]
            || {
                let lever = Single3::<I>::splat(lever);
                let mut heights = Single::same(f32::NEG_INFINITY);
                for [x, y, z, offset] in hull.faces() {
                    heights = heights.max(three([x, y, z]).dot(lever) - Single::of_column(offset));
                }
                highest = heights.largest();
            },
        );
        f64::from(-highest)
    }
}

/// Bits of [`MarkWithin`] for a vertex inside both half-spaces.
pub(crate) const IN_BOTH: u8 = 3;

/// Marks each vertex of `hull` with two bits, one per half-space containing it.
pub(crate) struct MarkWithin<'a> {
    pub(crate) hull: &'a Columns,
    pub(crate) spaces: &'a [HalfSpace; 2],
    pub(crate) marks: &'a mut Vec<u8>,
}

impl Kernel for MarkWithin<'_> {
    type Output = ();

    fn compute<I: Instructions>(self) {
        let Self { hull, spaces, marks } = self;
        let depth = |space: &HalfSpace| space.offset - space.normal.dot(hull.middle);
        let depths = [depth(&spaces[0]), depth(&spaces[1])];
        marks.resize(LANES * hull.vertices().len(), 0);
        I::run(
            #[inline(always)]
            || {
                let normals =
                    [Single3::<I>::splat(spaces[0].normal), Single3::splat(spaces[1].normal)];
                let depths = [Single::splat(depths[0]), Single::splat(depths[1])];
                for (block, [x, y, z]) in hull.vertices().iter().enumerate() {
                    let lever = three([x, y, z]);
                    let out_of_first = lever.dot(normals[0]).above(depths[0]);
                    let out_of_second = lever.dot(normals[1]).above(depths[1]);
                    for lane in 0..LANES {
                        let marks = &mut marks[LANES * block + lane];
                        *marks = u8::from(!out_of_first.get(lane))
                            | u8::from(!out_of_second.get(lane)) << 1;
                    }
                }
            },
        );
    }
}

/// Indices of the two ridges, one per hull, with the largest separation along their common
/// perpendicular, among non-parallel pairs that form a face of the Minkowski difference. The first
/// hull's ridges come with the largest bound first.
pub(crate) struct FurthestEdges<'a> {
    pub(crate) ridges: [&'a [Ridge]; 2],
    pub(crate) columns: &'a mut Vec<RidgeColumns>,
}

impl Kernel for FurthestEdges<'_> {
    type Output = Option<[usize; 2]>;

    fn compute<I: Instructions>(self) -> Option<[usize; 2]> {
        let Self { ridges: [first, second], columns } = self;
        // Columns of the second hull's ridges, relative to the first ridge's start; padding has zero
        // length.
        const NONE: Singles = Singles([0.0; LANES]);
        let origin = first.first()?.ends[0];
        columns.clear();
        columns.resize(second.len().div_ceil(LANES), [[NONE; 3]; 5]);
        for (at, ridge) in second.iter().enumerate() {
            let [beside, other_beside] = ridge.normals;
            let start = ridge.ends[0] - origin;
            let lines = [start, ridge.along, beside, other_beside, ridge.outward()];
            for (columns, line) in columns[at / LANES].iter_mut().zip(lines) {
                for (column, number) in columns.iter_mut().zip(line.to_array()) {
                    column.0[at % LANES] = number as f32;
                }
            }
        }

        let mut found = None;
        I::run(
            #[inline(always)]
            || {
                let parallel = Single::<I>::splat(PARALLEL * PARALLEL);
                let (mut best, mut of_first) = (Best::none(), Single::<I>::ZERO);
                for (at, ridge) in first.iter().enumerate() {
                    let is_bounded = ridge.bound < f64::INFINITY;
                    if is_bounded && ridge.bound < f64::from(best.number.largest()) {
                        break;
                    }
                    let (along, start) =
                        (Single3::splat(ridge.along), Single3::splat(ridge.ends[0] - origin));
                    let normals =
                        [Single3::splat(ridge.normals[0]), Single3::splat(ridge.normals[1])];
                    let squared_length = along.dot(along);
                    for (block, [other_start, other_along, beside, other_beside, outward]) in
                        columns.iter().enumerate()
                    {
                        // Arcs of the Gauss map: the arc between the first edge's normals must cross
                        // the arc between the second edge's negated normals, else other features are
                        // further apart.
                        let (other_along, beside, other_beside) =
                            (three_of(other_along), three_of(beside), three_of(other_beside));
                        let (c, d) = (beside.dot(along), other_beside.dot(along));
                        let (u, v) = (-normals[0].dot(other_along), -normals[1].dot(other_along));
                        let cross = negative(c * d).and(negative(u * v)).and(negative(-(c * v)));
                        if !cross.any() {
                            continue;
                        }
                        let across = along.cross(other_along);
                        let squared = across.dot(across);
                        let lengths = squared_length * other_along.dot(other_along);
                        let outward = across.dot(three_of(outward));
                        let apart = across.dot(start - three_of(other_start))
                            * (Single::same(1.0) / squared.sqrt());
                        let apart = negative(outward).select(-apart, apart);
                        let counts = cross.and(squared.above(parallel * lengths));
                        let apart = counts.select(apart, Single::same(f32::NEG_INFINITY));
                        of_first =
                            best.look(block, apart).select(Single::same(at as f32), of_first);
                    }
                }
                let lane = best.lane();
                if best.number.to_array()[lane] > f32::NEG_INFINITY {
                    found = Some([of_first.to_array()[lane] as usize, best.at()]);
                }
            },
        );
        found
    }
}

/// Lanes with negative numbers.
#[inline(always)]
fn negative<I: Instructions>(numbers: Single<I>) -> Mask {
    Single::ZERO.above(numbers)
}

/// Lower and upper extent of a hull along three unit vectors, from the frame's origin, as a vector
/// each [m]; in single precision, rounded outwards.
pub(crate) fn extents<I: Instructions>(hull: &Columns, along: [DVec3; 3]) -> (DVec3, DVec3) {
    /// Rounding allowance relative to the largest extent: several single-precision errors [1].
    const ROUNDING: f64 = 1e-6;
    let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
    I::run(
        #[inline(always)]
        || {
            let axes = along.map(Single3::<I>::splat);
            let mut most = [Single::same(f32::NEG_INFINITY); 6];
            for [x, y, z] in hull.vertices() {
                let vertex = three([x, y, z]);
                for (axis, along) in axes.into_iter().enumerate() {
                    let height = vertex.dot(along);
                    most[axis] = most[axis].max(height);
                    most[axis + 3] = most[axis + 3].max(-height);
                }
            }
            let [x, y, z, less_x, less_y, less_z] = most.map(|most| f64::from(most.largest()));
            (low, high) = (-DVec3::new(less_x, less_y, less_z), DVec3::new(x, y, z));
        },
    );
    let (middle, rounding) =
        (along.map(|along| along.dot(hull.middle)), ROUNDING * (high - low).max_element());
    (DVec3::from_array(middle) + low - rounding, DVec3::from_array(middle) + high + rounding)
}

/// Running maximum per lane over blocks of eight numbers.
pub(super) struct Best<I> {
    pub(super) number: Single<I>,
    /// Block of the maximum, the first on ties.
    block: Single<I>,
}

impl<I: Instructions> Best<I> {
    #[inline(always)]
    pub(super) fn none() -> Self {
        Self { number: Single::same(f32::NEG_INFINITY), block: Single::ZERO }
    }

    /// Compares the next block. Returns the lanes with a new maximum.
    #[inline(always)]
    pub(super) fn look(&mut self, block: usize, numbers: Single<I>) -> Mask {
        let is_better = numbers.above(self.number);
        self.number = is_better.select(numbers, self.number);
        self.block = is_better.select(Single::same(block as f32), self.block);
        is_better
    }

    /// Lane of the maximum in the earliest block.
    #[inline(always)]
    pub(super) fn lane(&self) -> usize {
        let (numbers, best) = (self.number.to_array(), self.number.largest());
        let (blocks, mut found) = (self.block.to_array(), (f32::INFINITY, 0));
        for lane in 0..LANES {
            if numbers[lane] == best && blocks[lane] < found.0 {
                found = (blocks[lane], lane);
            }
        }
        found.1
    }

    /// Index of the maximum.
    #[inline(always)]
    pub(super) fn at(&self) -> usize {
        let lane = self.lane();
        LANES * self.block.to_array()[lane] as usize + lane
    }
}

/// A vector per lane.
#[inline(always)]
pub(super) fn three<I: Instructions>([x, y, z]: [&Singles; 3]) -> Single3<I> {
    Three { x: Single::of_column(x), y: Single::of_column(y), z: Single::of_column(z) }
}

#[inline(always)]
fn three_of<I: Instructions>([x, y, z]: &[Singles; 3]) -> Single3<I> {
    three([x, y, z])
}

/// The same vector in all lanes.
#[inline(always)]
pub(super) fn same<I: Instructions>([x, y, z]: [f32; 3]) -> Single3<I> {
    Three { x: Single::same(x), y: Single::same(y), z: Single::same(z) }
}
