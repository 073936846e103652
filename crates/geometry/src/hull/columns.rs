//! A hull's faces and vertices side by side in single precision, for who looks at many of them at a
//! time.

use crate::half_space::HalfSpace;
use frangible_math::{LANES, Singles};
use glam::DVec3;
use std::sync::OnceLock;

/// The faces and vertices of a hull.
#[derive(Clone, Debug)]
pub struct Columns {
    /// The mean of the vertices, in the hull's frame [m]: all is relative to it, so that single
    /// precision is relative to the hull's size.
    pub middle: DVec3,
    /// Four for each eight faces, then three for each eight vertices.
    columns: Box<[Singles]>,
    /// Number of face columns.
    of_faces: usize,
}

impl Columns {
    /// Normals and offsets [m], of eight faces each; the last eight are filled up with the first
    /// one.
    #[inline]
    pub fn faces(&self) -> &[[Singles; 4]] {
        self.columns[..self.of_faces].as_chunks().0
    }

    /// Positions [m], of eight vertices each; the last eight are filled up with the first one.
    #[inline]
    pub fn vertices(&self) -> &[[Singles; 3]] {
        self.columns[self.of_faces..].as_chunks().0
    }

    /// All columns, for prefetching.
    #[inline]
    pub fn all(&self) -> &[Singles] {
        &self.columns
    }

    fn new(vertices: &[DVec3], planes: &[HalfSpace]) -> Self {
        let middle = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
        let (faces, corners) = (planes.len().div_ceil(LANES), vertices.len().div_ceil(LANES));
        let (of_faces, of_vertices) = (4 * faces, 3 * corners);
        let mut columns = vec![Singles::ZERO; of_faces + of_vertices].into_boxed_slice();
        let (for_faces, for_vertices) = columns.split_at_mut(of_faces);
        for at in 0..faces * LANES {
            let HalfSpace { normal, offset } = *planes.get(at).unwrap_or(&planes[0]);
            let numbers = [normal.x, normal.y, normal.z, offset - normal.dot(middle)];
            for (column, number) in for_faces[4 * (at / LANES)..].iter_mut().zip(numbers) {
                column.0[at % LANES] = number as f32;
            }
        }
        for at in 0..corners * LANES {
            let lever = *vertices.get(at).unwrap_or(&vertices[0]) - middle;
            for (column, number) in
                for_vertices[3 * (at / LANES)..].iter_mut().zip(lever.to_array())
            {
                column.0[at % LANES] = number as f32;
            }
        }
        Self { middle, columns, of_faces }
    }
}

/// Room for [`Columns`], which are found when they are first asked for, as for bounds: cutting
/// makes hulls that never become bodies. They tell nothing new, so all are equal.
#[derive(Clone, Debug, Default)]
pub(super) struct LazyColumns(OnceLock<Columns>);

impl PartialEq for LazyColumns {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl LazyColumns {
    #[inline]
    pub(super) fn get_or_find(&self, vertices: &[DVec3], planes: &[HalfSpace]) -> &Columns {
        self.0.get_or_init(|| Columns::new(vertices, planes))
    }

    /// Columns, if already computed.
    #[inline]
    pub(super) fn get(&self) -> Option<&Columns> {
        self.0.get()
    }
}

#[cfg(test)]
mod tests {
    use crate::hull::Hull;
    use frangible_math::RigidTransform;
    use glam::{DQuat, DVec3};

    /// Far from the frame's origin as near it, all faces and vertices are where they are, to single
    /// precision.
    #[test]
    fn columns_hold_faces_and_vertices() {
        let away = RigidTransform::new(DQuat::from_rotation_x(0.3), DVec3::new(1e4, -2e4, 3e3));
        let hull = Hull::cuboid(DVec3::new(1.0, 2.0, 3.0)).transformed(&away);
        let columns = hull.columns();
        assert_eq!((columns.faces().len(), columns.vertices().len()), (1, 1));
        for (at, vertex) in hull.vertices().iter().enumerate() {
            let lever =
                DVec3::from_array(columns.vertices()[0].map(|column| f64::from(column.0[at])));
            assert!((columns.middle + lever - vertex).length() < 1e-6, "{at}");
        }
        for at in 0..8 {
            let plane = hull.planes()[if at < 6 { at } else { 0 }];
            let [x, y, z, offset] = columns.faces()[0].map(|column| f64::from(column.0[at]));
            assert!((DVec3::new(x, y, z) - plane.normal).length() < 1e-6);
            assert!((plane.distance(columns.middle) + offset).abs() < 1e-6);
        }
        assert_eq!(hull, hull.clone());
    }
}
