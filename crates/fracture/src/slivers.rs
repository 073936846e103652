//! Slivers join a neighbour: one rule for all ways of breaking.

use frangible_geometry::{MassProperties, Shape};
use frangible_math::cancel;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The bounds below which a part is a sliver, and no piece of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Smallest {
    /// Of the mean volume of the pieces of one break (a ratio). Default 1e-4.
    pub part: f64,
    /// [m^3]; default 0.
    pub volume: f64,
    /// Of the smallest principal moment to the largest (a ratio); for polyhedra. Default 0.
    pub slenderness: f64,
}

/// Of the mean volume of the pieces of one break.
const PART: f64 = 1e-4;

/// Of the volume of the first body, which was broken into pieces again and again: a cube a
/// thousandth as wide.
const OF_FIRST: f64 = 1e-9;

/// Of no body [m^3]: a cube of a micrometre.
const LEAST_VOLUME: f64 = 1e-18;

/// Needles with moments that lie further apart turn about their axis by what single precision
/// rounds off of their inverses.
const SLENDER: f64 = 1e-6;

impl Default for Smallest {
    fn default() -> Self {
        Self { part: PART, volume: 0.0, slenderness: 0.0 }
    }
}

impl Smallest {
    /// For a body of a scene and all that it breaks into, in a row: without an end, each break
    /// would leave pieces that are smaller again. A body that is a needle itself breaks into
    /// needles.
    pub fn of_first(first: &Shape) -> Self {
        let slenderness = slenderness(first.unit_moments).min(1.0);
        Self {
            part: PART,
            volume: (OF_FIRST * first.volume).max(LEAST_VOLUME),
            slenderness: SLENDER * slenderness,
        }
    }

    /// Sliver volume limit [m^3] for pieces with these volumes, relative to the mean of the
    /// remaining pieces.
    pub(crate) fn least(&self, volumes: &[f64]) -> f64 {
        let total: f64 = volumes.iter().sum();
        let mut least = self.volume;
        loop {
            let stay = volumes.iter().filter(|&&volume| volume >= least).count().max(1);
            let next = self.volume.max(self.part * total / stay as f64);
            if next <= least {
                return least;
            }
            least = next;
        }
    }

    /// True if a piece is a needle.
    pub(crate) fn is_slender(&self, mass: &MassProperties) -> bool {
        self.slenderness > 0.0 && slenderness(mass.principal_axes().0) < self.slenderness
    }
}

/// Ratio of the smallest principal moment to the largest.
fn slenderness(moments: DVec3) -> f64 {
    if moments.max_element() > 0.0 { moments.min_element() / moments.max_element() } else { 0.0 }
}

/// Two touching pieces, and their contact area in any unit.
pub type Contact = ([usize; 2], f64);

/// Merges slivers: for each piece the index of its host, its own index if unmerged.
///
/// A sliver joins the neighbour with the largest contact area, lightest first. A sliver without
/// neighbours stays, unless below [`Smallest::volume`]: then it joins the heaviest piece.
pub fn join_slivers(volumes: &[f64], contacts: &[Contact], smallest: &Smallest) -> Vec<usize> {
    let least = smallest.least(volumes);
    let too_small: Vec<bool> = volumes.iter().map(|&volume| volume < least).collect();
    let mut groups = Groups::new(volumes, &too_small);
    groups.join(contacts, |_, _, volume| Some(volume < least));
    groups.join_loose(|sliver, _| volumes[sliver] < smallest.volume);
    groups.of_piece()
}

/// Groups of merged pieces, named by one member.
pub(crate) struct Groups {
    /// [m^3], of all members.
    volumes: Vec<f64>,
    /// Of all members: none is large enough to stand alone.
    too_small: Vec<bool>,
    /// Empty for a piece that has joined another.
    members: Vec<Vec<usize>>,
}

impl Groups {
    /// Each piece alone.
    pub(crate) fn new(volumes: &[f64], too_small: &[bool]) -> Self {
        let members = (0..volumes.len()).map(|piece| vec![piece]).collect();
        Self { volumes: volumes.to_vec(), too_small: too_small.to_vec(), members }
    }

    /// Merges each sliver with a fitting neighbour by contact area, lightest first, lowest index on
    /// ties. `fits(sliver, host, volume)` tests a pair with their total volume [m^3]: `None` if
    /// they do not fit, else true if the merged piece is still a sliver. The merged piece takes the
    /// host's place.
    pub(crate) fn join(
        &mut self,
        contacts: &[Contact],
        mut fits: impl FnMut(usize, usize, f64) -> Option<bool>,
    ) {
        let mut host_of: Vec<usize> = (0..self.volumes.len()).collect();
        let mut open: Vec<usize> =
            (0..self.volumes.len()).filter(|&piece| self.too_small[piece]).collect();
        let mut touching: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.volumes.len()];
        for &([a, b], area) in contacts {
            touching[a].push((b, area));
            touching[b].push((a, area));
        }
        while let Some(at) = self.lightest(&open) {
            cancel::check();
            let sliver = open.swap_remove(at);
            let around = self.hosts(sliver, &touching, &host_of);
            let mut join = |host: usize| {
                Some((host, fits(sliver, host, self.volumes[sliver] + self.volumes[host])?))
            };
            let Some((host, is_small)) = around.iter().find_map(|&(host, _)| join(host)) else {
                continue;
            };
            let own = std::mem::take(&mut self.members[sliver]);
            own.iter().for_each(|&member| host_of[member] = host);
            self.members[host].extend(own);
            self.volumes[host] += self.volumes[sliver];
            open.retain(|&other| other != host);
            self.too_small[host] &= is_small;
            if self.too_small[host] {
                open.push(host);
            }
        }
    }

    /// Merges a sliver without a fitting neighbour into the heaviest piece, if `fits(sliver,
    /// heaviest)`.
    pub(crate) fn join_loose(&mut self, mut fits: impl FnMut(usize, usize) -> bool) {
        let heaviest = (0..self.volumes.len())
            .max_by(|&a, &b| self.volumes[a].total_cmp(&self.volumes[b]).then(b.cmp(&a)));
        let Some(heaviest) = heaviest else { return };
        for piece in 0..self.volumes.len() {
            let is_left =
                piece != heaviest && self.too_small[piece] && !self.members[piece].is_empty();
            if is_left && fits(piece, heaviest) {
                let own = std::mem::take(&mut self.members[piece]);
                self.members[heaviest].extend(own);
                self.volumes[heaviest] += self.volumes[piece];
            }
        }
    }

    /// Group of each piece.
    pub(crate) fn of_piece(&self) -> Vec<usize> {
        let mut of_piece = vec![0; self.members.len()];
        for (group, members) in self.members.iter().enumerate() {
            members.iter().for_each(|&member| of_piece[member] = group);
        }
        of_piece
    }

    /// Where in the list the lightest is; the least number of equals.
    fn lightest(&self, open: &[usize]) -> Option<usize> {
        let volume = |at: usize| self.volumes[open[at]];
        (0..open.len()).min_by(|&a, &b| volume(a).total_cmp(&volume(b)).then(open[a].cmp(&open[b])))
    }

    /// The groups that a sliver touches, with the area: the largest first, the least number of
    /// equals.
    fn hosts(
        &self,
        sliver: usize,
        touching: &[Vec<(usize, f64)>],
        host_of: &[usize],
    ) -> Vec<(usize, f64)> {
        let mut around: Vec<(usize, f64)> = Vec::new();
        for &(other, area) in self.members[sliver].iter().flat_map(|&member| &touching[member]) {
            let host = host_of[other];
            match around.iter_mut().find(|(known, _)| *known == host) {
                _ if host == sliver => {}
                Some((_, sum)) => *sum += area,
                None => around.push((host, area)),
            }
        }
        around.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        around
    }
}
