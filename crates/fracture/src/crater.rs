//! Breaking a body of convex polyhedra within a reach: a crater, and a rest that stays whole.
//!
//! The crater comes loose in pieces, as all of a body does otherwise. The rest is not convex: it is
//! a compound of the parts that the crater's facets, or the pattern's cells, cut the body into, and
//! more than one if it is not connected. Everything is exact.

use crate::align::Impact;
use crate::fragment::Fragment;
use crate::interfaces::hulls;
use crate::pattern::Pattern;
use crate::piece::{Piece, give_absorbed, together};
use crate::placement::Placement;
use crate::reach::{Reach, Rim};
use crate::shatter::settings::ShatterSettings;
use crate::shatter_hull::{CutHull, NO_VOLUME, NOT_FILLED, SAME_VERTEX, Workshop};
use frangible_geometry::{
    CellCutter, Compound, Geometry, HalfSpace, Hull, MassProperties, Shape, weld_hulls,
};
use frangible_math::DisjointSets;
use glam::DVec3;

/// Parts of the rest below this fraction of the parent's volume are no parts of its compound: their
/// mass is.
const NO_PART: f64 = 1e-8;

/// A polyhedron cut out of the parent, in its grid frame.
struct Part {
    hull: Hull,
    mass: MassProperties,
    /// [`Fragment::REST`] for parts of the rest.
    cell: u32,
}

/// Breaks a body that is one convex polyhedron or several by a planar pattern, within a reach.
/// Empty if it is not, and if it is too thin for its length to be cut exactly.
pub(crate) fn shatter_within(
    parent: &Shape,
    pattern: &Pattern,
    impact: &Impact,
    (settings, reach): (&ShatterSettings, &Reach),
) -> Vec<Fragment> {
    let Some(hulls) = convex_parts(parent) else { return Vec::new() };
    let placement = Placement::with(pattern, impact, parent, settings);
    let mut parts: Vec<Part> = Vec::new();
    for hull in &hulls {
        let of_part = match reach.rim {
            Rim::Bowl => cut_bowl(hull, (pattern, &placement), (settings, reach)),
            Rim::Cells => cut_cells(hull, (pattern, &placement), settings),
        };
        parts.extend(of_part);
    }
    if reach.rim == Rim::Cells {
        keep_what_is_far(&mut parts, placement.point_grid, reach.distance);
    }
    if parts.iter().all(|part| part.cell == Fragment::REST) {
        return Vec::new();
    }
    let (low, high) = parent.bounds;
    let close = SAME_VERTEX * (high - low).max_element();
    let groups = group(parts, close, parent, settings);
    let fragments: Vec<Fragment> = fragments(parent, &hulls, groups);
    let volume: f64 = fragments.iter().map(|fragment| fragment.shape.volume).sum();
    if (volume - parent.volume).abs() <= NOT_FILLED * parent.volume {
        fragments
    } else {
        Vec::new()
    }
}

/// The polyhedra of a body in its grid frame.
pub(crate) fn convex_parts(body: &Shape) -> Option<Vec<Hull>> {
    match &body.geometry {
        Geometry::Compound(compound) => {
            Some(compound.parts().iter().map(|part| part.hull.clone()).collect())
        }
        _ => Some(vec![body.breaks_as()?.clone()]),
    }
}

/// Cuts the bowl out of a polyhedron and the bowl into cells; then the rest along the facets, one
/// after the other.
fn cut_bowl(
    hull: &Hull,
    (pattern, placement): (&Pattern, &Placement),
    (settings, reach): (&ShatterSettings, &Reach),
) -> Vec<Part> {
    let volume = hull.volume();
    let mut facets = reach.bowl(placement);
    // Those that cut most off come first: fewer parts are left for the others.
    let highest = |facet: &HalfSpace| {
        hull.vertices().iter().map(|&vertex| facet.distance(vertex)).fold(0.0, f64::max)
    };
    facets.sort_by(|a, b| highest(b).total_cmp(&highest(a)));
    facets.retain(|facet| highest(facet) > 0.0);
    let mut cutter = CellCutter::new(hull);
    let mut part =
        |cuts: &[HalfSpace]| cutter.part(cuts).filter(|part| part.volume() > NO_VOLUME * volume);
    let Some(core) = part(&facets) else {
        return vec![Part::rest(hull.clone())];
    };

    let mut parts = cut_cells(&core, (pattern, placement), settings);
    let mut cuts: Vec<HalfSpace> = Vec::with_capacity(facets.len());
    for facet in &facets {
        cuts.push(facet.flipped());
        parts.extend(part(&cuts).map(Part::rest));
        if let Some(last) = cuts.last_mut() {
            *last = *facet;
        }
    }
    parts
}

/// Cuts a polyhedron into the cells of a pattern.
fn cut_cells(
    hull: &Hull,
    (pattern, placement): (&Pattern, &Placement),
    settings: &ShatterSettings,
) -> Vec<Part> {
    let mut workshop = Workshop::new(hull, hull.volume());
    let regions = pattern.planar().unwrap_or_default().iter().zip(0..);
    let pieces: Vec<Piece<CutHull>> =
        regions.filter_map(|(region, cell)| workshop.cell(placement, region, cell)).collect();
    let pieces = workshop.join_small(pieces, &settings.smallest, true);
    let part = |Piece { form, mass, cell }: Piece<CutHull>| Part { hull: form.hull, mass, cell };
    pieces.into_iter().map(part).collect()
}

/// Cells with their centre farther than `reach` from the blow stay whole; the one that is struck
/// does not.
fn keep_what_is_far(parts: &mut [Part], point: DVec3, reach: f64) {
    let away = |part: &Part| part.hull.distance_and_gradient(point).0;
    let nearest = (0..parts.len()).min_by(|&a, &b| away(&parts[a]).total_cmp(&away(&parts[b])));
    for (index, part) in parts.iter_mut().enumerate() {
        if Some(index) != nearest && part.mass.center.distance(point) > reach {
            part.cell = Fragment::REST;
        }
    }
}

impl Part {
    fn rest(hull: Hull) -> Self {
        Self { mass: hull.mass_properties(), hull, cell: Fragment::REST }
    }
}

/// Parts that are one body: those of a cell, or of the rest, that touch. What is too small to be a
/// body goes to the heaviest of the rest.
fn group(
    mut parts: Vec<Part>,
    close: f64,
    parent: &Shape,
    settings: &ShatterSettings,
) -> Vec<Vec<Part>> {
    let cells: Vec<u32> = parts.iter().map(|part| part.cell).collect();
    let mut hulls: Vec<Hull> = parts.iter().map(|part| part.hull.clone()).collect();
    weld_hulls(&mut hulls, close);
    let mut sets = DisjointSets::new(parts.len());
    for contact in hulls::contacts(&hulls) {
        if cells[contact.a] == cells[contact.b] {
            sets.unite(contact.a as u32, contact.b as u32);
        }
    }
    for (part, hull) in parts.iter_mut().zip(hulls) {
        part.hull = hull;
    }
    let roots: Vec<u32> = (0..parts.len() as u32).map(|part| sets.root(part)).collect();
    let mut place = vec![usize::MAX; parts.len()];
    let mut groups: Vec<Vec<Part>> = Vec::new();
    for (part, root) in parts.into_iter().zip(roots) {
        let group = &mut place[root as usize];
        if *group == usize::MAX {
            *group = groups.len();
            groups.push(Vec::new());
        }
        groups[*group].push(part);
    }

    // Scraps of the rest stay with it.
    let volume = |group: &[Part]| group.iter().map(|part| part.mass.volume).sum::<f64>();
    let least = settings.smallest.volume.max(NO_PART * parent.volume);
    let is_rest = |group: &[Part]| group.iter().any(|part| part.cell == Fragment::REST);
    let heaviest = (0..groups.len())
        .filter(|&group| is_rest(&groups[group]))
        .max_by(|&a, &b| volume(&groups[a]).total_cmp(&volume(&groups[b])).then(b.cmp(&a)));
    if let Some(heaviest) = heaviest {
        for group in 0..groups.len() {
            if group != heaviest && volume(&groups[group]) < least {
                let scraps = std::mem::take(&mut groups[group]);
                groups[heaviest].extend(scraps);
            }
        }
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// The bodies of groups of parts. Mass that the parent has absorbed goes to the heaviest.
fn fragments(parent: &Shape, hulls: &[Hull], groups: Vec<Vec<Part>>) -> Vec<Fragment> {
    let sum = |masses: &mut dyn Iterator<Item = MassProperties>| {
        masses.reduce(|all, next| together(&all, &next))
    };
    let mut masses: Vec<MassProperties> =
        groups.iter().filter_map(|group| sum(&mut group.iter().map(|part| part.mass))).collect();
    let without = sum(&mut hulls.iter().map(Hull::mass_properties));
    if let Some(without) = without {
        give_absorbed(masses.iter_mut(), parent, &without);
    }

    let mut fragments = Vec::with_capacity(groups.len());
    for (group, mass) in groups.into_iter().zip(masses) {
        let cell = group.iter().map(|part| part.cell).max().unwrap_or(Fragment::REST);
        let largest = group.iter().map(|part| part.mass.volume).fold(0.0, f64::max);
        let is_part =
            |part: &Part| part.mass.volume >= largest || part.mass.volume > NO_PART * parent.volume;
        let mut own: Vec<Hull> = group.into_iter().filter(is_part).map(|part| part.hull).collect();
        let spacing = parent.sample_spacing();
        let shape = match (own.len(), own.pop()) {
            (1, Some(hull)) => Shape::convex_with_mass(hull, &mass, spacing),
            (_, last) => {
                own.extend(last);
                Shape::compound_with_mass(Compound::new(own), &mass, spacing)
            }
        };
        let Ok(shape) = shape else { return Vec::new() };
        fragments.push(Fragment::new(parent, shape.cut_from(parent), cell));
    }
    fragments
}
