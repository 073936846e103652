//! Exact pieces of a break, of any form: their mass, and how small ones join others.

use crate::slivers::{Contact, Groups, Smallest};
use frangible_geometry::{MassProperties, Shape, parallel_axis};
use glam::DMat3;

/// Masses differ by less than this fraction of the parent's if they are the same but for rounding.
const SAME_VOLUME: f64 = 1e-12;

/// A part of the parent, on its way to a fragment.
pub(crate) struct Piece<F> {
    pub(crate) form: F,
    /// Mass properties including absorbed slivers, in the parent's grid frame.
    pub(crate) mass: MassProperties,
    /// Where it, or its larger part, comes from.
    pub(crate) cell: u32,
}

/// Joins pieces that are too small with their neighbours, over the largest crack first: as `join`
/// makes one piece of a sliver and its host. A negligible sliver that fits to no neighbour leaves
/// its mass with one, if it `absorbs`; others stay. `contacts` finds those of the pieces that are
/// too small.
pub(crate) fn join_small<F>(
    mut pieces: Vec<Piece<F>>,
    (smallest, absorbs): (&Smallest, bool),
    contacts: impl FnOnce(&[Piece<F>], &[bool]) -> Vec<Contact>,
    mut join: impl FnMut(&Piece<F>, &Piece<F>) -> Option<Piece<F>>,
) -> Vec<Piece<F>> {
    let volumes: Vec<f64> = pieces.iter().map(|piece| piece.mass.volume).collect();
    let least = smallest.least(&volumes);
    let is_small = |mass: &MassProperties| mass.volume < least || smallest.is_slender(mass);
    let too_small: Vec<bool> = pieces.iter().map(|piece| is_small(&piece.mass)).collect();
    if !too_small.contains(&true) {
        return pieces;
    }
    let contacts = contacts(&pieces, &too_small);
    let mut groups = Groups::new(&volumes, &too_small);

    // Join slivers, then absorb negligible ones.
    groups.join(&contacts, |sliver, host, _| {
        pieces[host] = join(&pieces[sliver], &pieces[host])?;
        Some(is_small(&pieces[host].mass))
    });
    let tiny =
        Smallest { part: smallest.part.min(Smallest::default().part), ..*smallest }.least(&volumes);
    let mut absorb = |sliver: usize, host: usize| {
        let own = pieces[sliver].mass;
        let is_absorbed = absorbs && (own.volume < tiny || smallest.is_slender(&own));
        pieces[host].mass = is_absorbed.then(|| together(&pieces[host].mass, &own))?;
        Some(is_small(&pieces[host].mass))
    };
    groups.join(&contacts, |sliver, host, _| absorb(sliver, host));
    groups.join_loose(|sliver, heaviest| absorb(sliver, heaviest).is_some());
    let of_piece = groups.of_piece();
    let stays = |(number, piece): (usize, Piece<F>)| (of_piece[number] == number).then_some(piece);
    pieces.into_iter().enumerate().filter_map(stays).collect()
}

/// Mass that a parent has absorbed is no part of its surface, which encloses the mass `without` it:
/// the heaviest of its pieces' masses grows by it.
pub(crate) fn give_absorbed<'a>(
    masses: impl Iterator<Item = &'a mut MassProperties>,
    parent: &Shape,
    without: &MassProperties,
) {
    let heaviest = masses.max_by(|a, b| a.volume.total_cmp(&b.volume));
    if let (Some(heaviest), Some(lump)) = (heaviest, absorbed_by(parent, without)) {
        *heaviest = lump.iter().fold(*heaviest, |mass, part| together(&mass, part));
    }
}

/// The mass that a parent has absorbed besides that of its surface: all of its own, and that taken
/// from it.
fn absorbed_by(parent: &Shape, without: &MassProperties) -> Option<[MassProperties; 2]> {
    if (parent.volume - without.volume).abs() <= SAME_VOLUME * parent.volume {
        return None;
    }
    let axes = DMat3::from_quat(parent.body_from_grid.inverse().rotation);
    let whole = MassProperties {
        volume: parent.volume,
        center: parent.body_from_grid.inverse().translation,
        inertia: axes * DMat3::from_diagonal(parent.unit_moments) * axes.transpose(),
    };
    let opposite =
        MassProperties { volume: -without.volume, inertia: -without.inertia, ..*without };
    Some([whole, opposite])
}

/// Mass properties of two rigidly joined parts.
pub(crate) fn together(a: &MassProperties, b: &MassProperties) -> MassProperties {
    let volume = a.volume + b.volume;
    let center = (a.volume * a.center + b.volume * b.center) / volume;
    let about =
        |part: &MassProperties| part.inertia + parallel_axis(part.volume, part.center - center);
    MassProperties { volume, center, inertia: about(a) + about(b) }
}
