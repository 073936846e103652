//! Closed surfaces and their grouping into solids.

use crate::bvh::Bvh;
use crate::winding_number::WindingNumber;
use glam::DVec3;

/// Places at which a shell is compared with another one.
const SAMPLES: usize = 9;
/// Boxes, areas and volumes that differ by less, relatively, are the same.
const SAME: f64 = 1e-6;

/// A closed, connected surface whose triangles agree.
pub(super) struct Shell {
    /// Corners of the triangles [m].
    pub(super) corners: Vec<[DVec3; 3]>,
    pub(super) low: DVec3,
    pub(super) high: DVec3,
    /// [m^3], negative if it faces inward.
    pub(super) volume: f64,
    /// [m^2]
    pub(super) area: f64,
}

/// The solid or cavity that a shell bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Role {
    /// A solid of its own.
    Solid,
    /// A solid in another shell's solid.
    In(usize),
    /// A cavity of the shell's solid.
    CavityOf(usize),
    /// The same solid as another shell.
    Repeated,
}

impl Shell {
    pub(super) fn new(corners: Vec<[DVec3; 3]>) -> Self {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for &corner in corners.iter().flatten() {
            low = low.min(corner);
            high = high.max(corner);
        }
        let middle = 0.5 * (low + high);
        let (mut volume, mut area) = (0.0, 0.0);
        for &[a, b, c] in &corners {
            let across = (b - a).cross(c - a);
            area += 0.5 * across.length();
            volume += (a - middle).dot(across) / 6.0;
        }
        Self { corners, low, high, volume, area }
    }

    pub(super) fn diagonal(&self) -> f64 {
        (self.high - self.low).length()
    }

    /// Sample points on its triangles, spread over the list.
    fn samples(&self) -> impl Iterator<Item = DVec3> + '_ {
        let step = self.corners.len().div_ceil(SAMPLES).max(1);
        self.corners.iter().step_by(step).map(|&[a, b, c]| (a + b + c) / 3.0)
    }

    fn surrounds(&self, other: &Self) -> bool {
        let margin = SAME * self.diagonal();
        (self.low - margin).cmple(other.low).all() && (self.high + margin).cmpge(other.high).all()
    }

    /// True if another shell has the same surface, perhaps in other triangles or turned round.
    fn repeats(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
        let alike = self.surrounds(other)
            && other.surrounds(self)
            && close(self.volume.abs(), other.volume.abs())
            && close(self.area, other.area);
        if !alike {
            return false;
        }
        let margin = SAME * self.diagonal();
        let tree = Bvh::new(&other.corners);
        self.samples().all(|point| tree.closest(point, margin * margin).is_some())
    }
}

/// Role of each shell. A nested shell with opposite orientation is a cavity, and a shell in a
/// cavity is a solid.
pub(super) fn roles(shells: &[Shell]) -> Vec<Role> {
    let boxes: Vec<(DVec3, DVec3)> = shells.iter().map(|shell| (shell.low, shell.high)).collect();
    let tree = Bvh::of_boxes(&boxes);
    let mut windings: Vec<Option<WindingNumber>> = shells.iter().map(|_| None).collect();
    let mut roles = vec![Role::Solid; shells.len()];

    // The largest first: what surrounds a shell has its role already.
    let mut order: Vec<usize> = (0..shells.len()).collect();
    let size = |shell: usize| shells[shell].volume.abs();
    order.sort_by(|&a, &b| size(b).total_cmp(&size(a)).then(a.cmp(&b)));
    let mut rank = vec![0; shells.len()];
    order.iter().enumerate().for_each(|(place, &shell)| rank[shell] = place);
    for &inner in &order {
        let shell = &shells[inner];
        let mut around: Vec<usize> = Vec::new();
        let margin = SAME * shell.diagonal();
        let enters = |low: DVec3, high: DVec3| {
            (low - margin).cmple(shell.low).all() && (high + margin).cmpge(shell.high).all()
        };
        tree.visit(enters, |outer| {
            let known = rank[outer] < rank[inner] && roles[outer] != Role::Repeated;
            if known && shells[outer].surrounds(shell) {
                around.push(outer);
            }
        });
        around.sort_by_key(|&outer| std::cmp::Reverse(rank[outer]));

        // Choose the smallest enclosing shell.
        for outer in around {
            if shell.repeats(&shells[outer]) {
                roles[inner] = Role::Repeated;
                break;
            }
            let winding = windings[outer]
                .get_or_insert_with(|| WindingNumber::new(Bvh::new(&shells[outer].corners)));
            if lies_in(shell, winding) {
                let opposite = (shell.volume < 0.0) != (shells[outer].volume < 0.0);
                let in_solid = matches!(roles[outer], Role::Solid | Role::In(_));
                if in_solid {
                    roles[inner] = if opposite { Role::CavityOf(outer) } else { Role::In(outer) };
                }
                break;
            }
        }
    }
    roles
}

/// True if a shell lies in the volume of another; it may touch the other from inside.
fn lies_in(shell: &Shell, outer: &WindingNumber) -> bool {
    let mut inside = 0;
    for point in shell.samples() {
        let winding = outer.at(point).abs();
        if winding < 0.25 {
            return false;
        }
        inside += usize::from(winding > 0.75);
    }
    inside > 0
}
