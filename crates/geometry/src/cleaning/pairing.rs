//! Which triangles meet at which edges.

use crate::bvh::Bvh;
use crate::mesh::TriMesh;
use frangible_math::DisjointSets;
use glam::DVec3;

/// No partner.
pub(super) const NONE: u32 = u32::MAX;

/// Angles around an edge that differ by less are the same [rad].
const SAME_ANGLE: f64 = 1e-5;

/// The same, while copies of the triangles may be nearby.
const FOLDED: f64 = 1e-3;

/// The half-edges that may be paired.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// Two triangles, by the vertices of the file.
    File,
    /// Any number, while there may be others nearby.
    Near,
    /// Any number.
    Last,
}

/// Triangles paired at their edges. The half-edge `3 t + k` runs from corner `k` of triangle `t`
/// to the next one.
pub(super) struct Pairing {
    pub(super) mesh: TriMesh,
    /// Representative of each vertex's welded group.
    pub(super) place: Vec<u32>,
    /// For each half-edge the one of the neighbour, or [`NONE`].
    pub(super) partner: Vec<u32>,
    /// Dropped triangles: repeated, or with two corners in one place.
    pub(super) dropped: Vec<bool>,
}

/// An unpaired half-edge: its two vertices, the lower first, its index, and true if it runs from
/// the higher to the lower vertex.
type Open = (u32, u32, u32, bool);

impl Pairing {
    /// Pairs what meets by the mesh's own vertices, then what lies at the same place, then what is
    /// closer than each of the `tolerances` [m]; each time only edges that are still open.
    pub(super) fn new(mesh: TriMesh, tolerances: &[f64]) -> Self {
        let place = (0..mesh.positions.len() as u32).collect();
        let partner = vec![NONE; 3 * mesh.triangles.len()];
        let dropped = vec![false; mesh.triangles.len()];
        let mut pairing = Self { mesh, place, partner, dropped };
        pairing.drop_collapsed();
        pairing.drop_repeated();
        pairing.pair_open(Stage::File);
        for (step, &tolerance) in std::iter::once(&0.0).chain(tolerances).enumerate() {
            let open = pairing.open_places();
            if open.is_empty() {
                return pairing;
            }
            let welded = if step == 0 {
                pairing.weld_equal(&open)
            } else {
                pairing.weld_near(&open, tolerance)
            };
            if welded {
                pairing.drop_collapsed();
                pairing.drop_repeated();
            }
            if welded || step == 0 {
                pairing.pair_open(Stage::Near);
            }
        }
        pairing.pair_open(Stage::Last);
        pairing
    }

    /// The places that a half-edge joins, from and to.
    pub(super) fn ends(&self, half_edge: u32) -> [u32; 2] {
        let (triangle, corner) = (half_edge as usize / 3, half_edge as usize % 3);
        let corners = self.mesh.triangles[triangle];
        [corners[corner], corners[(corner + 1) % 3]].map(|vertex| self.place[vertex as usize])
    }

    /// The half-edges without a partner, of triangles that are not dropped.
    pub(super) fn open(&self) -> impl Iterator<Item = u32> + '_ {
        let half_edges = 0..self.partner.len() as u32;
        half_edges.filter(|&h| self.partner[h as usize] == NONE && !self.dropped[h as usize / 3])
    }

    /// The places at the ends of open half-edges.
    pub(super) fn open_places(&self) -> Vec<u32> {
        let mut places: Vec<u32> = self.open().flat_map(|half_edge| self.ends(half_edge)).collect();
        places.sort_unstable();
        places.dedup();
        places
    }

    /// Welds open places with equal positions.
    fn weld_equal(&mut self, open: &[u32]) -> bool {
        let key = |place: u32| {
            (self.mesh.positions[place as usize] + DVec3::ZERO).to_array().map(f64::to_bits)
        };
        let mut order = open.to_vec();
        order.sort_unstable_by_key(|&place| (key(place), place));
        let mut sets = DisjointSets::new(self.mesh.positions.len());
        let mut welded = false;
        for same in order.chunk_by(|&a, &b| key(a) == key(b)).filter(|same| same.len() > 1) {
            same.iter().for_each(|&place| sets.unite(same[0], place));
            welded = true;
        }
        self.weld(&mut sets, welded)
    }

    /// Welds open places that are no farther apart than `tolerance` [m].
    fn weld_near(&mut self, open: &[u32], tolerance: f64) -> bool {
        let points: Vec<DVec3> =
            open.iter().map(|&place| self.mesh.positions[place as usize]).collect();
        let boxes: Vec<_> =
            points.iter().map(|&point| (point - tolerance, point + tolerance)).collect();
        let tree = Bvh::of_boxes(&boxes);
        let mut sets = DisjointSets::new(self.mesh.positions.len());
        let mut welded = false;
        for (number, &point) in points.iter().enumerate() {
            let enters =
                |low: DVec3, high: DVec3| point.cmpge(low).all() && point.cmple(high).all();
            tree.visit(enters, |other| {
                if other < number && points[other].distance(point) <= tolerance {
                    sets.unite(open[other], open[number]);
                    welded = true;
                }
            });
        }
        self.weld(&mut sets, welded)
    }

    fn weld(&mut self, sets: &mut DisjointSets, welded: bool) -> bool {
        if welded {
            self.place.iter_mut().for_each(|place| *place = sets.root(*place));
        }
        welded
    }

    /// Drops triangles with two corners in one place, and unpairs their partners.
    fn drop_collapsed(&mut self) {
        for triangle in 0..self.mesh.triangles.len() {
            let [a, b, c] = self.mesh.triangles[triangle].map(|vertex| self.place[vertex as usize]);
            if self.dropped[triangle] || (a != b && b != c && c != a) {
                continue;
            }
            self.dropped[triangle] = true;
            for half_edge in 3 * triangle..3 * triangle + 3 {
                self.unpair(half_edge as u32);
            }
        }
    }

    pub(super) fn pair(&mut self, a: u32, b: u32) {
        self.partner[a as usize] = b;
        self.partner[b as usize] = a;
    }

    pub(super) fn unpair(&mut self, half_edge: u32) {
        let partner = std::mem::replace(&mut self.partner[half_edge as usize], NONE);
        if partner != NONE {
            self.partner[partner as usize] = NONE;
        }
    }

    /// Drops open triangles that have the places of another one in the same sense of rotation.
    fn drop_repeated(&mut self) {
        let mut keys: Vec<([u32; 3], bool, u32)> = Vec::new();
        for (triangle, corners) in self.mesh.triangles.iter().enumerate() {
            let half_edges = 3 * triangle..3 * triangle + 3;
            let is_open = self.partner[half_edges].contains(&NONE);
            if !self.dropped[triangle] {
                let mut places = corners.map(|vertex| self.place[vertex as usize]);
                let lowest = (0..3).min_by_key(|&corner| places[corner]).unwrap_or(0);
                places.rotate_left(lowest);
                keys.push((places, is_open, triangle as u32));
            }
        }
        keys.sort_unstable();
        for same in keys.chunk_by(|a, b| a.0 == b.0) {
            for &(_, _, triangle) in same[1..].iter().filter(|&&(_, is_open, _)| is_open) {
                self.dropped[triangle as usize] = true;
                (3 * triangle..3 * triangle + 3).for_each(|half_edge| self.unpair(half_edge));
            }
        }
    }

    /// Pairs open half-edges between the same places.
    fn pair_open(&mut self, stage: Stage) {
        let mut open: Vec<Open> = self
            .open()
            .map(|half_edge| {
                let [from, to] = self.ends(half_edge);
                (from.min(to), from.max(to), half_edge, from > to)
            })
            .collect();
        open.sort_unstable();

        // Triangles with an edge that nothing meets are loose.
        let mut loose = vec![false; self.mesh.triangles.len()];
        let edges = || open.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
        edges()
            .filter(|edge| edge.len() == 1)
            .for_each(|edge| loose[edge[0].2 as usize / 3] = true);
        for edge in edges() {
            match edge {
                [_] => {}
                [a, b] => {
                    let least = if stage == Stage::Near { FOLDED } else { SAME_ANGLE };
                    if !self.folded(a.2, b.2, least) {
                        self.pair(a.2, b.2);
                    }
                }
                _ if stage == Stage::File => {}
                _ => {
                    let ordered = self.by_angle(edge);
                    let is_loose = |&(half_edge, _): &(u32, bool)| loose[half_edge as usize / 3];
                    let (rest, firm): (Vec<_>, Vec<_>) =
                        ordered.iter().copied().partition(is_loose);
                    if firm.len() >= 2 && firm.len().is_multiple_of(2) {
                        self.pair_around(&firm);
                        self.pair_around(&rest);
                    } else {
                        self.pair_around(&ordered);
                    }
                }
            }
        }
    }

    /// True if the triangles of two half-edges at the same edge lie on one another, with an angle
    /// below `least` [rad]: two sides of a sheet, or one triangle twice. Those of one part are
    /// joined like the rim of a hole.
    fn folded(&self, a: u32, b: u32, least: f64) -> bool {
        let at = |place: u32| self.mesh.positions[place as usize];
        let [from, to] = self.ends(a).map(at);
        let axis = (to - from).normalize_or_zero();
        let [a, b] = [a, b].map(|half_edge| {
            let way = at(self.apex(half_edge)) - from;
            (way - way.dot(axis) * axis).normalize_or_zero()
        });
        a.dot(b) > 0.0 && a.cross(b).length() < least
    }

    /// The place across from a half-edge.
    fn apex(&self, half_edge: u32) -> u32 {
        let (triangle, corner) = (half_edge as usize / 3, half_edge as usize % 3);
        self.place[self.mesh.triangles[triangle][(corner + 2) % 3] as usize]
    }

    /// Pairs triangles around an edge by angle: first each two with a solid between them by
    /// orientation, then the remaining ones in sequence.
    fn pair_around(&mut self, ordered: &[(u32, bool)]) {
        let mut opened: Vec<u32> = Vec::new();
        for &(half_edge, backward) in ordered.iter().chain(ordered) {
            if self.partner[half_edge as usize] != NONE {
                continue;
            }
            if backward {
                if !opened.contains(&half_edge) {
                    opened.push(half_edge);
                }
            } else if let Some(opening) = opened.pop() {
                self.pair(opening, half_edge);
            }
        }
        let is_free = |&(half_edge, _): &(u32, bool)| {
            (self.partner[half_edge as usize] == NONE).then_some(half_edge)
        };
        let left: Vec<u32> = ordered.iter().filter_map(is_free).collect();
        if left.len().is_multiple_of(2) {
            for two in left.chunks_exact(2) {
                if !self.folded(two[0], two[1], SAME_ANGLE) {
                    self.pair(two[0], two[1]);
                }
            }
        }
    }

    /// Half-edges at an edge by the angle of their triangles, starting at a gap. At equal angles a
    /// solid's end comes before a solid's begin.
    fn by_angle(&self, edge: &[Open]) -> Vec<(u32, bool)> {
        let at = |place: u32| self.mesh.positions[place as usize];
        let (from, to) = (at(edge[0].0), at(edge[0].1));
        let axis = (to - from).normalize_or(DVec3::X);
        let (u, v) = axis.any_orthonormal_pair();
        let mut by_angle: Vec<(f64, bool, u32)> = edge
            .iter()
            .map(|&(_, _, half_edge, backward)| {
                let way = at(self.apex(half_edge)) - from;
                (libm::atan2(way.dot(v), way.dot(u)), backward, half_edge)
            })
            .collect();
        by_angle.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));

        // Begin after the widest gap, so that no two at the same angle are at both ends.
        let count = by_angle.len();
        let turn = 2.0 * std::f64::consts::PI;
        let gap = |n: usize| {
            let before = by_angle[(n + count - 1) % count].0 - if n == 0 { turn } else { 0.0 };
            by_angle[n].0 - before
        };
        let first = (0..count).max_by(|&a, &b| gap(a).total_cmp(&gap(b))).unwrap_or(0);
        by_angle.rotate_left(first);
        let mut ordered = Vec::with_capacity(count);
        for same in by_angle.chunk_by(|a, b| (b.0 - a.0).abs() < SAME_ANGLE) {
            for wanted in [false, true] {
                let those = same.iter().filter(|&&(_, backward, _)| backward == wanted);
                ordered.extend(those.map(|&(_, backward, half_edge)| (half_edge, backward)));
            }
        }
        ordered
    }

    /// Which triangles are to be turned so that neighbours agree, and for each triangle the lowest
    /// one of its connected part. Of a part the smaller area is turned. Opens edges where no turn
    /// makes neighbours agree.
    pub(super) fn agree(&mut self) -> (Vec<bool>, Vec<u32>) {
        let count = self.mesh.triangles.len();
        let mut turned = vec![false; count];
        let mut part = vec![NONE; count];
        let mut waiting = Vec::new();
        for first in 0..count {
            if self.dropped[first] || part[first] != NONE {
                continue;
            }
            part[first] = first as u32;
            let mut reached = vec![first];
            waiting.push(first);
            while let Some(triangle) = waiting.pop() {
                for half_edge in 3 * triangle as u32..3 * triangle as u32 + 3 {
                    let partner = self.partner[half_edge as usize];
                    if partner == NONE {
                        continue;
                    }
                    let neighbour = partner as usize / 3;
                    let against = self.ends(half_edge)[0] != self.ends(partner)[0];
                    let wanted = turned[triangle] ^ !against;
                    if part[neighbour] == NONE {
                        part[neighbour] = first as u32;
                        turned[neighbour] = wanted;
                        reached.push(neighbour);
                        waiting.push(neighbour);
                    } else if turned[neighbour] != wanted {
                        self.unpair(half_edge);
                    }
                }
            }
            let area = |want: bool| {
                let those = reached.iter().filter(|&&triangle| turned[triangle] == want);
                those.map(|&triangle| self.mesh.vector_area(triangle).length()).sum::<f64>()
            };
            if area(true) > area(false) {
                reached.iter().for_each(|&triangle| turned[triangle] ^= true);
            }
        }
        (turned, part)
    }
}
