//! A world, and its state as arrays.

use crate::convert;
use crate::errors::build_error;
use crate::interrupt::interruptible;
use crate::own_world::{Inner, OwnWorld};
use crate::scene_files::{scene, with_files};
use crate::threads::Pool;
use frangible::bodies::Motion;
use frangible::{BodyId, LookDesc, id_number};
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::OnceLock;
use std::time::Instant;

/// Vertices [m], triangles, and whether a crack made each.
type SurfaceArrays<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<u32>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray3<f32>>,
);

/// What a caller gives: a sentence tells what it must be.
type Given<'a, 'py> = &'a Bound<'py, PyAny>;

/// More threads than any machine has processors only take memory.
const MOST_THREADS: usize = 4096;

/// Bodies, and the engine that moves and breaks them.
#[pyclass(frozen, module = "frangible._frangible")]
pub(crate) struct World(OwnWorld);

impl World {
    /// A world of plain data, or of JSON.
    fn from_readable(
        py: Python<'_>,
        readable: &Bound<'_, PyAny>,
        threads: usize,
    ) -> PyResult<Self> {
        let scene = scene(readable)?;
        let mut pool = Pool::new(threads);
        let here = pool.here()?;
        let build = move || here.install(|| frangible::World::build(&scene));
        let mut world = interruptible(py, build)?.map_err(build_error)?;
        world.set_clock(seconds);
        // Materials of the scene's own, for bodies that are added.
        if let Ok(materials) = readable.getattr("materials_text") {
            world.set_note(materials.extract()?);
        }
        Ok(Self(OwnWorld::new(world, pool)))
    }
}

fn gone(id: BodyId) -> PyErr {
    PyKeyError::new_err(format!("no living body has the id {}", id_number(id)))
}

fn check_threads(threads: usize) -> PyResult<()> {
    if threads <= MOST_THREADS {
        return Ok(());
    }
    Err(build_error(format!("threads: {threads}, must be at most {MOST_THREADS}")))
}

/// Since it was asked first [s].
fn seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

#[pymethods]
impl World {
    /// Check a scene and build it.
    #[staticmethod]
    #[pyo3(signature = (scene, threads=0))]
    fn build(py: Python<'_>, scene: &Bound<'_, PyAny>, threads: usize) -> PyResult<Self> {
        check_threads(threads)?;
        with_files(scene, |readable| Self::from_readable(py, readable, threads))
    }

    /// Add a body as a scene would hold it; its id.
    fn add_body(&self, py: Python<'_>, body: &Bound<'_, PyAny>) -> PyResult<u64> {
        let materials = self.0.inner()?.world.note().to_owned();
        let alone = py.import("frangible.scenes")?.call_method1("scene_of", (body, materials))?;
        let scene = with_files(&alone, scene)?;
        let mut inner = self.0.inner()?;
        let Inner { world, pool } = &mut *inner;
        let body = &scene.bodies[0];
        let added = pool.here()?.install(|| world.add_body(body));
        added.map(id_number).map_err(build_error)
    }

    /// Take a living body out.
    fn remove_body(&self, id: Given<'_, '_>) -> PyResult<()> {
        let id = convert::body(id)?;
        self.0.act(|world| world.remove_body(id))
    }

    /// Advance by one frame and report on it.
    fn step<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let report = self.0.change(py, frangible::step)?;
        let report = serde_json::to_value(&report).map_err(build_error)?;
        convert::json(py, &report)
    }

    /// End the step that runs, or the next one, with `KeyboardInterrupt`.
    fn stop_step(&self) {
        self.0.stop();
    }

    #[getter]
    fn frame(&self) -> PyResult<u64> {
        Ok(self.0.inner()?.world.frame())
    }

    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.0.inner()?.world.time())
    }

    #[getter]
    fn dt(&self) -> PyResult<f64> {
        Ok(self.0.inner()?.world.dt())
    }

    #[getter]
    fn method<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::json(
            py,
            &serde_json::to_value(self.0.inner()?.world.method()).map_err(build_error)?,
        )
    }

    #[getter]
    fn energy(&self) -> PyResult<(f64, f64)> {
        let mut inner = self.0.inner()?;
        let pool = inner.pool.here()?;
        Ok(pool.install(|| inner.world.energy()))
    }

    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u64>>> {
        let world = &self.0.inner()?.world;
        Ok(PyArray1::from_iter(py, world.bodies().ids.iter().map(|&id| id_number(id))))
    }

    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        convert::rows(
            py,
            self.0.inner()?.world.bodies().poses.iter().map(|pose| pose.position.to_array()),
        )
    }

    #[getter]
    fn orientations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        convert::rows(
            py,
            self.0.inner()?.world.bodies().poses.iter().map(|pose| pose.orientation.to_array()),
        )
    }

    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let inner = self.0.inner()?;
        let bodies = inner.world.bodies();
        let linear = |i: usize| match bodies.motions[i] {
            Motion::Kinematic { linear, .. } => linear,
            Motion::Static | Motion::Dynamic => bodies.velocities[i].linear,
        };
        convert::rows(py, (0..bodies.len()).map(|i| linear(i).to_array()))
    }

    #[getter]
    fn angular_velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let inner = self.0.inner()?;
        let bodies = inner.world.bodies();
        let angular = |i: usize| match bodies.motions[i] {
            Motion::Kinematic { angular, .. } => angular,
            Motion::Static | Motion::Dynamic => bodies.inertias[i].angular_velocity(
                bodies.poses[i].orientation,
                bodies.velocities[i].angular_momentum,
            ),
        };
        convert::rows(py, (0..bodies.len()).map(|i| angular(i).to_array()))
    }

    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let world = &self.0.inner()?.world;
        let masses = world.bodies().ids.iter().filter_map(|&id| world.mass(id));
        Ok(PyArray1::from_iter(py, masses))
    }

    /// Of the shapes; 0 for those without a volume.
    #[getter]
    fn volumes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let inner = self.0.inner()?;
        let shapes = &inner.world.bodies().shapes;
        Ok(PyArray1::from_iter(py, shapes.iter().map(|shape| shape.volume)))
    }

    #[getter]
    fn asleep<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let world = &self.0.inner()?.world;
        Ok(PyArray1::from_iter(py, world.bodies().ids.iter().map(|&id| world.is_asleep(id))))
    }

    #[getter]
    fn waiting<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let world = &self.0.inner()?.world;
        Ok(PyArray1::from_iter(py, world.bodies().ids.iter().map(|&id| world.is_waiting(id))))
    }

    /// Start a body that waits.
    fn start(&self, id: Given<'_, '_>) -> PyResult<bool> {
        let id = convert::body(id)?;
        Ok(self.0.inner()?.world.start(id))
    }

    #[getter]
    fn names(&self) -> PyResult<Vec<String>> {
        Ok(self.0.inner()?.world.labels().iter().map(|label| label.name.clone()).collect())
    }

    #[getter]
    fn parents(&self) -> PyResult<Vec<Option<u64>>> {
        Ok(self.0.inner()?.world.labels().iter().map(|label| label.parent.map(id_number)).collect())
    }

    #[getter]
    fn looks(&self) -> PyResult<Vec<Option<&'static str>>> {
        Ok(self
            .0
            .inner()?
            .world
            .labels()
            .iter()
            .map(|label| label.look.map(LookDesc::name))
            .collect())
    }

    /// The frame of a living body's material, a mesh's own in metres, as seen from its body frame:
    /// origin [m] and orientation.
    fn material_frame(&self, id: Given<'_, '_>) -> PyResult<([f64; 3], [f64; 4])> {
        let id = convert::body(id)?;
        let inner = self.0.inner()?;
        let bodies = inner.world.bodies();
        let dense = bodies.index_of(id);
        let dense = dense.ok_or_else(|| gone(id))?;
        let frame = &bodies.shapes[dense].body_from_grid;
        Ok((frame.translation.to_array(), frame.rotation.to_array()))
    }

    /// Velocity of the centre of mass [m/s] and angular velocity [rad/s], world frame.
    fn set_velocity(
        &self,
        id: Given<'_, '_>,
        linear: Given<'_, '_>,
        angular: Given<'_, '_>,
    ) -> PyResult<()> {
        let id = convert::body(id)?;
        let (linear, angular) =
            (convert::vector("linear", linear)?, convert::vector("angular", angular)?);
        self.0.act(|world| world.set_velocity(id, linear.into(), angular.into()))
    }

    /// An impulse at a point; its work.
    fn apply_impulse(
        &self,
        id: Given<'_, '_>,
        impulse: Given<'_, '_>,
        point: Given<'_, '_>,
    ) -> PyResult<f64> {
        let id = convert::body(id)?;
        let (impulse, point) =
            (convert::vector("impulse", impulse)?, convert::vector("point", point)?);
        self.0.act(|world| world.apply_impulse(id, impulse.into(), point.into()))
    }

    /// Pull a point of a body to a place, until it is let go.
    fn hold(
        &self,
        id: Given<'_, '_>,
        point: Given<'_, '_>,
        target: Given<'_, '_>,
        force: Given<'_, '_>,
    ) -> PyResult<()> {
        let id = convert::body(id)?;
        let (point, target) =
            (convert::vector("point", point)?, convert::vector("target", target)?);
        let force = convert::scalar("force", force)?;
        self.0.act(|world| world.hold(id, point.into(), target.into(), force))
    }

    /// Let go of a body; False if it is not held.
    fn let_go(&self, id: Given<'_, '_>) -> PyResult<bool> {
        let id = convert::body(id)?;
        Ok(self.0.inner()?.world.let_go(id))
    }

    /// Cut a body along a plane; its pieces.
    fn cut(
        &self,
        py: Python<'_>,
        id: Given<'_, '_>,
        point: Given<'_, '_>,
        normal: Given<'_, '_>,
    ) -> PyResult<Vec<u64>> {
        let id = convert::body(id)?;
        let (point, normal) =
            (convert::vector("point", point)?, convert::vector("normal", normal)?);
        let cut = self.0.change(py, move |world| world.cut(id, point.into(), normal.into()))?;
        Ok(cut.map_err(build_error)?.into_iter().map(id_number).collect())
    }

    /// Break a body by its pattern and send the pieces apart; the pieces.
    #[pyo3(signature = (id, point, speed=0.0))]
    fn burst(
        &self,
        py: Python<'_>,
        id: Given<'_, '_>,
        point: Given<'_, '_>,
        speed: f64,
    ) -> PyResult<Vec<u64>> {
        let id = convert::body(id)?;
        let point = convert::vector("point", point)?;
        let burst = self.0.change(py, move |world| world.burst(id, point.into(), speed))?;
        Ok(burst.map_err(build_error)?.into_iter().map(id_number).collect())
    }

    /// Vertices (v, 3) in the body frame [m], triangles (t, 3), whether a crack made each (t,), and
    /// texture coordinates of their corners (t, 3, 2) [m].
    fn surface<'py>(&self, py: Python<'py>, id: Given<'_, '_>) -> PyResult<SurfaceArrays<'py>> {
        let id = convert::body(id)?;
        let mut inner = self.0.inner()?;
        let Inner { world, pool } = &mut *inner;
        let pool = pool.here()?;
        let surface = py.detach(|| pool.install(|| world.surface(id)));
        let surface = surface.ok_or_else(|| gone(id))?;
        let vertices = surface.mesh.positions.iter().map(|point| point.as_vec3().to_array());
        Ok((
            convert::rows(py, vertices)?,
            convert::rows(py, surface.mesh.triangles.iter().copied())?,
            PyArray1::from_vec(py, surface.interior),
            convert::coordinates(py, &surface.coordinates)?,
        ))
    }

    /// How deep each overlapping pair is.
    fn penetrations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut inner = self.0.inner()?;
        let Inner { world, pool } = &mut *inner;
        let pool = pool.here()?;
        Ok(PyArray1::from_vec(py, py.detach(|| pool.install(|| world.penetrations()))))
    }

    /// All of the state, for `restore`.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let inner = self.0.inner()?;
        let world = &inner.world;
        let bytes = py.detach(|| world.snapshot()).map_err(build_error)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// A world that goes on as the one that wrote the snapshot.
    #[staticmethod]
    #[pyo3(signature = (snapshot, threads=0))]
    fn restore(py: Python<'_>, snapshot: &[u8], threads: usize) -> PyResult<Self> {
        check_threads(threads)?;
        let mut world = py
            .detach(|| frangible::World::restore(snapshot))
            .map_err(|error| build_error(format!("snapshot: {error}")))?;
        world.set_clock(seconds);
        Ok(Self(OwnWorld::new(world, Pool::new(threads))))
    }

    /// Hexadecimal digest of the whole state.
    fn state_hash(&self) -> PyResult<String> {
        Ok(format!("{:016x}", self.0.inner()?.world.state_hash()))
    }

    /// What a notebook shows of it.
    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        slf.py().import("frangible.notebook")?.call_method1("world_html", (slf,))?.extract()
    }
}
