//! Points all over a solid: where the cells belong of a pattern that is made for it.
//!
//! A pattern of the usual kind fills a box around the body. In a plank most of its cells miss the
//! wood: 80 pieces of one of 3 x 0.1 x 0.3 m took thousands of cells. Cells around points of the
//! solid meet it, each of them.

mod lots;
mod mesh_columns;

use crate::align::{Impact, corners};
use crate::filling::lots::Lots;
use crate::filling::mesh_columns::points_of_triangles;
use crate::pattern::Pattern;
use crate::pattern::region::Region;
use crate::placement::Placement;
use crate::reach::{Reach, Rim};
use crate::shatter::settings::ShatterSettings;
use frangible_geometry::{Geometry, GridSolid, HalfSpace, Hull, Shape, TriMesh};
use glam::{DMat3, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Points for each piece: shares of the volume are known to a tenth.
const OF_A_PIECE: usize = 96;

/// Most points, and fewest: patterns of a few cells know their extents by them.
const MOST_POINTS: usize = 1 << 19;
const FEWEST_POINTS: usize = 1024;

/// Places that are tried for each point, where a solid fills little of what is known of it.
const TRIES: usize = 16;

/// The box around a solid is larger by this part of its longest side: no wall lies on a face.
const CLEAR: f64 = 1e-5;

/// No side of the box is shorter than this part of the longest: faces would get lost in rounding.
const FLATTEST: f64 = 2e-3;

/// Material in front of a blow comes loose up to 1.4 times as far away as the reach.
const IN_FRONT: f64 = 1.5;

/// Points all over a solid in the frame of a pattern that is made for it: the origin is in the
/// middle of a box around the solid, axes are as a [`Placement`] lays them, lengths in metres.
#[derive(Clone, Debug)]
pub struct Filling {
    /// In an order of chance: the first of them are spread as evenly as all.
    points: Vec<DVec3>,
    half_extent: DVec3,
    /// Where the blow is.
    center: DVec3,
    /// Box around what comes loose.
    extent: (DVec3, DVec3),
    /// [m^3]
    volume: f64,
    /// Number of pieces.
    wanted: usize,
}

impl Filling {
    /// Of what comes loose of a body for `wanted` pieces. `None` for a body that cannot break, and
    /// where nothing is in reach.
    pub fn of_body(
        struck: &Shape,
        impact: &Impact,
        settings: &ShatterSettings,
        (wanted, seed): (usize, u64),
    ) -> Option<Self> {
        let (axes, impact) = Placement::axes(impact, struck, settings.twist);
        let grid_from_body = struck.body_from_grid.inverse();
        let frame = Frame { axes, point: impact.point_body };
        let facets = settings.reach.map_or_else(Vec::new, |reach| frame.facets(&reach));
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let is_near = |point: &DVec3| match settings.reach {
            Some(Reach { distance, rim: Rim::Cells }) => {
                point.distance_squared(impact.point_body) <= distance * distance
            }
            _ => facets.iter().all(|facet| facet.distance(*point) <= 0.0),
        };
        let count = number_of_points(wanted);
        let (points, volume) = match &struck.geometry {
            Geometry::Grid(solid) => {
                (points_of_grid(solid, count, &mut random, is_near), struck.volume)
            }
            Geometry::Solid(solid) => {
                let mut triangles = Vec::new();
                solid.fans(|corners| triangles.push(corners));
                let bounds = solid.bounds();
                (points_of_triangles(&triangles, bounds, count, &mut random), struck.volume)
            }
            geometry => {
                let hulls = hulls_within(geometry, struck, &facets);
                points_of_hulls(&hulls, count, &mut random, is_near)
            }
        };
        let corners = corners(struck.bounds).map(|corner| grid_from_body.point(corner));
        let mut made = Self::around(&frame, &corners, points, (volume, wanted))?;
        match settings.reach {
            Some(Reach { rim: Rim::Cells, .. }) => made.extent = bounds(&made.points),
            Some(Reach { distance, rim: Rim::Bowl }) => made.trim(IN_FRONT * distance),
            None => {}
        }
        Some(made)
    }

    /// Of a closed surface, for `wanted` pieces. `None` if it encloses nothing.
    pub fn of_mesh(mesh: &TriMesh, impact: &Impact, (wanted, seed): (usize, u64)) -> Option<Self> {
        let corners = corners(mesh.bounds());
        let axes = Placement::axes_around(impact, &corners, 0.0);
        let frame = Frame { axes, point: impact.point_body };
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let triangles: Vec<[DVec3; 3]> =
            (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)).collect();
        let count = number_of_points(wanted);
        let points = points_of_triangles(&triangles, mesh.bounds(), count, &mut random);
        let volume = mesh.mass_properties().volume;
        Self::around(&frame, &corners, points, (volume, wanted))
    }

    fn around(
        frame: &Frame,
        corners: &[DVec3; 8],
        points: Vec<DVec3>,
        (volume, wanted): (f64, usize),
    ) -> Option<Self> {
        if points.is_empty() {
            return None;
        }
        let points: Vec<DVec3> = points.iter().map(|&point| frame.turned(point)).collect();
        let (low, high) = bounds(&corners.map(|corner| frame.turned(corner)));
        let longest = (high - low).max_element();
        let half_extent =
            (0.5 * (high - low) + CLEAR * longest).max(DVec3::splat(FLATTEST * longest));
        let middle = 0.5 * (low + high);
        let points = points.into_iter().map(|point| point - middle).collect();
        let extent = (low - middle, high - middle);
        Some(Self { points, half_extent, center: -middle, extent, volume, wanted })
    }

    /// Ends the box at a distance from the blow.
    fn trim(&mut self, distance: f64) {
        let low = (-self.half_extent).max(self.center - distance);
        let high = self.half_extent.min(self.center + distance);
        let middle = 0.5 * (low + high);
        self.points.iter_mut().for_each(|point| *point -= middle);
        self.half_extent = (0.5 * (high - low)).max(DVec3::splat(FLATTEST * distance));
        self.center -= middle;
        self.extent = (low - middle, high - middle);
    }

    /// The points, in an order of chance.
    pub(crate) fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Where the blow is.
    pub(crate) fn center(&self) -> DVec3 {
        self.center
    }

    /// Half of the edges of a box around the solid [m].
    pub(crate) fn half_extent(&self) -> DVec3 {
        self.half_extent
    }

    /// Box around what comes loose [m].
    pub(crate) fn extent(&self) -> (DVec3, DVec3) {
        self.extent
    }

    /// Volume of what comes loose [m^3].
    pub(crate) fn volume(&self) -> f64 {
        self.volume
    }

    /// Fewer points than this are a sliver: a fiftieth of a mean piece.
    pub(crate) fn sliver(&self) -> usize {
        (self.points.len() / (50 * self.wanted.max(1))).max(2)
    }

    /// Metres per unit at which a pattern's box of `half_extent` around the blow holds the solid.
    pub(crate) fn scale(&self, half_extent: DVec3) -> f64 {
        ((self.half_extent + self.center.abs()) / half_extent).max_element()
    }

    /// A pattern of convex cells, laid as it is.
    pub(crate) fn planar(&self, regions: Vec<Region>) -> Pattern {
        Pattern {
            center: self.center,
            scale: Some(1.0),
            ..Pattern::planar_in_box(self.half_extent, regions)
        }
    }
}

fn number_of_points(wanted: usize) -> usize {
    (OF_A_PIECE * wanted).clamp(FEWEST_POINTS, MOST_POINTS)
}

/// The blow, and the axes of a pattern that is laid there.
struct Frame {
    axes: DMat3,
    point: DVec3,
}

impl Frame {
    fn turned(&self, point: DVec3) -> DVec3 {
        self.axes.transpose() * (point - self.point)
    }

    /// The facets of a bowl; none of another rim.
    fn facets(&self, reach: &Reach) -> Vec<HalfSpace> {
        let placement = Placement {
            grid_from_pattern: self.axes,
            scale: 1.0,
            center_pattern: DVec3::ZERO,
            point_grid: self.point,
        };
        if reach.rim == Rim::Bowl { reach.bowl(&placement) } else { Vec::new() }
    }
}

fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.iter().fold(none, |(low, high), &point| (low.min(point), high.max(point)))
}

/// What facets leave of a body's polyhedra, in its grid frame.
fn hulls_within(geometry: &Geometry, body: &Shape, facets: &[HalfSpace]) -> Vec<Hull> {
    let hulls: Vec<&Hull> = match geometry {
        Geometry::Compound(compound) => compound.parts().iter().map(|part| &part.hull).collect(),
        _ => body.breaks_as().into_iter().collect(),
    };
    let clipped = |hull: &Hull| facets.iter().try_fold(hull.clone(), |hull, f| hull.clipped(f));
    hulls.into_iter().filter_map(clipped).collect()
}

/// Points of polyhedra, and the volume of all: each is made of tetrahedra around one of its
/// vertices.
fn points_of_hulls(
    hulls: &[Hull],
    count: usize,
    random: &mut Pcg64Mcg,
    is_near: impl Fn(&DVec3) -> bool,
) -> (Vec<DVec3>, f64) {
    let mut tetrahedra: Vec<[DVec3; 4]> = Vec::new();
    for hull in hulls {
        let vertices = hull.vertices();
        let Some(&top) = vertices.first() else { continue };
        for face in hull.faces() {
            let corner = |at: usize| vertices[face.vertices[at] as usize];
            let fan = (1..face.vertices.len().saturating_sub(1))
                .map(|at| [top, corner(0), corner(at), corner(at + 1)]);
            tetrahedra.extend(fan);
        }
    }
    let volume = |[a, b, c, d]: &[DVec3; 4]| (*b - *a).cross(*c - *a).dot(*d - *a).abs() / 6.0;
    let lots = Lots::new(tetrahedra.iter().map(volume));
    if lots.sum() <= 0.0 {
        return (Vec::new(), 0.0);
    }
    let mut points = Vec::with_capacity(count);
    for _ in 0..TRIES * count {
        let [a, b, c, d] = tetrahedra[lots.draw(random)];
        // Three sorted numbers divide 1 into four parts, each as likely as another.
        let mut parts: [f64; 3] = std::array::from_fn(|_| random.random());
        parts.sort_by(f64::total_cmp);
        let [r, s, t] = parts;
        let point = r * a + (s - r) * b + (t - s) * c + (1.0 - t) * d;
        if is_near(&point) {
            points.push(point);
            if points.len() == count {
                break;
            }
        }
    }
    (points, lots.sum())
}

/// Points of a solid on a grid.
fn points_of_grid(
    solid: &GridSolid,
    count: usize,
    random: &mut Pcg64Mcg,
    is_near: impl Fn(&DVec3) -> bool,
) -> Vec<DVec3> {
    let (grid, runs) = (solid.grid(), solid.runs());
    let lots = Lots::new(runs.iter().map(|run| run.moments[0]));
    let mut points = Vec::with_capacity(count);
    if lots.sum() <= 0.0 {
        return points;
    }
    for _ in 0..TRIES * count {
        let run = &runs[lots.draw(random)];
        let length = f64::from(run.end - run.start);
        let along = (f64::from(run.start) + length * random.random::<f64>() - 0.5) * grid.spacing;
        let [y, z] =
            run.row.map(|at| (f64::from(at) + random.random::<f64>() - 0.5) * grid.spacing);
        let point = grid.origin + DVec3::new(along, y, z);
        if solid.value(point) < 0.0 && is_near(&point) {
            points.push(point);
            if points.len() == count {
                break;
            }
        }
    }
    points
}
