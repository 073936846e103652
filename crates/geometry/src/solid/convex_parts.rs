//! A solid as nearly convex parts.

use super::Solid;
use super::elements::Edge;
use super::parts::SolidPart;
use super::quick_hull::QuickHull;
use crate::half_space::HalfSpace;
use glam::{DMat3, DVec3};

/// How many planes are compared, and how well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneSearch {
    /// For pieces: about 0.1 ms for each cut of a solid of 100 faces.
    Quick,
    /// For whole meshes: about 5 ms for each cut of a solid of 5,000 faces.
    Thorough,
}

/// The numbers of a search.
struct Effort {
    /// Planes are compared by about so many vertices, and as many places where they cut edges.
    samples: usize,
    /// So many of the concave edges are looked at.
    concave: usize,
    /// Planes go through so many of them.
    deepest: usize,
    /// The best so many planes are tried.
    tries: usize,
}

impl PlaneSearch {
    fn effort(self) -> Effort {
        match self {
            Self::Quick => Effort { samples: 32, concave: 64, deepest: 2, tries: 1 },
            Self::Thorough => Effort { samples: 400, concave: 400, deepest: 4, tries: 3 },
        }
    }
}

/// An edge is concave if its faces' normals turn by more (sine of the angle).
const CONCAVE: f64 = 0.02;
/// How much the hollow of the worse half counts beside both hulls: a cut through a ring leaves as
/// much hull as there was, and has to halve it.
const WORSE_HALF: f64 = 0.3;

/// A part with its hull's volume [m^3].
struct Hulled {
    part: SolidPart,
    hull: f64,
    /// No plane makes its hull less.
    is_final: bool,
}

impl Hulled {
    fn new(part: SolidPart, quick: &mut QuickHull) -> Self {
        let hull = quick.volume(part.solid.vertices());
        Self { part, hull, is_final: false }
    }

    fn hollow(&self) -> f64 {
        self.hull - self.part.mass.volume
    }
}

impl Solid {
    /// Parts between planes whose hulls exceed the solid's volume by at most `excess` (a ratio), or
    /// at most `most` parts that come near to that: the least convex part is cut again and again, by
    /// the plane that leaves the least hulls. The parts fill the solid, and no two hulls overlap.
    pub fn convex_parts(&self, most: usize, excess: f64, search: PlaneSearch) -> Vec<SolidPart> {
        let mut quick = QuickHull::default();
        let mass = self.mass_properties();
        let whole = SolidPart { solid: self.clone(), mass };
        let mut parts = vec![Hulled::new(whole, &mut quick)];
        while parts.len() < most {
            let hollow: f64 = parts.iter().map(Hulled::hollow).sum();
            if hollow <= excess * mass.volume {
                break;
            }
            let open = (0..parts.len()).filter(|&at| !parts[at].is_final);
            let worst = open.max_by(|&a, &b| parts[a].hollow().total_cmp(&parts[b].hollow()));
            let Some(worst) = worst else { break };
            let room = most - parts.len() + 1;
            match halved(&parts[worst], room, search, &mut quick) {
                Some(halves) => {
                    parts.splice(worst..=worst, halves);
                }
                None => parts[worst].is_final = true,
            }
        }
        parts.into_iter().map(|hulled| hulled.part).collect()
    }
}

/// The two sides of the best plane, each as one part or as `room` allows.
fn halved(
    whole: &Hulled,
    room: usize,
    search: PlaneSearch,
    quick: &mut QuickHull,
) -> Option<Vec<Hulled>> {
    let effort = search.effort();
    let solid = &whole.part.solid;
    let mut planes = candidates(whole, search, quick);
    let mut halves = Halves::new(solid, effort.samples);
    let mut scored: Vec<(f64, HalfSpace)> = planes
        .drain(..)
        .map(|plane| (halves.score(&plane, quick), plane))
        .filter(|(score, _)| score.is_finite())
        .collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<(f64, Vec<Hulled>)> = None;
    for (_, plane) in scored.iter().take(effort.tries) {
        let mut parts = Vec::new();
        for side in [*plane, plane.flipped()] {
            let mut own = solid.inside_of(&[side]);
            if own.len() > 1 && (parts.len() + own.len() > room - 1 || !are_apart(&own)) {
                own = vec![as_one(own)];
            }
            parts.extend(own.into_iter().map(|part| Hulled::new(part, quick)));
        }
        let score = parts.iter().map(|part| part.hull).sum::<f64>()
            + WORSE_HALF * parts.iter().map(Hulled::hollow).fold(0.0, f64::max);
        if parts.len() > 1 && best.as_ref().is_none_or(|(least, _)| score < *least) {
            best = Some((score, parts));
        }
    }
    best.map(|(_, parts)| parts)
}

/// Planes that may part a solid well: through its deepest concave edges, along both faces and
/// between them, and across its principal axes.
fn candidates(whole: &Hulled, search: PlaneSearch, quick: &mut QuickHull) -> Vec<HalfSpace> {
    let SolidPart { solid, mass } = &whole.part;
    let effort = search.effort();
    quick.volume(solid.vertices());
    let mut planes = Vec::new();
    let through = |normal: DVec3, point: DVec3| {
        let normal = normal.normalize_or_zero();
        (normal != DVec3::ZERO).then(|| HalfSpace { normal, offset: normal.dot(point) })
    };
    let (_, turn) = mass.principal_axes();
    let principal = DMat3::from_quat(turn);
    let axes = [principal.x_axis, principal.y_axis, principal.z_axis];
    planes.extend(axes.iter().filter_map(|&axis| through(axis, mass.center)));
    let mut deep = concave_edges(solid, quick, effort.concave);
    let mut chosen: Vec<DVec3> = Vec::new();
    while chosen.len() < effort.deepest {
        let away = |point: DVec3| {
            chosen.iter().map(|other| other.distance(point)).fold(f64::INFINITY, f64::min)
        };
        let worth = |edge: &DeepEdge| {
            if chosen.is_empty() { edge.depth } else { edge.depth * away(edge.middle) }
        };
        let next = (0..deep.len()).max_by(|&a, &b| worth(&deep[a]).total_cmp(&worth(&deep[b])));
        let Some(next) = next.filter(|&next| worth(&deep[next]) > 0.0) else { break };
        let DeepEdge { middle, normals: [first, second], .. } = deep.swap_remove(next);
        for normal in [first, second, first - second] {
            planes.extend(through(normal, middle));
        }
        if search == PlaneSearch::Thorough {
            planes.extend(axes.iter().filter_map(|&axis| through(axis, middle)));
            planes.extend(DVec3::AXES.iter().filter_map(|&axis| through(axis, middle)));
        }
        chosen.push(middle);
    }
    planes
}

/// A concave edge.
struct DeepEdge {
    /// Below the hull [m].
    depth: f64,
    middle: DVec3,
    normals: [DVec3; 2],
}

/// At most `most` of the concave edges, below the hull that `quick` has.
fn concave_edges(solid: &Solid, quick: &QuickHull, most: usize) -> Vec<DeepEdge> {
    let normal = |face: u32| solid.faces[face as usize].plane.normal;
    let concave = |edge: &&Edge| {
        let [a, b] = edge.ends.map(|end| solid.vertices[end as usize]);
        let [left, right] = edge.faces.map(normal);
        left.cross(b - a).dot(right) > CONCAVE * a.distance(b)
    };
    let edges: Vec<&Edge> = solid.edges.iter().filter(concave).collect();
    let stride = edges.len().div_ceil(most).max(1);
    let deep = |edge: &Edge| {
        let [a, b] = edge.ends.map(|end| solid.vertices[end as usize]);
        let middle = 0.5 * (a + b);
        let depths = quick.planes().map(|(normal, offset)| offset - normal.dot(middle));
        let depth = depths.fold(f64::INFINITY, f64::min);
        DeepEdge { depth, middle, normals: edge.faces.map(normal) }
    };
    edges.into_iter().step_by(stride).map(deep).collect()
}

/// What planes leave of a solid on both sides, by its vertices or some of them.
struct Halves<'a> {
    solid: &'a Solid,
    /// So many of them.
    samples: usize,
    heights: Vec<f64>,
    /// Of each side.
    points: [Vec<DVec3>; 2],
    section: Vec<DVec3>,
}

impl<'a> Halves<'a> {
    fn new(solid: &'a Solid, samples: usize) -> Self {
        Self {
            solid,
            samples,
            heights: Vec::new(),
            points: Default::default(),
            section: Vec::new(),
        }
    }

    /// The volume of both hulls, and a part of the larger one's.
    fn score(&mut self, plane: &HalfSpace, quick: &mut QuickHull) -> f64 {
        let Solid { vertices, edges, .. } = self.solid;
        self.heights.clear();
        self.heights.extend(vertices.iter().map(|&vertex| plane.distance(vertex)));
        self.points.iter_mut().for_each(Vec::clear);
        self.section.clear();
        let samples = self.samples;
        let stride = |count: usize| count.div_ceil(samples).max(1);
        for at in (0..vertices.len()).step_by(stride(vertices.len())) {
            self.points[usize::from(self.heights[at] > 0.0)].push(vertices[at]);
        }
        for edge in edges {
            let [a, b] = edge.ends.map(|end| self.heights[end as usize]);
            if a * b < 0.0 {
                let [from, to] = edge.ends.map(|end| vertices[end as usize]);
                self.section.push(from + (to - from) * (a / (a - b)));
            }
        }
        let sections = self.section.iter().step_by(stride(self.section.len()));
        for points in &mut self.points {
            points.extend(sections.clone());
        }
        if self.points.iter().any(|points| points.len() < 4) {
            return f64::INFINITY;
        }
        let [below, above] = [0, 1].map(|side| quick.volume(&self.points[side]));
        if below.min(above) <= 0.0 {
            return f64::INFINITY;
        }
        below + above + WORSE_HALF * below.max(above)
    }
}

/// True if planes across the axes, or between their centres, part all of them.
fn are_apart(parts: &[SolidPart]) -> bool {
    let span = |part: &SolidPart, normal: DVec3| {
        let heights = part.solid.vertices().iter().map(|&vertex| normal.dot(vertex));
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| {
            (low.min(height), high.max(height))
        })
    };
    (1..parts.len()).all(|at| {
        parts[..at].iter().all(|other| {
            let between = parts[at].mass.center - other.mass.center;
            [DVec3::X, DVec3::Y, DVec3::Z, between].into_iter().any(|normal| {
                let (own, theirs) = (span(&parts[at], normal), span(other, normal));
                own.0 >= theirs.1 || theirs.0 >= own.1
            })
        })
    })
}

/// Several solids as one.
fn as_one(parts: Vec<SolidPart>) -> SolidPart {
    let solids = parts.into_iter().map(|part| part.solid);
    let solid = solids.reduce(Solid::beside).unwrap_or_default();
    SolidPart { mass: solid.mass_properties(), solid }
}
