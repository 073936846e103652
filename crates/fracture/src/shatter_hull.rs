//! Breaking a convex polyhedron by planes: exact, without a grid.
//!
//! Each cell of a planar pattern cuts its part out of the parent. Fragments are snug: neighbours
//! share the vertices of their crack bit for bit, and what was the parent's surface keeps its
//! planes. Mass follows from the divergence theorem.

use crate::align::Impact;
use crate::fragment::Fragment;
use crate::interfaces::hulls::contacts_of_some;
use crate::pattern::Pattern;
use crate::pattern::region::Region;
use crate::placement::Placement;
use crate::polygon;
use crate::shatter::settings::ShatterSettings;
use crate::slivers::{Groups, Smallest};
use frangible_geometry::parallel_axis;
use frangible_geometry::weld_hulls;
use frangible_geometry::{CellCutter, HalfSpace, Hull, HullFace, MassProperties, Shape};
use frangible_math::cancel;
use glam::{DMat3, DVec3};
use std::ops::Range;

/// Parts below this fraction of the parent's volume are round-off.
pub(crate) const NO_VOLUME: f64 = 1e-13;

/// Two pieces merge across a crack if their convex hull equals their union, within this fraction of
/// the parent's volume.
const SAME_VOLUME: f64 = 1e-12;

/// Vertices of neighbours closer than this fraction of the parent's longest side are equal.
/// Different cutting orders displace vertices by about 1e-15.
pub(crate) const SAME_VERTEX: f64 = 1e-12;

/// Pieces of which so much of the parent's volume is missing, or is there twice, are none: a rod a
/// thousand times as long as thick cannot be cut lengthwise again and again in the precision that
/// its length leaves.
pub(crate) const NOT_FILLED: f64 = 1e-10;

/// Two pieces are not convex together if a vertex of one lies this far, relative to the parent's
/// longest side, beyond a plane of the other. Volumes tell of those that lie nearer.
const BEYOND: f64 = 1e-6;

/// Planes or pieces that there are room for at first.
const FEW: usize = 16;

/// A part of the parent, on its way to a fragment.
pub(crate) struct Piece {
    pub(crate) hull: Hull,
    /// Cuts of this piece, as a range in the workshop's list.
    cuts: Range<usize>,
    /// Mass properties including absorbed slivers, in the parent's grid frame.
    pub(crate) mass: MassProperties,
    /// Where it, or its larger part, comes from.
    pub(crate) cell: u32,
}

/// Breaks a body that has a polyhedron ([`Shape::breaks_as`]) along a planar pattern that is laid
/// onto the point of impact. The fragments fill the parent, so that mass, and with
/// [`fragment_velocity`](crate::fragment_velocity) momentum, angular momentum and kinetic energy,
/// are the parent's up to rounding.
///
/// A piece that is too small joins the neighbour over their largest crack, if the two without it
/// are convex. Where they are with none, its neighbour absorbs a sliver of less than a
/// ten-thousandth of the mean piece, or a needle: the mass goes over, where it is, and the
/// polyhedron stays as it is, beside a void that nobody sees. A larger one stays. Empty if the body
/// has no polyhedron or the pattern is not planar, and if it is too thin for its length to be cut
/// exactly.
pub fn shatter_hull(
    parent: &Shape,
    pattern: &Pattern,
    impact: &Impact,
    settings: &ShatterSettings,
) -> Vec<Fragment> {
    cut_hull(parent, pattern, impact, settings, true)
}

/// The same; where nothing `absorbs`, each piece's mass is that of its polyhedron, and slivers that
/// fit to nothing stay.
pub(crate) fn cut_hull(
    parent: &Shape,
    pattern: &Pattern,
    impact: &Impact,
    settings: &ShatterSettings,
    absorbs: bool,
) -> Vec<Fragment> {
    let (Some(hull), Some(regions)) = (parent.breaks_as(), pattern.planar()) else {
        return Vec::new();
    };
    let placement = Placement::with(pattern, impact, parent, settings);

    // Cut each cell's part out.
    let mut workshop = Workshop::new(hull, parent.volume);
    let mut pieces: Vec<Piece> = Vec::with_capacity(regions.len());
    let cells = regions.iter().zip(0..);
    pieces.extend(cells.filter_map(|(region, cell)| workshop.cell(&placement, region, cell)));
    give_lump(&mut pieces, parent, hull);
    let pieces = workshop.merge_slivers(pieces, &settings.smallest, absorbs);

    // Neighbours share their vertices.
    let masses: Vec<(MassProperties, u32)> =
        pieces.iter().map(|piece| (piece.mass, piece.cell)).collect();
    let mut hulls: Vec<Hull> = pieces.into_iter().map(|piece| piece.hull).collect();
    weld_hulls(&mut hulls, SAME_VERTEX * workshop.size());

    // Principal frame and body of each piece.
    let mut fragments = Vec::with_capacity(hulls.len());
    for (hull, (mass, cell)) in hulls.into_iter().zip(masses) {
        let Ok(shape) = Shape::convex_with_mass(hull, &mass, parent.sample_spacing()) else {
            return Vec::new();
        };
        fragments.push(Fragment::new(parent, shape.cut_from(parent), cell));
    }

    // Nothing is lost, and nothing is there twice.
    let volume: f64 = fragments.iter().map(|fragment| fragment.shape.volume).sum();
    if (volume - parent.volume).abs() <= NOT_FILLED * parent.volume {
        fragments
    } else {
        Vec::new()
    }
}

/// Mass that a parent has absorbed is no part of its polyhedron: its heaviest piece gets it.
fn give_lump(pieces: &mut [Piece], parent: &Shape, hull: &Hull) {
    let Some(lump) = absorbed_by(parent, &hull.mass_properties()) else { return };
    let heaviest = pieces.iter_mut().max_by(|a, b| a.mass.volume.total_cmp(&b.mass.volume));
    if let Some(piece) = heaviest {
        piece.mass = lump.iter().fold(piece.mass, |mass, part| together(&mass, part));
    }
}

/// The mass that a parent has absorbed besides that of its polyhedra: all of its own, and theirs
/// taken from it.
pub(crate) fn absorbed_by(parent: &Shape, without: &MassProperties) -> Option<[MassProperties; 2]> {
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

/// The parent and its cuts, in its grid frame.
pub(crate) struct Workshop<'a> {
    /// Middle and half of the edges of the parent's bounding box, and the radius of the ball around
    /// its middle that holds the parent [m].
    middle: DVec3,
    half: DVec3,
    radius: f64,
    /// [m^3]
    volume: f64,
    cutter: CellCutter<'a>,
    /// Of all pieces.
    cuts: Vec<HalfSpace>,
    /// A region's planes that reach the parent, with the heights of its middle over them [m].
    reaching: Vec<(f64, HalfSpace)>,
}

impl<'a> Workshop<'a> {
    pub(crate) fn new(parent: &'a Hull, volume: f64) -> Self {
        let (low, high) = parent.bounds();
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let square = |vertex: &DVec3| vertex.distance_squared(middle);
        let radius = parent.vertices().iter().map(square).fold(0.0, f64::max).sqrt();
        let cutter = CellCutter::new(parent);
        // A few planes of each cell reach the parent.
        let (cuts, reaching) = (Vec::with_capacity(FEW * FEW), Vec::with_capacity(FEW));
        Self { middle, half, radius, volume, cutter, cuts, reaching }
    }

    /// The parent's longest side [m].
    fn size(&self) -> f64 {
        2.0 * self.half.max_element()
    }

    /// The part of the parent in a region of the pattern.
    pub(crate) fn cell(
        &mut self,
        placement: &Placement,
        region: &Region,
        cell: u32,
    ) -> Option<Piece> {
        cancel::check();
        // Keep planes that reach the parent, deepest first: later cuts then have less to do.
        self.reaching.clear();
        for cut in &region.cuts {
            let plane = placement.half_space(&cut.half_space);
            let height = plane.distance(self.middle);
            let reach = self.half.dot(plane.normal.abs()).min(self.radius);
            if height > reach {
                return None;
            }
            if height > -reach {
                self.reaching.push((height, plane));
            }
        }
        self.reaching.sort_by(|a, b| b.0.total_cmp(&a.0));
        let first = self.cuts.len();
        self.cuts.extend(self.reaching.iter().map(|&(_, plane)| plane));
        self.piece(first, cell)
    }

    /// The part of the parent inside of the last cuts, from `first` on.
    fn piece(&mut self, first: usize, cell: u32) -> Option<Piece> {
        let hull = self.cutter.part(&self.cuts[first..]);
        let piece = hull.map(|hull| (hull.mass_properties(), hull));
        let Some((mass, hull)) = piece.filter(|(mass, _)| mass.volume > NO_VOLUME * self.volume)
        else {
            self.cuts.truncate(first);
            return None;
        };
        Some(Piece { hull, cuts: first..self.cuts.len(), mass, cell })
    }

    /// Joins pieces that are too small with their neighbours.
    pub(crate) fn merge_slivers(
        &mut self,
        mut pieces: Vec<Piece>,
        smallest: &Smallest,
        absorbs: bool,
    ) -> Vec<Piece> {
        let volumes: Vec<f64> = pieces.iter().map(|piece| piece.mass.volume).collect();
        let least = smallest.least(&volumes);
        let is_small = |mass: &MassProperties| mass.volume < least || smallest.is_slender(mass);
        let too_small: Vec<bool> = pieces.iter().map(|piece| is_small(&piece.mass)).collect();
        if !too_small.contains(&true) {
            return pieces;
        }
        let hulls: Vec<&Hull> = pieces.iter().map(|piece| &piece.hull).collect();
        let contacts = contacts_of_some(&hulls, &too_small);
        let mut groups = Groups::new(&volumes, &too_small);

        // Merge slivers that are convex with a neighbour, then absorb negligible slivers.
        groups.join(&contacts, |sliver, host, _| {
            pieces[host] = self.join(&pieces[sliver], &pieces[host])?;
            Some(is_small(&pieces[host].mass))
        });
        let tiny = Smallest { part: smallest.part.min(Smallest::default().part), ..*smallest }
            .least(&volumes);
        let mut absorb = |sliver: usize, host: usize| {
            let own = pieces[sliver].mass;
            let is_absorbed = absorbs && (own.volume < tiny || smallest.is_slender(&own));
            pieces[host].mass = is_absorbed.then(|| together(&pieces[host].mass, &own))?;
            Some(is_small(&pieces[host].mass))
        };
        groups.join(&contacts, |sliver, host, _| absorb(sliver, host));
        groups.join_loose(|sliver, heaviest| absorb(sliver, heaviest).is_some());
        let of_piece = groups.of_piece();
        let stays = |(number, piece): (usize, Piece)| (of_piece[number] == number).then_some(piece);
        pieces.into_iter().enumerate().filter_map(stays).collect()
    }

    /// A sliver and a neighbour without the crack between them, if the two are convex: behind the
    /// largest face where that is so.
    fn join(&mut self, sliver: &Piece, other: &Piece) -> Option<Piece> {
        let Piece { hull, cuts, mass, .. } = sliver;
        let area = |face: &HullFace<'_>| {
            let corners = face.vertices.iter().map(|&vertex| hull.vertices()[vertex as usize]);
            polygon::area(&corners.collect::<Vec<_>>())
        };
        let inner = hull.faces().filter(|face| face.inner);
        let mut faces: Vec<(f64, HalfSpace)> =
            inner.map(|face| (area(&face), face.plane)).collect();
        faces.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, crack) in faces {
            let others = &self.cuts[other.cuts.clone()];
            if !others.iter().any(|cut| self.same(&cut.flipped(), &crack)) {
                continue;
            }
            // All planes but the crack bound the two, if each piece lies inside of the other's.
            let own = self.cuts[cuts.clone()].iter().filter(|&cut| !self.same(cut, &crack));
            let others = others.iter().filter(|&cut| !self.same(&cut.flipped(), &crack));
            let beyond = |cut: &HalfSpace, hull: &Hull| {
                hull.vertices().iter().any(|&vertex| cut.distance(vertex) > BEYOND * self.size())
            };
            if own.clone().any(|cut| beyond(cut, &other.hull))
                || others.clone().any(|cut| beyond(cut, hull))
            {
                continue;
            }
            let all: Vec<HalfSpace> = own.chain(others).copied().collect();
            let first = self.cuts.len();
            self.cuts.extend(all);
            let (sum, tolerance) = (mass.volume + other.mass.volume, SAME_VOLUME * self.volume);
            let joined = self.piece(first, other.cell);
            if let Some(joined) =
                joined.filter(|joined| (joined.mass.volume - sum).abs() <= tolerance)
            {
                return Some(joined);
            }
        }
        None
    }

    /// True if two half-spaces are equal to rounding.
    fn same(&self, a: &HalfSpace, b: &HalfSpace) -> bool {
        let apart = (a.distance(self.middle) - b.distance(self.middle)).abs();
        a.normal.distance_squared(b.normal) < SAME_VERTEX && apart < SAME_VERTEX * self.size()
    }
}
