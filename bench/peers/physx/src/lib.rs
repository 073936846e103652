//! A pile in PhysX on processors, with the settings it comes with; nothing sleeps, nothing is
//! damped.

use peer_pile::{Body, Engine, Pile, Shape, State};
use physx_sys::*;
use std::ptr::{null, null_mut};

/// Room that a step may use instead of the allocator [B]: PhysX wants it aligned to 16, and a multiple
/// of 16 KiB.
const SCRATCH: usize = 32 << 20;

/// With one of its two solvers: projected Gauss-Seidel, its default, or temporal Gauss-Seidel,
/// which takes position iterations as small steps.
pub struct Physx<const TEMPORAL: bool> {
    scene: *mut PxScene,
    actors: Vec<*mut PxRigidActor>,
    scratch: Vec<u128>,
}

fn vector([x, y, z]: [f64; 3]) -> PxVec3 {
    PxVec3 { x: x as f32, y: y as f32, z: z as f32 }
}

/// A material for every pair of coefficients: there can be 65,535 at most.
#[derive(Default)]
struct Materials(Vec<([f64; 2], *mut PxMaterial)>);

impl Materials {
    fn of(&mut self, physics: *mut PxPhysics, body: &Body) -> *mut PxMaterial {
        let coefficients = [body.friction, body.restitution];
        if let Some((_, material)) = self.0.iter().find(|(others, _)| *others == coefficients) {
            return *material;
        }
        let [friction, restitution] = coefficients.map(|number| number as f32);
        // SAFETY: `physics` lives as long as the program.
        let material = unsafe { PxPhysics_createMaterial_mut(physics, friction, friction, restitution) };
        self.0.push((coefficients, material));
        material
    }
}

fn hull(physics: *mut PxPhysics, vertices: &[[f64; 3]]) -> PxConvexMeshGeometry {
    let points: Vec<PxVec3> = vertices.iter().map(|&vertex| vector(vertex)).collect();
    // SAFETY: parameters are PhysX's own defaults, and the points outlive the call, which copies
    // them.
    unsafe {
        let parameters = PxCookingParams_new(PxPhysics_getTolerancesScale(physics));
        let mut description = PxConvexMeshDesc_new();
        description.points.stride = size_of::<PxVec3>() as u32;
        description.points.data = points.as_ptr().cast();
        description.points.count = points.len() as u32;
        description.flags = PxConvexFlags::ComputeConvex;
        let inserter = PxPhysics_getPhysicsInsertionCallback_mut(physics);
        let mesh = phys_PxCreateConvexMesh(&parameters, &description, inserter, null_mut());
        assert!(!mesh.is_null(), "a hull of points that span space");
        PxConvexMeshGeometry_new(mesh, &PxMeshScale_new(), PxConvexMeshGeometryFlags::TightBounds)
    }
}

fn insert(
    physics: *mut PxPhysics,
    scene: *mut PxScene,
    body: &Body,
    material: *mut PxMaterial,
) -> *mut PxRigidActor {
    let [x, y, z, w] = body.orientation.map(|number| number as f32);
    let pose = PxTransform { q: PxQuat { x, y, z, w }, p: vector(body.position) };
    // SAFETY: all pointers are to things that live as long as the program, or are copied.
    unsafe {
        let actor = if body.is_static() {
            PxPhysics_createRigidStatic_mut(physics, &pose).cast()
        } else {
            let rigid = PxPhysics_createRigidDynamic_mut(physics, &pose);
            PxRigidBody_setMass_mut(rigid.cast(), body.mass as f32);
            PxRigidBody_setMassSpaceInertiaTensor_mut(rigid.cast(), &vector(body.inertia));
            PxRigidBody_setLinearDamping_mut(rigid.cast(), 0.0);
            PxRigidBody_setAngularDamping_mut(rigid.cast(), 0.0);
            PxRigidDynamic_setLinearVelocity_mut(rigid, &vector(body.velocity), true);
            PxRigidDynamic_setAngularVelocity_mut(rigid, &vector(body.angular_velocity), true);
            PxRigidDynamic_setSleepThreshold_mut(rigid, 0.0);
            rigid.cast()
        };
        match &body.shape {
            Shape::Hull(vertices) => attach(actor, &hull(physics, vertices), material),
            Shape::Box(half) => {
                let [x, y, z] = half.map(|half| half as f32);
                attach(actor, &PxBoxGeometry_new(x, y, z), material);
            }
            Shape::Ball(radius) => attach(actor, &PxSphereGeometry_new(*radius as f32), material),
        }
        PxScene_addActor_mut(scene, actor.cast(), null());
        actor
    }
}

/// Gives a body its only shape, which is there for the simulation, and not for queries that nobody
/// makes.
///
/// # Safety
/// The pointers are to things that live, and the geometry is one of PhysX's.
unsafe fn attach<G>(actor: *mut PxRigidActor, geometry: &G, material: *mut PxMaterial) {
    let geometry = std::ptr::from_ref(geometry).cast();
    // SAFETY: the caller's.
    let shape = unsafe {
        PxRigidActorExt_createExclusiveShape_1(actor, geometry, material, PxShapeFlags::SimulationShape)
    };
    assert!(!shape.is_null(), "PhysX takes the shape");
}

impl<const TEMPORAL: bool> Engine for Physx<TEMPORAL> {
    const NAME: &str = if TEMPORAL { "physx 5.1.3 TGS" } else { "physx 5.1.3 PGS" };
    const SUBSTEPS: u32 = 1;

    fn build(pile: &Pile) -> Self {
        // SAFETY: the description is PhysX's own default, and what it points to lives as long as
        // the program.
        let (physics, scene) = unsafe {
            let physics = physx_create_physics(physx_create_foundation());
            let mut description = PxSceneDesc_new(PxPhysics_getTolerancesScale(physics));
            description.gravity = vector(pile.gravity);
            description.solverType = if TEMPORAL { PxSolverType::Tgs } else { PxSolverType::Pgs };
            description.filterShader = get_default_simulation_filter_shader();
            // No thread but the one that steps.
            let mode = PxDefaultCpuDispatcherWaitForWorkMode::WaitForWork;
            description.cpuDispatcher = phys_PxDefaultCpuDispatcherCreate(0, null_mut(), mode, 0).cast();
            (physics, PxPhysics_createScene_mut(physics, &description))
        };
        assert!(!scene.is_null(), "PhysX takes the scene");
        let mut materials = Materials::default();
        let actors = pile
            .bodies
            .iter()
            .map(|body| insert(physics, scene, body, materials.of(physics, body)))
            .collect();
        Self { scene, actors, scratch: vec![0; SCRATCH / size_of::<u128>()] }
    }

    /// A substep is a shorter step, with contacts of its own.
    fn step(&mut self, dt: f64, substeps: u32) {
        let h = (dt / f64::from(substeps)) as f32;
        for _ in 0..substeps {
            let mut error = 0;
            let scratch = self.scratch.as_mut_ptr().cast();
            // SAFETY: the scene lives as long as the program, and nothing else uses the scratch.
            unsafe {
                PxScene_simulate_mut(self.scene, h, null_mut(), scratch, SCRATCH as u32, true);
                PxScene_fetchResults_mut(self.scene, true, &mut error);
            }
            assert!(error == 0, "PhysX steps: error {error}");
        }
    }

    fn state(&self, body: usize) -> State {
        let actor = self.actors[body];
        // SAFETY: no actor is ever released, and only those that move are asked for velocities.
        let (pose, velocity, spin) = unsafe {
            let pose = PxRigidActor_getGlobalPose(actor);
            if PxActor_getType(actor.cast()) == PxActorType::RigidStatic {
                (pose, vector([0.0; 3]), vector([0.0; 3]))
            } else {
                let rigid = actor.cast();
                (pose, PxRigidBody_getLinearVelocity(rigid), PxRigidBody_getAngularVelocity(rigid))
            }
        };
        let PxTransform { p, q } = pose;
        [p.x, p.y, p.z, q.x, q.y, q.z, q.w, velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z]
    }
}
