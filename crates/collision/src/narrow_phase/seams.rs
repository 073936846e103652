//! Seams between fixed bodies, or parts of one, with faces in one plane. A body over such a face
//! meets the plane there, and neither a side nor an edge that the next face covers.

use crate::manifold::ManifoldPoint;
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::pair_motion::PairMotion;
use frangible_bodies::Pose;
use frangible_geometry::{Compound, HalfSpace};
use frangible_math::RigidTransform;
use glam::DVec3;

/// Overlap with a face, and width of a gap to the next one, up to which a seam is a seam, in
/// overlaps of grazing [1]. Faces that differ in height by one such overlap lie in one plane. With
/// 1 four of 816 rows of tiles stop what crosses them instead of one, and four of 300 walls instead
/// of none.
const WIDTH: f64 = 5.0;

/// Distance from a point at which its face is looked at, in widths of seams [1].
const BESIDE: f64 = 2.0;

/// Cosine between normals that count as the same [1]: a ten-thousandth of a radian.
pub(crate) const SAME_NORMAL: f64 = 1.0 - 5e-9;

/// Cosine between normals of faces in one plane [1].
pub(crate) const FLAT: f64 = 0.9998;

/// Cosine of the angle to a face of a convex body up to which a normal over it is that of a body
/// that leans [1].
const LEANS: f64 = 0.98;

/// Distance from a point within which its surface is looked at [m].
pub(crate) fn near_seams(pair_motion: &PairMotion) -> f64 {
    BESIDE * WIDTH * pair_motion.grazing()
}

/// Distance from a face within which points lie on it, for those that look at it, in units of their
/// distance from each other [1].
const ROUNDING: f64 = 1e-6;

/// A part of a compound, by its number.
pub(crate) type OfCompound<'a> = Option<(&'a Compound, usize)>;

/// A body and a fixed one, or parts of them.
pub(crate) struct Seams<'a> {
    pub(crate) pair_motion: &'a PairMotion<'a>,
    /// Of the fixed body in the pair.
    pub(crate) side: usize,
    fixed: ConvexShape<'a>,
    part: OfCompound<'a>,
    mover: ConvexShape<'a>,
    /// [m]
    flush: f64,
    width: f64,
}

impl<'a> Seams<'a> {
    /// `None` for a pair without seams.
    pub(crate) fn new(
        pair_motion: &'a PairMotion<'a>,
        shapes: [ConvexShape<'a>; 2],
        parts: [OfCompound<'a>; 2],
    ) -> Option<Self> {
        let fixed = pair_motion.pair.both().map(|i| pair_motion.bodies.inertias[i].is_infinite());
        let side = fixed.into_iter().position(|is_fixed| is_fixed)?;
        if pair_motion.neighbours.is_empty() && parts[side].is_none() {
            return None;
        }
        let has_faces = matches!(shapes[side], ConvexShape::Hull(_) | ConvexShape::Mesh(_));
        let mover = shapes[1 - side];
        let is_round_or_hull =
            matches!(mover, ConvexShape::Ball(_) | ConvexShape::Hull(_) | ConvexShape::Revolved(_));
        let flush = pair_motion.grazing();
        (has_faces && is_round_or_hull).then_some(Self {
            pair_motion,
            side,
            fixed: shapes[side],
            part: parts[side],
            mover,
            flush,
            width: WIDTH * flush,
        })
    }

    /// The plane over which a body meets points of one normal, if neighbours of the fixed body
    /// cover all of them; in the fixed body's frame.
    pub(crate) fn plane_over(&self, points: &[ManifoldPoint]) -> Option<HalfSpace> {
        let world_from_fixed = self.pair_motion.paths[self.side].start.world_from_body();
        let outward = if self.side == 0 { -points[0].normal } else { points[0].normal };
        let outward = world_from_fixed.inverse().direction(outward);
        let at = |point: &ManifoldPoint| {
            if self.side == 0 { point.anchor_first } else { point.anchor_second }
        };
        let mut best: Option<(f64, HalfSpace)> = None;
        // On its way a body sinks into what bears it, and meets a side further down.
        let PairMotion { reach, size, .. } = *self.pair_motion;
        visit_faces(&self.fixed, at(&points[0]), self.width + reach + size, |plane, corners| {
            let Some(height) = self.height(&plane) else { return };
            let lowest = height.min(0.0) - self.width - reach;
            let is_near =
                |point: &ManifoldPoint| (lowest..=self.width).contains(&plane.distance(at(point)));
            let aside = outward - outward.dot(plane.normal) * plane.normal;
            let Some(aside) = aside.try_normalize() else { return };
            if outward.dot(plane.normal) >= SAME_NORMAL
                || !points.iter().all(is_near)
                || outside(at(&points[0]), &plane, corners) > self.width
            {
                return;
            }
            let is_better = best.is_none_or(|(best, _)| height > best);
            // A body that leans a little has its own face's normal at edges that it only passes.
            let leans = self.is_convex() && outward.dot(plane.normal) >= LEANS;
            let goes_on = |point: &ManifoldPoint| {
                let foot = at(point) - plane.distance(at(point)) * plane.normal;
                let is_inner = || reaches(corners, foot, aside, self.width);
                leans && is_inner() || self.goes_on(foot, plane.normal, Some(aside), self.width)
            };
            let is_free = |point: &ManifoldPoint| {
                // On its way into a wall a body meets what is under the wall.
                [at(point), self.start_of(point)].into_iter().any(|at| {
                    let foot = at - plane.distance(at) * plane.normal;
                    self.is_free(foot, plane.normal, leans)
                })
            };
            if is_better && points.iter().all(goes_on) && points.iter().any(is_free) {
                best = Some((height, plane));
            }
        });
        best.map(|(_, plane)| plane)
    }

    /// Where the moving body's point is at the start, in the fixed body's frame [m].
    fn start_of(&self, point: &ManifoldPoint) -> DVec3 {
        let anchors = [point.anchor_first, point.anchor_second];
        let [fixed, mover] =
            [self.side, 1 - self.side].map(|side| self.pair_motion.paths[side].start);
        let point_world = mover.world_from_body().point(anchors[1 - self.side]);
        fixed.world_from_body().inverse().point(point_world)
    }

    /// True for a point of contact with a plane that lies on a face: a plane has no borders, a face
    /// with a hole beside it has.
    pub(crate) fn is_over_face(&self, point: &ManifoldPoint, plane: &HalfSpace) -> bool {
        let at = if self.side == 0 { point.anchor_first } else { point.anchor_second };
        self.is_on_face(at - plane.distance(at) * plane.normal, plane.normal, self.width)
    }

    fn is_on_face(&self, foot: DVec3, normal: DVec3, beyond: f64) -> bool {
        let mut is_own = false;
        visit_faces(&self.fixed, foot, self.width, |face, corners| {
            is_own |= face.normal.dot(normal) >= FLAT && outside(foot, &face, corners) <= beyond;
        });
        is_own || self.goes_on(foot, normal, None, beyond)
    }

    fn is_convex(&self) -> bool {
        matches!(self.fixed, ConvexShape::Hull(_))
    }

    /// True for the same plane, as far as seams go.
    pub(crate) fn is_flush(&self, a: &HalfSpace, b: &HalfSpace) -> bool {
        a.normal.dot(b.normal) >= SAME_NORMAL && (a.offset - b.offset).abs() <= self.flush
    }

    /// The plane's normal in the world, from the second body to the first.
    pub(crate) fn normal_of(&self, plane: &HalfSpace) -> DVec3 {
        let outward = self.pair_motion.paths[self.side].start.orientation * plane.normal;
        if self.side == 0 { -outward } else { outward }
    }

    /// Height of the moving body over a plane at the frame's or the substep's start [m]; `None` if
    /// less than half of it is over the plane.
    fn height(&self, plane: &HalfSpace) -> Option<f64> {
        let PairMotion { bodies, pair, paths, is_substep, .. } = *self.pair_motion;
        let now = [0, 1].map(|side| &paths[side].start);
        let at_start = is_substep.then(|| pair.both().map(|i| &bodies.poses[i]));
        let over = |poses| {
            let [low, high] = self.heights(plane, poses);
            (low + high > 0.0).then_some(low)
        };
        [Some(now), at_start].into_iter().flatten().filter_map(over).reduce(f64::max)
    }

    /// Heights of the moving body's lowest and highest point over a plane [m].
    fn heights(&self, plane: &HalfSpace, poses: [&Pose; 2]) -> [f64; 2] {
        let [fixed, mover] = [self.side, 1 - self.side].map(|side| poses[side].world_from_body());
        let fixed_from_mover = fixed.inverse().after(&mover);
        [-1.0, 1.0]
            .map(|up| up * self.mover.reach(&fixed_from_mover, up * plane.normal) - plane.offset)
    }

    /// True if a neighbour's face holds a point of the fixed body, and goes on from it in a
    /// direction of the plane if one is given.
    fn goes_on(&self, foot: DVec3, normal: DVec3, aside: Option<DVec3>, beyond: f64) -> bool {
        self.any_neighbour(foot, |shape, here_from_fixed| {
            let foot = here_from_fixed.point(foot);
            let normal = here_from_fixed.direction(normal);
            let aside = aside.map(|aside| here_from_fixed.direction(aside));
            let mut goes_on = false;
            visit_faces(shape, foot, self.width, |plane, corners| {
                goes_on |= plane.normal.dot(normal) >= FLAT
                    && plane.distance(foot).abs() <= self.flush
                    && aside.is_none_or(|aside| reaches(corners, foot, aside, self.width))
                    && outside(foot, &plane, corners) <= beyond;
            });
            goes_on
        })
    }

    /// True if a face in the plane of a face is free somewhere near a point: no neighbour lies on
    /// it there. It is a neighbour's, unless its own counts, too.
    fn is_free(&self, foot: DVec3, normal: DVec3, own_counts: bool) -> bool {
        let near = near_seams(self.pair_motion);
        around(foot, normal, near).any(|at| {
            let is_on_face = if own_counts {
                self.is_on_face(at, normal, ROUNDING * near)
            } else {
                self.goes_on(at, normal, None, ROUNDING * near)
            };
            is_on_face
                && !self.any_neighbour(at, |shape, here_from_fixed| {
                    let (at, normal) =
                        (here_from_fixed.point(at), here_from_fixed.direction(normal));
                    lies_on(shape, at, normal, [self.flush, self.width])
                })
        })
    }

    /// True if `is_so` for a fixed body or a part of one near a point of the fixed body, but the
    /// pair's own; it is given the shape, and the way into its frame.
    fn any_neighbour(
        &self,
        point: DVec3,
        is_so: impl Fn(&ConvexShape, &RigidTransform) -> bool,
    ) -> bool {
        let of_parts = |compound: &Compound, here_from_fixed: &RigidTransform, but: usize| {
            let at = here_from_fixed.point(point);
            let near = compound.parts_near(at - self.width, at + self.width);
            near.into_iter().filter(|&part| part != but).any(|part| {
                is_so(&ConvexShape::Hull(&compound.parts()[part].hull), here_from_fixed)
            })
        };
        if let Some((compound, part)) = self.part
            && of_parts(compound, &RigidTransform::IDENTITY, part)
        {
            return true;
        }
        let PairMotion { bodies, pair, neighbours, .. } = *self.pair_motion;
        let own = pair.both()[self.side];
        let world_from_fixed = bodies.poses[own].world_from_body();
        let point_world = world_from_fixed.point(point);
        neighbours.iter().map(|&other| other as usize).filter(|&other| other != own).any(|other| {
            let away = bodies.poses[other].position.distance(point_world);
            if away > bodies.radii[other] + self.width {
                return false;
            }
            let here_from_fixed =
                bodies.poses[other].world_from_body().inverse().after(&world_from_fixed);
            let shape = &*bodies.shapes[other];
            match shape.compound.as_deref() {
                Some(compound) => of_parts(compound, &here_from_fixed, usize::MAX),
                None => is_so(&ConvexShape::of(shape), &here_from_fixed),
            }
        })
    }
}

/// Points around another one in a plane, at a distance [m].
fn around(point: DVec3, normal: DVec3, distance: f64) -> impl Iterator<Item = DVec3> {
    let across = normal.any_orthonormal_vector();
    let along = normal.cross(across);
    (0..8).map(move |step| {
        let (sin, cos) = libm::sincos(std::f64::consts::FRAC_PI_4 * f64::from(step));
        point + distance * (cos * across + sin * along)
    })
}

/// True if a shape lies on a face with a normal at a point, no further from it than a gap [m];
/// overlaps up to `flush` [m] do not count.
fn lies_on(shape: &ConvexShape, at: DVec3, normal: DVec3, [flush, gap]: [f64; 2]) -> bool {
    match shape {
        ConvexShape::Hull(hull) => {
            // The part of the way out of the face that lies in the hull.
            let (mut from, mut to) = (flush, gap);
            for plane in hull.planes() {
                let (height, rate) = (plane.distance(at), plane.normal.dot(normal));
                if rate.abs() < 1e-9 {
                    if height > flush {
                        return false;
                    }
                } else if rate > 0.0 {
                    to = to.min(-height / rate);
                } else {
                    from = from.max(-height / rate);
                }
            }
            from < to
        }
        ConvexShape::Mesh(_) => {
            let mut lies = false;
            visit_faces(shape, at, gap, |plane, corners| {
                lies |= plane.normal.dot(normal) <= -FLAT
                    && (-flush..=gap).contains(&plane.distance(at))
                    && outside(at, &plane, corners) <= flush;
            });
            lies
        }
        _ => false,
    }
}

/// Calls `visit` with the plane and the corners of each face near a point [m].
fn visit_faces(
    shape: &ConvexShape,
    near: DVec3,
    width: f64,
    mut visit: impl FnMut(HalfSpace, &[DVec3]),
) {
    match shape {
        ConvexShape::Hull(hull) => {
            let mut corners = Vec::new();
            for face in hull.faces() {
                if face.plane.distance(near).abs() <= width {
                    corners.clear();
                    corners.extend(face.vertices.iter().map(|&at| hull.vertices()[at as usize]));
                    visit(face.plane, &corners);
                }
            }
        }
        ConvexShape::Mesh(mesh) => {
            mesh.visit_box(near - width, near + width, |triangle| {
                let (corners, normal) = (mesh.corners(triangle), mesh.normal(triangle));
                visit(HalfSpace { normal, offset: normal.dot(corners[0]) }, &corners);
            });
        }
        _ => {}
    }
}

/// True if a face reaches further than `width` [m] from a point in a direction.
fn reaches(corners: &[DVec3], from: DVec3, direction: DVec3, width: f64) -> bool {
    corners.iter().any(|&corner| direction.dot(corner - from) > width)
}

/// Distance of a point from a convex face in its plane, negative inside; at its corners less [m].
fn outside(point: DVec3, plane: &HalfSpace, corners: &[DVec3]) -> f64 {
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let beyond = |at: usize| {
        let (from, to) = (corners[at], corners[(at + 1) % corners.len()]);
        let across = (to - from).cross(plane.normal).normalize_or_zero();
        let outward = if across.dot(middle - from) > 0.0 { -across } else { across };
        outward.dot(point - from)
    };
    (0..corners.len()).map(beyond).fold(f64::NEG_INFINITY, f64::max)
}
