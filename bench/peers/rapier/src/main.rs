//! A pile in Rapier, with the settings it comes with; nothing sleeps.

use peer_pile::{Body, Engine, Pile, Shape, State};
use rapier3d::prelude::*;
use std::io;

struct Rapier {
    world: PhysicsWorld,
    handles: Vec<RigidBodyHandle>,
}

fn vector(numbers: [f64; 3]) -> Vector {
    Vector::from_array(numbers.map(|number| number as Real))
}

fn collider(body: &Body) -> ColliderBuilder {
    let collider = match &body.shape {
        Shape::Hull(vertices) => {
            let points: Vec<Vector> = vertices.iter().map(|&vertex| vector(vertex)).collect();
            ColliderBuilder::convex_hull(&points).expect("a hull of points that span space")
        }
        Shape::Box(half) => {
            let [x, y, z] = half.map(|half| half as Real);
            ColliderBuilder::cuboid(x, y, z)
        }
        Shape::Ball(radius) => ColliderBuilder::ball(*radius as Real),
    };
    if body.is_static() {
        return collider;
    }
    collider.mass_properties(MassProperties::new(Vector::ZERO, body.mass as Real, vector(body.inertia)))
}

impl Engine for Rapier {
    const NAME: &str = "rapier3d 0.36.1";
    const SUBSTEPS: u32 = 4;

    fn build(pile: &Pile) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = vector(pile.gravity);
        let mut handles = Vec::with_capacity(pile.bodies.len());
        for body in &pile.bodies {
            let rotation = Rotation::from_array(body.orientation.map(|number| number as Real));
            let kind = if body.is_static() { RigidBodyBuilder::fixed() } else { RigidBodyBuilder::dynamic() };
            let rigid = kind
                .pose(Pose::from_parts(vector(body.position), rotation))
                .linvel(vector(body.velocity))
                .angvel(vector(body.angular_velocity))
                .can_sleep(false);
            let shape = collider(body).friction(body.friction as Real).restitution(body.restitution as Real);
            handles.push(world.insert(rigid, shape).0);
        }
        Self { world, handles }
    }

    /// A solver iteration is a substep.
    fn step(&mut self, dt: f64, substeps: u32) {
        self.world.integration_parameters.dt = dt as Real;
        self.world.integration_parameters.num_solver_iterations = substeps as usize;
        self.world.step();
    }

    fn state(&self, body: usize) -> State {
        let body = &self.world.bodies[self.handles[body]];
        let mut state = [0.0; 13];
        state[..3].copy_from_slice(&body.translation().to_array());
        state[3..7].copy_from_slice(&body.rotation().to_array());
        state[7..10].copy_from_slice(&body.linvel().to_array());
        state[10..].copy_from_slice(&body.angvel().to_array());
        state
    }
}

fn main() -> io::Result<()> {
    peer_pile::run::<Rapier>()
}
