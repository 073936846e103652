//! The surface of a solid, as balls inside of it meet it.

use crate::closed_form::ClosedForm;
use crate::compound::Compound;
use crate::grid_solid::{GridSolid, Root};
use crate::half_space::HalfSpace;
use crate::hull::Hull;
use crate::level_set::LevelSet;
use crate::mesh_boundary::MeshBoundary;
use crate::revolved::Revolved;
use crate::solid::Solid;
use glam::DVec3;

/// The planes, triangles and samples that a solid ends at, all in one frame.
#[derive(Default)]
pub(super) struct Walls<'a> {
    /// The solid lies inside of all of these.
    planes: Vec<HalfSpace>,
    triangles: Option<&'a MeshBoundary>,
    /// Hides triangles that lie inside of its parts.
    compound: Option<&'a Compound>,
    /// It lies inside of all of these, too.
    sampled: Vec<&'a LevelSet>,
}

/// The nearest point of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// To it [m]; negative outside.
    pub distance: f64,
    pub point: DVec3,
    /// Unit, outward.
    pub normal: DVec3,
}

impl<'a> Walls<'a> {
    pub(super) fn of_hull(hull: &Hull) -> Self {
        Self { planes: hull.planes().to_vec(), ..Self::default() }
    }

    pub(super) fn of_compound(compound: &'a Compound) -> Self {
        Self { triangles: Some(compound.boundary()), compound: Some(compound), ..Self::default() }
    }

    pub(super) fn of_solid(solid: &'a Solid) -> Self {
        Self { triangles: Some(solid.boundary()), ..Self::default() }
    }

    /// Of a formula, at a point: a body of revolution is there as its section through the point and
    /// the axis, and so is a ball.
    pub(super) fn of_form(form: &ClosedForm, point: DVec3) -> Self {
        let planes = match *form {
            ClosedForm::Box { half } => Hull::cuboid(half).planes().to_vec(),
            ClosedForm::HalfSpace(half_space) => vec![half_space],
            ClosedForm::Sphere { radius } => {
                let outward = point.try_normalize().unwrap_or(DVec3::Y);
                [outward, -outward].map(|normal| HalfSpace { normal, offset: radius }).to_vec()
            }
            _ => form.revolved().map_or_else(Vec::new, |revolved| section_planes(&revolved, point)),
        };
        Self { planes, ..Self::default() }
    }

    /// Of a solid on a grid, at a point.
    pub(super) fn of_grid(solid: &'a GridSolid, point: DVec3) -> Self {
        let outline = &solid.outline;
        let mut walls = match &outline.root {
            Root::ClosedForm(form) => Self::of_form(form, point),
            Root::Hull(hull) => Self::of_hull(hull),
            Root::Sampled(level_set) => match solid.boundary() {
                Some(boundary) => Self { triangles: Some(boundary), ..Self::default() },
                None => Self { sampled: vec![level_set], ..Self::default() },
            },
        };
        walls.planes.extend(&outline.cuts);
        walls.sampled.extend(outline.rough.iter().map(|cell| &**cell));
        walls
    }

    /// The nearest point of the surface. Between planes it may lie beyond another one.
    pub(super) fn nearest(&self, point: DVec3) -> Option<Foot> {
        let mut nearest: Option<Foot> = None;
        let mut offer = |foot: Foot| {
            if nearest.is_none_or(|known| foot.distance < known.distance) {
                nearest = Some(foot);
            }
        };
        self.planes.iter().for_each(|plane| offer(foot_on_plane(plane, point)));
        if let Some(triangles) = self.triangles
            && let Some((at, triangle)) = triangles.nearest(point, |at| !self.is_hidden(at))
        {
            let normal = triangles.normal(triangle);
            let is_outside = (point - at).dot(normal) > 0.0;
            let distance = if is_outside { -at.distance(point) } else { at.distance(point) };
            offer(Foot { distance, point: at, normal });
        }
        self.sampled.iter().for_each(|samples| offer(foot_on_samples(samples, point)));
        nearest
    }

    /// All points of the surface that are nearest on their part of it, closer than `reach` [m].
    pub(super) fn near(&self, point: DVec3, reach: f64) -> Vec<Foot> {
        let mut feet: Vec<Foot> =
            self.planes.iter().map(|plane| foot_on_plane(plane, point)).collect();
        feet.extend(self.sampled.iter().flat_map(|samples| feet_on_samples(samples, point)));
        feet.retain(|foot| foot.distance <= reach);
        if let Some(triangles) = self.triangles {
            triangles.visit_near(point, reach, |triangle, at| {
                if !self.is_hidden(at) {
                    let (distance, normal) = (at.distance(point), triangles.normal(triangle));
                    feet.push(Foot { distance, point: at, normal });
                }
            });
        }
        feet
    }

    /// True inside of a part of the compound: parts may overlap.
    fn is_hidden(&self, point: DVec3) -> bool {
        let Some(compound) = self.compound else { return false };
        let close = compound.close();
        let parts = compound.parts_near(point - close, point + close);
        parts.into_iter().any(|part| {
            let hull = &compound.parts()[part].hull;
            hull.planes().iter().all(|plane| plane.distance(point) < -close)
        })
    }
}

fn foot_on_plane(plane: &HalfSpace, point: DVec3) -> Foot {
    let height = plane.distance(point);
    Foot { distance: -height, point: point - height * plane.normal, normal: plane.normal }
}

/// By the gradient of the distance there.
fn foot_on_samples(samples: &LevelSet, point: DVec3) -> Foot {
    let (value, gradient) = samples.value_and_gradient(point);
    let normal = gradient.as_dvec3().normalize_or(DVec3::Y);
    let distance = f64::from(value);
    Foot { distance: -distance, point: point - distance * normal, normal }
}

/// Half-way between two sides the gradient belongs to neither: those of points around do.
fn feet_on_samples(samples: &LevelSet, point: DVec3) -> impl Iterator<Item = Foot> {
    let step = samples.grid().spacing;
    let around =
        DVec3::AXES.into_iter().flat_map(move |axis| [point - step * axis, point + step * axis]);
    std::iter::once(point).chain(around).map(move |from| {
        let foot = foot_on_samples(samples, from);
        Foot { distance: foot.point.distance(point), ..foot }
    })
}

/// The planes of a body of revolution's section through its axis and a point.
fn section_planes(revolved: &Revolved, point: DVec3) -> Vec<HalfSpace> {
    let outward = DVec3::new(point.x, 0.0, point.z).try_normalize().unwrap_or(DVec3::X);
    let [low, high] = revolved.ends;
    let side = revolved.side_normal();
    let rounding = revolved.rounding;
    let mut planes = Vec::with_capacity(4);
    for across in [outward, -outward] {
        let normal = side.x * across + side.y * DVec3::Y;
        let offset = side.x * low.radius + side.y * low.height + rounding;
        planes.push(HalfSpace { normal, offset });
    }
    for (end, normal) in [(low, -DVec3::Y), (high, DVec3::Y)] {
        if end.radius > 0.0 || rounding > 0.0 {
            planes.push(HalfSpace { normal, offset: normal.y * end.height + rounding });
        }
    }
    planes
}
