//! Separations against oracles: no direction separates more than the one found, and that one
//! separates as far as it says.

use super::*;
use frangible_geometry::{ClosedForm, HalfSpace, Hull};
use frangible_math::RigidTransform;
use glam::DQuat;
use proptest::prelude::*;

fn direction() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64)
        .prop_map(|(x, y, z)| DVec3::new(x, y, z))
        .prop_filter("any length", |way| way.length() > 0.05)
        .prop_map(DVec3::normalize)
}

/// Some are those of bodies that lie flat or stand.
fn orientation() -> impl Strategy<Value = DQuat> {
    let any =
        (direction(), 0.0..6.3_f64).prop_map(|(axis, angle)| DQuat::from_axis_angle(axis, angle));
    let flat = (0..4_i32, 0..4_i32).prop_map(|(x, z)| {
        let quarter = std::f64::consts::FRAC_PI_2;
        DQuat::from_rotation_x(quarter * f64::from(x))
            * DQuat::from_rotation_z(quarter * f64::from(z))
    });
    prop_oneof![3 => any, 1 => flat]
}

/// Thin discs, long rods and cones with tiny tips among them.
fn extent() -> impl Strategy<Value = f64> {
    (-2.0..0.3_f64).prop_map(libm::exp10)
}

fn form() -> impl Strategy<Value = ClosedForm> {
    (0..3, extent(), extent()).prop_map(|(kind, radius, length)| match kind {
        0 => ClosedForm::Cylinder { radius, half_height: length },
        1 => ClosedForm::Capsule { radius, half_height: length },
        _ => ClosedForm::Cone { radius, height: length },
    })
}

/// Boxes and hulls of few points.
fn hull() -> impl Strategy<Value = Hull> {
    let cuboid =
        (extent(), extent(), extent()).prop_map(|(x, y, z)| Hull::cuboid(DVec3::new(x, y, z)));
    let points = (proptest::collection::vec(direction(), 5..14), extent(), extent()).prop_map(
        |(points, wide, high)| {
            let scale = DVec3::new(wide, high, wide);
            let points: Vec<DVec3> = points.iter().map(|&point| point * scale).collect();
            Hull::of_points(&points)
        },
    );
    let points = points.prop_filter_map("flat", |hull| hull.ok());
    prop_oneof![cuboid, points]
}

#[derive(Clone, Debug)]
enum Other {
    Hull(Hull),
    Form(ClosedForm),
    Plane(DVec3),
}

fn other() -> impl Strategy<Value = Other> {
    prop_oneof![
        4 => hull().prop_map(Other::Hull),
        4 => form().prop_map(Other::Form),
        1 => direction().prop_map(Other::Plane),
    ]
}

/// Support of a body of revolution, by its definition.
fn reach_of(form: &ClosedForm, pose: &RigidTransform, direction: DVec3) -> f64 {
    let own = pose.inverse().direction(direction);
    let across = (own.x * own.x + own.z * own.z).sqrt();
    let reach = match *form {
        ClosedForm::Cylinder { radius, half_height } => radius * across + half_height * own.y.abs(),
        ClosedForm::Capsule { radius, half_height } => radius + half_height * own.y.abs(),
        ClosedForm::Cone { radius, height } => {
            (0.75 * height * own.y).max(radius * across - 0.25 * height * own.y)
        }
        _ => panic!("not round"),
    };
    reach + pose.translation.dot(direction)
}

struct Case {
    form: ClosedForm,
    pose: RigidTransform,
    other: Other,
}

impl Case {
    /// Separation along a direction from the partner.
    fn along(&self, normal: DVec3) -> f64 {
        let of_other = match &self.other {
            Other::Hull(hull) => {
                hull.vertices().iter().map(|v| v.dot(normal)).fold(f64::NEG_INFINITY, f64::max)
            }
            Other::Form(form) => reach_of(form, &RigidTransform::IDENTITY, normal),
            Other::Plane(_) => 0.0,
        };
        -reach_of(&self.form, &self.pose, -normal) - of_other
    }

    fn size(&self) -> f64 {
        let extent = |form: &ClosedForm| form.bounds().1.length();
        let of_other = match &self.other {
            Other::Hull(hull) => hull.bounds().1.length(),
            Other::Form(form) => extent(form),
            Other::Plane(_) => f64::INFINITY,
        };
        extent(&self.form).min(of_other)
    }

    fn found(&self) -> Separation {
        let round = PlacedRevolved::new(&self.form.revolved().unwrap(), &self.pose);
        let partner = match &self.other {
            Other::Hull(hull) => Partner::Hull(hull),
            Other::Form(form) => Partner::Revolved(PlacedRevolved::new(
                &form.revolved().unwrap(),
                &RigidTransform::IDENTITY,
            )),
            Other::Plane(normal) => Partner::Plane(HalfSpace { normal: *normal, offset: 0.0 }),
        };
        let guess = round.middle.normalize_or(DVec3::Y);
        separation(&round, &partner, self.size(), guess)
    }

    /// The best of many directions and of steps from the best ones.
    fn best(&self) -> f64 {
        const COUNT: usize = 3000;
        let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let mut all: Vec<(f64, DVec3)> = (0..COUNT)
            .map(|n| {
                let y = 1.0 - (2 * n + 1) as f64 / COUNT as f64;
                let ring = (1.0 - y * y).sqrt();
                let (sin, cos) = (golden * n as f64).sin_cos();
                let normal = DVec3::new(ring * cos, y, ring * sin);
                (self.along(normal), normal)
            })
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut starts: Vec<(f64, DVec3)> = Vec::new();
        for (value, normal) in all {
            if starts.len() < 12 && starts.iter().all(|s| s.1.dot(normal) < 0.98) {
                starts.push((value, normal));
            }
        }
        let climb = |&(value, normal): &(f64, DVec3)| {
            let (mut value, mut normal, mut step, mut turn) = (value, normal, 0.05, 0.0_f64);
            while step > 1e-11 {
                let (u, v) = normal.any_orthonormal_pair();
                turn += 1.0;
                let tries = (0..12).map(|n| {
                    let (sin, cos) = (turn + std::f64::consts::FRAC_PI_6 * f64::from(n)).sin_cos();
                    let next = (normal + step * (cos * u + sin * v)).normalize();
                    (self.along(next), next)
                });
                let next = tries.fold((value, normal), |a, b| if b.0 > a.0 { b } else { a });
                if next.0 > value { (value, normal) = next } else { step *= 0.6 }
            }
            value
        };
        starts.iter().map(climb).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A pair, its distance so that about as many overlap as not; some only just.
fn case() -> impl Strategy<Value = Case> {
    let near =
        prop_oneof![0.0..1.3_f64, 0.9..1.1_f64, Just(1.0), Just(1.0 + 1e-6), Just(1.0 - 1e-6)];
    (form(), other(), orientation(), direction(), direction(), near).prop_map(
        |(form, other, rotation, way, aside, near)| {
            let way = if let Other::Plane(normal) = other { normal } else { way };
            let mut case = Case { form, pose: RigidTransform::new(rotation, DVec3::ZERO), other };
            // Where they touch along this direction at a factor of 1.
            case.pose.translation = -case.along(way) * near * way;
            case.pose.translation += 0.1 * (1.0 - near).abs() * aside * case.size().min(10.0);
            case
        },
    )
}

fn check(case: &Case) -> Result<(), TestCaseError> {
    let found = case.found();
    let size = case.size().min(10.0);
    if matches!(case.other, Other::Plane(_)) {
        prop_assert!((found.gap - case.along(found.normal)).abs() < 1e-12);
        return Ok(());
    }
    prop_assert!((found.normal.length() - 1.0).abs() < 1e-9);
    // The normal found separates as far.
    let along = case.along(found.normal);
    prop_assert!((along - found.gap).abs() <= 1e-6 * size, "{along} {found:?} {size}");
    // Nothing else separates further.
    let best = case.best();
    prop_assert!(
        best <= found.gap + 1e-6 * size,
        "{:?} {:?}: {best} is better than {found:?}, size {size}",
        case.form,
        case.other
    );
    Ok(())
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?} at {:?} and {:?}", self.form, self.pose, self.other)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_direction_separates_further(case in case()) {
        check(&case)?;
    }
}
