//! A pile in Jolt, with the settings it comes with; nothing sleeps, nothing is damped.

use oxijolt_sys::*;
use peer_pile::{Body, Engine, Pile, Shape, State};
use std::io;

/// Layers of objects, and of the broad phase: static boxes need not find each other.
const STILL: u32 = 0;
const MOVING: u32 = 1;
const LAYERS: u32 = 2;

/// Room for pairs of bodies whose boxes overlap, and for pairs that touch, for each body; a step
/// says if it is too little.
const MOST_PAIRS: u32 = 128;
const MOST_CONTACTS: u32 = 32;

/// Of what a step needs for itself, constraints above all [B]; of this, what is not used is never
/// touched.
const SCRATCH: u32 = 1 << 30;

struct Jolt {
    system: *mut JPH_PhysicsSystem,
    jobs: *mut JPH_JobSystem,
    scratch: *mut JPH_TempAllocator,
    bodies: Vec<JPH_BodyID>,
}

fn vector([x, y, z]: [f64; 3]) -> JPH_Vec3 {
    JPH_Vec3 { x: x as f32, y: y as f32, z: z as f32 }
}

fn mass(body: &Body) -> JPH_MassProperties {
    let [x, y, z] = body.inertia.map(|moment| moment as f32);
    let column = |x, y, z, w| JPH_Vec4 { x, y, z, w };
    let columns = [
        column(x, 0.0, 0.0, 0.0),
        column(0.0, y, 0.0, 0.0),
        column(0.0, 0.0, z, 0.0),
        column(0.0, 0.0, 0.0, 1.0),
    ];
    JPH_MassProperties { mass: body.mass as f32, inertia: JPH_Mat4 { column: columns } }
}

/// A hull or a box is rounded as much as Jolt rounds by default.
fn shape(body: &Body) -> *const JPH_Shape {
    let round = JPH_DEFAULT_CONVEX_RADIUS as f32;
    // SAFETY: the points outlive the calls, which copy them.
    let shape: *const JPH_Shape = unsafe {
        match &body.shape {
            Shape::Hull(vertices) => {
                let points: Vec<JPH_Vec3> = vertices.iter().map(|&vertex| vector(vertex)).collect();
                let settings =
                    JPH_ConvexHullShapeSettings_Create(points.as_ptr(), points.len() as u32, round);
                JPH_ConvexHullShapeSettings_CreateShape(settings).cast()
            }
            Shape::Box(half) => JPH_BoxShape_Create(&vector(*half), round).cast(),
            Shape::Ball(radius) => JPH_SphereShape_Create(*radius as f32).cast(),
        }
    };
    assert!(!shape.is_null(), "Jolt takes the shape");
    shape
}

fn insert(bodies: *mut JPH_BodyInterface, body: &Body) -> JPH_BodyID {
    let [x, y, z, w] = body.orientation.map(|number| number as f32);
    let (motion, layer, activation) = if body.is_static() {
        (JPH_MotionType_Static, STILL, JPH_Activation_DontActivate)
    } else {
        (JPH_MotionType_Dynamic, MOVING, JPH_Activation_Activate)
    };
    // SAFETY: all pointers are to things that live, and settings are copied.
    unsafe {
        let place = vector(body.position);
        let settings =
            JPH_BodyCreationSettings_Create3(shape(body), &place, &JPH_Quat { x, y, z, w }, motion, layer);
        JPH_BodyCreationSettings_SetLinearVelocity(settings, &vector(body.velocity));
        JPH_BodyCreationSettings_SetAngularVelocity(settings, &vector(body.angular_velocity));
        JPH_BodyCreationSettings_SetFriction(settings, body.friction as f32);
        JPH_BodyCreationSettings_SetRestitution(settings, body.restitution as f32);
        JPH_BodyCreationSettings_SetLinearDamping(settings, 0.0);
        JPH_BodyCreationSettings_SetAngularDamping(settings, 0.0);
        JPH_BodyCreationSettings_SetAllowSleeping(settings, false);
        if !body.is_static() {
            JPH_BodyCreationSettings_SetOverrideMassProperties(
                settings,
                JPH_OverrideMassProperties_MassAndInertiaProvided,
            );
            JPH_BodyCreationSettings_SetMassPropertiesOverride(settings, &mass(body));
        }
        let id = JPH_BodyInterface_CreateAndAddBody(bodies, settings, activation);
        JPH_BodyCreationSettings_Destroy(settings);
        id
    }
}

/// A world without bodies, in which what moves finds everything.
fn system(gravity: [f64; 3], bodies: u32) -> *mut JPH_PhysicsSystem {
    // SAFETY: tables are as large as their layers are many, and live as long as the program.
    unsafe {
        let layers = JPH_BroadPhaseLayerInterfaceTable_Create(LAYERS, LAYERS);
        for layer in [STILL, MOVING] {
            JPH_BroadPhaseLayerInterfaceTable_MapObjectToBroadPhaseLayer(
                layers,
                layer,
                layer as JPH_BroadPhaseLayer,
            );
        }
        let pairs = JPH_ObjectLayerPairFilterTable_Create(LAYERS);
        JPH_ObjectLayerPairFilterTable_EnableCollision(pairs, MOVING, MOVING);
        JPH_ObjectLayerPairFilterTable_EnableCollision(pairs, MOVING, STILL);
        let system = JPH_PhysicsSystem_Create(&JPH_PhysicsSystemSettings {
            maxBodies: bodies,
            numBodyMutexes: 0,
            maxBodyPairs: MOST_PAIRS * bodies,
            maxContactConstraints: MOST_CONTACTS * bodies,
            _padding: 0,
            broadPhaseLayerInterface: layers,
            objectLayerPairFilter: pairs,
            objectVsBroadPhaseLayerFilter: JPH_ObjectVsBroadPhaseLayerFilterTable_Create(
                layers, LAYERS, pairs, LAYERS,
            ),
        });
        JPH_PhysicsSystem_SetGravity(system, &vector(gravity));
        system
    }
}

impl Engine for Jolt {
    const NAME: &str = "jolt 5.6.0";
    const SUBSTEPS: u32 = 1;

    fn build(pile: &Pile) -> Self {
        // SAFETY: Jolt is started before anything else of it is called, and once.
        unsafe {
            assert!(JPH_Init(), "Jolt starts");
            let system = system(pile.gravity, pile.bodies.len() as u32);
            let interface = JPH_PhysicsSystem_GetBodyInterface(system);
            let bodies = pile.bodies.iter().map(|body| insert(interface, body)).collect();
            JPH_PhysicsSystem_OptimizeBroadPhase(system);
            let jobs = JPH_JobSystemSingleThreaded_Create(JPH_MAX_PHYSICS_JOBS);
            Self { system, jobs, scratch: JPH_TempAllocator_Create(SCRATCH), bodies }
        }
    }

    /// A collision step is a substep that finds its own contacts.
    fn step(&mut self, dt: f64, substeps: u32) {
        // SAFETY: all of them live as long as the program.
        let error = unsafe {
            let (dt, substeps) = (dt as f32, substeps as i32);
            JPH_PhysicsSystem_Update2(self.system, dt, substeps, self.scratch, self.jobs)
        };
        assert!(error == JPH_PhysicsUpdateError_None, "Jolt leaves contacts out: no room, {error}");
    }

    fn state(&self, body: usize) -> State {
        let id = self.bodies[body];
        let [mut position, mut velocity, mut spin] = [vector([0.0; 3]); 3];
        let mut turned = JPH_Quat { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
        // SAFETY: no body is ever destroyed.
        unsafe {
            let interface = JPH_PhysicsSystem_GetBodyInterface(self.system);
            JPH_BodyInterface_GetCenterOfMassPosition(interface, id, &mut position);
            JPH_BodyInterface_GetRotation(interface, id, &mut turned);
            JPH_BodyInterface_GetLinearVelocity(interface, id, &mut velocity);
            JPH_BodyInterface_GetAngularVelocity(interface, id, &mut spin);
        }
        [
            position.x, position.y, position.z, turned.x, turned.y, turned.z, turned.w, velocity.x,
            velocity.y, velocity.z, spin.x, spin.y, spin.z,
        ]
    }
}

fn main() -> io::Result<()> {
    peer_pile::run::<Jolt>()
}
