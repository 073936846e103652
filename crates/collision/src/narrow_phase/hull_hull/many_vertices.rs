//! Hulls of many vertices: the same features by fewer looks, and no size from which on they cost
//! more.

use crate::narrow_phase::hull_hull::face_clipping::clip_by_all;
use crate::narrow_phase::hull_hull::furthest_face::FurthestFace;
use crate::narrow_phase::hull_hull::hull_pair::HullPair;
use crate::narrow_phase::hull_hull::hull_point::{Feature, HullPoint};
use crate::narrow_phase::hull_hull::reduction::reduce;
use crate::narrow_phase::hull_hull::reference_sides::Sides;
use crate::narrow_phase::hull_hull::scratch::{Corner, Scratch, Side};
use crate::narrow_phase::hull_hull::separating_axis::{edge_axis, gather_ridges};
use crate::narrow_phase::hull_hull::turning_clip::clip_in_turn;
use crate::oracle::draw::Draw;
use frangible_geometry::Hull;
use frangible_math::{Instructions, Kernel, RigidTransform, Width, with_widest};
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

/// An ellipsoid with evenly spread vertices, of about 1 m.
fn ellipsoid(count: usize) -> Hull {
    let point = |at: usize| {
        let at = at as f64 + 0.5;
        let (polar, around) =
            ((1.0 - 2.0 * at / count as f64).acos(), PI * (1.0 + 5_f64.sqrt()) * at);
        let (sin, cos) = around.sin_cos();
        DVec3::new(cos * polar.sin(), 0.7 * sin * polar.sin(), 0.85 * polar.cos())
    };
    Hull::of_points(&(0..count).map(point).collect::<Vec<_>>()).unwrap()
}

/// A prism of a regular polygon with a radius of 1 m.
fn prism(sides: usize, half: f64) -> Hull {
    let point = |at: usize| {
        let (sin, cos) = (TAU * (at / 2) as f64 / sides as f64).sin_cos();
        DVec3::new(cos, if at.is_multiple_of(2) { -half } else { half }, sin)
    };
    Hull::of_points(&(0..2 * sides).map(point).collect::<Vec<_>>()).unwrap()
}

fn placed(draw: &mut Draw, way: DVec3) -> RigidTransform {
    RigidTransform::new(DQuat::from_axis_angle(draw.direction(), draw.any(0.0, TAU)), way)
}

/// The best face by all faces and vertices, or by bounds.
struct Both<'a> {
    kernel: FurthestFace<'a>,
    by_bounds: bool,
}

impl Kernel for Both<'_> {
    type Output = [usize; 2];

    fn compute<I: Instructions>(self) -> [usize; 2] {
        let Self { kernel, by_bounds } = self;
        let mut found = [0; 2];
        I::run(|| {
            found = if by_bounds { kernel.by_bounds::<I>() } else { kernel.of_all::<I>() };
        });
        found
    }
}

fn best_face(pair: &HullPair, by_bounds: bool) -> ([usize; 2], usize) {
    let Scratch { mut face_blocks, lowest: [mut lowest, _], .. } = Scratch::default();
    let [hull, other] = pair.hulls.map(Hull::columns);
    let kernel = FurthestFace {
        hull,
        other,
        hull_from_other: &pair.first_from_second,
        other_from_hull: &pair.second_from_first,
        blocks: &mut face_blocks,
        lowest: &mut lowest,
    };
    let found = with_widest(pair.width, Both { kernel, by_bounds });
    (found, lowest.len())
}

/// Bounds find the face and the vertex that comparing all finds, also where many are as good.
#[test]
fn bounds_find_the_best_face() {
    let mut draw = Draw::new(1);
    for round in 0..300 {
        let hulls = [0, 1].map(|_| match draw.of(4) {
            0 => Hull::cuboid(DVec3::new(0.5, 0.7, 0.3)),
            1 => prism(draw.of(40) + 3, 0.4),
            _ => ellipsoid(draw.of(300) + 4),
        });
        let way = draw.any(0.0, 2.5) * draw.direction();
        let flush = RigidTransform::new(DQuat::IDENTITY, draw.any(0.0, 1.0) * DVec3::Y);
        let pose = if round % 5 == 0 { flush } else { placed(&mut draw, way) };
        let pair = HullPair::new([&hulls[0], &hulls[1]], &pose, 0.5, Width::Avx512);
        assert_eq!(best_face(&pair, true).0, best_face(&pair, false).0, "{round}");
    }
}

/// The work for a pair of hulls in contact grows no faster than the hulls: few faces and edges are
/// looked at with the whole other hull, however many there are.
#[test]
fn many_vertices_need_few_looks() {
    for (gap, most_faces, most_pairs) in [(0.01, 30, 500), (-0.002, 30, 500), (-0.4, 100, 60_000)] {
        for count in [20, 87, 88, 200, 800, 3000] {
            let hull = ellipsoid(count);
            let mut draw = Draw::new(count as u64);
            let turn = placed(&mut draw, DVec3::ZERO);
            let lowest = |vertex: &DVec3| turn.direction(*vertex).y;
            let of_second = hull.vertices().iter().map(lowest).fold(f64::INFINITY, f64::min);
            let of_first = hull.vertices().iter().map(|v| v.y).fold(0.0, f64::max);
            let pose =
                RigidTransform { translation: (of_first - of_second + gap) * DVec3::Y, ..turn };
            let pair = HullPair::new([&hull, &hull], &pose, 0.7, Width::Avx512);
            let mut scratch = Scratch::default();
            let axes = pair.face_axes(1.0, &mut scratch).unwrap();
            let looks: usize = scratch.lowest.iter().map(Vec::len).sum();
            assert!(looks <= most_faces, "{count}, {gap}: {looks} faces");

            let face = axes[0].separation.max(axes[1].separation);
            gather_ridges(&pair, &axes, gap.abs() + pair.close, &mut scratch);
            let _ = edge_axis(&pair, face + pair.close, &mut scratch);
            let [first, second] = scratch.ridges.each_ref().map(Vec::len);
            assert!(first * second <= most_pairs, "{count}, {gap}: {first} x {second} edges");
        }
    }
}

/// The bounds that sort edges hide none that is better.
#[test]
fn bounds_find_the_best_edges() {
    let mut draw = Draw::new(3);
    for round in 0..60 {
        let hulls = [0, 1].map(|_| ellipsoid(draw.of(200) + 40));
        let way = draw.any(0.1, 1.5) * draw.direction();
        let pose = placed(&mut draw, way);
        let pair = HullPair::new([&hulls[0], &hulls[1]], &pose, 0.7, Width::Avx512);
        let mut scratch = Scratch::default();
        let Ok(axes) = pair.face_axes(0.1, &mut scratch) else { continue };
        let find = |scratch: &mut Scratch| {
            gather_ridges(&pair, &axes, 0.3, scratch);
            edge_axis(&pair, f64::NEG_INFINITY, scratch).map(|axis| (axis.edges, axis.separation))
        };
        let bounded = find(&mut scratch);
        // Without known vertices nothing is bounded.
        scratch.lowest.iter_mut().for_each(Vec::clear);
        assert_eq!(bounded, find(&mut scratch), "{round}");
    }
}

/// Around two polygons of many corners in turn, or all corners by all sides: the same polygon.
#[test]
fn faces_of_many_corners_are_clipped_as_others() {
    let mut draw = Draw::new(4);
    for round in 0..200 {
        let [reference, incident] = [0, 1].map(|_| prism(draw.of(90) + 3, 0.5));
        let face = |hull: &Hull, up: f64| {
            hull.planes().iter().position(|plane| plane.normal.y * up > 0.9).unwrap()
        };
        let [top, bottom] = [face(&reference, 1.0), face(&incident, -1.0)];
        let turn = DQuat::from_rotation_y(draw.any(0.0, TAU));
        let shift = DVec3::new(draw.any(-1.5, 1.5), 1.0, draw.any(-1.5, 1.5));
        let pose = RigidTransform::new(turn, shift);
        let pair = HullPair::new([&reference, &incident], &pose, 1.0, Width::Avx512);
        let views = pair.views();
        let sides = Sides { reference: &views[0], face: &reference.face(top), normal: DVec3::Y };
        let of_face = incident.face(bottom);
        let corner = |(&vertex, &edge): (&u32, &u32)| Corner {
            point: views[1].vertex(vertex as usize),
            feature: Feature::VertexOfSecond(vertex),
            side: Side::Incident(edge),
            beyond: 0.0,
        };
        let polygon: Vec<Corner> = of_face.vertices.iter().zip(of_face.edges).map(corner).collect();
        let (mut by_all, mut in_turn) = (polygon.clone(), polygon);
        clip_by_all(&sides, 1e-9, &mut by_all, &mut Vec::new());
        clip_in_turn(&sides, 1e-9, &mut in_turn, &mut Vec::new());
        let names = |polygon: &[Corner]| {
            let name = |corner: &Corner| {
                (format!("{:?} {:?}", corner.feature, corner.side), corner.point.to_array())
            };
            let mut names: Vec<_> = polygon.iter().map(name).collect();
            names.sort_by(|a, b| a.0.cmp(&b.0));
            names
        };
        assert_eq!(names(&by_all), names(&in_turn), "{round}");
    }
}

/// What lies higher above another point than beside it is left out of few points as of many.
#[test]
fn many_points_are_reduced_as_few() {
    let mut draw = Draw::new(5);
    for count in [5, 100, 129, 400] {
        let point = |number: u32, draw: &mut Draw| {
            let on = DVec3::new(draw.any(-1.0, 1.0), 0.0, draw.any(-1.0, 1.0));
            let gap = draw.any(0.0, 0.3);
            let feature = Feature::VertexOfFirst(number);
            HullPoint { on: [on + gap * DVec3::Y, on], normal: DVec3::Y, gap, feature }
        };
        let points: Vec<HullPoint> = (0..count).map(|number| point(number, &mut draw)).collect();
        let middle = |point: &HullPoint| 0.5 * (point.on[0] + point.on[1]);
        let is_covered = |point: &HullPoint| {
            points.iter().any(|other| {
                let beside = (middle(point) - middle(other)).with_y(0.0).length();
                point.gap - other.gap > beside.max(1e-3)
            })
        };
        let expected: Vec<Feature> =
            points.iter().filter(|point| !is_covered(point)).map(|point| point.feature).collect();
        let mut kept = points.clone();
        reduce(&mut kept, &mut Vec::new(), usize::MAX, (DVec3::Y, 1e-3));
        let kept: Vec<Feature> = kept.iter().map(|point| point.feature).collect();
        assert_eq!(kept, expected);
    }
}
