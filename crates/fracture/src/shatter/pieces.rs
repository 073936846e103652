//! Each piece's solid: the parent, clipped by the piece's regions [Su09 sec. 4.2 "Level Set"].

use super::components::Components;
use super::laid::Laid;
use super::slivers::Pieces;
use crate::pattern::region::Region;
use crate::shatter::regions::intervals::NONE;
use frangible_geometry::{Grid, GridSolid, HalfSpace, Portion, Run};

/// Which pieces a region's inside belongs to, in ascending order: more than one where the body is
/// not connected within the region.
pub(crate) fn pieces_of_regions(
    regions: usize,
    components: &Components,
    pieces: &Pieces,
) -> Vec<Vec<u32>> {
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

/// Intersects the parent's level set with the regions'. A piece with all content of its regions is
/// the clipped parent; a partial piece has resampled distances, to end where it does.
pub(crate) fn intersect_level_sets(
    parent: &GridSolid,
    regions: &[Region],
    components: &mut Components,
    pieces: &Pieces,
) -> Vec<GridSolid> {
    let of_regions = pieces_of_regions(regions.len(), components, pieces);
    let portions = portions_of_pieces(parent.grid(), components, pieces);
    let planes_of = |region: u32| -> Vec<HalfSpace> {
        regions[region as usize].cuts.iter().map(|cut| cut.half_space).collect()
    };
    let solid = |(members, portion): (&Vec<u32>, Portion)| {
        let (own, any_inside) = regions_of_piece(members, components);
        let planes: Vec<Vec<HalfSpace>> = own.iter().map(|&region| planes_of(region)).collect();
        let planes: Vec<&[HalfSpace]> = planes.iter().map(Vec::as_slice).collect();
        let clipped = parent.clipped(portion, &planes);
        let is_all = own.iter().all(|&region| of_regions[region as usize].len() == 1);
        if is_all && any_inside { clipped } else { clipped.sampled() }
    };
    pieces.components.iter().zip(portions).map(solid).collect()
}

/// The same for cells of any form, whose distances are sampled at the pieces' nodes.
pub(crate) fn intersect_sampled(
    parent: &GridSolid,
    laid: &Laid,
    parts: &[(Portion, Vec<u32>)],
) -> Vec<GridSolid> {
    let solid = |(portion, own): &(Portion, Vec<u32>)| {
        parent.intersected(portion.clone(), |grid| laid.distances(own, grid))
    };
    parts.iter().map(solid).collect()
}

/// Material of each piece, moved out of its components, and its regions.
pub(crate) fn parts_of_pieces(
    grid: &Grid,
    components: &mut Components,
    pieces: &Pieces,
) -> Vec<(Portion, Vec<u32>)> {
    let portions = portions_of_pieces(grid, components, pieces);
    let regions = |members: &Vec<u32>| regions_of_piece(members, components).0;
    portions.into_iter().zip(pieces.components.iter().map(regions)).collect()
}

/// Regions of a piece, and true with an inside node. Films of surface voxels do not add their
/// region.
fn regions_of_piece(members: &[u32], components: &Components) -> (Vec<u32>, bool) {
    let mut own: Vec<u32> = Vec::new();
    let any_inside = members.iter().any(|&component| components.has_inside[component as usize]);
    for &component in members {
        let region = components.region[component as usize];
        let counts = components.has_inside[component as usize] || !any_inside;
        if counts && !own.contains(&region) {
            own.push(region);
        }
    }
    (own, any_inside)
}

/// Content of each piece, moved out of its components.
fn portions_of_pieces(grid: &Grid, components: &mut Components, pieces: &Pieces) -> Vec<Portion> {
    let portion = |members: &Vec<u32>| {
        let mut all = Portion::with_capacity(grid, 0);
        for &component in members {
            let own = &mut components.portions[component as usize];
            all.sums.merge(&own.sums);
            if all.runs.is_empty() {
                std::mem::swap(&mut all.runs, &mut own.runs);
            } else {
                all.runs.append(&mut own.runs);
            }
        }
        if members.len() > 1 {
            all.runs.sort_by_key(Run::place);
        }
        all
    };
    pieces.components.iter().map(portion).collect()
}
