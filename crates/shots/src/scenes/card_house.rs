//! Cards leaning against each other in pairs, with horizontal cards as floors of the next storey.

use crate::shot::Shot;
use frangible::{BodyDesc, LookDesc, Resolution, SceneDesc, ShapeDesc};

/// Five storeys.
pub(crate) const CARD_HOUSE: Shot = Shot {
    name: "card-house",
    caption: "a house of 40 cards stands",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |_| Ok(card_house(FRICTION)),
};

/// Number of storeys, and of pairs of cards in the lowest.
const STOREYS: usize = 5;

/// Coulomb's coefficient of paper on paper: under a load a card that leans by an angle needs its
/// tangent.
pub(crate) const FRICTION: f64 = 0.5;

/// Of a card: thickness, height and width [m].
const CARD: [f64; 3] = [0.005, 0.5, 0.3];

/// Between a leaning card and the vertical [rad].
const LEAN: f64 = 0.35;

/// Of a pair's feet from the next pair's, in units of those from each other.
const APART: f64 = 0.2;

/// Overhang of the outer horizontal cards beyond their supports [m].
const OVERHANG: f64 = 0.05;

/// Between lying cards [m].
const GAP: f64 = 0.002;

/// Of paper [kg/m^3].
const DENSITY: f64 = 800.0;

/// Cards of some friction, on ground with the same.
pub(crate) fn card_house(friction: f64) -> SceneDesc {
    let (sin, cos) = (libm::sin(LEAN), libm::cos(LEAN));
    let [thickness, height, width] = CARD;
    let card = |position: [f64; 2], turn: f64, size: [f64; 3]| BodyDesc {
        position: [position[0], position[1], 0.0],
        orientation: [0.0, 0.0, libm::sin(0.5 * turn), libm::cos(0.5 * turn)],
        density: DENSITY,
        friction,
        restitution: 0.0,
        look: Some(LookDesc::Wood),
        ..BodyDesc::new("card", ShapeDesc::Box { size, resolution: Resolution::default() })
    };
    let mut scene = SceneDesc::new("");
    scene.bodies.push(BodyDesc { friction, ..BodyDesc::ground(0.0) });

    // Two that lean are this wide and this high.
    let (half, storey) = (thickness * cos + height * sin, height * cos + thickness * sin);
    let pitch = 2.0 * half * (1.0 + APART);
    for level in 0..STOREYS {
        let pairs = STOREYS - level;
        let along = |place: f64, count: usize| (place - 0.5 * (count as f64 - 1.0)) * pitch;
        let floor = level as f64 * (storey + thickness);
        for pair in 0..pairs {
            for side in [-1.0, 1.0] {
                let place = along(pair as f64, pairs) + side * 0.5 * half;
                scene.bodies.push(card([place, floor + 0.5 * storey], side * LEAN, CARD));
            }
        }
        for lying in 1..pairs {
            let ends = [lying - 1, lying].map(|pair| along(pair as f64, pairs));
            let low = ends[0] + if lying == 1 { -OVERHANG } else { 0.5 * GAP };
            let high = ends[1] + if lying + 1 == pairs { OVERHANG } else { -0.5 * GAP };
            let size = [high - low, thickness, width];
            scene.bodies.push(card(
                [0.5 * (low + high), floor + storey + 0.5 * thickness],
                0.0,
                size,
            ));
        }
    }
    scene
}
