//! Breaking a solid of any form by planes: exact, without a grid [Su09 sec. 4.4].
//!
//! A cell of the pattern is convex, and a piece lies in its cell: so does the piece's hull, however
//! concave the piece is, and hulls of neighbours do not overlap. A piece meets others as that hull,
//! or where it is much larger than the piece as a few hulls of parts of it.

use crate::fragment::Fragment;
use crate::interfaces;
use crate::pattern::region::Region;
use crate::piece::{Piece, give_absorbed, join_small, together};
use crate::placement::Placement;
use crate::shatter::settings::ShatterSettings;
use crate::slivers::Contact;
use frangible_geometry::{
    Cell, CellCutter, ContactHulls, Hull, PlaneSearch, Shape, Solid, SolidPart,
};
use frangible_math::{RigidTransform, threads};
use glam::{DQuat, DVec3};

/// The hulls as which a piece meets others. With 32 vertices a hull of the bunny's 60 pieces stays
/// within 1.8 % of a piece's diagonal, with 24 within 2.8 %; with all of them a frame took 200 times
/// as long. Four parts halve the gap between what is drawn and what collides of a thin vase; with
/// more, the parts that meet cost more than samples.
const OF_PIECES: ContactHulls = ContactHulls {
    vertices: 32,
    within: 0.01,
    convex: 0.25,
    parts: 4,
    excess: 0.1,
    search: PlaneSearch::Quick,
};

/// The box around the solid in which cells are looked at is larger by this part of its longest
/// side: no face of the solid lies on it.
const CLEAR: f64 = 1e-3;

/// Vertices of the two sides of a crack are apart by less, relative to the solid's longest side.
const SAME_VERTEX: f64 = 1e-9;

/// Pieces of which so much of the parent's volume is missing, or is there twice, are none: cells
/// from a file need not fill space.
const NOT_FILLED: f64 = 1e-9;

/// Breaks a solid by the regions of a planar pattern that is laid.
///
/// A piece that is too small joins the neighbour over their largest crack, mass and surface; the
/// neighbour meets others as before. One that cannot leaves its mass there if it is negligible, and
/// else stays. Empty if the pieces do not fill the solid.
pub(crate) fn shatter_solid(
    (parent, solid): (&Shape, &Solid),
    (placement, regions): (&Placement, &[Region]),
    settings: &ShatterSettings,
) -> Vec<Fragment> {
    let (low, high) = solid.bounds();
    let size = (high - low).max_element();
    let (numbers, cells): (Vec<u32>, Vec<Cell>) =
        cells((low, high), placement, regions).into_iter().unzip();
    let piece = |(cell, SolidPart { solid, mass }): (usize, SolidPart)| Piece {
        form: CutSolid { solid, core: None },
        mass,
        cell: numbers[cell],
    };
    let mut pieces: Vec<Piece<CutSolid>> = solid.cut(&cells).into_iter().map(piece).collect();
    let masses = pieces.iter_mut().map(|piece| &mut piece.mass);
    give_absorbed(masses, parent, &solid.mass_properties());
    let volume: f64 = pieces.iter().map(|piece| piece.mass.volume).sum();
    if (volume - parent.volume).abs() > NOT_FILLED * parent.volume {
        return Vec::new();
    }
    let join = |sliver: &Piece<CutSolid>, host: &Piece<CutSolid>| {
        let solid = host.form.solid.joined(&sliver.form.solid, SAME_VERTEX * size)?;
        let core = Some(host.form.core().clone());
        let mass = together(&host.mass, &sliver.mass);
        Some(Piece { form: CutSolid { solid, core }, mass, cell: host.cell })
    };
    let contacts = |pieces: &[Piece<CutSolid>], _: &[bool]| contacts_of_pieces(pieces);
    let pieces = join_small(pieces, (&settings.smallest, true), contacts, join);

    // Hulls and principal frame of each piece.
    let count = pieces.len();
    let fragment = |Piece { form, mass, cell }: Piece<CutSolid>| {
        let (hulls, _) = OF_PIECES.of(form.core());
        let spacing = parent.sample_spacing();
        let shape = Shape::solid_with_mass(form.solid, hulls, &mass, spacing).ok()?;
        Some(Fragment::new(parent, shape, cell))
    };
    let fragments = threads::map(pieces, count * WORTH, fragment);
    fragments.into_iter().collect::<Option<_>>().unwrap_or_default()
}

/// Things that a piece's hull is worth, for sharing pieces out.
const WORTH: usize = 64;

/// A connected part of the solid in a cell.
struct CutSolid {
    solid: Solid,
    /// The part as it was before smaller ones joined it.
    core: Option<Solid>,
}

impl CutSolid {
    /// The part whose hull the piece meets others as: within its cell.
    fn core(&self) -> &Solid {
        self.core.as_ref().unwrap_or(&self.solid)
    }
}

/// Areas of the cracks between pieces.
fn contacts_of_pieces(pieces: &[Piece<CutSolid>]) -> Vec<Contact> {
    let placed: Vec<(&Solid, RigidTransform)> =
        pieces.iter().map(|piece| (&piece.form.solid, RigidTransform::IDENTITY)).collect();
    let contacts = interfaces::solids::contacts(&placed);
    contacts.into_iter().map(|contact| ([contact.a, contact.b], contact.area)).collect()
}

/// The regions of a pattern that come near a solid with these bounds, with their numbers.
fn cells(
    (low, high): (DVec3, DVec3),
    placement: &Placement,
    regions: &[Region],
) -> Vec<(u32, Cell)> {
    let clear = CLEAR * (high - low).max_element();
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low) + clear);
    let around = Hull::cuboid(half).transformed(&RigidTransform::new(DQuat::IDENTITY, middle));
    let mut cutter = CellCutter::new(&around);
    let mut cells = Vec::with_capacity(regions.len());
    for (number, region) in (0..).zip(regions) {
        // Planes that reach the box.
        let laid = region.cuts.iter().map(|cut| placement.half_space(&cut.half_space));
        let reaching: Vec<_> =
            laid.filter(|plane| plane.distance(middle) > -half.dot(plane.normal.abs())).collect();
        if let Some(cell) = cutter.part(&reaching) {
            let is_face = |plane: &_| cell.planes().contains(plane);
            let planes = reaching.into_iter().filter(is_face).collect();
            cells.push((number, Cell { planes, bounds: cell.bounds() }));
        }
    }
    cells
}
