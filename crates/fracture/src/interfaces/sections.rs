//! Sections of crack planes: where two pieces on a lattice touch, by their exact planes and the
//! body's surface.

use crate::interfaces::cross_section::{CrossSection, Farthest, FlatPart};
use frangible_geometry::{GridSolid, HalfSpace, outer};
use glam::{DMat3, DVec2, DVec3};

/// Points of a section per voxel face: contacts of ten voxels a side are then within half a
/// percent. With 16 a break into 10 pieces takes half as long again.
const POINTS_PER_FACE: f64 = 8.0;

/// Least number of points of a rectangle, for thin contacts.
const LEAST_POINTS: f64 = 400.0;

/// Most points of a rectangle: a contact of a hundred voxels a side has as many.
const MOST_POINTS: f64 = 160_000.0;

/// Points within this distance of a plane are on it, in units of the spacing: the two sides of a
/// plane agree to a millionth.
const ON_PLANE: f64 = 1e-5;

/// Fractions of the plastic number's powers: their multiples fill a square evenly, off all axes
/// [Roberts 2018, The unreasonable effectiveness of quasirandom sequences].
const FILLS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

/// The two axes of a plane in which rectangles lie.
pub(super) fn axes(plane: &HalfSpace) -> [DVec3; 2] {
    let (across, along) = plane.normal.any_orthonormal_pair();
    [across, along]
}

/// The part of a plane that lies in both of two solids, within the rectangle from `low` to `high`
/// along its [`axes`] [m]. `is_between` tells if a point lies between voxels of both. `None` for
/// solids that are not clipped by planes.
pub(super) fn section(
    [a, b]: [&GridSolid; 2],
    plane: &HalfSpace,
    (low, high): (DVec2, DVec2),
    is_between: impl Fn(DVec3) -> bool,
) -> Option<FlatPart> {
    if a.parts().is_empty() || b.parts().is_empty() {
        return None;
    }
    let spacing = a.grid().spacing;
    let [across, along] = axes(plane);
    let corner = plane.offset * plane.normal + low.x * across + low.y * along;
    let DVec2 { x: width, y: height } = high - low;
    let faces = width * height / (spacing * spacing);
    let count = (POINTS_PER_FACE * faces).clamp(LEAST_POINTS, MOST_POINTS) as usize;
    let slack = ON_PLANE * spacing;
    // Of points seen from the corner.
    let (mut held, mut sum, mut squares) = (0_usize, DVec3::ZERO, DMat3::ZERO);
    let mut farthest = Farthest::default();
    for n in 1..=count {
        let [u, v] = FILLS.map(|fill| {
            let multiple = n as f64 * fill;
            multiple - multiple.floor()
        });
        let from_corner = width * u * across + height * v * along;
        let point = corner + from_corner;
        if a.holds(point, slack) && b.holds(point, slack) && is_between(point) {
            held += 1;
            sum += from_corner;
            squares += outer(from_corner, from_corner);
            farthest.add(point);
        }
    }
    let share = width * height / count as f64;
    let mean = sum / held.max(1) as f64;
    let centroid = corner + mean;
    Some(FlatPart {
        vector: share * held as f64 * plane.normal,
        centroid,
        section: CrossSection {
            second_moment: (squares - outer(mean, mean) * held as f64) * share,
            rim: farthest.rim(centroid),
        },
    })
}
