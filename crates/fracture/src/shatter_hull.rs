//! Breaking a convex polyhedron by planes: exact, without a grid.
//!
//! Each cell of a planar pattern cuts its part out of the parent. Fragments are snug: neighbours share the vertices of their crack
//! bit for bit, and what was the parent's surface keeps its planes. Mass follows from the divergence theorem.

use crate::pattern::Region;
use crate::{Fragment, Impact, Pattern, Placement, ShatterSettings};
use frangible_geometry::hull::weld_hulls;
use frangible_geometry::{Carver, HalfSpace, Hull, Shape};
use glam::DVec3;

/// What has less of the parent's volume than this is round-off, not a piece.
const NO_VOLUME: f64 = 1e-13;

/// Two pieces may leave out the crack between them if the convex body without it is their union, up to so much of the parent's
/// volume.
const SAME_VOLUME: f64 = 1e-12;

/// Vertices of neighbours that are closer than this, relative to the parent's longest side, are one. Cuts in different orders move
/// them by some 1e-15.
const SAME_VERTEX: f64 = 1e-12;

/// Pieces of which so much of the parent's volume is missing, or is there twice, are none: a rod a thousand times as long as thick
/// cannot be cut lengthwise again and again in the precision that its length leaves.
const NOT_FILLED: f64 = 1e-10;

/// A part of the parent, on its way to a fragment.
struct Piece {
    hull: Hull,
    /// What cut it out of the parent.
    cuts: Vec<HalfSpace>,
    /// [m^3]
    volume: f64,
    /// Where it, or its larger part, comes from.
    cell: u32,
    /// Whether it is a sliver that fits to no neighbour.
    alone: bool,
}

/// Breaks a body that has a polyhedron ([`Shape::breaks_as`]) along a planar pattern that is laid onto the point of impact. The
/// fragments fill the parent, so that mass, and with [`fragment_velocity`](crate::fragment_velocity) momentum, angular momentum and
/// kinetic energy, are the parent's up to rounding.
///
/// A piece with less than the smallest part of the parent's volume joins a neighbour if the two without their crack are convex;
/// if they are with none, it stays as it is: it is exact however small. Empty if the body has no polyhedron or the pattern is not
/// planar, and if it is too thin for its length to be cut exactly.
pub fn shatter_hull(
    parent: &Shape,
    pattern: &Pattern,
    impact: &Impact,
    settings: &ShatterSettings,
) -> Vec<Fragment> {
    let (Some(hull), Some(regions)) = (parent.breaks_as(), pattern.planar()) else { return Vec::new() };
    let placement = Placement::new(pattern, impact, parent);

    // Cut each cell's part out.
    let mut workshop = Workshop::new(hull);
    let mut pieces: Vec<Piece> = regions
        .iter()
        .zip(0..)
        .filter_map(|(region, cell)| workshop.cell(&placement, region, cell))
        .collect();
    workshop.merge_slivers(&mut pieces, settings.smallest_fragment_part);
    let (mut hulls, cells): (Vec<Hull>, Vec<u32>) =
        pieces.into_iter().map(|piece| (piece.hull, piece.cell)).unzip();
    weld_hulls(&mut hulls, SAME_VERTEX * workshop.size());

    // Mass properties and principal frame.
    let fragment = |(hull, cell): (Hull, u32)| {
        let shape = Shape::convex(hull, parent.sample_spacing()).ok()?;
        Some(Fragment::new(parent, shape, cell))
    };
    let fragments: Option<Vec<Fragment>> = hulls.into_iter().zip(cells).map(fragment).collect();

    // Nothing is lost, and nothing is there twice.
    let fragments = fragments.unwrap_or_default();
    let volume: f64 = fragments.iter().map(|fragment| fragment.shape.volume).sum();
    if (volume - parent.volume).abs() <= NOT_FILLED * parent.volume { fragments } else { Vec::new() }
}

/// The parent and what cuts it, in its grid frame.
struct Workshop<'a> {
    /// Middle and half of the edges of the parent's bounding box [m].
    middle: DVec3,
    half: DVec3,
    /// [m^3]
    volume: f64,
    carver: Carver<'a>,
}

impl<'a> Workshop<'a> {
    fn new(parent: &'a Hull) -> Self {
        let (low, high) = parent.bounds();
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        Self { middle, half, volume: parent.volume(), carver: Carver::new(parent) }
    }

    /// The parent's longest side [m].
    fn size(&self) -> f64 {
        2.0 * self.half.max_element()
    }

    /// The part of the parent in a region of the pattern.
    fn cell(&mut self, placement: &Placement, region: &Region, cell: u32) -> Option<Piece> {
        // Only planes that reach the parent's box cut it; the deepest first, because the later ones then have less to do.
        let mut cuts: Vec<(f64, HalfSpace)> = Vec::with_capacity(region.cuts.len());
        for cut in &region.cuts {
            let plane = placement.half_space(&cut.half_space);
            let height = plane.distance(self.middle);
            let reach = self.half.dot(plane.normal.abs());
            if height > reach {
                return None;
            }
            if height > -reach {
                cuts.push((height, plane));
            }
        }
        cuts.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.piece(cuts.into_iter().map(|(_, cut)| cut).collect(), cell)
    }

    /// The part of the parent inside of all cuts.
    fn piece(&mut self, cuts: Vec<HalfSpace>, cell: u32) -> Option<Piece> {
        let hull = self.carver.part(&cuts)?;
        let volume = hull.volume();
        (volume > NO_VOLUME * self.volume).then_some(Piece { hull, cuts, volume, cell, alone: false })
    }

    /// Joins each piece of less than `smallest` of the parent's volume with a neighbour if the two are convex together, the
    /// lightest first, until each has grown up or stands alone.
    fn merge_slivers(&mut self, pieces: &mut Vec<Piece>, smallest: f64) {
        let least = smallest * self.volume;
        loop {
            let is_open = |piece: &Piece| piece.volume < least && !piece.alone;
            let lightest = (0..pieces.len())
                .filter(|&piece| is_open(&pieces[piece]))
                .min_by(|&a, &b| pieces[a].volume.total_cmp(&pieces[b].volume).then(a.cmp(&b)));
            let Some(sliver) = lightest else { return };
            match self.join(pieces, sliver) {
                Some((host, joined)) => {
                    pieces[host] = joined;
                    pieces.remove(sliver);
                }
                None => pieces[sliver].alone = true,
            }
        }
    }

    /// A neighbour of a sliver, and the two without the crack between them: behind the largest face of those where that is convex.
    fn join(&mut self, pieces: &[Piece], sliver: usize) -> Option<(usize, Piece)> {
        let Piece { hull, cuts, volume, .. } = &pieces[sliver];
        let mut faces: Vec<(f64, HalfSpace)> = hull
            .faces()
            .filter(|face| face.inner)
            .map(|face| (area(hull, face.vertices), face.plane))
            .collect();
        faces.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, crack) in faces {
            for (number, other) in pieces.iter().enumerate() {
                if number == sliver || !other.cuts.iter().any(|cut| self.same(&turned(cut), &crack)) {
                    continue;
                }
                let own = cuts.iter().filter(|&cut| !self.same(cut, &crack));
                let others = other.cuts.iter().filter(|&cut| !self.same(&turned(cut), &crack));
                let all = own.chain(others).copied().collect();
                let (sum, tolerance) = (volume + other.volume, SAME_VOLUME * self.volume);
                let joined = self.piece(all, other.cell);
                if let Some(joined) = joined.filter(|joined| (joined.volume - sum).abs() <= tolerance) {
                    return Some((number, joined));
                }
            }
        }
        None
    }

    /// Whether two planes, and the sides they look to, are the same but for rounding.
    fn same(&self, a: &HalfSpace, b: &HalfSpace) -> bool {
        let apart = (a.distance(self.middle) - b.distance(self.middle)).abs();
        a.normal.distance_squared(b.normal) < SAME_VERTEX && apart < SAME_VERTEX * self.size()
    }
}

/// The other side of a plane.
fn turned(half_space: &HalfSpace) -> HalfSpace {
    HalfSpace { normal: -half_space.normal, offset: -half_space.offset }
}

/// Of a face [m^2].
fn area(hull: &Hull, corners: &[u32]) -> f64 {
    let corner = |at: usize| hull.vertices()[corners[at] as usize];
    let origin = corner(0);
    let fan = (1..corners.len() - 1).map(|at| (corner(at) - origin).cross(corner(at + 1) - origin));
    0.5 * fan.sum::<DVec3>().length()
}
