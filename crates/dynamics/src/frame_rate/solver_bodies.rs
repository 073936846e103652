//! Solver bodies: two cache lines of single precision each, relative to the frame's start.
//! Double-precision poses and velocities stay outside the substep loop.

use frangible_bodies::{Bodies, Inertia, Motion, Pose, Rotation, Velocity, advance};
use frangible_math::Singles;
use glam::{DMat3, DQuat, DVec3, Vec3};
use std::ops::Range;

/// Target rotation of non-round bodies per substep [rad], within the maximum substep count: a top
/// precesses within 0.1 percent.
pub(super) const TURN: f64 = 0.05;

/// Rotation per frame [rad] above which a body counts as spinning: its constraints are prepared
/// again, and non-round bodies rotate exactly from then on. Below this angle gyroscopic motion
/// within a frame is a hundredth of the rotation.
const FAST_SPIN: f64 = 2.0 * TURN;

/// Rotation per substep [rad] above which contacts skip warm starting (reached if substeps are
/// limited): the last substep's impulses had other arms, and would add energy to slivers. Also the
/// maximum rotation that an impact reverts.
pub(super) const SPINS: f32 = 4.0 * TURN as f32;

/// Maximum relative difference of the principal moments of a round body.
const ROUND: f64 = 1e-3;

/// Bodies with a velocity change of at most this multiple of gravity's kick drift with the mean of
/// the velocities before and after a substep: free fall and sliding become exact.
const SECOND_ORDER: f64 = 1.05;

/// A body in the substep loop.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct SolverBody {
    /// Linear velocity [m/s], angular velocity [rad/s], inverse mass [1/kg], radius [m].
    pub(super) velocity: Singles,
    /// Since the frame's start: translation [m], rotation (x, y, z, w). Then the rotation angle
    /// since the last `prepare` of its constraints [rad].
    pub(super) displacement: Singles,
}

impl SolverBody {
    /// An immovable body: the other side of empty lanes.
    const FIXED: Self = Self {
        velocity: Singles::ZERO,
        displacement: Singles([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
    };

    pub(super) fn is_movable(&self) -> bool {
        self.velocity.0[6] > 0.0
    }

    /// Rotation since the frame's start.
    pub(super) fn turn(&self) -> DQuat {
        let Singles(d) = self.displacement;
        DQuat::from_xyzw(d[3].into(), d[4].into(), d[5].into(), d[6].into())
    }

    /// Present pose of a body with the pose `start` at the frame's start.
    pub(super) fn pose(&self, start: &Pose) -> Pose {
        let Singles(d) = self.displacement;
        Pose {
            position: start.position + Vec3::new(d[0], d[1], d[2]).as_dvec3(),
            orientation: (self.turn() * start.orientation).normalize(),
        }
    }

    /// The body after another `h` [s] with its velocity.
    pub(super) fn drifted(mut self, h: f32) -> Self {
        drift(&mut self, h, Vec3::ZERO);
        self
    }
}

/// The bodies of an island group.
pub(super) struct SolverBodies {
    /// Dense index of each line's body; `None` for static bodies.
    pub(super) body_of: Vec<Option<usize>>,
    pub(super) lines: Vec<SolverBody>,
    /// World frame: xx, yy, zz, yz, xz, xy, unused, unused [1/(kg m^2)].
    pub(super) inverse_inertias: Vec<Singles>,
    /// Linear velocities after the substep's impacts, less gravity's kick [m/s].
    before_kick: Vec<Vec3>,
    /// Exactly rotated bodies, sorted by line.
    spinning: Vec<SpinningBody>,
    /// Lines with constraints to prepare again.
    pub(super) turned: Vec<usize>,
}

/// Solver lines of some batches.
pub(super) struct Lines<'a> {
    pub(super) bodies: &'a mut [SolverBody],
    pub(super) inverse_inertias: &'a [Singles],
}

/// A non-round body with noticeable rotation within a frame.
pub(super) struct SpinningBody {
    /// Solver line.
    pub(super) line: usize,
    /// Dense body index.
    body: usize,
    angular_momentum: DVec3,
    inverse_inertia: DMat3,
    /// In the precision of its solver line.
    angular_velocity: DVec3,
    orientation: DQuat,
}

impl SolverBodies {
    pub(super) fn new(bodies: &Bodies, body_of: Vec<Option<usize>>, dt: f64) -> Self {
        let mut all = Self {
            lines: vec![SolverBody::FIXED; body_of.len()],
            inverse_inertias: vec![Singles::ZERO; body_of.len()],
            before_kick: vec![Vec3::ZERO; body_of.len()],
            spinning: Vec::new(),
            turned: Vec::new(),
            body_of,
        };
        for (line, &i) in all.body_of.iter().enumerate() {
            let Some(i) = i else { continue };
            let (pose, velocity, inertia) =
                (&bodies.poses[i], &bodies.velocities[i], &bodies.inertias[i]);
            let angular = bodies.spin(i, pose, velocity);
            let linear = match bodies.motions[i] {
                Motion::Kinematic { linear, .. } => linear,
                Motion::Static | Motion::Dynamic => velocity.linear,
            };
            let inverse_inertia = inertia.inverse_tensor(pose.orientation);
            if angular.length() * dt > FAST_SPIN && !is_round(inertia) {
                all.spinning.push(SpinningBody {
                    line,
                    body: i,
                    angular_momentum: velocity.angular_momentum,
                    inverse_inertia,
                    angular_velocity: angular.as_vec3().as_dvec3(),
                    orientation: pose.orientation,
                });
            }
            let [v, w] = [linear, angular].map(DVec3::as_vec3);
            let inverse_mass = inertia.inverse_mass as f32;
            let radius = bodies.radii[i] as f32;
            all.lines[line].velocity =
                Singles([v.x, v.y, v.z, w.x, w.y, w.z, inverse_mass, radius]);
            all.inverse_inertias[line] = symmetric_line(&inverse_inertia);
        }
        all
    }

    /// Present pose of a line's body with the pose `start` at the frame's start, and its linear
    /// [m/s] and angular velocity [rad/s].
    pub(super) fn now(&self, line: usize, start: &Pose) -> (Pose, [DVec3; 2]) {
        let Singles(v) = self.lines[line].velocity;
        let [linear, angular] =
            [[v[0], v[1], v[2]], [v[3], v[4], v[5]]].map(|v| Vec3::from_array(v).as_dvec3());
        (self.lines[line].pose(start), [linear, angular])
    }

    /// Present angular speed of a line [rad/s].
    pub(super) fn spin_speed(&self, line: usize) -> f64 {
        let Singles(v) = self.lines[line].velocity;
        Vec3::new(v[3], v[4], v[5]).length().into()
    }

    /// Inverse mass [1/kg], and inverse inertia in the world frame [1/(kg m^2)], of a line.
    pub(super) fn inverse_mass_and_inertia(&self, line: usize) -> (f64, DMat3) {
        (self.lines[line].velocity.0[6].into(), symmetric(&self.inverse_inertias[line]))
    }

    /// The lines in `range`.
    pub(super) fn lines(&mut self, range: Range<usize>) -> Lines<'_> {
        Lines {
            bodies: &mut self.lines[range.clone()],
            inverse_inertias: &self.inverse_inertias[range],
        }
    }

    /// Adds gravity's impulse of a substep.
    pub(super) fn kick(&mut self, velocity_change: Vec3) {
        for body in &mut self.lines {
            let Singles(v) = &mut body.velocity;
            if v[6] > 0.0 {
                v[0] += velocity_change.x;
                v[1] += velocity_change.y;
                v[2] += velocity_change.z;
            }
        }
    }

    /// Notes the velocities that [`drift`](Self::drift) begins with. What has bounced falls on from
    /// there: without this an elastic ball lost g h^2 / 2 of its height in each bounce.
    pub(super) fn end_impacts(&mut self, kick: Vec3) {
        for (body, before) in self.lines.iter().zip(&mut self.before_kick) {
            let Singles(v) = body.velocity;
            *before = Vec3::new(v[0], v[1], v[2]);
            if v[6] > 0.0 {
                *before -= kick;
            }
        }
    }

    /// Integrates positions and rotations over a substep `h` [s]; `kick` is gravity's velocity
    /// change [m/s].
    pub(super) fn drift(&mut self, h: f32, kick: f32) {
        let limit = SECOND_ORDER as f32 * kick;
        self.turned.clear();
        for (line, (body, before)) in self.lines.iter_mut().zip(&self.before_kick).enumerate() {
            let change = Vec3::new(
                body.velocity.0[0] - before.x,
                body.velocity.0[1] - before.y,
                body.velocity.0[2] - before.z,
            );
            let is_smooth = body.is_movable() && change.length_squared() <= limit * limit;
            drift(body, h, if is_smooth { 0.5 * change } else { Vec3::ZERO });
            let Singles(v) = body.velocity;
            let turned = &mut body.displacement.0[7];
            *turned += h * (v[3] * v[3] + v[4] * v[4] + v[5] * v[5]).sqrt();
            if *turned > FAST_SPIN as f32 {
                *turned = 0.0;
                self.turned.push(line);
            }
        }
    }

    /// Rotates spinning bodies exactly, replacing the rotation of [`drift`](Self::drift), and adds
    /// bodies that began to spin.
    pub(super) fn spin(&mut self, bodies: &Bodies, rotation: Rotation, h: f64) {
        for body in &mut self.spinning {
            let line = &mut self.lines[body.line];
            body.apply(line);
            let pose = Pose { position: DVec3::ZERO, orientation: body.orientation };
            let velocity =
                Velocity { linear: DVec3::ZERO, angular_momentum: body.angular_momentum };
            let inertia = &bodies.inertias[body.body];
            body.orientation = advance(&pose, &velocity, inertia, h, rotation).orientation;
            self.inverse_inertias[body.line] = body.show(bodies, line);
        }
        for &line in &self.turned {
            let Some(i) = self.body_of[line] else { continue };
            let (at, inertia) = (self.spinning_at(line), &bodies.inertias[i]);
            if let (Err(at), false) = (at, is_round(inertia)) {
                let Singles(v) = self.lines[line].velocity;
                let orientation = self.lines[line].pose(&bodies.poses[i]).orientation;
                let angular_velocity = Vec3::new(v[3], v[4], v[5]).as_dvec3();
                let mut body = SpinningBody {
                    line,
                    body: i,
                    angular_momentum: inertia.tensor(orientation) * angular_velocity,
                    inverse_inertia: DMat3::ZERO,
                    angular_velocity,
                    orientation,
                };
                self.inverse_inertias[line] = body.show(bodies, &mut self.lines[line]);
                self.spinning.insert(at, body);
            }
        }
    }

    fn spinning_at(&self, line: usize) -> Result<usize, usize> {
        self.spinning.binary_search_by_key(&line, |body| body.line)
    }

    /// Writes a line to its body: linear velocity from the frame's momentum change [N s], angular
    /// velocity and displacement from the loop.
    pub(super) fn write_back(
        &mut self,
        bodies: &mut Bodies,
        (line, i): (usize, usize),
        momentum_change: DVec3,
    ) {
        let SolverBody { velocity: Singles(v), displacement: Singles(d) } = self.lines[line];
        bodies.velocities[i].linear += bodies.inertias[i].inverse_mass * momentum_change;
        bodies.poses[i].position += Vec3::new(d[0], d[1], d[2]).as_dvec3();

        if let Ok(at) = self.spinning_at(line) {
            self.spinning[at].apply(&self.lines[line]);
            bodies.velocities[i].angular_momentum = self.spinning[at].angular_momentum;
            bodies.poses[i].orientation = self.spinning[at].orientation;
        } else {
            let pose = bodies.poses[i];
            let before = bodies.spin(i, &pose, &bodies.velocities[i]).as_vec3().as_dvec3();
            let after = Vec3::new(v[3], v[4], v[5]).as_dvec3();
            bodies.velocities[i].angular_momentum +=
                bodies.inertias[i].tensor(pose.orientation) * (after - before);
            let turn = DQuat::from_xyzw(d[3].into(), d[4].into(), d[5].into(), d[6].into());
            bodies.poses[i].orientation = (turn * pose.orientation).normalize();
        }
    }
}

impl SpinningBody {
    /// Adds contact's change of the line's angular velocity to the angular momentum.
    fn apply(&mut self, line: &SolverBody) {
        let Singles(v) = line.velocity;
        let now = Vec3::new(v[3], v[4], v[5]).as_dvec3();
        self.angular_momentum += self.inverse_inertia.inverse() * (now - self.angular_velocity);
        self.angular_velocity = now;
    }

    /// Stores orientation and spin in the line, and returns the inverse inertia.
    fn show(&mut self, bodies: &Bodies, line: &mut SolverBody) -> Singles {
        self.inverse_inertia = bodies.inertias[self.body].inverse_tensor(self.orientation);
        let angular = (self.inverse_inertia * self.angular_momentum).as_vec3();
        self.angular_velocity = angular.as_dvec3();

        let turn = self.orientation * bodies.poses[self.body].orientation.conjugate();
        let turn = if turn.w < 0.0 { -turn } else { turn };
        line.velocity.0[3..6].copy_from_slice(&angular.to_array());
        line.displacement.0[3..7].copy_from_slice(&turn.as_quat().to_array());
        symmetric_line(&self.inverse_inertia)
    }
}

/// True for bodies with nearly equal principal moments, whose orientation hardly changes the
/// inertia.
pub(super) fn is_round(inertia: &Inertia) -> bool {
    let moments = inertia.inverse_moments;
    let largest = moments.max_element();
    largest - moments.min_element() <= ROUND * largest
}

/// Integrates a line over `h` [s] with its velocity minus `less` [m/s].
#[inline(always)]
fn drift(body: &mut SolverBody, h: f32, less: Vec3) {
    let Singles(v) = body.velocity;
    let Singles(d) = &mut body.displacement;
    d[0] += h * (v[0] - less.x);
    d[1] += h * (v[1] - less.y);
    d[2] += h * (v[2] - less.z);
    let half = 0.5 * h;
    let [a, b, c] = [half * v[3], half * v[4], half * v[5]];
    let [x, y, z, w] = [d[3], d[4], d[5], d[6]];
    let turned = [
        x + a * w + b * z - c * y,
        y + b * w + c * x - a * z,
        z + c * w + a * y - b * x,
        w - a * x - b * y - c * z,
    ];
    let squared = turned.iter().map(|part| part * part).sum::<f32>();
    let scale = 1.0 / squared.sqrt();
    for k in 0..4 {
        d[3 + k] = turned[k] * scale;
    }
}

fn symmetric_line(m: &DMat3) -> Singles {
    let entries =
        [m.x_axis.x, m.y_axis.y, m.z_axis.z, m.y_axis.z, m.x_axis.z, m.x_axis.y, 0.0, 0.0];
    Singles(entries.map(|entry| entry as f32))
}

/// Matrix of a line's entries.
pub(super) fn symmetric(line: &Singles) -> DMat3 {
    let [xx, yy, zz, yz, xz, xy, ..] = line.0.map(f64::from);
    DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
}
