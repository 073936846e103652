//! Plane, sphere, box, cylinder, capsule and cone in closed form: bodies, and the oracles of the
//! tests.

use crate::half_space::HalfSpace;
use crate::mass_properties::MassProperties;
use crate::revolved::{Revolved, RevolvedEnd};
use frangible_math::check::{Check, Checked, require};
use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A shape whose signed distance, gradient and mass properties are formulas. Its centre of mass is
/// the origin of its frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ClosedForm {
    /// The ground: everything below a plane. Has no volume, so it can only be static.
    HalfSpace(HalfSpace),
    /// `radius` [m].
    Sphere {
        /// [m]
        radius: f64,
    },
    /// Axis-aligned, from `-half` to `half` [m].
    Box {
        /// Half of the edge lengths [m].
        half: DVec3,
    },
    /// Around the y axis.
    Cylinder {
        /// [m]
        radius: f64,
        /// Half of the height [m].
        half_height: f64,
    },
    /// All within `radius` of a segment of the y axis.
    Capsule {
        /// [m]
        radius: f64,
        /// Half of the segment [m].
        half_height: f64,
    },
    /// Around the y axis, its apex up: the base lies a quarter of the height below the origin.
    Cone {
        /// Of the base [m].
        radius: f64,
        /// [m]
        height: f64,
    },
}

impl Check for ClosedForm {
    fn check(&self) -> Checked {
        let sizes = match *self {
            Self::HalfSpace(half_space) => return half_space.check(),
            Self::Sphere { radius } => [radius; 3],
            Self::Box { half } => half.to_array(),
            Self::Cylinder { radius, half_height } => [radius, radius, half_height],
            Self::Capsule { radius, half_height } => [radius, radius, radius + half_height.abs()],
            Self::Cone { radius, height } => [radius, radius, height],
        };
        require(sizes.iter().all(|&size| size > 0.0 && size < 1e9), "a form with a size")
    }
}

impl ClosedForm {
    /// The body of revolution around the y axis; `None` for other forms.
    #[inline]
    pub fn revolved(&self) -> Option<Revolved> {
        let end = |height: f64, radius: f64| RevolvedEnd { height, radius };
        match *self {
            Self::Cylinder { radius, half_height } => Some(Revolved {
                ends: [end(-half_height, radius), end(half_height, radius)],
                rounding: 0.0,
            }),
            Self::Capsule { radius, half_height } => Some(Revolved {
                ends: [end(-half_height, 0.0), end(half_height, 0.0)],
                rounding: radius,
            }),
            Self::Cone { radius, height } => Some(cone(radius, height)),
            Self::HalfSpace(_) | Self::Sphere { .. } | Self::Box { .. } => None,
        }
    }

    /// Signed distance [m], negative inside, and its unit gradient. Where several points of the
    /// surface are nearest (a sphere's centre, a box's diagonals), the gradient belongs to one of
    /// them, always the same.
    pub fn distance_and_gradient(&self, point: DVec3) -> (f64, DVec3) {
        match *self {
            Self::HalfSpace(half_space) => (half_space.distance(point), half_space.normal),
            Self::Sphere { radius } => {
                let (length, direction) = length_and_direction(point);
                (length - radius, direction)
            }
            Self::Box { half } => {
                let (distance, gradient) = distance_to_corner(point.abs() - half);
                (distance, gradient * sign(point))
            }
            Self::Cylinder { radius, half_height } => {
                let (from_axis, outward) = length_and_direction(DVec3::new(point.x, 0.0, point.z));
                // On the axis the y direction stands for "no direction"; any radial one is as near.
                let outward = if from_axis > 0.0 { outward } else { DVec3::X };
                let (distance, gradient) = distance_to_corner(DVec3::new(
                    from_axis - radius,
                    point.y.abs() - half_height,
                    f64::NEG_INFINITY,
                ));
                (distance, gradient.x * outward + gradient.y * sign(point).y * DVec3::Y)
            }
            Self::Capsule { radius, half_height } => {
                let (length, direction) = length_and_direction(from_segment(point, half_height));
                (length - radius, if length > 0.0 { direction } else { DVec3::X })
            }
            Self::Cone { radius, height } => cone(radius, height).distance_and_gradient(point),
        }
    }

    /// Signed distance [m] alone.
    pub fn distance(&self, point: DVec3) -> f64 {
        match *self {
            Self::HalfSpace(half_space) => half_space.distance(point),
            Self::Sphere { radius } => point.length() - radius,
            Self::Box { half } => length_beyond(point.abs() - half),
            Self::Cylinder { radius, half_height } => {
                let from_axis = DVec2::new(point.x, point.z).length();
                length_beyond(DVec3::new(
                    from_axis - radius,
                    point.y.abs() - half_height,
                    f64::NEG_INFINITY,
                ))
            }
            Self::Capsule { radius, half_height } => {
                from_segment(point, half_height).length() - radius
            }
            Self::Cone { radius, height } => cone(radius, height).distance_and_gradient(point).0,
        }
    }

    /// Lowest and highest corner of the bounding box [m]; infinite for a half-space.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let high = match *self {
            Self::HalfSpace(_) => DVec3::INFINITY,
            Self::Sphere { radius } => DVec3::splat(radius),
            Self::Box { half } => half,
            Self::Cylinder { radius, half_height } => DVec3::new(radius, half_height, radius),
            Self::Capsule { radius, half_height } => {
                DVec3::new(radius, half_height + radius, radius)
            }
            Self::Cone { radius, height } => {
                let low = DVec3::new(-radius, -0.25 * height, -radius);
                return (low, DVec3::new(radius, 0.75 * height, radius));
            }
        };
        (-high, high)
    }

    /// Exact volume, centre and inertia at unit density; `None` for a half-space.
    pub fn mass_properties(&self) -> Option<MassProperties> {
        let (volume, moments_per_volume) = match *self {
            Self::HalfSpace(_) => return None,
            Self::Sphere { radius } => {
                (4.0 / 3.0 * PI * radius * radius * radius, DVec3::splat(0.4 * radius * radius))
            }
            Self::Box { half } => {
                let square = half * half;
                let moments =
                    DVec3::new(square.y + square.z, square.z + square.x, square.x + square.y) / 3.0;
                (8.0 * half.x * half.y * half.z, moments)
            }
            Self::Cylinder { radius, half_height } => {
                let around = 0.5 * radius * radius;
                let across = 0.25 * radius * radius + half_height * half_height / 3.0;
                (2.0 * PI * radius * radius * half_height, DVec3::new(across, around, across))
            }
            Self::Capsule { radius, half_height } => {
                // A cylinder and two half balls, whose centres of mass are 3/8 of the radius beyond
                // its ends.
                let square = radius * radius;
                let (side, ball) =
                    (2.0 * PI * square * half_height, 4.0 / 3.0 * PI * square * radius);
                let beyond = half_height * (half_height + 0.75 * radius);
                let around = 0.5 * side * square + 0.4 * ball * square;
                let across = side * (0.25 * square + half_height * half_height / 3.0)
                    + ball * (0.4 * square + beyond);
                let volume = side + ball;
                (volume, DVec3::new(across, around, across) / volume)
            }
            Self::Cone { radius, height } => {
                let around = 0.3 * radius * radius;
                let across = 0.15 * radius * radius + 0.0375 * height * height;
                (PI / 3.0 * radius * radius * height, DVec3::new(across, around, across))
            }
        };
        let inertia = DMat3::from_diagonal(volume * moments_per_volume);
        Some(MassProperties { volume, center: DVec3::ZERO, inertia })
    }
}

fn cone(radius: f64, height: f64) -> Revolved {
    let end = |height: f64, radius: f64| RevolvedEnd { height, radius };
    Revolved { ends: [end(-0.25 * height, radius), end(0.75 * height, 0.0)], rounding: 0.0 }
}

/// From the nearest point of a segment of the y axis [m].
fn from_segment(point: DVec3, half_height: f64) -> DVec3 {
    point - point.y.clamp(-half_height, half_height) * DVec3::Y
}

/// Length and direction of a vector, without underflow; the direction of zero is y.
fn length_and_direction(vector: DVec3) -> (f64, DVec3) {
    let largest = vector.abs().max_element();
    if largest == 0.0 {
        return (0.0, DVec3::Y);
    }
    let scaled = vector / largest;
    let length = scaled.length();
    (length * largest, scaled / length)
}

/// Signed distance and unit gradient of the octant where all components of `beyond` are negative.
fn distance_to_corner(beyond: DVec3) -> (f64, DVec3) {
    if beyond.max_element() > 0.0 {
        return length_and_direction(beyond.max(DVec3::ZERO));
    }
    // Inside the nearest face decides; of equally near ones the first.
    if beyond.x >= beyond.y && beyond.x >= beyond.z {
        (beyond.x, DVec3::X)
    } else if beyond.y >= beyond.z {
        (beyond.y, DVec3::Y)
    } else {
        (beyond.z, DVec3::Z)
    }
}

/// -1 or +1 for each component; +1 for both zeros.
fn sign(vector: DVec3) -> DVec3 {
    DVec3::select(vector.cmplt(DVec3::ZERO), DVec3::NEG_ONE, DVec3::ONE)
}

/// Distance from a corner of a box to a point with these distances from its faces [m].
fn length_beyond(from_faces: DVec3) -> f64 {
    from_faces.max(DVec3::ZERO).length() + from_faces.max_element().min(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(half: f64) -> impl Strategy<Value = DVec3> {
        (-half..half, -half..half, -half..half).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    fn forms() -> [ClosedForm; 7] {
        [
            ClosedForm::HalfSpace(HalfSpace { normal: DVec3::new(0.6, 0.8, 0.0), offset: 0.3 }),
            ClosedForm::Sphere { radius: 0.8 },
            ClosedForm::Box { half: DVec3::new(0.5, 0.9, 0.2) },
            ClosedForm::Cylinder { radius: 0.7, half_height: 0.4 },
            ClosedForm::Capsule { radius: 0.3, half_height: 0.4 },
            ClosedForm::Cone { radius: 0.7, height: 0.9 },
            ClosedForm::Cone { radius: 0.1, height: 1.9 },
        ]
    }

    /// The point of a box's or cylinder's solid nearest to an outside point, by clamping.
    fn nearest_inside(form: &ClosedForm, point: DVec3) -> Option<DVec3> {
        match *form {
            ClosedForm::Box { half } => Some(point.clamp(-half, half)),
            ClosedForm::Cylinder { radius, half_height } => {
                let shrink = (radius / (point.x * point.x + point.z * point.z).sqrt()).min(1.0);
                Some(DVec3::new(
                    point.x * shrink,
                    point.y.clamp(-half_height, half_height),
                    point.z * shrink,
                ))
            }
            _ => None,
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5000))]

        /// Walking against the gradient by the distance ends on the surface, and no way to it is
        /// shorter.
        #[test]
        fn the_foot_of_each_point_is_on_the_surface(point in vector(2.0), other in vector(2.0)) {
            for form in forms() {
                let (distance, gradient) = form.distance_and_gradient(point);
                prop_assert!((gradient.length() - 1.0).abs() < 1e-14);
                let (at_foot, _) = form.distance_and_gradient(point - distance * gradient);
                prop_assert!(at_foot.abs() < 1e-12, "{form:?} at {point}: {at_foot}");
                let (at_other, _) = form.distance_and_gradient(other);
                prop_assert!((distance - at_other).abs() <= (point - other).length() + 1e-12);
            }
        }

        /// Outside of a convex solid, the distance is that to the clamped point; in it, negative.
        #[test]
        fn distance_outside_is_euclidean(point in vector(2.0)) {
            for form in forms() {
                let Some(nearest) = nearest_inside(&form, point) else { continue };
                let (distance, _) = form.distance_and_gradient(point);
                let expected = (point - nearest).length();
                if expected > 1e-9 {
                    prop_assert!((distance - expected).abs() < 1e-12);
                } else {
                    prop_assert!(distance < 1e-9);
                }
            }
        }
    }

    #[test]
    fn degenerate_points_have_a_unit_gradient() {
        let tiny = 1e-300;
        for form in forms() {
            for point in [
                DVec3::ZERO,
                DVec3::splat(tiny),
                DVec3::new(0.5, 0.9, 0.2),
                DVec3::new(0.0, 0.4, 0.0),
            ] {
                for point in [point, -point, point + DVec3::new(tiny, 0.0, tiny)] {
                    let (distance, gradient) = form.distance_and_gradient(point);
                    assert!(
                        distance.is_finite() && (gradient.length() - 1.0).abs() < 1e-14,
                        "{form:?} at {point}"
                    );
                }
            }
        }
        let cube = ClosedForm::Box { half: DVec3::ONE };
        assert_eq!(
            cube.distance_and_gradient(DVec3::ZERO),
            cube.distance_and_gradient(-DVec3::ZERO)
        );
    }

    /// The inertia of a solid cut into slabs along y: analytic against a sum over its
    /// cross-sections.
    #[test]
    fn moments_are_those_of_the_textbook() {
        let half = DVec3::new(0.5, 0.9, 0.2);
        let cuboid = ClosedForm::Box { half }.mass_properties().unwrap();
        let mass = 8.0 * half.x * half.y * half.z;
        let edge = 2.0 * half;
        assert!((cuboid.volume - mass).abs() < 1e-15);
        assert!(
            (cuboid.inertia.x_axis.x - mass * (edge.y * edge.y + edge.z * edge.z) / 12.0).abs()
                < 1e-15
        );
        assert!(
            (cuboid.inertia.y_axis.y - mass * (edge.x * edge.x + edge.z * edge.z) / 12.0).abs()
                < 1e-15
        );

        // Discs of radius r and thickness dy: pi r^4 / 4 about a diameter, pi r^2 y^2 by the
        // parallel axis.
        let (radius, half_height, slabs) = (0.7, 0.4, 20_000);
        let through_discs = |half_height: f64, square_radius: &dyn Fn(f64) -> f64| {
            let dy = 2.0 * half_height / f64::from(slabs);
            let (mut volume, mut across, mut around) = (0.0, 0.0, 0.0);
            for slab in 0..slabs {
                let y = -half_height + (f64::from(slab) + 0.5) * dy;
                let square = square_radius(y);
                volume += PI * square * dy;
                across += PI * square * (0.25 * square + y * y) * dy;
                around += 0.5 * PI * square * square * dy;
            }
            (volume, DVec3::new(across, around, across))
        };
        let cylinder = through_discs(half_height, &|_| radius * radius);
        let sphere = through_discs(radius, &|y| radius * radius - y * y);
        let capsule = through_discs(half_height + radius, &|y| {
            let beyond = (y.abs() - half_height).max(0.0);
            radius * radius - beyond * beyond
        });
        // The origin is a quarter of the height above the base.
        let height = 1.5;
        let mut cone = through_discs(0.5 * height, &|y| {
            let part = 0.5 - y / height;
            radius * radius * part * part
        });
        cone.1 -= DVec3::new(1.0, 0.0, 1.0) * (cone.0 * (0.25 * height) * (0.25 * height));
        let solids = [
            ClosedForm::Cylinder { radius, half_height },
            ClosedForm::Sphere { radius },
            ClosedForm::Capsule { radius, half_height },
            ClosedForm::Cone { radius, height },
        ];
        for (form, (volume, moments)) in solids.iter().zip([cylinder, sphere, capsule, cone]) {
            let exact = form.mass_properties().unwrap();
            assert!((exact.volume - volume).abs() < 1e-7);
            assert!((exact.inertia - DMat3::from_diagonal(moments)).abs_diff_eq(DMat3::ZERO, 1e-7));
        }
        assert_eq!(forms()[0].mass_properties(), None);
    }
}
