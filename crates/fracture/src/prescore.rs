//! Cutting a body into the pieces that it is glued together of.

use crate::align::{Impact, align_pattern};
use crate::crater::convex_parts;
use crate::fragment::Fragment;
use crate::grid_pieces::GridPieces;
use crate::interfaces;
use crate::interfaces::interface::{Contacts, Interface};
use crate::interfaces::meshes::{CutPiece, mesh_interfaces_within};
use crate::mesh_pattern::{Drawn, bounds};
use crate::pattern::Pattern;
use crate::placement::Placement;
use crate::shatter::settings::ShatterSettings;
use crate::shatter_hull::cut_hull;
use crate::slivers::{Contact, Groups, Smallest};
use frangible_geometry::{Geometry, HalfSpace, Hull, PlaneClipper, Shape, TriMesh};
use frangible_math::RigidTransform;
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// Pieces of fewer voxels are slivers: in a block of three voxels a side the middle one is the
/// first whose distance the samples resolve.
const SMALLEST_VOXELS: f64 = 27.0;

/// Part of a body's volume below which a piece is rounding [1].
const SMALLEST_PIECE: f64 = 1e-12;

/// Sides of a crack in a file of single precision are apart by less, relative to the longest side
/// of the body [1].
const SAME_PLANE: f64 = 1e-6;

/// The pieces that a glued body is cut into.
#[derive(Clone, Debug)]
pub struct Prescored {
    pub(crate) forms: Forms,
    /// Block of each piece. Pieces of one block stay together: mortar sticks to the brick of its
    /// block.
    pub(crate) blocks: Vec<u32>,
    /// If they are known.
    pub(crate) contacts: Option<Vec<Interface>>,
}

/// Shapes of the pieces.
#[derive(Clone, Debug)]
pub(crate) enum Forms {
    /// In the frame of the body's grid.
    Hulls(Vec<Hull>),
    /// Of a body on a grid.
    Grid(Arc<GridPieces>),
}

impl From<Vec<Hull>> for Prescored {
    /// Each a block.
    fn from(hulls: Vec<Hull>) -> Self {
        let blocks = (0..hulls.len() as u32).collect();
        Self { blocks, forms: Forms::Hulls(hulls), contacts: None }
    }
}

impl Prescored {
    /// Number of pieces.
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// True without pieces.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }
}

/// The block of a cell: a joint belongs to the last cell before it that is none.
fn block_of(pattern: &Pattern, part: usize, cell: usize) -> u32 {
    let owner = (0..=cell).rev().find(|&cell| !pattern.is_joint(cell)).unwrap_or(cell);
    (part * pattern.len() + owner) as u32
}

/// Convex pieces, as they are cut.
#[derive(Default)]
struct Cut {
    hulls: Vec<Hull>,
    blocks: Vec<u32>,
}

impl Cut {
    /// Adds the piece that a cell of a pattern cuts out of one of a body's parts. A joint has its
    /// own material.
    fn add(&mut self, hull: Hull, pattern: &Pattern, part: usize, cell: usize) {
        self.hulls.push(if pattern.is_joint(cell) { hull.all_inner() } else { hull });
        self.blocks.push(block_of(pattern, part, cell));
    }

    fn finish(self) -> Prescored {
        Prescored { forms: Forms::Hulls(self.hulls), blocks: self.blocks, contacts: None }
    }
}

/// The pieces of a body in the frame of its grid: cut along a pattern, that is laid on the body as
/// for an impact, or the parts of a compound. A body of convex polyhedra and a planar pattern make
/// polyhedra; what lies on a grid is cut there. `None` for others, and for a body that neither has
/// parts nor is cut.
pub fn prescore(
    body: &Arc<Shape>,
    pattern: Option<&Arc<Pattern>>,
    impact: &Impact,
) -> Option<Prescored> {
    let settings =
        ShatterSettings { smallest: Smallest::of_first(body), ..ShatterSettings::default() };
    if let (Geometry::Grid(_), Some(pattern)) = (&body.geometry, pattern) {
        let placement = Placement::new(pattern, impact, body);
        let pieces = GridPieces::cut(body.clone(), pattern.clone(), placement, &settings)?;
        return Some(on_grid(pieces, pattern, None));
    }
    let parts = convex_parts(body)?;
    let Some(pattern) = pattern else { return Some(parts.into()) };
    pattern.planar()?;
    let mut pieces = Cut::default();
    if body.breaks_as().is_some() {
        for fragment in cut_hull(body, pattern, impact, &settings, false) {
            pieces.add(fragment.shape.breaks_as()?.clone(), pattern, 0, fragment.cell as usize);
        }
        return Some(pieces.finish());
    }

    // Each part of a compound is cut by itself.
    let regions = align_pattern(pattern, impact, body);
    let mut clipper = PlaneClipper::default();
    for (number, part) in parts.iter().enumerate() {
        for (cell, region) in regions.iter().enumerate() {
            let cuts: Vec<HalfSpace> = region.cuts.iter().map(|cut| cut.half_space).collect();
            let piece = clipper.clipped(part, &cuts);
            if let Some(piece) = piece.filter(|piece| piece.volume() > SMALLEST_PIECE * body.volume)
            {
                pieces.add(piece, pattern, number, cell);
            }
        }
    }
    Some(pieces.finish())
}

/// The pieces of a body on a grid that are closed meshes in its grid frame, as a break of its mesh
/// has left them. Those that the grid does not resolve join a neighbour. Contacts are those that are
/// given, or else the common faces of the meshes; where a mesh has none, those of the voxels.
///
/// # Errors
/// If a mesh is not closed or too thin to be sampled, or the body lies on no grid.
pub fn prescore_parts(
    body: &Arc<Shape>,
    meshes: Vec<TriMesh>,
    contacts: Option<Vec<Interface>>,
) -> Result<Prescored, String> {
    let contacts = contacts.unwrap_or_else(|| common_faces(&meshes));
    let (meshes, contacts) = without_slivers(meshes, contacts, body);
    let count = meshes.len();
    let pattern = Arc::new(Pattern::of_pieces(meshes)?);
    let placement = Placement {
        grid_from_pattern: DMat3::IDENTITY,
        scale: 1.0,
        center_pattern: DVec3::ZERO,
        point_grid: DVec3::ZERO,
    };
    // A piece is what it is, however small.
    let settings = ShatterSettings {
        smallest_fragment_voxels: 0.0,
        smallest: Smallest { part: 0.0, ..Smallest::default() },
        ..ShatterSettings::default()
    };
    let pieces = GridPieces::cut(body.clone(), pattern.clone(), placement, &settings)
        .ok_or("the body lies on no grid")?;
    let touches = |cell: usize| contacts.iter().any(|one| [one.a, one.b].contains(&cell));
    let all_touch = (0..count).all(touches);
    let contacts = if all_touch { of_pieces(contacts, &pieces, count) } else { None };
    Ok(on_grid(pieces, &pattern, contacts))
}

/// Contacts of meshes as those of the pieces that they are on the grid, in order; `None` if a mesh
/// is no piece there, or several.
fn of_pieces(
    contacts: Vec<Interface>,
    pieces: &GridPieces,
    count: usize,
) -> Option<Vec<Interface>> {
    let mut piece_of = vec![None; count];
    for (piece, cell) in pieces.cells().enumerate() {
        if piece_of[cell as usize].replace(piece).is_some() {
            return None;
        }
    }
    let renamed = |contact: Interface| {
        let (a, b) = (piece_of[contact.a]?, piece_of[contact.b]?);
        let normal = if a < b { contact.normal } else { -contact.normal };
        Some(Interface { a: a.min(b), b: a.max(b), normal, ..contact })
    };
    let mut contacts: Vec<Interface> = contacts.into_iter().map(renamed).collect::<Option<_>>()?;
    contacts.sort_by_key(|contact| (contact.a, contact.b));
    piece_of.iter().all(Option::is_some).then_some(contacts)
}

/// Contacts where faces of meshes lie on one another.
fn common_faces(meshes: &[TriMesh]) -> Vec<Interface> {
    let piece =
        |mesh: &TriMesh| CutPiece { mesh: mesh.clone(), inner: vec![true; mesh.triangles.len()] };
    let pieces: Vec<CutPiece> = meshes.iter().map(piece).collect();
    mesh_interfaces_within(&pieces, SAME_PLANE)
}

/// Meshes that the grid does not resolve join the neighbour with which they have most in common.
fn without_slivers(
    meshes: Vec<TriMesh>,
    contacts: Vec<Interface>,
    body: &Shape,
) -> (Vec<TriMesh>, Vec<Interface>) {
    let Geometry::Grid(solid) = &body.geometry else { return (meshes, contacts) };
    let around = bounds(&meshes).unwrap_or_default();
    let least = SMALLEST_VOXELS * solid.grid().voxel_volume();
    let volumes: Vec<f64> = meshes.iter().map(|mesh| mesh.mass_properties().volume).collect();
    let is_sliver =
        |(mesh, &volume): (&TriMesh, &f64)| volume.abs() < least || !Drawn::resolves(mesh, around);
    let too_small: Vec<bool> = meshes.iter().zip(&volumes).map(is_sliver).collect();
    if !too_small.contains(&true) {
        return (meshes, contacts);
    }
    let areas: Vec<Contact> = contacts.iter().map(|one| ([one.a, one.b], one.area)).collect();
    let mut groups = Groups::new(&volumes, &too_small);
    groups.join(&areas, |_, _, volume| Some(volume < least));
    let hosts = groups.of_piece();

    // Number those that are left.
    let mut number = vec![0; meshes.len()];
    let mut joined: Vec<TriMesh> = Vec::new();
    for (piece, mesh) in meshes.iter().enumerate().filter(|&(piece, _)| hosts[piece] == piece) {
        number[piece] = joined.len();
        joined.push(mesh.clone());
    }
    for (piece, mesh) in meshes.iter().enumerate().filter(|&(piece, _)| hosts[piece] != piece) {
        let host = &mut joined[number[hosts[piece]]];
        let first = host.positions.len() as u32;
        host.positions.extend(&mesh.positions);
        host.triangles.extend(mesh.triangles.iter().map(|corners| corners.map(|at| at + first)));
    }
    let mut of_hosts = Contacts::default();
    for contact in contacts {
        let (a, b) = (number[hosts[contact.a]], number[hosts[contact.b]]);
        if a != b {
            let mut part = contact.flat_part();
            part.vector = if a < b { part.vector } else { -part.vector };
            of_hosts.add((a.min(b), a.max(b)), part);
        }
    }
    (joined, of_hosts.into_interfaces())
}

/// Each piece is a block, but joints belong to that of their owner.
fn on_grid(pieces: GridPieces, pattern: &Pattern, contacts: Option<Vec<Interface>>) -> Prescored {
    let cells: Vec<u32> = pieces.cells().collect();
    let block = |(piece, &cell): (usize, &u32)| {
        let owner = block_of(pattern, 0, cell as usize);
        let of_owner = cells.iter().position(|&other| owner != cell && other == owner);
        of_owner.unwrap_or(piece) as u32
    };
    let blocks = cells.iter().enumerate().map(block).collect();
    Prescored { forms: Forms::Grid(Arc::new(pieces)), blocks, contacts }
}

/// A bond for each face that two hulls share.
pub(crate) fn touching(hulls: &[Hull]) -> Vec<Interface> {
    let fragment = |hull: &Hull| {
        let (low, high) = hull.bounds();
        let shape = Shape::convex(hull.clone(), (high - low).max_element()).ok()?;
        let parent_from_fragment: RigidTransform = shape.body_from_grid.inverse();
        Some(Fragment { shape, parent_from_fragment, cell: 0 })
    };
    let fragments: Option<Vec<Fragment>> = hulls.iter().map(fragment).collect();
    fragments.map(|fragments| interfaces(&fragments)).unwrap_or_default()
}
