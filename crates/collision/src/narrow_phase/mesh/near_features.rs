//! Edges and vertices of a mesh that a polyhedron may meet on its way.

use crate::narrow_phase::mesh::hull_way::HullWay;
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use frangible_geometry::StaticMesh;
use glam::DVec3;

/// Largest product of a hull's face and vertex counts [1] up to which a face's reach is that of the
/// vertices; above, it is a bound from the turn. States are the same either way. With the bound for
/// all hulls, boxes and hulls of 12 points on ground of 6 cm triangles take 4 % longer; with the
/// vertices for all, hulls of 300 points take 20 % longer.
const MOST_PRODUCTS: usize = 1024;

/// Depth of overlaps of edges, relative to the smaller body's radius [1].
const DEPTH: f64 = 0.25;

/// Features of a mesh that a hull may touch.
#[derive(Default)]
pub(crate) struct NearFeatures {
    pub(crate) edges: Vec<NearEdge>,
    pub(crate) vertices: Vec<usize>,
}

/// An edge of a mesh near a hull.
#[derive(Clone, Copy)]
pub(crate) struct NearEdge {
    /// A triangle, and its corner where the edge begins.
    pub(crate) triangle: usize,
    pub(crate) corner: usize,
    /// Its part that lies where the hull may come, mesh frame [m].
    pub(crate) part: [DVec3; 2],
    /// Depth of overlaps at the start that are possible [m].
    pub(crate) depth: f64,
    /// Faces of the hull under which the part does not stay deep, by their [`bit`]: only their
    /// edges may touch it.
    pub(crate) near_faces: u64,
}

/// Part of the speculative margin by which features are looked for further [1]: those of the free
/// flight are then, nearly always, also those of the way along the triangles that bear the body.
const SPARE: f64 = 0.25;

/// A bit for a face; faces of large hulls share them.
pub(crate) fn bit(face: usize) -> u64 {
    1 << (face % u64::BITS as usize)
}

/// A face of the hull at the frame's start, mesh frame, and bounds of its way.
struct Face {
    normal: DVec3,
    /// Distance of the plane from the origin along the normal [m].
    offset: f64,
    /// How far the hull reaches beyond the plane in the frame, with the speculative margin [m].
    reach: f64,
    /// By how much a point near the hull may come out from under the face in the frame [m].
    shift: f64,
}

impl Face {
    /// Of a triangle's corners over the plane [m].
    #[inline]
    fn heights(&self, corners: &[DVec3; 3]) -> [f64; 3] {
        let Self { normal, offset, .. } = *self;
        [
            normal.dot(corners[0]) - offset,
            normal.dot(corners[1]) - offset,
            normal.dot(corners[2]) - offset,
        ]
    }

    /// True if the hull does not come to a triangle through the plane.
    #[inline]
    fn is_below(&self, corners: &[DVec3; 3]) -> bool {
        let [a, b, c] = self.heights(corners);
        a > self.reach && b > self.reach && c > self.reach
    }
}

/// Memory of the triangles before.
struct Scratch {
    /// For each face, of a triangle's corners over its plane [m].
    heights: Vec<[f64; 3]>,
    /// The face beyond which one lay last: its neighbours do, too.
    last_out: usize,
    cuts: Vec<Cut>,
}

/// Features that a face leaves out.
#[derive(Clone, Copy)]
struct Cut {
    /// True if anything lay beyond its reach.
    beyond: bool,
    /// True if an edge stays deep under it.
    under: bool,
}

/// A hull's faces in a frame.
struct Swept {
    faces: Vec<Face>,
    /// Twice the speculative margin [m].
    margin: f64,
    /// Largest depth of overlaps [m].
    most_depth: f64,
}

impl Swept {
    fn new(hull_way: &HullWay) -> Self {
        let HullWay { motion, hull, inside, .. } = *hull_way;
        let margin = motion.pair_motion.near + motion.thin;
        let start = &hull_way.flight.instants[0];
        let middle = start.mesh_from_body.point(inside);
        let squared = |vertex: &DVec3| vertex.distance_squared(inside);
        let radius = hull.vertices().iter().map(squared).fold(0.0, f64::max).sqrt();
        let has_few = hull.planes().len() * hull.vertices().len() <= MOST_PRODUCTS;
        let face = |plane: &frangible_geometry::HalfSpace| {
            let normal = start.rotation * plane.normal;
            let offset = plane.offset + normal.dot(start.mesh_from_body.translation);
            let (mut reach, mut shift) = (0.0_f64, 0.0_f64);
            for way in hull_way.ways() {
                for (number, instant) in way.instants.iter().enumerate().skip(1) {
                    let turned = instant.rotation * plane.normal;
                    let away = instant.mesh_from_body.point(inside) - middle;
                    let turn = (turned - normal).length();
                    let around = radius + margin + away.length();
                    shift = shift.max(turn * around - turned.dot(away));
                    reach = if has_few {
                        let most = |most: f64, vertex: &DVec3| most.max(vertex.dot(normal));
                        way.vertices(number).iter().fold(reach + offset, most) - offset
                    } else {
                        reach.max(turn * radius + normal.dot(away))
                    };
                }
            }
            Face { normal, offset, reach: reach + margin, shift }
        };
        Self {
            faces: hull.planes().iter().map(face).collect(),
            margin: 2.0 * margin,
            most_depth: DEPTH * motion.pair_motion.size,
        }
    }

    fn meets_box(&self, low: DVec3, high: DVec3) -> bool {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        self.faces.iter().all(|face| {
            face.normal.dot(middle) - face.offset - face.reach <= half.dot(face.normal.abs())
        })
    }

    /// Appends the features that a triangle stands for.
    fn add(
        &self,
        mesh: &StaticMesh,
        (triangle, corners): (usize, &[DVec3; 3]),
        scratch: &mut Scratch,
        features: &mut NearFeatures,
    ) {
        // Parts of the edges where the hull may come; which corners lie there.
        let (mut first, mut last) = ([0.0_f64; 3], [1.0_f64; 3]);
        let mut is_inside = [true; 3];
        let Scratch { heights, last_out, cuts } = scratch;
        if self.faces[*last_out].is_below(corners) {
            cuts[*last_out].beyond = true;
            return;
        }
        for (number, face) in self.faces.iter().enumerate() {
            let (above, reach) = (face.heights(corners), face.reach);
            heights[number] = above;
            let is_out = [above[0] > reach, above[1] > reach, above[2] > reach];
            if is_out == [false; 3] {
                continue;
            }
            cuts[number].beyond = true;
            if is_out == [true; 3] {
                *last_out = number;
                return;
            }
            for corner in 0..3 {
                let next = (corner + 1) % 3;
                let (from, to) = (above[corner] - reach, above[next] - reach);
                is_inside[corner] &= !is_out[corner];
                match [is_out[corner], is_out[next]] {
                    [true, true] => last[corner] = -1.0,
                    [true, false] => first[corner] = first[corner].max(from / (from - to)),
                    [false, true] => last[corner] = last[corner].min(from / (from - to)),
                    [false, false] => {}
                }
            }
        }
        for corner in 0..3 {
            let within = [first[corner], last[corner]];
            if within[0] <= within[1] && mesh.owns_edge(triangle, corner) {
                let next = (corner + 1) % 3;
                if let Some((depth, near_faces)) =
                    self.near_faces((heights, cuts), [corner, next], within)
                {
                    let part = within.map(|part| corners[corner].lerp(corners[next], part));
                    features.edges.push(NearEdge { triangle, corner, part, depth, near_faces });
                }
            }
            if is_inside[corner] && mesh.owns_vertex(triangle, corner) {
                features.vertices.push(mesh.triangles()[triangle][corner] as usize);
            }
        }
    }

    /// Of a part of the edge between two corners: depth of its overlaps, and the faces that it is
    /// near to. `None` if those are fewer than two, which an edge of the hull has.
    fn near_faces(
        &self,
        (heights, cuts): (&[[f64; 3]], &mut [Cut]),
        [from, to]: [usize; 2],
        [first, last]: [f64; 2],
    ) -> Option<(f64, u64)> {
        let ends = |above: &[f64; 3]| {
            let (start, way) = (above[from], above[to] - above[from]);
            [start + first * way, start + last * way]
        };
        let is_apart = heights.iter().any(|above| ends(above).into_iter().all(|end| end > 0.0));
        let depth = if is_apart { 0.0 } else { self.most_depth };
        let deepest = -self.margin - depth;
        let (mut near, mut count) = (0, 0);
        for (number, (face, above)) in self.faces.iter().zip(heights).enumerate() {
            let [a, b] = ends(above);
            if a.max(b) + face.shift >= deepest {
                near |= bit(number);
                count += 1;
            } else {
                cuts[number].under = true;
            }
        }
        (count >= 2).then_some((depth, near))
    }

    /// True if features that another one found, with what it left out at its faces, are all that
    /// this one would find.
    fn lies_in(&self, other: &Self, cuts: &[Cut]) -> bool {
        self.faces.iter().zip(&other.faces).zip(cuts).all(|((own, other), cut)| {
            (own.reach <= other.reach || !cut.beyond) && (own.shift <= other.shift || !cut.under)
        })
    }

    /// With some room around it.
    fn roomy(mut self) -> Self {
        let spare = 0.5 * SPARE * self.margin;
        for face in &mut self.faces {
            face.reach += spare;
            face.shift += spare;
        }
        self
    }
}

/// Features that a hull may touch, and the space in which they were looked for.
pub(crate) struct FoundFeatures {
    pub(crate) features: NearFeatures,
    swept: Swept,
    /// For each of its faces.
    cuts: Vec<Cut>,
}

impl FoundFeatures {
    pub(crate) fn new(hull_way: &HullWay) -> Self {
        let swept = Swept::new(hull_way).roomy();
        let (features, cuts) = find(hull_way, &swept);
        Self { features, swept, cuts }
    }

    /// Those on a way that differs a little.
    pub(crate) fn renewed(self, hull_way: &HullWay) -> Self {
        if Swept::new(hull_way).lies_in(&self.swept, &self.cuts) {
            self
        } else {
            Self::new(hull_way)
        }
    }
}

/// Edges and vertices that a hull may touch on its ways, and what was left out at its faces.
fn find(hull_way: &HullWay, swept: &Swept) -> (NearFeatures, Vec<Cut>) {
    let MeshMotion { mesh, ref nearby, .. } = *hull_way.motion;
    let mut features = NearFeatures::default();
    let count = swept.faces.len();
    // Whole boxes are left out without a look at faces.
    let is_unknown = nearby.listed().is_none();
    let cut = Cut { beyond: is_unknown, under: is_unknown };
    let mut scratch =
        Scratch { heights: vec![[0.0; 3]; count], last_out: 0, cuts: vec![cut; count] };
    match nearby.listed() {
        Some(listed) => {
            for near in listed.filter(|near| !mesh.owns_nothing(near.index)) {
                swept.add(mesh, (near.index, &near.corners), &mut scratch, &mut features);
            }
        }
        None => {
            let enters = |low: DVec3, high: DVec3| swept.meets_box(low, high);
            mesh.visit_features(enters, |triangle| {
                if !mesh.owns_nothing(triangle) {
                    let corners = mesh.corners(triangle);
                    swept.add(mesh, (triangle, &corners), &mut scratch, &mut features);
                }
            });
        }
    }
    (features, scratch.cuts)
}
