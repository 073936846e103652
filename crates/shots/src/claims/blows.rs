//! Blows: what should break breaks, at every frame rate and on every ground, and nothing else does.

use super::claim::{Claim, Finding, Obstacle, largest};
use super::scenes::{GRAVITY, ball, cuboid};
use super::watch::step;
use frangible::fracture::{Concrete, Voronoi};
use frangible::{
    BodyDesc, BreakingDesc, BuildError, MaterialName, MotionDesc, PartDesc, PatternDesc,
    Resolution, SceneDesc, ShapeDesc, StepReport, StrengthDesc, World,
};
use glam::{DQuat, DVec3};

/// What topples.
pub(super) const TOPPLES: Claim = Claim {
    name: "toppling-breaks",
    says: "a column, a wall and a plank that fall over break when they slam down, by the same blow at every rate, on a plane, a box, a compound and a mesh",
    source: "mechanics",
    measure: topples,
};

/// What slides into a wall.
pub(super) const SLIDES: Claim = Claim {
    name: "sliding-breaks",
    says: "a cube and a cylinder that slide or roll into a wall break by the same blow whether floor and wall are two bodies, a compound or a mesh",
    source: "mechanics",
    measure: slides,
};

/// What rolls.
pub(super) const ROLLS: Claim = Claim {
    name: "rolling-stays-whole",
    says: "balls, cylinders and capsules of every material roll on as unbreakable ones, and stay whole",
    source: "mechanics",
    measure: rolls,
};

/// A break into one piece.
pub(super) const ONE_PIECE: Claim = Claim {
    name: "one-piece-is-no-break",
    says: "a blow above the strength that splits nothing leaves the motion of an unbreakable body, to the last bit",
    source: "docs/adr/037",
    measure: one_piece,
};

/// A blow through another body.
pub(super) const THROUGH: Claim = Claim {
    name: "blows-pass-through",
    says: "a slab breaks under a block that lies on it and is struck",
    source: "docs/adr/037",
    measure: through,
};

/// Frames per second.
const RATES: [f64; 6] = [24.0, 30.0, 60.0, 120.0, 240.0, 1000.0];

/// How far blows at other rates and on other grounds may be from the one on a plane at 240 Hz.
const EQUAL: f64 = 0.02;

/// Friction of a cylinder that spins as it rolls into a wall adds to its blow, up to this factor.
const SPINNING: f64 = 1.08;

/// Of the bodies [kg/m^3].
const DENSITY: f64 = 1000.0;

fn voronoi(cells: usize) -> PatternDesc {
    PatternDesc::Voronoi(Voronoi { cells, seed: 3, ..Voronoi::default() })
}

fn build(rate: f64, bodies: Vec<BodyDesc>) -> Result<World, BuildError> {
    World::build(&SceneDesc { frames_per_second: rate, bodies, ..SceneDesc::new("blow") })
}

/// Advances a world by some seconds until something breaks. Returns the break's impulse [N s], or
/// zero.
fn first_blow(world: &mut World, rate: f64, seconds: f64) -> f64 {
    for _ in 0..(seconds * rate).ceil() as u64 {
        let StepReport { fractures, .. } = step(world);
        if let Some(fracture) = fractures.first() {
            return fracture.impulse;
        }
    }
    0.0
}

/// A solid of a profile in the x-y plane, counter-clockwise, two metres to both sides.
fn prism(profile: &[[f64; 2]], caps: &[[u32; 3]]) -> ShapeDesc {
    let count = profile.len() as u32;
    let side = |z: f64| profile.iter().map(move |&[x, y]| [x, y, z]);
    let positions = side(-2.0).chain(side(2.0)).collect();
    let mut triangles = Vec::new();
    for i in 0..count {
        let j = (i + 1) % count;
        triangles.extend([[i, j, count + j], [i, count + j, count + i]]);
    }
    for &[a, b, c] in caps {
        triangles.extend([[a, c, b], [count + a, count + b, count + c]]);
    }
    ShapeDesc::Triangles {
        positions,
        triangles,
        thickness: None,
        sides: None,
        resolution: Resolution::default(),
    }
}

fn fixed(name: &str, shape: ShapeDesc) -> BodyDesc {
    BodyDesc { motion: MotionDesc::Static, friction: 0.6, ..BodyDesc::new(name, shape) }
}

fn part(size: [f64; 3], position: [f64; 3]) -> PartDesc {
    PartDesc::Box { size, position, orientation: DQuat::IDENTITY.to_array() }
}

/// Level grounds with their tops at zero.
fn grounds() -> Vec<(&'static str, BodyDesc)> {
    let slab = BodyDesc { position: [0.0, -0.5, 0.0], ..fixed("box", cuboid([16.0, 1.0, 8.0])) };
    let halves = ShapeDesc::Compound {
        parts: vec![
            part([8.0, 1.0, 8.0], [-4.0, -0.5, 0.0]),
            part([8.0, 1.0, 8.0], [4.0, -0.5, 0.0]),
        ],
        resolution: Resolution::default(),
    };
    let profile = [[-8.0, -1.0], [8.0, -1.0], [8.0, 0.0], [-8.0, 0.0]];
    let mesh = prism(&profile, &[[0, 1, 2], [0, 2, 3]]);
    vec![
        ("plane", BodyDesc { friction: 0.6, ..BodyDesc::ground(0.0) }),
        ("box", slab),
        ("compound", fixed("compound", halves)),
        ("mesh", fixed("mesh", mesh)),
    ]
}

/// A box that leans by an angle [rad] on the lower edge of its right side, with its blow when it
/// falls flat and comes to rest, m w h / 2 for a thin one that begins to fall upright.
fn leaning([width, height, depth]: [f64; 3], angle: f64) -> (BodyDesc, f64) {
    let turn = DQuat::from_rotation_z(-angle);
    let corner = DVec3::new(0.5 * width, -0.5 * height, 0.0);
    let position = -(turn * corner);
    let mass = DENSITY * width * height * depth;
    let spin = (3.0 * GRAVITY / height).sqrt();
    let estimate = 0.5 * mass * spin * height;
    let breaking = BreakingDesc {
        pieces: Some(12),
        ..BreakingDesc::once(StrengthDesc::Impulse(0.3 * estimate), voronoi(12))
    };
    let body = BodyDesc {
        position: position.to_array(),
        orientation: turn.to_array(),
        friction: 0.6,
        restitution: 0.1,
        density: DENSITY,
        breaking: Some(breaking),
        ..BodyDesc::new("column", cuboid([width, height, depth]))
    };
    (body, estimate)
}

fn topples() -> Result<Vec<Finding>, Obstacle> {
    let bodies = [
        ("column of 3 m", [0.4, 3.0, 0.4], 0.21),
        ("wall of 2 m", [0.2, 2.0, 1.5], 0.15),
        ("plank of 0.6 m", [0.05, 0.6, 0.2], 0.15),
    ];
    let mut findings = Vec::new();
    for (name, size, angle) in bodies {
        let blow = |ground: &BodyDesc, rate: f64| -> Result<f64, BuildError> {
            let (column, _) = leaning(size, angle);
            Ok(first_blow(&mut build(rate, vec![ground.clone(), column])?, rate, 3.0))
        };
        let grounds = grounds();
        let expected = blow(&grounds[0].1, 240.0)?;
        let (_, estimate) = leaning(size, angle);
        let quantity = format!("blow of a {name} at 240 Hz per m w h / 2");
        findings.push(Finding::between(quantity, "1", expected / estimate, 0.8, 1.2));
        for (on, ground) in &grounds {
            let mut off = Vec::new();
            for rate in RATES {
                off.push((blow(ground, rate)? / expected - 1.0).abs());
            }
            let quantity = format!("blow of a {name} on a {on}, off at 24 to 1000 Hz");
            findings.push(Finding::at_most(quantity, "1", largest(off), EQUAL));
        }
    }
    Ok(findings)
}

/// Floor and wall as two boxes, as a compound, as a mesh.
fn corners() -> Vec<(&'static str, Vec<BodyDesc>)> {
    let (floor, wall) = ([20.0, 1.0, 4.0], [1.0, 3.0, 4.0]);
    let (floor_at, wall_at) = ([0.0, -0.5, 0.0], [10.5, 1.5, 0.0]);
    let compound = ShapeDesc::Compound {
        parts: vec![part(floor, floor_at), part(wall, wall_at)],
        resolution: Resolution::default(),
    };
    let profile =
        [[-10.0, -1.0], [11.0, -1.0], [11.0, 3.0], [10.0, 3.0], [10.0, 0.0], [-10.0, 0.0]];
    let mesh = prism(&profile, &[[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]]);
    vec![
        (
            "two boxes",
            vec![
                BodyDesc { position: floor_at, ..fixed("floor", cuboid(floor)) },
                BodyDesc { position: wall_at, ..fixed("wall", cuboid(wall)) },
            ],
        ),
        ("a compound", vec![fixed("corner", compound)]),
        ("a mesh", vec![fixed("corner", mesh)]),
    ]
}

fn slides() -> Result<Vec<Finding>, Obstacle> {
    let speed = 12.0;
    let lying = DQuat::from_rotation_x(0.5 * std::f64::consts::PI);
    let (radius, height) = (0.25, 0.5);
    let cylinder = ShapeDesc::Cylinder { radius, height, resolution: Resolution::default() };
    let cube = BodyDesc { friction: 0.0, ..BodyDesc::new("cube", cuboid([0.5; 3])) };
    let cylinder = BodyDesc {
        orientation: lying.to_array(),
        angular_velocity: [0.0, 0.0, -speed / radius],
        ..BodyDesc::new("cylinder", cylinder)
    };
    let cylinder_mass = DENSITY * std::f64::consts::PI * radius * radius * height;
    let mut findings = Vec::new();
    for (name, body, mass) in [("cube", cube, 125.0), ("cylinder", cylinder, cylinder_mass)] {
        // Along the normal; friction of what spins adds to it.
        let expected = 1.1 * mass * speed;
        let body = BodyDesc {
            position: [8.0, 0.25, 0.0],
            linear_velocity: [speed, 0.0, 0.0],
            restitution: 0.1,
            density: DENSITY,
            breaking: Some(BreakingDesc::once(StrengthDesc::Impulse(0.2 * expected), voronoi(12))),
            ..body
        };
        for (corner, bodies) in corners() {
            let mut blows = Vec::new();
            for rate in RATES {
                let all = bodies.iter().cloned().chain([body.clone()]).collect();
                blows.push(first_blow(&mut build(rate, all)?, rate, 0.5) / expected);
            }
            let quantity =
                format!("blow of a {name} in {corner} per (1 + e) m v, at 24 to 1000 Hz");
            let least = blows.iter().copied().fold(f64::INFINITY, f64::min);
            let low = 1.0 - EQUAL;
            let most = if name == "cube" { 1.0 + EQUAL } else { SPINNING };
            findings.push(Finding::at_least(format!("least {quantity}"), "1", least, low));
            findings.push(Finding::at_most(
                format!("largest {quantity}"),
                "1",
                largest(blows),
                most,
            ));
        }
    }
    Ok(findings)
}

/// Rough for concrete: such bodies break on a grid.
fn pattern_of(material: MaterialName) -> PatternDesc {
    match material {
        MaterialName::Concrete => {
            PatternDesc::Concrete(Concrete { cells: 12, ..Concrete::default() })
        }
        _ => voronoi(12),
    }
}

fn rolls() -> Result<Vec<Finding>, Obstacle> {
    const MATERIALS: [MaterialName; 5] = [
        MaterialName::Glass,
        MaterialName::Concrete,
        MaterialName::Brick,
        MaterialName::Wood,
        MaterialName::Ice,
    ];
    let lying = DQuat::from_rotation_x(0.5 * std::f64::consts::PI);
    let (radius, height, resolution) = (0.25, 0.5, Resolution::default());
    let shapes = [
        ("balls", ball(radius)),
        ("cylinders", ShapeDesc::Cylinder { radius, height, resolution }),
        ("capsules", ShapeDesc::Capsule { radius, height, resolution }),
    ];
    let mut findings = Vec::new();
    for (name, shape) in shapes {
        let (mut broken, mut off) = (0, Vec::new());
        for (material, speed) in MATERIALS.into_iter().zip([0.3, 1.0, 3.0, 3.0, 6.0]) {
            for rate in [30.0, 240.0] {
                let rolling = BodyDesc {
                    position: [0.0, radius, 0.0],
                    orientation: lying.to_array(),
                    linear_velocity: [speed, 0.0, 0.0],
                    angular_velocity: [0.0, 0.0, -speed / radius],
                    breaking: Some(BreakingDesc::once(
                        StrengthDesc::Named(material),
                        pattern_of(material),
                    )),
                    ..BodyDesc::new("rolling", shape.clone())
                };
                let mut world = build(rate, vec![BodyDesc::ground(0.0), rolling])?;
                broken += u64::from(first_blow(&mut world, rate, 1.0) > 0.0);
                off.push((world.bodies().poses[1].position.x / speed - 1.0).abs());
            }
        }
        let quantity = format!("{name} of five materials that break while they roll, of 10");
        findings.push(Finding::at_most(quantity, "1", broken as f64, 0.0));
        let quantity = format!("way of {name} in a second, off");
        findings.push(Finding::at_most(quantity, "1", largest(off), 1e-3));
    }
    Ok(findings)
}

fn one_piece() -> Result<Vec<Finding>, Obstacle> {
    let rebound = |strength: f64| -> Result<DVec3, BuildError> {
        let plate = BodyDesc {
            breaking: Some(BreakingDesc::once(StrengthDesc::Impulse(strength), voronoi(1))),
            ..BodyDesc::new("plate", cuboid([1.5, 0.2, 1.5]))
        };
        let striker = BodyDesc {
            position: [0.2, 0.8, 0.1],
            linear_velocity: [0.0, -12.0, 0.0],
            density: 7800.0,
            ..BodyDesc::new("ball", ball(0.1))
        };
        let scene = SceneDesc {
            gravity: [0.0; 3],
            bodies: vec![plate, striker],
            ..SceneDesc::new("plate")
        };
        let mut world = World::build(&scene)?;
        (0..12).for_each(|_| drop(step(&mut world)));
        Ok(world.bodies().velocities[1].linear)
    };
    let unbroken = rebound(1e9)?;
    let mut off = Vec::new();
    for strength in [1.0, 30.0, 100.0, 300.0] {
        off.push((rebound(strength)? - unbroken).length());
    }
    Ok(vec![
        Finding::at_least("speed of the rebound", "m/s", unbroken.y, 0.5),
        Finding::at_most("rebound of four strengths, off", "m/s", largest(off), 0.0),
    ])
}

fn through() -> Result<Vec<Finding>, Obstacle> {
    let mut broken = 0;
    for rate in RATES {
        let support = |x: f64| BodyDesc {
            position: [x, 0.25, 0.0],
            ..fixed("support", cuboid([0.2, 0.5, 1.0]))
        };
        let slab = BodyDesc {
            position: [0.0, 0.55, 0.0],
            restitution: 0.3,
            breaking: Some(BreakingDesc::once(StrengthDesc::Impulse(100.0), voronoi(12))),
            ..BodyDesc::new("slab", cuboid([2.0, 0.1, 1.0]))
        };
        let block = BodyDesc {
            position: [0.0, 0.7, 0.0],
            restitution: 0.3,
            ..BodyDesc::new("block", cuboid([0.2; 3]))
        };
        let striker = BodyDesc {
            position: [0.0, 4.0, 0.0],
            linear_velocity: [0.0, -15.0, 0.0],
            density: 7800.0,
            restitution: 0.3,
            ..BodyDesc::new("ball", ball(0.15))
        };
        let bodies = vec![support(-0.9), support(0.9), slab, block, striker];
        broken += u64::from(first_blow(&mut build(rate, bodies)?, rate, 0.6) > 0.0);
    }
    let quantity = "slabs that break under a struck block, of six rates";
    Ok(vec![Finding::between(quantity, "1", broken as f64, 6.0, 6.0)])
}
