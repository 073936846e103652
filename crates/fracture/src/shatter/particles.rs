//! Which fragment each surface sample goes to [Su09 sec. 4.2 "Surface Particles"].

pub(crate) mod body_regions;
pub(crate) mod owners;

use super::crack_samples::{CrackFace, Sampler};
use super::laid::Laid;
use crate::pattern::region::Region;
use crate::placement::Placement;
use crate::shatter::crack_samples::parent::Parent;
use crate::shatter::settings::ShatterSettings;
use body_regions::{BodyRegions, Neighbourhood, POINTS};
use frangible_geometry::{BodyFrame, Clip, ClusteredSamples, GridSolid, HalfSpace, Shape};
use frangible_math::RigidTransform;
use glam::{DMat3, DVec3, Vec3};
use owners::Owners;

/// A body with fewer samples cannot stand on anything.
const FEWEST_SAMPLES: usize = 4;

/// A crack's points lie within the body, or so far outside of its surface [voxels]: the samples of
/// a level set round its edges off.
const AT_SURFACE: f64 = 0.05;

/// Lookup of the piece at a sample.
pub(crate) struct Lookup<'a> {
    /// Of planar cells, with where it is laid.
    pub(crate) pattern: Option<(&'a Placement, &'a [Region])>,
    /// Its planes on the body.
    pub(crate) regions: &'a [Region],
    /// The pieces that each region's inside belongs to.
    pub(crate) of_regions: &'a [Vec<u32>],
    /// Each piece's solid, and the frame of its body.
    pub(crate) pieces: &'a [(GridSolid, BodyFrame)],
}

/// The pieces that share the samples, and the owner of each voxel where the regions alone do not
/// tell: in a convex body each region is one piece; elsewhere voxels of a region without a node
/// inside may belong to a piece of another region.
struct Sharing<'a> {
    lookup: &'a Lookup<'a>,
    owners: Option<Owners>,
}

/// A rigid transform of many points.
struct Motion {
    rotation: DMat3,
    translation: DVec3,
}

impl Motion {
    fn new(transform: &RigidTransform) -> Self {
        Self { rotation: transform.matrix(), translation: transform.translation }
    }

    #[inline]
    fn point(&self, point: DVec3) -> Vec3 {
        (self.rotation * point + self.translation).as_vec3()
    }
}

/// One piece's samples, in its body frame [m].
struct Collector {
    /// The clusters of the parent that are all of this piece.
    whole: ClusteredSamples,
    /// Of the parent's other samples.
    single: Vec<Vec3>,
    cracks: Vec<Vec3>,
    body_from_grid: Motion,
    body_from_parent: Motion,
}

impl Collector {
    fn new(frame: &BodyFrame, grid_from_parent: &RigidTransform) -> Self {
        Self {
            whole: ClusteredSamples::default(),
            single: Vec::new(),
            cracks: Vec::new(),
            body_from_grid: Motion::new(&frame.body_from_grid),
            body_from_parent: Motion::new(&frame.body_from_grid.after(grid_from_parent)),
        }
    }
}

/// Samples of each fragment in its body frame [m]: those of the parent, each given to one fragment,
/// and those of the cracks, given to the fragments on both sides.
pub(crate) fn assign_particles(
    parent: (&Shape, &GridSolid),
    lookup: &Lookup,
    settings: &ShatterSettings,
) -> Vec<ClusteredSamples> {
    let (shape, solid) = parent;
    let grid_from_parent = shape.body_from_grid.inverse();
    let mut collectors: Vec<Collector> =
        lookup.pieces.iter().map(|(_, frame)| Collector::new(frame, &grid_from_parent)).collect();
    let owners = (!solid.is_convex()).then(|| Owners::new(solid, lookup.pieces));
    let sharing = Sharing { lookup, owners };
    sharing.share_out_samples(shape, &mut collectors);
    let spacing = settings.sample_spacing_voxels * solid.grid().spacing;
    sharing.sample_cracks(solid, spacing, &mut collectors);

    finish(collectors, lookup.pieces)
}

/// The same for cells of any form, with points of the cracks on every so many rows of nodes.
pub(crate) fn assign_to_sampled(
    parent: (&Shape, &GridSolid),
    pieces: (&[(GridSolid, BodyFrame)], &[Vec<u32>]),
    laid: &Laid,
    spacing: usize,
) -> Vec<ClusteredSamples> {
    let (shape, solid) = parent;
    let (pieces, of_regions) = pieces;
    let lookup = &Lookup { pattern: None, regions: &[], of_regions, pieces };
    let owners = Owners::new(solid, pieces);
    let grid_from_parent = shape.body_from_grid.inverse();
    let mut collectors: Vec<Collector> =
        pieces.iter().map(|(_, frame)| Collector::new(frame, &grid_from_parent)).collect();
    owners.for_each_crossing(spacing, laid, |[a, b], point| {
        if f64::from(solid.value(point)) <= AT_SURFACE * solid.grid().spacing {
            for piece in [a, b] {
                let collector = &mut collectors[piece as usize];
                collector.cracks.push(collector.body_from_grid.point(point));
            }
        }
    });
    let sharing = Sharing { lookup, owners: Some(owners) };
    for &sample in shape.samples() {
        let point = grid_from_parent.point(sample.as_dvec3());
        if let Some(piece) = sharing.piece_at(laid.cell_at(point) as usize, point) {
            let collector = &mut collectors[piece];
            collector.single.push(collector.body_from_parent.point(sample.as_dvec3()));
        }
    }
    finish(collectors, pieces)
}

/// Collects each piece's samples; pieces with almost none get samples from their voxels.
fn finish(collectors: Vec<Collector>, pieces: &[(GridSolid, BodyFrame)]) -> Vec<ClusteredSamples> {
    let finish = |(mut collector, (solid, _)): (Collector, &(GridSolid, BodyFrame))| {
        let count = collector.whole.samples.len() + collector.single.len() + collector.cracks.len();
        if count < FEWEST_SAMPLES {
            let points = project_surface_voxels(solid);
            collector
                .single
                .extend(points.into_iter().map(|point| collector.body_from_grid.point(point)));
        }
        let mut surface = collector.whole;
        surface.samples.reserve_exact(collector.single.len() + collector.cracks.len());
        for points in [collector.cracks, collector.single] {
            surface.samples.extend(points);
            surface.cluster_rest();
        }
        surface
    };
    collectors.into_iter().zip(pieces).map(finish).collect()
}

impl Sharing<'_> {
    /// Distributes the parent's samples to fragments: clusters without a crack move as a whole.
    fn share_out_samples(&self, parent: &Shape, collectors: &mut [Collector]) {
        let regions = BodyRegions::new(self.lookup.regions, parent);
        let only_piece = |&number: &usize| match self.lookup.of_regions[number].as_slice() {
            [piece] => Some(*piece as usize),
            _ => None,
        };
        let only_pieces: Vec<Option<usize>> = regions.numbers.iter().map(only_piece).collect();
        let grid_from_body = parent.body_from_grid.inverse();
        let mut nearest = 0;
        let mut around = Neighbourhood::new(&regions);
        for cluster in parent.sample_clusters() {
            let samples =
                &parent.samples()[cluster.first as usize..(cluster.first + cluster.count) as usize];
            let center = cluster.center.as_dvec3();
            around.look(center, f64::from(cluster.radius));
            let whole =
                around.region_of_all().and_then(|region| only_pieces[region]).filter(|&piece| {
                    let point = |sample: &Vec3| grid_from_body.point(sample.as_dvec3());
                    samples.iter().all(|sample| self.is_beside(piece, point(sample)))
                });
            if let Some(piece) = whole {
                let collector = &mut collectors[piece];
                let motion = &collector.body_from_parent;
                let moved = samples.iter().map(|&sample| motion.point(sample.as_dvec3()));
                let center = motion.point(center);
                collector.whole.push_cluster(moved, center, cluster.radius);
                continue;
            }
            for samples in samples.chunks(POINTS) {
                for (&sample, region) in samples.iter().zip(around.regions_of(samples)) {
                    let point = sample.as_dvec3();
                    let region = region.unwrap_or_else(|| {
                        nearest = regions.nearest(point, nearest);
                        nearest
                    });
                    let point_grid = grid_from_body.point(point);
                    let lies_on = only_pieces[region]
                        .filter(|&piece| self.is_beside(piece, point_grid))
                        .or_else(|| self.piece_at(regions.numbers[region], point_grid));
                    if let Some(piece) = lies_on {
                        let collector = &mut collectors[piece];
                        collector.single.push(collector.body_from_parent.point(point));
                    }
                }
            }
        }
    }

    /// The piece that a point in a region is on: of those with a part of the region the one with
    /// the least level set; if the region has no inside of its own, of all. Where voxels have
    /// owners, of those beside the point.
    fn piece_at(&self, region: usize, point: DVec3) -> Option<usize> {
        let value = |piece: usize| self.lookup.pieces[piece].0.value(point);
        let least = |a: &usize, b: &usize| value(*a).total_cmp(&value(*b));
        let of_region = self.lookup.of_regions[region].as_slice();
        let beside = self.owners.as_ref().map_or(Vec::new(), |owners| owners.around(point));
        let of_both = beside.iter().copied().filter(|&piece| of_region.contains(&(piece as u32)));
        if let Some(piece) = of_both.min_by(least).or_else(|| beside.iter().copied().min_by(least))
        {
            return Some(piece);
        }
        match of_region {
            [] => (0..self.lookup.pieces.len()).min_by(least),
            [piece] => Some(*piece as usize),
            several => several.iter().map(|&piece| piece as usize).min_by(least),
        }
    }

    /// True if a piece has a voxel beside a point, as far as that is asked for.
    fn is_beside(&self, piece: usize, point: DVec3) -> bool {
        self.owners.as_ref().is_none_or(|owners| owners.around(point).contains(&piece))
    }

    /// Samples the cracks around each region, for the pieces that its inside belongs to.
    fn sample_cracks(&self, solid: &GridSolid, spacing: f64, collectors: &mut [Collector]) {
        let parent = Parent::new(solid);
        let mut sampler = Sampler::new(&parent, spacing);
        let Some((placement, regions)) = self.lookup.pattern else { return };
        for (number, of_pattern) in regions.iter().enumerate() {
            if self.lookup.of_regions[number].is_empty() {
                continue;
            }
            for face in sampler.sample(&self.lookup.regions[number], placement, of_pattern) {
                if let [piece] = self.lookup.of_regions[number].as_slice()
                    && self.is_all_on_surface(solid, *piece as usize, face)
                {
                    let Collector { cracks, body_from_grid, .. } = &mut collectors[*piece as usize];
                    cracks.extend(face.points().map(|&point| body_from_grid.point(point)));
                    continue;
                }
                for &point in face.points() {
                    if let Some(piece) = self.piece_at(number, point)
                        && self.lookup.of_regions[number].contains(&(piece as u32))
                        && self.is_on_surface(piece, point, face.normal)
                    {
                        let collector = &mut collectors[piece];
                        collector.cracks.push(collector.body_from_grid.point(point));
                    }
                }
            }
        }
    }

    /// True if a region's crack is known to lie on a piece everywhere, with the region as the whole
    /// piece: the parent is unbroken, and no merged sliver lies across.
    fn is_all_on_surface(&self, parent: &GridSolid, piece: usize, face: CrackFace) -> bool {
        let (solid, _) = &self.lookup.pieces[piece];
        let across = 0.5 * solid.grid().spacing * face.normal;
        let misses = |part: &Clip| {
            let beyond = |plane: &HalfSpace| {
                face.corners.iter().all(|&at| plane.distance(at + across) > 0.0)
            };
            part.half_spaces().iter().any(beyond)
        };
        match solid.parts() {
            [_] => self.owners.is_none(),
            parts => parent.is_convex() && parent.parts().is_empty() && parts.iter().all(misses),
        }
    }

    /// True if a point of a region's crack is on a piece, and no sliver merged across the crack
    /// there.
    fn is_on_surface(&self, piece: usize, point: DVec3, normal: DVec3) -> bool {
        let (solid, _) = &self.lookup.pieces[piece];
        let grid = solid.grid();
        let half_voxel = 0.5 * grid.spacing;
        let value = |point: DVec3, most: f64| {
            f64::from(solid.value_at_lattice(grid.lattice_from_point(point).as_vec3(), most as f32))
        };
        value(point + half_voxel * normal, 0.0) > 0.0 && value(point, half_voxel) < half_voxel
    }
}

/// The nodes of a solid's outermost voxels, moved onto its surface.
fn project_surface_voxels(solid: &GridSolid) -> Vec<DVec3> {
    let grid = solid.grid();
    let coverage = solid.coverage();
    let strides = [1, grid.dims[0], grid.dims[0] * grid.dims[1]];
    // A fragment's grid has empty layers around it.
    let at_surface = |&node: &usize| {
        coverage[node] > 0.0
            && strides
                .iter()
                .any(|stride| coverage[node - stride] == 0.0 || coverage[node + stride] == 0.0)
    };
    (0..grid.len())
        .filter(at_surface)
        .map(|node| {
            let [i, j, k] = grid.coordinates(node);
            let point = grid.node(i, j, k);
            let (distance, gradient) = solid.value_and_gradient(point);
            let outward = gradient.as_dvec3().try_normalize().unwrap_or(DVec3::ZERO);
            // The distance of a sliver is rough: stay within the voxel.
            point - outward * f64::from(distance).clamp(-0.5 * grid.spacing, 0.5 * grid.spacing)
        })
        .collect()
}
