//! Random shapes and places: sizes of seven decades, slivers and needles, hulls nearly flat or with
//! nearly coplanar faces; deep in each other, touching, near and far, at any angle or flush.

use crate::oracle::body::Convex;
use crate::oracle::{along, truth};
use frangible_geometry::{ClosedForm, Compound, HalfSpace, Hull, Shape};
use frangible_math::RigidTransform;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Kinds of shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Ball,
    Box,
    Hull,
    Cylinder,
    Capsule,
    Cone,
    HalfSpace,
    Compound,
    /// A hull that is nearly none.
    Sliver,
    /// A hull of many vertices.
    Round,
}

/// All kinds.
pub(crate) const KINDS: [Kind; 10] = [
    Kind::Ball,
    Kind::Box,
    Kind::Hull,
    Kind::Cylinder,
    Kind::Capsule,
    Kind::Cone,
    Kind::HalfSpace,
    Kind::Compound,
    Kind::Sliver,
    Kind::Round,
];

/// A pair of shapes in the frame of the second.
pub(crate) struct Drawn {
    pub(crate) shapes: [Shape; 2],
    /// Of the body frames.
    pub(crate) second_from_first: RigidTransform,
    /// Convex parts of both in the second's frame; none for a half-space.
    pub(crate) parts: [Vec<Convex>; 2],
    /// Radius of the smaller one [m].
    pub(crate) size: f64,
}

/// A source of random numbers.
pub(crate) struct Draw {
    random: Pcg64,
}

impl Draw {
    pub(crate) fn new(seed: u64) -> Self {
        Self { random: Pcg64::seed_from_u64(seed) }
    }

    pub(crate) fn any(&mut self, low: f64, high: f64) -> f64 {
        self.random.random_range(low..high)
    }

    pub(crate) fn of(&mut self, count: usize) -> usize {
        self.random.random_range(0..count)
    }

    fn power(&mut self, low: f64, high: f64) -> f64 {
        libm::exp10(self.any(low, high))
    }

    pub(crate) fn direction(&mut self) -> DVec3 {
        loop {
            let way = DVec3::new(self.any(-1.0, 1.0), self.any(-1.0, 1.0), self.any(-1.0, 1.0));
            if (0.01..1.0).contains(&way.length()) {
                return way.normalize();
            }
        }
    }

    /// Any, quarter turns, nearly quarter turns, or about one axis.
    fn orientation(&mut self) -> DQuat {
        let quarters = |of: &mut Self| {
            let [x, y] = [of.of(4), of.of(4)].map(|count| FRAC_PI_2 * count as f64);
            DQuat::from_rotation_x(x) * DQuat::from_rotation_y(y)
        };
        match self.of(6) {
            0 | 1 => DQuat::from_axis_angle(self.direction(), self.any(0.0, TAU)),
            2 | 3 => quarters(self),
            4 => {
                let tilt = self.power(-9.0, -1.0);
                DQuat::from_axis_angle(self.direction(), tilt) * quarters(self)
            }
            _ => {
                DQuat::from_axis_angle(DVec3::AXES[self.of(3)], self.any(0.0, TAU)) * quarters(self)
            }
        }
    }

    /// An extent relative to the size: thin in one of four.
    fn extent(&mut self) -> f64 {
        if self.of(4) == 0 { self.power(-4.0, 0.0) } else { self.power(-1.0, 0.0) }
    }

    fn extents(&mut self) -> DVec3 {
        DVec3::new(self.extent(), self.extent(), self.extent())
    }

    fn hull(&mut self, size: f64) -> Hull {
        loop {
            let scale = size * self.extents();
            let points: Vec<DVec3> = match self.of(5) {
                // A rock.
                0 => (0..self.of(12) + 4).map(|_| scale * self.direction()).collect(),
                // A box, its corners moved a little: faces that are nearly flat.
                1 => {
                    let off = self.power(-9.0, -1.0);
                    let corners = Hull::cuboid(scale);
                    let corners = corners.vertices().iter();
                    corners.map(|&corner| corner + off * scale * self.direction()).collect()
                }
                // A prism or a pyramid of many sides.
                2 => {
                    let sides = self.of(20) + 3;
                    let top = if self.of(2) == 0 { 1.0 } else { self.any(0.0, 1.0) };
                    let turn = |side: usize| TAU * side as f64 / sides as f64;
                    let ring = |y: f64, wide: f64| {
                        (0..sides).map(move |side| {
                            let (sin, cos) = turn(side).sin_cos();
                            DVec3::new(wide * cos, y, wide * sin)
                        })
                    };
                    ring(-1.0, 1.0).chain(ring(1.0, top)).map(|point| scale * point).collect()
                }
                // Many faces at small angles.
                3 => (0..30).map(|_| scale * self.direction()).collect(),
                // A tetrahedron.
                _ => (0..4).map(|_| scale * self.direction()).collect(),
            };
            if let Ok(hull) = Hull::of_points(&points) {
                return hull;
            }
        }
    }

    /// Plates, needles and wedges as thin as hulls can be, with corners that are nearly one, nearly on
    /// the line of two others or nearly in the plane of a face.
    fn sliver(&mut self, size: f64) -> Option<Hull> {
        let thin = self.power(-4.6, -2.0);
        let wide = if self.of(2) == 0 { self.power(-4.6, 0.0) } else { 1.0 };
        let scale = size * DVec3::new(1.0, wide, thin);
        let mut points: Vec<DVec3> = match self.of(3) {
            0 => (0..self.of(10) + 4).map(|_| scale * self.direction()).collect(),
            1 => Hull::cuboid(scale).vertices().to_vec(),
            // A wedge: two edges across each other, one of them short.
            _ => {
                let short = self.power(-5.0, 0.0);
                let ends = [DVec3::X, -DVec3::X, DVec3::new(0.0, short, 1.0)];
                let last = DVec3::new(self.any(-1.0, 1.0) * short, -short, 1.0);
                ends.into_iter().chain([last]).map(|point| scale * point).collect()
            }
        };
        for _ in 0..self.of(6) {
            let [a, b, c] = [0; 3].map(|_| points[self.of(points.len())]);
            let on = match self.of(3) {
                0 => a,
                1 => a.lerp(b, self.any(0.0, 1.0)),
                _ => a.lerp(b, self.any(0.0, 1.0)).lerp(c, self.any(0.0, 1.0)),
            };
            points.push(on + self.power(-17.0, -6.0) * size * self.direction());
        }
        Hull::of_points(&points).ok()
    }

    /// An ellipsoid or a prism of 20 to 630 points.
    fn round(&mut self, size: f64) -> Option<Hull> {
        let count = self.power(1.3, 2.8) as usize;
        let scale = size * DVec3::new(self.any(0.2, 1.0), self.any(0.2, 1.0), self.any(0.2, 1.0));
        let turn = |part: usize| TAU * part as f64 / count as f64;
        let is_prism = self.of(3) == 0;
        let point = |at: usize, of: &mut Self| {
            if is_prism {
                let (sin, cos) = turn(2 * (at / 2)).sin_cos();
                DVec3::new(cos, if at.is_multiple_of(2) { 1.0 } else { -1.0 }, sin)
            } else {
                of.direction()
            }
        };
        let points: Vec<DVec3> = (0..count).map(|at| scale * point(at, self)).collect();
        Hull::of_points(&points).ok()
    }

    fn shape(&mut self, kind: Kind, size: f64) -> Shape {
        let spacing = size;
        let [radius, length] = [size * self.extent(), size * self.extent()];
        match kind {
            Kind::Ball => Shape::closed_form(ClosedForm::Sphere { radius: size }, spacing),
            Kind::Box => {
                Shape::closed_form(ClosedForm::Box { half: size * self.extents() }, spacing)
            }
            Kind::Cylinder => {
                Shape::closed_form(ClosedForm::Cylinder { radius, half_height: length }, spacing)
            }
            Kind::Capsule => {
                Shape::closed_form(ClosedForm::Capsule { radius, half_height: length }, spacing)
            }
            Kind::Cone => {
                Shape::closed_form(ClosedForm::Cone { radius, height: 2.0 * length }, spacing)
            }
            Kind::HalfSpace => {
                let normal = if self.of(2) == 0 { DVec3::Y } else { self.direction() };
                let offset = size * self.any(-1.0, 1.0);
                Shape::closed_form(ClosedForm::HalfSpace(HalfSpace { normal, offset }), spacing)
            }
            Kind::Hull => loop {
                if let Ok(shape) = Shape::convex(self.hull(size), spacing) {
                    return shape;
                }
            },
            Kind::Sliver => loop {
                if let Some(shape) =
                    self.sliver(size).and_then(|hull| Shape::convex(hull, spacing).ok())
                {
                    return shape;
                }
            },
            Kind::Round => loop {
                if let Some(shape) =
                    self.round(size).and_then(|hull| Shape::convex(hull, spacing).ok())
                {
                    return shape;
                }
            },
            Kind::Compound => loop {
                let part = |of: &mut Self| {
                    let pose = RigidTransform::new(of.orientation(), size * of.direction());
                    of.hull(size).transformed(&pose)
                };
                let hulls = (0..self.of(3) + 2).map(|_| part(self)).collect();
                if let Ok(shape) = Shape::compound(Compound::new(hulls), spacing) {
                    return shape;
                }
            },
        }
    }

    /// A pair of shapes of two kinds; the first is not a half-space.
    pub(crate) fn pair(&mut self, kinds: [Kind; 2]) -> Drawn {
        let size = self.power(-4.0, 3.0);
        let ratio = if self.of(2) == 0 { self.power(-1.0, 1.0) } else { self.power(-4.0, 4.0) };
        let other = (size * ratio).clamp(1e-4, 1e3);
        let shapes = [self.shape(kinds[0], size), self.shape(kinds[1], other)];
        let mut drawn = Drawn {
            size: shapes[0].radius().min(shapes[1].radius()),
            second_from_first: RigidTransform::new(self.orientation(), DVec3::ZERO),
            parts: [Vec::new(), Vec::new()],
            shapes,
        };
        drawn.parts[1] = convex_parts(&drawn.shapes[1], &RigidTransform::IDENTITY);
        self.place(&mut drawn);
        drawn.parts[0] = convex_parts(&drawn.shapes[0], &drawn.second_from_first);
        drawn
    }

    fn place(&mut self, drawn: &mut Drawn) {
        let size = drawn.size;
        // Where they touch along a direction.
        let way = match self.of(3) {
            0 => DVec3::AXES[self.of(3)] * if self.of(2) == 0 { 1.0 } else { -1.0 },
            1 => drawn.second_from_first.direction(DVec3::AXES[self.of(3)]),
            _ => self.direction(),
        };
        let half_space = drawn.half_space();
        let way = half_space.map_or(way, |plane| plane.normal);
        let first = convex_parts(&drawn.shapes[0], &drawn.second_from_first);
        let reach = |parts: &[Convex], way: DVec3| {
            let reach = |part: &Convex| part.support(way).dot(way) + part.rounding;
            parts.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
        };
        let of_second =
            half_space.map_or_else(|| reach(&drawn.parts[1], way), |plane| plane.offset);
        let touching = reach(&first, -way) + of_second;
        let near = match self.of(8) {
            0 | 1 => -self.any(0.0, 1.0),
            2 => 0.0,
            3 => self.power(-9.0, -3.0),
            4 => -self.power(-9.0, -3.0),
            5 => self.any(0.0, 0.1),
            6 => -self.any(0.0, 0.1),
            _ => self.any(0.0, 3.0),
        };
        let aside = if self.of(3) == 0 { 0.0 } else { self.any(0.0, 1.0) * size };
        drawn.second_from_first.translation =
            (touching + near * size) * way + aside * self.direction();
        // Moved apart or together along the true normal until they are as far from each other.
        if half_space.is_none() && self.of(3) == 0 {
            let first = convex_parts(&drawn.shapes[0], &drawn.second_from_first);
            let found = truth(&first[0], &drawn.parts[1][0]);
            if found.of_cores > 0.0 {
                let to = if self.of(2) == 0 { 0.0 } else { near.min(0.1) * size };
                drawn.second_from_first.translation += (to - found.gap) * found.normal;
            }
        }
    }
}

impl Drawn {
    pub(crate) fn half_space(&self) -> Option<HalfSpace> {
        match self.shapes[1].geometry {
            frangible_geometry::Geometry::ClosedForm(ClosedForm::HalfSpace(plane)) => Some(plane),
            _ => None,
        }
    }

    /// Separation along a unit normal from the second to the first of their deepest parts [m].
    pub(crate) fn along(&self, normal: DVec3) -> f64 {
        if let Some(plane) = self.half_space() {
            let gap = |part: &Convex| plane.distance(part.support(-plane.normal)) - part.rounding;
            return self.parts[0].iter().map(gap).fold(f64::INFINITY, f64::min);
        }
        let each = self.parts[0].iter().flat_map(|a| self.parts[1].iter().map(move |b| (a, b)));
        each.map(|(a, b)| along(a, b, normal)).fold(f64::INFINITY, f64::min)
    }

    /// Separation of the deepest parts [m], and its normal.
    pub(crate) fn truth(&self) -> (f64, DVec3) {
        if let Some(plane) = self.half_space() {
            return (self.along(plane.normal), plane.normal);
        }
        let each = self.parts[0].iter().flat_map(|a| self.parts[1].iter().map(move |b| (a, b)));
        each.map(|(a, b)| truth(a, b)).fold((f64::INFINITY, DVec3::Y), |least, found| {
            if found.gap < least.0 { (found.gap, found.normal) } else { least }
        })
    }
}

fn convex_parts(shape: &Shape, here_from_body: &RigidTransform) -> Vec<Convex> {
    if let Some(compound) = &shape.compound {
        let part = |part: &frangible_geometry::Part| Convex::of_hull(&part.hull, here_from_body);
        return compound.parts().iter().map(part).collect();
    }
    match (&shape.geometry, &shape.hull) {
        (frangible_geometry::Geometry::ClosedForm(form), _) => {
            Convex::of_form(form, here_from_body).into_iter().collect()
        }
        (_, Some(hull)) => vec![Convex::of_hull(hull, here_from_body)],
        _ => Vec::new(),
    }
}
