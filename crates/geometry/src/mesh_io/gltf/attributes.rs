//! Normals, texture coordinates and colours of glTF's vertices.

use super::super::attributes::{CornerAttributes, unit};
use crate::mesh_io::gltf::accessor::items;
use glam::{DMat3, DMat4, DVec3, Vec2};
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Node, Primitive, Semantic};

/// Of a node, or of the mesh that it holds; `None` if both have none.
pub(super) fn name(node: &Node) -> Option<String> {
    let mesh = node.mesh();
    let name = node.name().or_else(|| mesh.as_ref().and_then(|mesh| mesh.name()));
    name.filter(|name| !name.is_empty()).map(str::to_owned)
}

/// The attributes of each of the `count` vertices of a primitive. Unreadable ones are left out:
/// they must not refuse a shape.
pub(super) fn corners(
    primitive: &Primitive,
    buffers: &[Vec<u8>],
    scene_from_node: &DMat4,
    count: usize,
) -> Vec<CornerAttributes> {
    // The set of coordinates that the colour's image is laid on by.
    let material = primitive.material();
    let base = material.pbr_metallic_roughness().base_color_texture();
    let set = base.map_or(0, |texture| texture.tex_coord());
    let read = |semantic: &Semantic| {
        let values = numbers(&primitive.get(semantic)?, buffers)?;
        (values.len() >= count).then_some(values)
    };
    let coordinates = read(&Semantic::TexCoords(set));
    let normals = read(&Semantic::Normals);
    let colours = read(&Semantic::Colors(0));

    // Normals turn with the inverse transpose.
    let linear = DMat3::from_mat4(*scene_from_node);
    let turn = linear.inverse().transpose();
    let corner = |vertex: usize| {
        let at = |values: &Option<Vec<[f64; 4]>>| values.as_ref().map(|values| values[vertex]);
        CornerAttributes {
            // Files have v down.
            coordinates: at(&coordinates).map(|[u, v, ..]| Vec2::new(u as f32, (1.0 - v) as f32)),
            normal: at(&normals).and_then(|[x, y, z, _]| unit(turn * DVec3::new(x, y, z))),
            colour: at(&colours).map(|colour| colour.map(|channel| channel as f32)),
        }
    };
    (0..count).map(corner).collect()
}

/// The numbers of each item of an accessor, ones behind the last; normalized integers are parts of
/// their type's largest number. `None` if they cannot be read.
fn numbers(accessor: &Accessor, buffers: &[Vec<u8>]) -> Option<Vec<[f64; 4]>> {
    let columns = match accessor.dimensions() {
        Dimensions::Vec2 => 2,
        Dimensions::Vec3 => 3,
        Dimensions::Vec4 => 4,
        _ => return None,
    };
    let width = accessor.data_type().size();
    let scale = |full: f64| if accessor.normalized() { full } else { 1.0 };
    let least = if accessor.normalized() { -1.0 } else { f64::MIN };
    let number = |bytes: &[u8]| match (accessor.data_type(), bytes) {
        (DataType::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        (DataType::U8, &[a]) => f64::from(a) / scale(f64::from(u8::MAX)),
        (DataType::U16, &[a, b]) => {
            f64::from(u16::from_le_bytes([a, b])) / scale(f64::from(u16::MAX))
        }
        (DataType::I8, &[a]) => (f64::from(a as i8) / scale(f64::from(i8::MAX))).max(least),
        (DataType::I16, &[a, b]) => {
            (f64::from(i16::from_le_bytes([a, b])) / scale(f64::from(i16::MAX))).max(least)
        }
        _ => f64::NAN,
    };
    let item = |bytes: &&[u8]| {
        let mut row = [1.0; 4];
        for (value, bytes) in row.iter_mut().zip(bytes.chunks_exact(width)).take(columns) {
            *value = number(bytes);
        }
        row
    };
    let rows: Vec<[f64; 4]> = items(accessor, buffers).ok()?.iter().map(item).collect();
    rows.iter().flatten().all(|number| number.is_finite()).then_some(rows)
}
