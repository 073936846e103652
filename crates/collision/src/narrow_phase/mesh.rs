//! Contacts of static triangle meshes: by features, so that edges inside of a flat or hollow
//! surface touch nothing.
//!
//! A ball or a point meets triangles from the front, and a ball also edges and corners that stand
//! out. A polyhedron meets triangles with its corners, faces with the mesh's corners, and edges
//! with edges, where both stand out along the common normal (their arcs on the Gauss map
//! [Gregorius13]). Each contact is that of the touch within the frame.

pub(crate) mod edge_contacts;
pub(crate) mod edge_sweep;
pub(crate) mod hull_faces;
pub(crate) mod hull_mesh;
pub(crate) mod hull_way;
pub(crate) mod mesh_contact;
pub(crate) mod mesh_motion;
pub(crate) mod moving_point;
pub(crate) mod near_features;
pub(crate) mod nearby;
pub(crate) mod overlap;
pub(crate) mod round_mesh;
pub(crate) mod round_motion;
pub(crate) mod sample_mesh;
pub(crate) mod selection;
pub(crate) mod sunken;
pub(crate) mod triangle_sweep;

#[cfg(test)]
mod tests;
