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
use crate::piece::{Piece, give_absorbed, join_small};
use crate::placement::Placement;
use crate::polygon;
use crate::shatter::settings::ShatterSettings;
use crate::slivers::Smallest;
use frangible_geometry::weld_hulls;
use frangible_geometry::{CellCutter, HalfSpace, Hull, HullFace, MassProperties, Shape};
use frangible_math::cancel;
use glam::DVec3;
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

/// A polyhedron that was cut out of the parent.
pub(crate) struct CutHull {
    pub(crate) hull: Hull,
    /// The cuts of it, as a range in the workshop's list.
    cuts: Range<usize>,
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
    let mut pieces: Vec<Piece<CutHull>> = Vec::with_capacity(regions.len());
    let cells = regions.iter().zip(0..);
    pieces.extend(cells.filter_map(|(region, cell)| workshop.cell(&placement, region, cell)));
    let masses = pieces.iter_mut().map(|piece| &mut piece.mass);
    give_absorbed(masses, parent, &hull.mass_properties());
    let pieces = workshop.join_small(pieces, &settings.smallest, absorbs);

    // Neighbours share their vertices.
    let masses: Vec<(MassProperties, u32)> =
        pieces.iter().map(|piece| (piece.mass, piece.cell)).collect();
    let mut hulls: Vec<Hull> = pieces.into_iter().map(|piece| piece.form.hull).collect();
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
    ) -> Option<Piece<CutHull>> {
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
    fn piece(&mut self, first: usize, cell: u32) -> Option<Piece<CutHull>> {
        let hull = self.cutter.part(&self.cuts[first..]);
        let piece = hull.map(|hull| (hull.mass_properties(), hull));
        let Some((mass, hull)) = piece.filter(|(mass, _)| mass.volume > NO_VOLUME * self.volume)
        else {
            self.cuts.truncate(first);
            return None;
        };
        let form = CutHull { hull, cuts: first..self.cuts.len() };
        Some(Piece { form, mass, cell })
    }

    /// Joins pieces that are too small with their neighbours, if they are convex with them.
    pub(crate) fn join_small(
        &mut self,
        pieces: Vec<Piece<CutHull>>,
        smallest: &Smallest,
        absorbs: bool,
    ) -> Vec<Piece<CutHull>> {
        let contacts = |pieces: &[Piece<CutHull>], too_small: &[bool]| {
            let hulls: Vec<&Hull> = pieces.iter().map(|piece| &piece.form.hull).collect();
            contacts_of_some(&hulls, too_small)
        };
        join_small(pieces, (smallest, absorbs), contacts, |sliver, host| self.join(sliver, host))
    }

    /// A sliver and a neighbour without the crack between them, if the two are convex: behind the
    /// largest face where that is so.
    fn join(&mut self, sliver: &Piece<CutHull>, other: &Piece<CutHull>) -> Option<Piece<CutHull>> {
        let Piece { form: CutHull { hull, cuts }, mass, .. } = sliver;
        let area = |face: &HullFace<'_>| {
            let corners = face.vertices.iter().map(|&vertex| hull.vertices()[vertex as usize]);
            polygon::area(&corners.collect::<Vec<_>>())
        };
        let inner = hull.faces().filter(|face| face.inner);
        let mut faces: Vec<(f64, HalfSpace)> =
            inner.map(|face| (area(&face), face.plane)).collect();
        faces.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, crack) in faces {
            let others = &self.cuts[other.form.cuts.clone()];
            if !others.iter().any(|cut| self.same(&cut.flipped(), &crack)) {
                continue;
            }
            // All planes but the crack bound the two, if each piece lies inside of the other's.
            let own = self.cuts[cuts.clone()].iter().filter(|&cut| !self.same(cut, &crack));
            let others = others.iter().filter(|&cut| !self.same(&cut.flipped(), &crack));
            let beyond = |cut: &HalfSpace, hull: &Hull| {
                hull.vertices().iter().any(|&vertex| cut.distance(vertex) > BEYOND * self.size())
            };
            if own.clone().any(|cut| beyond(cut, &other.form.hull))
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
