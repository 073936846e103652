//! A world, and its state as arrays.

use crate::interrupt::interruptible;
use crate::{build_error, convert};
use frangible::dynamics::Motion;
use frangible::{LookDesc, SceneDesc, id_from_number, id_number};
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArray3, PyArrayLike1};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Vertices [m], triangles, and whether a crack made each.
type SurfaceArrays<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<u32>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray3<f32>>,
);

/// More threads than any machine has processors only take memory.
const MOST_THREADS: usize = 4096;

/// Bodies, and the engine that moves and breaks them.
#[pyclass(module = "frangible._frangible")]
pub(crate) struct World {
    world: frangible::World,
    pool: ThreadPool,
}

#[pymethods]
impl World {
    /// Check a scene and build it.
    #[staticmethod]
    #[pyo3(signature = (scene_json, threads=0))]
    fn build(py: Python<'_>, scene_json: &str, threads: usize) -> PyResult<Self> {
        let scene: SceneDesc =
            serde_json::from_str(scene_json).map_err(|error| build_error(format!("scene: {error}")))?;
        if threads > MOST_THREADS {
            return Err(build_error(format!("threads: {threads}, must be at most {MOST_THREADS}")));
        }
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(build_error)?;
        let build = move || (pool.install(|| frangible::World::build(&scene)), pool);
        let (world, pool) = interruptible(py, build)?;
        Ok(Self { world: world.map_err(build_error)?, pool })
    }

    /// Advance by one frame and report on it.
    fn step<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let Self { world, pool } = self;
        let report = py.detach(|| pool.install(|| frangible::step(world)));
        let report = serde_json::to_value(&report).map_err(build_error)?;
        convert::json(py, &report)
    }

    #[getter]
    fn frame(&self) -> u64 {
        self.world.frame()
    }

    #[getter]
    fn time(&self) -> f64 {
        self.world.time()
    }

    #[getter]
    fn dt(&self) -> f64 {
        self.world.dt()
    }

    #[getter]
    fn method<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::json(py, &serde_json::to_value(self.world.method()).map_err(build_error)?)
    }

    #[getter]
    fn energy(&self) -> (f64, f64) {
        self.world.energy()
    }

    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        PyArray1::from_iter(py, self.world.bodies().ids.iter().map(|&id| id_number(id)))
    }

    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        convert::rows(py, self.world.bodies().poses.iter().map(|pose| pose.position.to_array()))
    }

    #[getter]
    fn orientations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        convert::rows(py, self.world.bodies().poses.iter().map(|pose| pose.orientation.to_array()))
    }

    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bodies = self.world.bodies();
        let linear = |i: usize| match bodies.motions[i] {
            Motion::Kinematic { linear, .. } => linear,
            Motion::Static | Motion::Dynamic => bodies.velocities[i].linear,
        };
        convert::rows(py, (0..bodies.len()).map(|i| linear(i).to_array()))
    }

    #[getter]
    fn angular_velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bodies = self.world.bodies();
        let angular = |i: usize| match bodies.motions[i] {
            Motion::Kinematic { angular, .. } => angular,
            Motion::Static | Motion::Dynamic => bodies.inertias[i]
                .angular_velocity(bodies.poses[i].orientation, bodies.velocities[i].angular_momentum),
        };
        convert::rows(py, (0..bodies.len()).map(|i| angular(i).to_array()))
    }

    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.world.bodies().masses)
    }

    #[getter]
    fn asleep<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_iter(py, self.world.bodies().ids.iter().map(|&id| self.world.is_asleep(id)))
    }

    #[getter]
    fn names(&self) -> Vec<&str> {
        self.world.labels().iter().map(|label| label.name.as_str()).collect()
    }

    #[getter]
    fn parents(&self) -> Vec<Option<u64>> {
        self.world.labels().iter().map(|label| label.parent.map(id_number)).collect()
    }

    #[getter]
    fn looks(&self) -> Vec<Option<&'static str>> {
        self.world.labels().iter().map(|label| label.look.map(LookDesc::name)).collect()
    }

    /// Velocity of the centre of mass [m/s] and angular velocity [rad/s], world frame.
    fn set_velocity(
        &mut self,
        id: u64,
        linear: PyArrayLike1<'_, f64, AllowTypeChange>,
        angular: PyArrayLike1<'_, f64, AllowTypeChange>,
    ) -> PyResult<()> {
        let (linear, angular) = (convert::vector("linear", &linear)?, convert::vector("angular", &angular)?);
        self.world.set_velocity(id_from_number(id), linear.into(), angular.into()).map_err(build_error)
    }

    /// Vertices (v, 3) in the body frame [m], triangles (t, 3), whether a crack made each (t,), and texture coordinates of their
    /// corners (t, 3, 2) [m].
    fn surface<'py>(&self, py: Python<'py>, id: u64) -> PyResult<SurfaceArrays<'py>> {
        let surface = py.detach(|| self.pool.install(|| self.world.surface(id_from_number(id))));
        let surface =
            surface.ok_or_else(|| PyKeyError::new_err(format!("no living body has the id {id}")))?;
        let vertices = surface.mesh.positions.iter().map(|point| point.as_vec3().to_array());
        Ok((
            convert::rows(py, vertices)?,
            convert::rows(py, surface.mesh.triangles.iter().copied())?,
            PyArray1::from_vec(py, surface.interior),
            convert::coordinates(py, &surface.coordinates)?,
        ))
    }

    /// How deep each overlapping pair is.
    fn penetrations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let world = &self.world;
        PyArray1::from_vec(py, py.detach(|| world.penetrations()))
    }

    /// Hexadecimal digest of the whole state.
    fn state_hash(&self) -> String {
        format!("{:016x}", self.world.state_hash())
    }
}
