//! Each piece's solid: the parent, clipped by the piece's regions [Su09 sec. 4.2 "Level Set"].

use super::{
    components::Components,
    regions::{NONE, Shares},
    slivers::Pieces,
};
use crate::pattern::Region;
use frangible_geometry::{GridSolid, HalfSpace, Span};

/// Which pieces a region's inside belongs to, in ascending order: more than one where the body is not connected within the
/// region.
pub(crate) fn pieces_of_regions(regions: usize, components: &Components, pieces: &Pieces) -> Vec<Vec<u32>> {
    let mut of_region = vec![Vec::new(); regions];
    for (component, &piece) in pieces.of_component.iter().enumerate() {
        if piece != NONE && components.has_inside[component] {
            of_region[components.region[component] as usize].push(piece);
        }
    }
    for pieces in &mut of_region {
        pieces.sort_unstable();
        pieces.dedup();
    }
    of_region
}

/// The parent's level set and the regions', intersected. A piece that is all that its regions hold of the parent is the
/// parent, clipped; one that is only a part of that has its own distances sampled, so that it ends where it does.
pub(crate) fn intersect_level_sets(
    parent: &GridSolid,
    regions: &[Region],
    shares: &Shares,
    components: &Components,
    pieces: &Pieces,
) -> Vec<GridSolid> {
    let of_regions = pieces_of_regions(regions.len(), components, pieces);
    let shares_of_pieces = shares_of_pieces(shares, components, pieces);
    let planes_of = |region: u32| -> Vec<HalfSpace> {
        regions[region as usize].cuts.iter().map(|cut| cut.half_space).collect()
    };
    let solid = |(members, share): (&Vec<u32>, &Vec<(u32, Span)>)| {
        // A film of surface voxels does not take the region that it lies in along.
        let mut own: Vec<u32> = Vec::new();
        let any_inside = members.iter().any(|&component| components.has_inside[component as usize]);
        for &component in members {
            let region = components.region[component as usize];
            let counts = components.has_inside[component as usize] || !any_inside;
            if counts && !own.contains(&region) {
                own.push(region);
            }
        }
        let planes: Vec<Vec<HalfSpace>> = own.iter().map(|&region| planes_of(region)).collect();
        let planes: Vec<&[HalfSpace]> = planes.iter().map(Vec::as_slice).collect();
        let clipped = parent.clipped(share, &planes);
        let is_all = own.iter().all(|&region| of_regions[region as usize].len() == 1);
        if is_all && any_inside { clipped } else { clipped.sampled() }
    };
    pieces.components.iter().zip(&shares_of_pieces).map(solid).collect()
}

/// Rows and spans of each piece's material, in order.
fn shares_of_pieces(shares: &Shares, components: &Components, pieces: &Pieces) -> Vec<Vec<(u32, Span)>> {
    let mut of_pieces: Vec<Vec<(u32, Span)>> = vec![Vec::new(); pieces.components.len()];
    for row in 0..shares.rows() {
        for at in shares.row(row) {
            let piece = pieces.of_component[components.of_share[at] as usize];
            if piece != NONE {
                of_pieces[piece as usize].push((row as u32, shares.all[at].span));
            }
        }
    }
    of_pieces
}
