//! A pile in Box3D, with the settings it comes with and four substeps, as its manual has it;
//! nothing sleeps.

use box3d_sys::*;
use peer_pile::{Body, Engine, Pile, Shape, State};
use std::io;

/// Enough for any hull of a pile.
const MOST_VERTICES: i32 = 128;

/// Of a box with edges of 2.
const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, 1.0, 1.0],
    [1.0, -1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
];

struct Box3d {
    world: b3WorldId,
    bodies: Vec<b3BodyId>,
}

fn vector([x, y, z]: [f64; 3]) -> b3Vec3 {
    b3Vec3 { x: x as f32, y: y as f32, z: z as f32 }
}

fn attach_hull(id: b3BodyId, shape: &b3ShapeDef, vertices: &[[f64; 3]]) {
    let points: Vec<b3Vec3> = vertices.iter().map(|&vertex| vector(vertex)).collect();
    // SAFETY: the points outlive the call, and a shape copies its hull.
    unsafe {
        let hull = b3CreateHull(points.as_ptr(), points.len() as i32, MOST_VERTICES);
        assert!(!hull.is_null(), "a hull of points that span space");
        b3CreateHullShape(id, shape, hull);
        b3DestroyHull(hull);
    }
}

fn insert(world: b3WorldId, body: &Body) -> b3BodyId {
    let [x, y, z, w] = body.orientation;
    let [ix, iy, iz] = body.inertia;
    let inertia =
        b3Matrix3 { cx: vector([ix, 0.0, 0.0]), cy: vector([0.0, iy, 0.0]), cz: vector([0.0, 0.0, iz]) };
    // SAFETY: definitions are Box3D's own defaults, and ids are of things that live.
    unsafe {
        let mut rigid = b3DefaultBodyDef();
        rigid.type_ = if body.is_static() { b3BodyType_b3_staticBody } else { b3BodyType_b3_dynamicBody };
        rigid.position = vector(body.position);
        rigid.rotation = b3Quat { v: vector([x, y, z]), s: w as f32 };
        rigid.linearVelocity = vector(body.velocity);
        rigid.angularVelocity = vector(body.angular_velocity);
        rigid.enableSleep = false;
        let id = b3CreateBody(world, &rigid);
        let mut shape = b3DefaultShapeDef();
        shape.baseMaterial.friction = body.friction as f32;
        shape.baseMaterial.restitution = body.restitution as f32;
        match &body.shape {
            Shape::Hull(vertices) => attach_hull(id, &shape, vertices),
            // Boxes are hulls here.
            Shape::Box(half) => attach_hull(
                id,
                &shape,
                &CORNERS.map(|corner| [0, 1, 2].map(|axis| corner[axis] * half[axis])),
            ),
            Shape::Ball(radius) => {
                let ball = b3Sphere { center: vector([0.0; 3]), radius: *radius as f32 };
                b3CreateSphereShape(id, &shape, &ball);
            }
        }
        if !body.is_static() {
            let mass = b3MassData { mass: body.mass as f32, center: vector([0.0; 3]), inertia };
            b3Body_SetMassData(id, mass);
        }
        id
    }
}

impl Engine for Box3d {
    const NAME: &str = "box3d 0.1.0";
    /// "Usually 4."
    const SUBSTEPS: u32 = 4;

    fn build(pile: &Pile) -> Self {
        // SAFETY: the definition is Box3D's own default.
        let world = unsafe {
            let mut definition = b3DefaultWorldDef();
            definition.gravity = vector(pile.gravity);
            definition.enableSleep = false;
            definition.workerCount = 1;
            b3CreateWorld(&definition)
        };
        Self { world, bodies: pile.bodies.iter().map(|body| insert(world, body)).collect() }
    }

    fn step(&mut self, dt: f64, substeps: u32) {
        // SAFETY: the world lives as long as the program.
        unsafe { b3World_Step(self.world, dt as f32, substeps as i32) }
    }

    fn state(&self, body: usize) -> State {
        let id = self.bodies[body];
        // SAFETY: no body is ever destroyed.
        let (position, turned, velocity, spin) = unsafe {
            (
                b3Body_GetPosition(id),
                b3Body_GetRotation(id),
                b3Body_GetLinearVelocity(id),
                b3Body_GetAngularVelocity(id),
            )
        };
        [
            position.x, position.y, position.z, turned.v.x, turned.v.y, turned.v.z, turned.s, velocity.x,
            velocity.y, velocity.z, spin.x, spin.y, spin.z,
        ]
    }
}

fn main() -> io::Result<()> {
    peer_pile::run::<Box3d>()
}
