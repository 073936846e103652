//! The WebAssembly door: worlds that JavaScript builds, steps and reads.

#![allow(unsafe_code, reason = "what wasm-bindgen writes for a module's exports")]

use frangible::bodies::Motion;
use frangible::{BodyDesc, BodyId, SceneDesc, id_from_number, id_number};
use frangible_shots::{Shot, ShotOptions};
use js_sys::{Float32Array, Float64Array, JSON, Uint8Array, Uint32Array};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = include_str!("types.ts");

#[wasm_bindgen]
extern "C" {
    /// Milliseconds since the page or its worker began.
    #[wasm_bindgen(js_namespace = performance, js_name = now)]
    fn milliseconds() -> f64;

    /// Report of a frame.
    #[wasm_bindgen(typescript_type = "StepReport")]
    pub type StepReport;
}

fn seconds() -> f64 {
    1e-3 * milliseconds()
}

fn error(error: impl std::error::Error) -> JsError {
    JsError::new(&error.to_string())
}

/// A built-in shot as JSON of a scene; throws for a name that no shot has, and for shots that need
/// files.
#[wasm_bindgen(js_name = shotScene)]
pub fn shot_scene(name: &str) -> Result<String, JsError> {
    let shot = Shot::find(name).map_err(error)?;
    let scene = shot.scene(&ShotOptions::default()).map_err(error)?;
    serde_json::to_string(&scene).map_err(error)
}

/// Bodies, and the engine that moves and breaks them.
#[wasm_bindgen]
pub struct World {
    world: frangible::World,
}

/// State of a world at some frame.
#[wasm_bindgen]
pub struct Snapshot {
    world: frangible::World,
}

/// A closed surface in its body's frame.
#[wasm_bindgen]
pub struct Surface {
    surface: frangible::geometry::Surface,
}

#[wasm_bindgen]
impl World {
    /// Checks a scene, which is JSON, and builds it; throws the first rule that it breaks.
    #[wasm_bindgen(constructor)]
    pub fn new(scene: &str) -> Result<World, JsError> {
        let scene = SceneDesc::from_json(scene).map_err(error)?;
        let mut world = frangible::World::build(&scene).map_err(error)?;
        world.set_clock(seconds);
        Ok(Self { world })
    }

    /// Advances by one frame and reports on it.
    pub fn step(&mut self) -> Result<StepReport, JsError> {
        let report = serde_json::to_string(&frangible::step(&mut self.world)).map_err(error)?;
        let report = JSON::parse(&report).map_err(|_| JsError::new("the report is no JSON"))?;
        Ok(report.unchecked_into())
    }

    /// Number of frames so far.
    #[wasm_bindgen(getter)]
    pub fn frame(&self) -> f64 {
        self.world.frame() as f64
    }

    /// Simulated time [s].
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.world.time()
    }

    /// Length of a frame [s].
    #[wasm_bindgen(getter)]
    pub fn dt(&self) -> f64 {
        self.world.dt()
    }

    /// Ids of the living bodies, in order of birth.
    pub fn ids(&self) -> Float64Array {
        let ids: Vec<f64> = self.world.bodies().ids.iter().map(|&id| number(id)).collect();
        ids.as_slice().into()
    }

    /// Seven numbers of each body, in the order of `ids`: place of its centre of mass [m] and
    /// quaternion x, y, z, w that takes its frame to the world's.
    pub fn poses(&self) -> Float32Array {
        let pose = |pose: &frangible::bodies::Pose| {
            let [x, y, z] = pose.position.as_vec3().to_array();
            let [i, j, k, w] = pose.orientation.as_quat().to_array();
            [x, y, z, i, j, k, w]
        };
        let poses: Vec<f32> = self.world.bodies().poses.iter().flat_map(pose).collect();
        poses.as_slice().into()
    }

    /// Six numbers of each body, in the order of `ids`: velocity of its centre of mass [m/s] and
    /// angular velocity [rad/s], world frame.
    pub fn velocities(&self) -> Float32Array {
        let bodies = self.world.bodies();
        let velocity = |i: usize| {
            let (linear, angular) = match bodies.motions[i] {
                Motion::Kinematic { linear, angular } => (linear, angular),
                Motion::Static | Motion::Dynamic => (
                    bodies.velocities[i].linear,
                    bodies.inertias[i].angular_velocity(
                        bodies.poses[i].orientation,
                        bodies.velocities[i].angular_momentum,
                    ),
                ),
            };
            let ([u, v, w], [p, q, r]) =
                (linear.as_vec3().to_array(), angular.as_vec3().to_array());
            [u, v, w, p, q, r]
        };
        let velocities: Vec<f32> = (0..bodies.len()).flat_map(velocity).collect();
        velocities.as_slice().into()
    }

    /// [kg], in the order of `ids`; 0 for what has no mass.
    pub fn masses(&self) -> Float64Array {
        self.world.bodies().masses.as_slice().into()
    }

    /// Of a body; throws for an id that no living body has.
    pub fn name(&self, id: f64) -> Result<String, JsError> {
        Ok(self.world.labels()[self.dense(id)?].name.clone())
    }

    /// `"dynamic"`, `"kinematic"` or `"static"`; throws for an id that no living body has.
    pub fn motion(&self, id: f64) -> Result<String, JsError> {
        let motion = match self.world.bodies().motions[self.dense(id)?] {
            Motion::Dynamic => "dynamic",
            Motion::Kinematic { .. } => "kinematic",
            Motion::Static => "static",
        };
        Ok(motion.into())
    }

    /// Appearance of a body, if the scene gives one; throws for an id that no living body has.
    pub fn look(&self, id: f64) -> Result<Option<String>, JsError> {
        let look = self.world.labels()[self.dense(id)?].look;
        Ok(look.map(|look| look.name().into()))
    }

    /// Id of what a piece broke off from; throws for an id that no living body has.
    pub fn parent(&self, id: f64) -> Result<Option<f64>, JsError> {
        Ok(self.world.labels()[self.dense(id)?].parent.map(number))
    }

    /// Surface of a body; throws for an id that no living body has.
    pub fn surface(&self, id: f64) -> Result<Surface, JsError> {
        let surface = self.world.surface(body(id));
        surface.map(|surface| Surface { surface }).ok_or_else(|| stale(id))
    }

    /// Sets a body's velocity: `linear` of its centre of mass [m/s] and `angular` [rad/s], three
    /// numbers each. A kinematic body keeps it until the next call. Throws for a static body, an id
    /// that no living body has, and speeds out of range.
    #[wasm_bindgen(js_name = setVelocity)]
    pub fn set_velocity(
        &mut self,
        id: f64,
        linear: Vec<f64>,
        angular: Vec<f64>,
    ) -> Result<(), JsError> {
        let (linear, angular) = (vector("linear", linear)?, vector("angular", angular)?);
        self.world.set_velocity(body(id), linear.into(), angular.into()).map_err(error)
    }

    /// Adds a body, JSON as in a scene, behind all others; returns its id. Throws the first rule
    /// that it breaks.
    #[wasm_bindgen(js_name = addBody)]
    pub fn add_body(&mut self, json: &str) -> Result<f64, JsError> {
        let value = serde_json::from_str(json).map_err(error)?;
        let body: BodyDesc = frangible::read(value, "body").map_err(error)?;
        self.world.add_body(&body).map(number).map_err(error)
    }

    /// Takes a body out; throws for an id that no living body has.
    #[wasm_bindgen(js_name = removeBody)]
    pub fn remove_body(&mut self, id: f64) -> Result<(), JsError> {
        self.world.remove_body(body(id)).map_err(error)
    }

    /// Gives a dynamic body an impulse [N s] at a point [m], three numbers each, world frame;
    /// returns its work [J], which the next report counts as such. Throws the first rule that it
    /// breaks.
    #[wasm_bindgen(js_name = applyImpulse)]
    pub fn apply_impulse(
        &mut self,
        id: f64,
        impulse: Vec<f64>,
        point: Vec<f64>,
    ) -> Result<f64, JsError> {
        let (impulse, point) = (vector("impulse", impulse)?, vector("point", point)?);
        self.world.apply_impulse(body(id), impulse.into(), point.into()).map_err(error)
    }

    /// Pulls a point of a dynamic body's own frame [m] to a target in the world frame [m] with at
    /// most so much `force` [N], frame after frame until `letGo`, or until the body breaks. Holding
    /// a body again moves the hand. Throws the first rule that it breaks.
    pub fn hold(
        &mut self,
        id: f64,
        point: Vec<f64>,
        target: Vec<f64>,
        force: f64,
    ) -> Result<(), JsError> {
        let (point, target) = (vector("point", point)?, vector("target", target)?);
        self.world.hold(body(id), point.into(), target.into(), force).map_err(error)
    }

    /// Lets go of a body; false if it is not held.
    #[wasm_bindgen(js_name = letGo)]
    pub fn let_go(&mut self, id: f64) -> bool {
        self.world.let_go(body(id))
    }

    /// Cuts a body along the plane through a point [m], across a normal, world frame; returns the
    /// ids of its pieces, none if the plane does not part it. They have its mass and motion. Throws
    /// the first rule that it breaks.
    pub fn cut(
        &mut self,
        id: f64,
        point: Vec<f64>,
        normal: Vec<f64>,
    ) -> Result<Float64Array, JsError> {
        let (point, normal) = (vector("point", point)?, vector("normal", normal)?);
        self.world.cut(body(id), point.into(), normal.into()).map(numbers).map_err(error)
    }

    /// Breaks a body by its pattern, as a blow at a point of its surface would [m, world frame],
    /// and sends the pieces apart, the farthest with `speed` [m/s]; momentum stays. Returns their
    /// ids. Throws for an unbreakable body.
    pub fn burst(&mut self, id: f64, point: Vec<f64>, speed: f64) -> Result<Float64Array, JsError> {
        let point = vector("point", point)?;
        self.world.burst(body(id), point.into(), speed).map(numbers).map_err(error)
    }

    /// Kinetic and potential energy of all dynamic bodies [J].
    pub fn energy(&self) -> Float64Array {
        let (kinetic, potential) = self.world.energy();
        [kinetic, potential].as_slice().into()
    }

    /// Hexadecimal digest of ids, poses and velocities: the same on every machine.
    #[wasm_bindgen(js_name = stateHash)]
    pub fn state_hash(&self) -> String {
        format!("{:016x}", self.world.state_hash())
    }

    /// All of the state, to go back to with `restore`.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot { world: self.world.clone() }
    }

    /// Goes back to a snapshot of this world.
    pub fn restore(&mut self, snapshot: &Snapshot) {
        self.world = snapshot.world.clone();
    }

    fn dense(&self, id: f64) -> Result<usize, JsError> {
        self.world.bodies().index_of(body(id)).ok_or_else(|| stale(id))
    }
}

#[wasm_bindgen]
impl Surface {
    /// Three numbers of each corner [m].
    pub fn positions(&self) -> Float32Array {
        let points = self.surface.mesh.positions.iter();
        let positions: Vec<f32> = points.flat_map(|point| point.as_vec3().to_array()).collect();
        positions.as_slice().into()
    }

    /// Three corners of each triangle, counter-clockwise seen from outside.
    pub fn triangles(&self) -> Uint32Array {
        self.surface.mesh.triangles.as_flattened().into()
    }

    /// For each triangle 1 if a crack made it, else 0.
    pub fn interior(&self) -> Uint8Array {
        let interior: Vec<u8> = self.surface.interior.iter().map(|&made| made.into()).collect();
        interior.as_slice().into()
    }
}

fn number(id: BodyId) -> f64 {
    id_number(id) as f64
}

fn numbers(ids: Vec<BodyId>) -> Float64Array {
    ids.into_iter().map(number).collect::<Vec<f64>>().as_slice().into()
}

fn body(id: f64) -> BodyId {
    id_from_number(id as u64)
}

fn stale(id: f64) -> JsError {
    JsError::new(&format!("no living body has the id {id}"))
}

fn vector(name: &str, numbers: Vec<f64>) -> Result<[f64; 3], JsError> {
    let count = numbers.len();
    let rule = |_| JsError::new(&format!("{name}: {count} numbers, must be 3"));
    numbers.try_into().map_err(rule)
}
