//! Two parts of a solid as one again, without the crack between them.

use super::Solid;
use super::clip::Loose;
use super::elements::{Edge, FaceOrigin, NONE};
use super::parts::connected_parts;
use frangible_math::DisjointSets;
use glam::{DVec2, DVec3};

/// The volume of both may change by this part.
const SAME_VOLUME: f64 = 1e-12;

/// Faces lean less against each other if they are one (sine of the angle).
const SAME_PLANE: f64 = 1e-9;

/// The sides of cracks that lie on each other: from a vertex to another one, and its edge.
type Side = (u32, u32, usize);

impl Solid {
    /// This solid and another one, which the same planes have parted, as one: where cracks of both
    /// lie on each other, they go. Vertices of these cracks that are within `close` [m] become one,
    /// and split the edges that they lie on. `None` if they do not lie on each other, or if the
    /// result is not one closed solid of the same volume.
    pub fn joined(&self, other: &Self, close: f64) -> Option<Self> {
        let volume = self.mass_properties().volume + other.mass_properties().volume;
        let own_faces = self.faces.len() as u32;
        let both = self.clone().beside(other.clone());
        let cracks = facing_cracks(&both, own_faces, close);
        if cracks.is_empty() {
            return None;
        }
        let mut seam = Seam { solid: both, is_on_it: Vec::new(), close };
        for [own, theirs] in &cracks {
            seam.relabel(own);
            seam.relabel(theirs);
        }
        let cracks: Vec<[u32; 2]> = cracks.iter().map(|faces| [faces[0][0], faces[1][0]]).collect();
        seam.weld(&cracks);
        for &faces in &cracks {
            seam.split_edges(faces);
        }
        for &faces in &cracks {
            seam.cancel(faces);
        }
        seam.merge_cracks();
        seam.straighten();
        let Self { vertices, edges, faces, .. } = seam.solid;
        let least = 0.1 * SAME_VOLUME * volume;
        let face_of = |number: u32| faces[number as usize];
        let mut parts = connected_parts(Loose { vertices, edges }, least, face_of);
        let part = parts.pop().filter(|_| parts.is_empty())?;
        // And what rounding of coordinates makes of it.
        let (low, high) = part.solid.bounds();
        let reach = low.abs().max(high.abs()).max_element();
        let size = (high - low).max_element();
        let allowed = SAME_VOLUME * volume + 4.0 * f64::EPSILON * reach * size * size;
        let is_same = (part.mass.volume - volume).abs() <= allowed;
        (is_same && part.solid.is_closed()).then_some(part.solid)
    }
}

/// Cracks of the first faces and cracks of the others that lie on each other, plane by plane.
fn facing_cracks(solid: &Solid, own_faces: u32, close: f64) -> Vec<[Vec<u32>; 2]> {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut bounds = vec![none; solid.faces.len()];
    for edge in &solid.edges {
        for face in edge.faces {
            let bounds = &mut bounds[face as usize];
            for vertex in edge.ends.map(|end| solid.vertices[end as usize]) {
                *bounds = (bounds.0.min(vertex - close), bounds.1.max(vertex + close));
            }
        }
    }
    let is_crack = |&face: &u32| solid.faces[face as usize].origin == FaceOrigin::Crack;
    let count = solid.faces.len() as u32;
    let mut sets = DisjointSets::new(solid.faces.len());
    let mut is_facing = vec![false; solid.faces.len()];
    for own in (0..own_faces).filter(is_crack) {
        for theirs in (own_faces..count).filter(is_crack) {
            let ((low, high), beside) = (bounds[own as usize], bounds[theirs as usize]);
            let [first, second] = [own, theirs].map(|face| solid.faces[face as usize].plane);
            let meet = low.cmple(beside.1).all() && beside.0.cmple(high).all();
            let middle = 0.5 * (low.max(beside.0) + high.min(beside.1));
            let lean = (first.normal + second.normal).length();
            // Where their boxes meet, their planes are the same.
            let apart = first.distance(middle) + second.distance(middle);
            if meet && lean < SAME_PLANE && apart.abs() <= close {
                sets.unite(own, theirs);
                is_facing[own as usize] = true;
                is_facing[theirs as usize] = true;
            }
        }
    }
    let mut cracks: Vec<[Vec<u32>; 2]> = Vec::new();
    let mut number = vec![NONE; solid.faces.len()];
    for face in (0..count).filter(|&face| is_facing[face as usize]) {
        let number = &mut number[sets.root(face) as usize];
        if *number == NONE {
            *number = cracks.len() as u32;
            cracks.push(Default::default());
        }
        cracks[*number as usize][usize::from(face >= own_faces)].push(face);
    }
    cracks
}

/// Both solids on their way to one.
struct Seam {
    solid: Solid,
    /// True for vertices of cracks that go.
    is_on_it: Vec<bool>,
    /// [m]
    close: f64,
}

impl Seam {
    fn at(&self, vertex: u32) -> DVec3 {
        self.solid.vertices[vertex as usize]
    }

    /// Makes one face of several.
    fn relabel(&mut self, faces: &[u32]) {
        for face in self.solid.edges.iter_mut().flat_map(|edge| &mut edge.faces) {
            if faces.contains(face) {
                *face = faces[0];
            }
        }
        self.solid.edges.retain(|edge| edge.faces[0] != edge.faces[1]);
    }

    /// The sides of a face.
    fn sides(&self, face: u32) -> Vec<Side> {
        let mut sides = Vec::new();
        for (index, &Edge { ends: [a, b], faces }) in self.solid.edges.iter().enumerate() {
            for (own, (from, to)) in faces.into_iter().zip([(a, b), (b, a)]) {
                if own == face {
                    sides.push((from, to, index));
                }
            }
        }
        sides
    }

    /// Makes one vertex of those of cracks at one place.
    fn weld(&mut self, cracks: &[[u32; 2]]) {
        self.is_on_it = vec![false; self.solid.vertices.len()];
        for edge in &self.solid.edges {
            if edge.faces.iter().any(|face| cracks.iter().any(|faces| faces.contains(face))) {
                edge.ends.iter().for_each(|&end| self.is_on_it[end as usize] = true);
            }
        }
        let mut on_it: Vec<u32> =
            (0..self.is_on_it.len() as u32).filter(|&at| self.is_on_it[at as usize]).collect();
        on_it.sort_by(|&a, &b| self.at(a).x.total_cmp(&self.at(b).x).then(a.cmp(&b)));
        let mut sets = DisjointSets::new(self.solid.vertices.len());
        for (at, &vertex) in on_it.iter().enumerate() {
            let place = self.at(vertex);
            let near = |other: &&u32| self.at(**other).x - place.x <= self.close;
            for &other in on_it[at + 1..].iter().take_while(near) {
                if self.at(other).distance(place) <= self.close {
                    sets.unite(vertex, other);
                }
            }
        }
        for end in self.solid.edges.iter_mut().flat_map(|edge| &mut edge.ends) {
            *end = sets.root(*end);
        }
        self.solid.edges.retain(|edge| edge.ends[0] != edge.ends[1]);
    }

    /// Splits the edges of two cracks at each other's vertices, and where they cross.
    fn split_edges(&mut self, faces: [u32; 2]) {
        let [own, theirs] = faces.map(|face| self.sides(face));
        let normal = self.solid.faces[faces[0] as usize].plane.normal;
        // Of an edge, in parts of it.
        let mut splits: Vec<(usize, f64, u32)> = Vec::new();
        for (sides, others) in [(&own, &theirs), (&theirs, &own)] {
            for &(from, to, edge) in sides {
                for &(vertex, ..) in others {
                    if let Some(part) = self.part_along(from, to, self.at(vertex)) {
                        splits.push((edge, part, vertex));
                    }
                }
            }
        }
        for &(from, to, edge) in &own {
            for &(start, end, other) in &theirs {
                let Some(place) = self.crossing([from, to], [start, end], normal) else { continue };
                let vertex = self.solid.vertices.len() as u32;
                let parts = [self.part_along(from, to, place), self.part_along(start, end, place)];
                if let [Some(first), Some(second)] = parts {
                    self.solid.vertices.push(place);
                    self.is_on_it.push(true);
                    splits.extend([(edge, first, vertex), (other, second, vertex)]);
                }
            }
        }
        // Parts along a side are counted from its edge's first vertex.
        for (edge, part, vertex) in &mut splits {
            let [a, b] = self.solid.edges[*edge].ends.map(|end| self.at(end));
            *part = (self.at(*vertex) - a).dot(b - a);
        }
        splits.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        splits.dedup_by_key(|split| (split.0, split.2));
        for of_edge in splits.chunk_by(|a, b| a.0 == b.0) {
            let Edge { ends: [mut last, end], faces } = self.solid.edges[of_edge[0].0];
            for &(_, _, vertex) in of_edge {
                self.solid.edges.push(Edge { ends: [last, vertex], faces });
                last = vertex;
            }
            self.solid.edges[of_edge[0].0] = Edge { ends: [last, end], faces };
        }
    }

    /// How far along a side a place lies on it, if it does and is not one of its ends.
    fn part_along(&self, from: u32, to: u32, place: DVec3) -> Option<f64> {
        let (a, b) = (self.at(from), self.at(to));
        let part = (place - a).dot(b - a) / a.distance_squared(b);
        let is_on_it = part > 0.0
            && part < 1.0
            && place.distance(a.lerp(b, part)) <= self.close
            && place.distance(a).min(place.distance(b)) > self.close;
        is_on_it.then_some(part)
    }

    fn crossing(&self, first: [u32; 2], second: [u32; 2], normal: DVec3) -> Option<DVec3> {
        if first.iter().any(|end| second.contains(end)) {
            return None;
        }
        let ([a, b], [c, d]) = (first.map(|end| self.at(end)), second.map(|end| self.at(end)));
        let side = |from: DVec3, to: DVec3, point: DVec3| {
            (to - from).cross(point - from).dot(normal) / from.distance(to)
        };
        let (of_c, of_d) = (side(a, b, c), side(a, b, d));
        let (of_a, of_b) = (side(c, d, a), side(c, d, b));
        let is_apart = [of_a, of_b, of_c, of_d].iter().all(|side| side.abs() > self.close);
        let crosses = is_apart && of_c * of_d < 0.0 && of_a * of_b < 0.0;
        crosses.then(|| a.lerp(b, of_a / (of_a - of_b)))
    }

    /// Takes away two cracks where they lie on each other. What one has beyond the other stays.
    fn cancel(&mut self, [own, theirs]: [u32; 2]) {
        let sides = [own, theirs].map(|face| self.sides(face));
        let mut opposite = sides[1].clone();
        opposite.sort_unstable();
        let mut is_gone = vec![false; self.solid.edges.len()];
        for &(from, to, edge) in &sides[0] {
            let at = opposite.partition_point(|&(a, b, _)| (a, b) < (to, from));
            let beside = opposite[at..].iter().take_while(|side| (side.0, side.1) == (to, from));
            let free = |side: &&Side| !is_gone[side.2] && side.2 != edge;
            let Some(&(.., other)) = beside.into_iter().find(free) else { continue };
            let beyond = |edge: usize, face: u32| {
                let [first, second] = self.solid.edges[edge].faces;
                if first == face { second } else { first }
            };
            // The other solid's face goes the crack's way, this one's comes back.
            let faces = [beyond(other, theirs), beyond(edge, own)];
            self.solid.edges[edge] = Edge { ends: [from, to], faces };
            is_gone[other] = true;
            is_gone[edge] = faces[0] == faces[1];
        }
        self.share_out([own, theirs], &sides, &is_gone);
        let mut index = 0;
        self.solid.edges.retain(|_| {
            index += 1;
            !is_gone[index - 1]
        });
    }

    /// The sides that are left of a crack but lie within the other one are sides of what that has
    /// beyond the first.
    fn share_out(&mut self, faces: [u32; 2], sides: &[Vec<Side>; 2], is_gone: &[bool]) {
        let (u, v) = self.solid.faces[faces[0] as usize].plane.normal.any_orthonormal_pair();
        let flat = |vertex: u32| DVec2::new(u.dot(self.at(vertex)), v.dot(self.at(vertex)));
        let mut changes = Vec::new();
        for (slot, own) in sides.iter().enumerate() {
            let around = &sides[1 - slot];
            for &(from, to, edge) in own {
                let is_left = !is_gone[edge] && self.solid.edges[edge].faces.contains(&faces[slot]);
                let is_shared = |side: &Side| (side.0, side.1) == (from, to);
                if !is_left || around.iter().any(is_shared) {
                    continue;
                }
                let point = 0.5 * (flat(from) + flat(to));
                let crosses = |&&(a, b, _): &&Side| {
                    let (a, b) = (flat(a), flat(b));
                    (a.y > point.y) != (b.y > point.y)
                        && (point.x - a.x) < (b.x - a.x) * (point.y - a.y) / (b.y - a.y)
                };
                if around.iter().filter(crosses).count() % 2 == 1 {
                    changes.push((edge, faces[slot], faces[1 - slot]));
                }
            }
        }
        for (edge, before, after) in changes {
            let faces = &mut self.solid.edges[edge].faces;
            faces.iter_mut().filter(|face| **face == before).for_each(|face| *face = after);
        }
    }

    /// Makes one crack of two in one plane that meet where the crack between them was.
    fn merge_cracks(&mut self) {
        let Solid { edges, faces, .. } = &mut self.solid;
        let mut sets = DisjointSets::new(faces.len());
        for edge in edges.iter() {
            let [first, second] = edge.faces.map(|face| faces[face as usize]);
            let are_cracks = [first, second].iter().all(|face| face.origin == FaceOrigin::Crack);
            let lean = (first.plane.normal - second.plane.normal).length();
            let is_on_it = edge.ends.iter().all(|&end| self.is_on_it[end as usize]);
            if are_cracks && is_on_it && lean < SAME_PLANE {
                sets.unite(edge.faces[0], edge.faces[1]);
            }
        }
        for face in edges.iter_mut().flat_map(|edge| &mut edge.faces) {
            *face = sets.root(*face);
        }
        edges.retain(|edge| edge.faces[0] != edge.faces[1]);
    }

    /// Takes away vertices of the former cracks that lie between two faces in a straight edge.
    fn straighten(&mut self) {
        let mut edges_at: Vec<Vec<usize>> = vec![Vec::new(); self.solid.vertices.len()];
        for (index, edge) in self.solid.edges.iter().enumerate() {
            edge.ends.iter().for_each(|&end| edges_at[end as usize].push(index));
        }
        let mut is_gone = vec![false; self.solid.edges.len()];
        for vertex in 0..edges_at.len() as u32 {
            let &[first, second] = &edges_at[vertex as usize][..] else { continue };
            if !self.is_on_it[vertex as usize] {
                continue;
            }
            // To the vertex, and away from it.
            let [before, after] = [(first, 1), (second, 0)].map(|(edge, slot)| {
                let edge = self.solid.edges[edge];
                if edge.ends[slot] == vertex { edge } else { edge.turned() }
            });
            let ends = [before.ends[0], after.ends[1]];
            let is_straight = ends[0] != ends[1]
                && before.faces == after.faces
                && self.part_along(ends[0], ends[1], self.at(vertex)).is_some();
            if is_straight {
                self.solid.edges[first] = Edge { ends, faces: before.faces };
                is_gone[second] = true;
                for edge in &mut edges_at[ends[1] as usize] {
                    if *edge == second {
                        *edge = first;
                    }
                }
            }
        }
        let mut index = 0;
        self.solid.edges.retain(|_| {
            index += 1;
            !is_gone[index - 1]
        });
    }
}

impl Edge {
    /// The same edge, the other way round.
    fn turned(self) -> Self {
        let ([a, b], [left, right]) = (self.ends, self.faces);
        Self { ends: [b, a], faces: [right, left] }
    }
}
