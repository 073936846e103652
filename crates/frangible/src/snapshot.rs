//! A world as bytes, and back: what a step needs, to the bit. Values that bodies share are written
//! once; what can be made from others, and patterns that a generator makes, are made again.

mod rules;

use crate::fingerprint::Fnv1a;
use crate::hand::state::Hand;
use crate::report::books::Books;
use crate::scene::desc::Method;
use crate::world::{Label, World};
use frangible_bodies::{Bodies, BodyId, StepSettings};
use frangible_collision::{BirthFits, ContactCache, ImpulseCache};
use frangible_dynamics::{Ledger, RecentImpacts};
use frangible_math::check::Check;
use frangible_math::shared;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What every snapshot begins with.
const MAGIC: &[u8] = b"frangible world\n";

/// Another version may lay out the state in another way, and go on to other bits. The number after
/// the dash counts changes of the layout between versions.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "-5");

/// Why a snapshot was not written or not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SnapshotError {
    /// Not one at all.
    #[error("not a snapshot of a Frangible world")]
    Foreign,
    /// Of another version.
    #[error("a snapshot of version {found}, where version {VERSION} reads its own alone")]
    Version {
        /// The version that wrote it.
        found: String,
    },
    /// Cut off or changed.
    #[error("a damaged snapshot: {0}")]
    Damaged(String),
    /// Something of the world has no form in bytes.
    #[error("the world cannot be written: {0}")]
    Unwritable(String),
}

/// The fields of a world in a snapshot: only what is checked when it is read becomes a world.
#[derive(Serialize, Deserialize)]
#[serde(remote = "World")]
struct Fields {
    bodies: Bodies,
    labels: Vec<Label>,
    frame: u64,
    dt: f64,
    gravity: DVec3,
    settings: StepSettings,
    books: Books,
    ledger: Ledger,
    method: Method,
    warm: ImpulseCache,
    recent_impacts: RecentImpacts,
    contact_cache: ContactCache,
    fits: BirthFits,
    spared: Vec<(BodyId, f64)>,
    #[serde(skip)]
    born_of_pieces: usize,
    note: String,
    hand: Hand,
    #[serde(skip)]
    clock: Option<fn() -> f64>,
}

#[derive(Serialize)]
struct Written<'a>(#[serde(with = "Fields")] &'a World);

#[derive(Deserialize)]
struct Read(#[serde(with = "Fields")] World);

impl World {
    /// All of the world's state. [`World::restore`] makes a world of it whose next frames are this
    /// one's, to the bit.
    ///
    /// # Errors
    /// If a pattern came from a file and has no form in JSON.
    pub fn snapshot(&self) -> Result<Vec<u8>, SnapshotError> {
        let state = shared::scope(|| postcard::to_stdvec(&Written(self)))
            .map_err(|error| SnapshotError::Unwritable(error.to_string()))?;
        let digest = digest(&state).to_le_bytes();
        Ok([MAGIC, &[VERSION.len() as u8], VERSION.as_bytes(), &digest, &state].concat())
    }

    /// The world of a snapshot. It has no clock; see [`World::set_clock`].
    ///
    /// # Errors
    /// If these are not the bytes of a snapshot of this version, as they were written, or if they
    /// were changed such that they hold no world.
    pub fn restore(snapshot: &[u8]) -> Result<Self, SnapshotError> {
        let rest = snapshot.strip_prefix(MAGIC).ok_or(SnapshotError::Foreign)?;
        let cut_off = || SnapshotError::Damaged("it ends too early".into());
        let (length, rest) = rest.split_first().ok_or_else(cut_off)?;
        let (version, rest) = rest.split_at_checked(usize::from(*length)).ok_or_else(cut_off)?;
        if version != VERSION.as_bytes() {
            let found = String::from_utf8_lossy(version).into_owned();
            return Err(SnapshotError::Version { found });
        }
        let (expected, state) = rest.split_first_chunk().ok_or_else(cut_off)?;
        if digest(state) != u64::from_le_bytes(*expected) {
            return Err(SnapshotError::Damaged("its bytes are not those that were written".into()));
        }
        let Read(world) = shared::scope(|| postcard::from_bytes(state))
            .map_err(|error| SnapshotError::Damaged(error.to_string()))?;
        let broken = |rule: &str| SnapshotError::Damaged(format!("it must hold {rule}"));
        world.check().map_err(broken)?;
        Ok(world)
    }
}

fn digest(bytes: &[u8]) -> u64 {
    let mut hash = Fnv1a::default();
    hash.add_bytes(bytes);
    hash.digest()
}
