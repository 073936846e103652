//! All scenes, a file each.

pub(crate) mod arch;
pub(crate) mod bonded_pillar;
pub(crate) mod bricks;
pub(crate) mod card_house;
pub(crate) mod concrete;
pub(crate) mod cradle;
pub(crate) mod cylinder;
pub(crate) mod debris;
pub(crate) mod impact;
pub(crate) mod incline;
pub(crate) mod masonry;
pub(crate) mod nut;
pub(crate) mod pane;
pub(crate) mod pile_table;
pub(crate) mod piles;
pub(crate) mod pillar;
pub(crate) mod plank;
pub(crate) mod plate;
pub(crate) mod rain;
pub(crate) mod refracture;
pub(crate) mod slab;
pub(crate) mod stack;
pub(crate) mod timber;
pub(crate) mod towers;
pub(crate) mod wall;

use crate::shot::{Shot, ShotError};
use frangible::nearest;

/// All shots.
pub const SHOTS: &[Shot] = &[
    wall::UPPER,
    wall::MIDDLE,
    wall::LOWER,
    wall::BALL,
    wall::NATURAL,
    cylinder::CYLINDER,
    impact::BUNNY,
    refracture::REFRACTURE,
    rain::RAIN_25,
    rain::RAIN_100,
    rain::RAIN_1000,
    pane::PANE,
    masonry::MASONRY,
    timber::TIMBER,
    concrete::CONCRETE,
    impact::IMPACT,
    pillar::PILLAR,
    bonded_pillar::BONDED_PILLAR,
    plank::PLANK,
    stack::STACK,
    incline::INCLINE,
    piles::SPREAD,
    piles::DEEP,
    pile_table::TABLE,
    bricks::BRICKS,
    bricks::STILL,
    towers::TOWER,
    towers::PYRAMID,
    towers::LOAD,
    arch::ARCH,
    slab::SLAB,
    debris::DEBRIS,
    plate::PLATE,
    nut::NUT,
    cradle::CRADLE,
    card_house::CARD_HOUSE,
];

impl Shot {
    /// The shot of a name.
    ///
    /// # Errors
    /// If there is none.
    pub fn find(name: &str) -> Result<&'static Self, ShotError> {
        let known = || {
            let names: Vec<&str> = SHOTS.iter().map(|shot| shot.name).collect();
            names.join(", ") + &nearest(name, &names)
        };
        SHOTS
            .iter()
            .find(|shot| shot.name == name)
            .ok_or_else(|| ShotError::Unknown { name: name.into(), known: known() })
    }
}
