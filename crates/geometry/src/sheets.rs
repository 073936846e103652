//! Sheets of the surface in one cell of a dual contour.
//!
//! Corner index `x + 2 y + 4 z`; edge index along axis `a`: `4 a + p + 2 q`, with `p` and `q` its
//! position along the next two axes, cyclically; face index `2 a + side`.

/// Edges along each of a face's own two axes: `edges[0][q]` runs along the first axis at place `q`
/// of the second, `edges[1][p]` along the second at place `p` of the first.
fn face_edges(face: usize) -> [[usize; 2]; 2] {
    let (axis, side) = (face / 2, face % 2);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    [[4 * u + 2 * side, 4 * u + 1 + 2 * side], [4 * v + side, 4 * v + side + 2]]
}

/// Number of the corner at places `p` and `q` along a face's own axes.
fn face_corner(face: usize, p: usize, q: usize) -> usize {
    let (axis, side) = (face / 2, face % 2);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    (side << axis) | (p << u) | (q << v)
}

/// Bit `corner` of `inside`.
fn is_inside(inside: u8, corner: usize) -> bool {
    inside >> corner & 1 == 1
}

/// True for a face with two opposite inside corners: the surface can pass it in two ways.
pub(crate) fn is_ambiguous(inside: u8, face: usize) -> bool {
    let at = |p, q| is_inside(inside, face_corner(face, p, q));
    at(0, 0) == at(1, 1) && at(0, 1) == at(1, 0) && at(0, 0) != at(1, 0)
}

/// The number of the sheet that each edge's crossing belongs to, and how many sheets there are.
/// Edges without crossing have a meaningless number.
///
/// `inside` has a bit for each corner. An ambiguous face keeps its two inside corners apart, or if
/// its bit in `joined` is set, its two outside corners. Each sheet is a disc, bounded by one loop
/// over the cell's faces.
pub(crate) fn sheets(inside: u8, joined: u8) -> ([u8; 12], u8) {
    // Crossings on the same face are neighbours, two by two.
    let mut leader: [usize; 12] = std::array::from_fn(|edge| edge);
    for face in 0..6 {
        let [along_u, along_v] = face_edges(face);
        let at = |p, q| is_inside(inside, face_corner(face, p, q));
        if is_ambiguous(inside, face) {
            // The arc around corner (p, q) links the two edges that meet there.
            let around = if at(0, 0) != (joined >> face & 1 == 1) {
                [(0, 0), (1, 1)]
            } else {
                [(1, 0), (0, 1)]
            };
            for (p, q) in around {
                link(&mut leader, along_u[q], along_v[p]);
            }
        } else {
            let crossed = [
                (at(0, 0) != at(1, 0), along_u[0]),
                (at(0, 1) != at(1, 1), along_u[1]),
                (at(0, 0) != at(0, 1), along_v[0]),
                (at(1, 0) != at(1, 1), along_v[1]),
            ];
            let mut two = crossed.iter().filter(|(crosses, _)| *crosses).map(|&(_, edge)| edge);
            if let (Some(first), Some(second)) = (two.next(), two.next()) {
                link(&mut leader, first, second);
            }
        }
    }

    // Number the groups of crossed edges in order.
    let mut number = [u8::MAX; 12];
    let mut sheet_of_edge = [0; 12];
    let mut count = 0;
    for edge in 0..12 {
        let (low, high) = edge_corners(edge);
        if is_inside(inside, low) != is_inside(inside, high) {
            let first = leader_of(&leader, edge);
            if number[first] == u8::MAX {
                number[first] = count;
                count += 1;
            }
            sheet_of_edge[edge] = number[first];
        }
    }
    (sheet_of_edge, count)
}

/// True if both arcs across an ambiguous face belong to the same sheet.
pub(crate) fn passes_twice(inside: u8, joined: u8, face: usize) -> bool {
    let (sheet, _) = sheets(inside, joined);
    let [[a, b], [c, d]] = face_edges(face);
    sheet[a] == sheet[b] && sheet[b] == sheet[c] && sheet[c] == sheet[d]
}

/// The two corners of an edge.
fn edge_corners(edge: usize) -> (usize, usize) {
    let (axis, place) = (edge / 4, edge % 4);
    let low = (place & 1) << ((axis + 1) % 3) | (place >> 1) << ((axis + 2) % 3);
    (low, low | 1 << axis)
}

fn leader_of(leader: &[usize; 12], mut edge: usize) -> usize {
    while leader[edge] != edge {
        edge = leader[edge];
    }
    edge
}

fn link(leader: &mut [usize; 12], a: usize, b: usize) {
    let (a, b) = (leader_of(leader, a), leader_of(leader, b));
    leader[a.max(b)] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_are_counted_as_in_marching_cubes() {
        assert_eq!(sheets(0b0000_0001, 0).1, 1);
        // Opposite corners of a face, then of the cube: two caps.
        assert_eq!(sheets(0b0000_1001, 0).1, 2);
        assert_eq!(sheets(0b1000_0001, 0).1, 2);
        // Every second corner: four caps.
        assert_eq!(sheets(0b0110_1001, 0).1, 4);
        // The same with the outside corners apart.
        assert_eq!(sheets(0b0110_1001, 0b11_1111).1, 4);
        // Two corners of a face with their inside joined: one band.
        assert_eq!(sheets(0b0000_1001, 0b01_0000).1, 1);
    }

    /// Choosing the other way across a face always splits a sheet that passes it twice.
    #[test]
    fn the_other_way_splits_a_sheet_that_passes_twice() {
        let mut found = 0;
        for inside in 0..=255u8 {
            for joined in 0..64u8 {
                for face in 0..6 {
                    if is_ambiguous(inside, face) && passes_twice(inside, joined, face) {
                        let other = joined ^ 1 << face;
                        assert!(!passes_twice(inside, other, face));
                        assert_eq!(sheets(inside, other).1, sheets(inside, joined).1 + 1);
                        found += 1;
                    }
                }
            }
        }
        assert!(found > 0);
    }
}
