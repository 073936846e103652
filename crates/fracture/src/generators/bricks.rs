//! Masonry.

use crate::filling::Filling;
use crate::generators::parameters::{MOST_CELLS, deviation, require, require_box};
use crate::pattern::Pattern;
use crate::pattern::error::PatternError;
use crate::pattern::region::Region;
use frangible_geometry::HalfSpace;
use glam::{DVec2, DVec3};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bricks in running bond: courses along x, stacked along y, each shifted by half a brick; one
/// brick deep. Mortar breaks off in pieces of its own, a joint beside each brick and one above it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Bricks {
    /// Number of bricks along a course, joints included; at least 1.
    pub columns: usize,
    /// Number of courses, joints included; at least 1.
    pub courses: usize,
    /// Thickness of the joints relative to the height of a course, from 0 (none) to 0.5.
    pub mortar: f64,
    /// Irregularity from 0 to 1: displacement of the bricks' ends.
    pub jitter: f64,
    /// Of the random numbers.
    pub seed: u64,
    /// Shape of the pattern's box; only its proportions matter.
    #[schemars(with = "[f64; 3]")]
    pub half_extent: DVec3,
}

impl Default for Bricks {
    fn default() -> Self {
        // A brick of 240 x 71 mm with joints of 12 mm is three times as long as high.
        Self {
            columns: 6,
            courses: 18,
            mortar: 0.14,
            jitter: 0.1,
            seed: 1,
            half_extent: DVec3::new(1.0, 1.0, 0.25),
        }
    }
}

impl Pattern {
    /// Running bond in a centred box.
    ///
    /// # Errors
    /// If a parameter is out of its range, or the numbers make more than 10000 cells.
    pub fn bricks(bricks: &Bricks) -> Result<Self, PatternError> {
        let &Bricks { columns, courses, mortar, jitter, seed, half_extent } = bricks;
        require(columns >= 1, "columns", columns as f64, "at least 1")?;
        require(courses >= 1, "courses", courses as f64, "at least 1")?;
        let most = columns.saturating_add(1).saturating_mul(courses).saturating_mul(3);
        require(
            most <= MOST_CELLS,
            "columns",
            columns as f64,
            "at most 3332 divided by the courses",
        )?;
        require((0.0..=0.5).contains(&mortar), "mortar", mortar, "from 0 to 0.5")?;
        require((0.0..=1.0).contains(&jitter), "jitter", jitter, "from 0 to 1")?;
        require_box(half_extent)?;
        let mut random = Pcg64Mcg::seed_from_u64(seed);

        let size = 2.0 * half_extent.truncate() / DVec2::new(columns as f64, courses as f64);
        let joint = (mortar * size.y).min(0.25 * size.x);
        let mut regions = Vec::new();
        let mut joints = Vec::new();
        for course in 0..courses {
            let bottom = course as f64 * size.y - half_extent.y;
            let top = bottom + size.y - joint;
            // Where each brick begins; the first and the last end at the box.
            let shift = if course % 2 == 0 { 0.0 } else { 0.5 };
            let starts: Vec<f64> = (0..=columns)
                .map(|column| column as f64 - shift + 0.2 * jitter * deviation(&mut random))
                .map(|start| start * size.x - half_extent.x)
                .collect();
            // A shifted course has a half brick at both ends, so one more.
            let count = if course % 2 == 0 { columns } else { columns + 1 };
            for column in 0..count {
                let left = if column == 0 { -half_extent.x } else { starts[column] };
                let last = column + 1 == count;
                // The last brick of a course has no joint beside it.
                let right = if last { half_extent.x } else { starts[column + 1] };
                let end = if last { right } else { right - joint };
                let above = bottom + size.y;
                regions.extend(block([left, end], [bottom, top], half_extent));
                let brick = regions.len();
                if joint > 0.0 {
                    regions.extend(block([end, right], [bottom, top], half_extent));
                    regions.extend(block([left, right], [top, above], half_extent));
                }
                joints.extend(brick..regions.len());
            }
        }
        Ok(Self { joints, ..Self::planar_in_box(half_extent, regions) })
    }
}

impl Pattern {
    /// Running bond on a solid, with `cells` blocks in the box around it. Where whole courses do not
    /// come out even, mortar of some bricks sticks to them.
    pub fn bricks_in(bricks: &Bricks, cells: usize, filling: &Filling) -> Self {
        let (low, high) = filling.extent();
        let size = high - low;
        let aspect = (bricks.half_extent.x / bricks.columns.max(1) as f64)
            / (bricks.half_extent.y / bricks.courses.max(1) as f64);
        let proportion = aspect * size.y / size.x;
        let has_mortar = bricks.mortar > 0.0;
        let [columns, courses] = laid_in(cells, proportion, has_mortar);
        let mut over = made_of(columns, courses, has_mortar).saturating_sub(cells);

        let step = DVec2::new(size.x / columns as f64, size.y / courses as f64);
        let joint = (bricks.mortar * step.y).min(0.25 * step.x);
        let half_extent = filling.half_extent();
        let mut random = Pcg64Mcg::seed_from_u64(bricks.seed);
        let (mut regions, mut joints) = (Vec::new(), Vec::new());
        let mut add = |[left, right]: [f64; 2], [bottom, top]: [f64; 2], is_joint: bool| {
            // Blocks at the rim of the solid go on to the walls.
            let sides = [
                (-DVec3::X, -left, left > low.x + CLOSE * step.x),
                (DVec3::X, right, right < high.x - CLOSE * step.x),
                (-DVec3::Y, -bottom, bottom > low.y + CLOSE * step.y),
                (DVec3::Y, top, top < high.y - CLOSE * step.y),
            ];
            let cracks = sides.into_iter().filter(|side| side.2);
            let sides: Vec<HalfSpace> =
                cracks.map(|(normal, offset, _)| HalfSpace { normal, offset }).collect();
            if let Some(region) = Region::from_half_spaces(&sides, half_extent) {
                if is_joint {
                    joints.push(regions.len());
                }
                regions.push(region);
            }
        };
        for course in 0..courses {
            let bottom = low.y + course as f64 * step.y;
            let above = bottom + step.y;
            let is_shifted = course % 2 == 1;
            let count = columns + usize::from(is_shifted);
            let shift = if is_shifted { 0.5 } else { 0.0 };
            let mut left = low.x;
            let mut waits = None;
            for column in 0..count {
                let is_last = column + 1 == count;
                let jitter = 0.2 * bricks.jitter * deviation(&mut random);
                let next = (column as f64 + 1.0 - shift + jitter) * step.x + low.x;
                let right = if is_last { high.x } else { next };
                if !has_mortar {
                    // A longer brick for two.
                    let start = waits.take().unwrap_or(left);
                    if over > 0 && !is_last {
                        over -= 1;
                        waits = Some(start);
                    } else {
                        add([start, right], [bottom, above], false);
                    }
                    left = right;
                    continue;
                }
                let has_bed = over == 0;
                over -= usize::from(!has_bed);
                let has_head = !is_last && over == 0;
                over -= usize::from(!is_last && !has_head);
                let top = if has_bed { above - joint } else { above };
                let end = if has_head { right - joint } else { right };
                add([left, end], [bottom, top], false);
                if has_head {
                    add([end, right], [bottom, top], true);
                }
                if has_bed {
                    add([left, right], [top, above], true);
                }
                left = right;
            }
        }
        Self { joints, ..filling.planar(regions) }
    }
}

/// Sides nearer than this part of a brick to the rim of the solid are no cracks.
const CLOSE: f64 = 1e-6;

/// Number of blocks of so many columns and courses.
fn made_of(columns: usize, courses: usize, has_mortar: bool) -> usize {
    let laid = courses * columns + courses / 2;
    // Each brick has a joint above it, and beside it if another follows.
    if has_mortar { 3 * laid - courses } else { laid }
}

/// Columns and courses that make at least so many blocks, few more, with about `proportion` courses
/// for each column.
fn laid_in(cells: usize, proportion: f64, has_mortar: bool) -> [usize; 2] {
    // A block that sticks to another counts like this relative error of the proportion.
    const STUCK: f64 = 2.0;
    let off = |[columns, courses]: [usize; 2]| {
        let over = made_of(columns, courses, has_mortar) as f64 / cells as f64 - 1.0;
        STUCK * over + libm::log(courses as f64 / columns as f64 / proportion).abs()
    };
    let mut best = [cells, 1];
    for columns in 1..=cells {
        // The fewest courses that are enough.
        let of_two = made_of(columns, 2, has_mortar);
        let mut courses = (2 * cells / of_two).max(1);
        while made_of(columns, courses, has_mortar) < cells {
            courses += 1;
        }
        // Beyond these bricks would have to stick together.
        let over = made_of(columns, courses, has_mortar) - cells;
        let most =
            if has_mortar { 2 * courses * columns - courses } else { courses * (columns - 1) };
        if over <= most && off([columns, courses]) < off(best) {
            best = [columns, courses];
        }
    }
    best
}

/// The block between two positions along x and two along y; sides on the box are no cracks. `None`
/// if empty.
fn block([left, right]: [f64; 2], [bottom, top]: [f64; 2], half_extent: DVec3) -> Option<Region> {
    // Joints of no width are rounding.
    let tiny = 1e-9 * half_extent.max_element();
    if right - left <= tiny || top - bottom <= tiny {
        return None;
    }
    let sides = [
        (-DVec3::X, -left, left > tiny - half_extent.x),
        (DVec3::X, right, right < half_extent.x - tiny),
        (-DVec3::Y, -bottom, bottom > tiny - half_extent.y),
        (DVec3::Y, top, top < half_extent.y - tiny),
    ];
    let cuts = sides.into_iter().filter(|&(_, _, crack)| crack);
    let half_spaces: Vec<HalfSpace> =
        cuts.map(|(normal, offset, _)| HalfSpace { normal, offset }).collect();
    Region::from_half_spaces(&half_spaces, half_extent)
}
