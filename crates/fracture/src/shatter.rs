//! Breaking a body [Su09 sec. 4.2].
//!
//! - *Region*: a convex cell of the pattern, laid onto the body.
//! - *Component*: a connected part of the body's voxels within one region.
//! - *Piece*: one or more components that stay together, a sliver having joined its neighbour.
//! - *Solid*: the level set, coverage and outline of a piece, without samples, mass or frame.
//! - *Fragment*: the finished piece, a solid with its samples, mass properties and body frame.

pub(crate) mod components;
pub(crate) mod crack_samples;
pub(crate) mod laid;
pub(crate) mod particles;
pub(crate) mod pieces;
pub(crate) mod regions;
pub(crate) mod settings;
pub(crate) mod slivers;

use crate::align::Impact;
use crate::crater::shatter_within;
use crate::fragment::Fragment;
use crate::pattern::Pattern;
use crate::pattern::region::Region;
use crate::placement::Placement;
use crate::shatter::settings::ShatterSettings;
use crate::shatter_hull;
use crate::shatter_solid::shatter_solid;
use components::Components;
use frangible_geometry::{BodyFrame, ClusteredSamples, Geometry, GridSolid, Portion, Shape};
use frangible_math::cancel;
use laid::Laid;
use particles::Lookup;
use slivers::Pieces;

/// Breaks a body along a pattern that is laid onto the point of impact: one that has a polyhedron
/// exactly, see [`shatter_hull`], if the pattern is planar; what lies on a grid voxel by voxel.
/// There the fragments share out the parent's voxels, so that mass, and with
/// [`fragment_velocity`](crate::fragment_velocity) momentum, angular momentum and kinetic energy,
/// are the parent's. Empty for what has neither a polyhedron nor a grid, and for a polyhedron and a
/// pattern of other than planar cells.
pub fn shatter(
    parent: &Shape,
    pattern: &Pattern,
    impact: &Impact,
    settings: &ShatterSettings,
) -> Vec<Fragment> {
    cancel::check();
    match (&parent.geometry, pattern.planar()) {
        (Geometry::Grid(solid), Some(regions)) if settings.reach.is_none() => {
            let placement = Placement::with(pattern, impact, parent, settings);
            shatter_planar((parent, solid), (&placement, regions), settings)
        }
        (Geometry::Grid(solid), _) => shatter_sampled((parent, solid), pattern, impact, settings),
        (Geometry::Solid(solid), Some(regions)) => {
            let placement = Placement::with(pattern, impact, parent, settings);
            shatter_solid((parent, solid), (&placement, regions), settings)
        }
        (_, Some(_)) => match &settings.reach {
            Some(reach) => shatter_within(parent, pattern, impact, (settings, reach)),
            None => shatter_hull(parent, pattern, impact, settings),
        },
        (_, None) => Vec::new(),
    }
}

/// A solid, broken by planes.
fn shatter_planar(
    (parent, solid): (&Shape, &GridSolid),
    pattern: (&Placement, &[Region]),
    settings: &ShatterSettings,
) -> Vec<Fragment> {
    // Lay the pattern onto the body, and share out its voxels among the regions.
    let regions = pattern.0.planes(pattern.1);
    let smallest = settings.smallest_fragment_voxels;

    // Each connected part of a region's share is a piece, unless it is too small for the grid.
    let mut components = if solid.is_convex() {
        components::of_convex(regions::convex::portions_of_regions(solid, &regions))
    } else {
        components::connected_components(solid, regions::share_out(solid, &regions), Some(smallest))
    };
    let pieces = slivers::merge_slivers(solid, &components, smallest, &settings.smallest, None);

    // Level set, mass properties and principal frame of each piece, then its surface samples.
    let framed = frame(pieces::intersect_level_sets(solid, &regions, &mut components, &pieces));
    let of_regions = &pieces::pieces_of_regions(regions.len(), &components, &pieces);
    let lookup = Lookup { pattern: Some(pattern), regions: &regions, of_regions, pieces: &framed };
    let surfaces = particles::assign_particles((parent, solid), &lookup, settings);
    finish(parent, framed, surfaces, (&components, &pieces))
}

/// A solid, broken by cells of any form, whose distances are sampled at the pieces' nodes.
fn shatter_sampled(
    (parent, solid): (&Shape, &GridSolid),
    pattern: &Pattern,
    impact: &Impact,
    settings: &ShatterSettings,
) -> Vec<Fragment> {
    pattern.prepare();
    let reach = settings.reach.as_ref();
    let placement = Placement::with(pattern, impact, parent, settings);
    let mut laid = Laid::new(pattern, placement, solid);
    if let Some(reach) = reach {
        laid.end_at(reach, solid);
    }

    let mut fragments = cut_sampled((parent, solid), &laid, settings).fragments;
    for fragment in &mut fragments {
        if fragment.cell as usize >= pattern.len() {
            fragment.cell = Fragment::REST;
        }
    }
    fragments
}

/// A solid in pieces.
pub(crate) struct CutUp {
    pub(crate) fragments: Vec<Fragment>,
    /// Of each fragment its material on the parent's grid, and its cells.
    pub(crate) parts: Vec<(Portion, Vec<u32>)>,
}

/// The same along a pattern that is laid: the stages are those for planes.
pub(crate) fn cut_sampled(
    (parent, solid): (&Shape, &GridSolid),
    laid: &Laid,
    settings: &ShatterSettings,
) -> CutUp {
    let shares = regions::share_out_nodes(solid, laid);
    let mut components = components::connected_components(solid, shares, None);
    let voxels = settings.smallest_fragment_voxels;
    let pieces =
        slivers::merge_slivers(solid, &components, voxels, &settings.smallest, laid.rest());
    let parts = pieces::parts_of_pieces(solid.grid(), &mut components, &pieces);
    let framed = frame(pieces::intersect_sampled(solid, laid, &parts));
    let of_regions = pieces::pieces_of_regions(laid.cells(), &components, &pieces);
    let spacing = (settings.sample_spacing_voxels as usize).max(1);
    let surfaces =
        particles::assign_to_sampled((parent, solid), (&framed, &of_regions), laid, spacing);
    let fragments = finish(parent, framed, surfaces, (&components, &pieces));
    CutUp { fragments, parts }
}

/// Mass properties and principal frame of each solid. Every piece has mass, and a voxel's own
/// inertia keeps the least one regular.
fn frame(solids: Vec<GridSolid>) -> Vec<(GridSolid, BodyFrame)> {
    let framed = |solid: GridSolid| BodyFrame::of(&solid).ok().map(|frame| (solid, frame));
    solids.into_iter().filter_map(framed).collect()
}

/// Bodies of the pieces.
fn finish(
    parent: &Shape,
    framed: Vec<(GridSolid, BodyFrame)>,
    surfaces: Vec<ClusteredSamples>,
    (components, pieces): (&Components, &Pieces),
) -> Vec<Fragment> {
    let cells = pieces.components.iter().map(|parts| components.region[parts[0] as usize]);
    let fragment = |(((solid, frame), surface), cell)| {
        Fragment::new(parent, Shape::from_clusters(solid, frame, surface), cell)
    };
    framed.into_iter().zip(surfaces).zip(cells).map(fragment).collect()
}
