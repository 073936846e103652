use super::*;
use crate::manifold::ManifoldPoint;
use crate::pair::Pair;
use crate::{Contactant, NewBody, Pose, Velocity};
use frangible_geometry::{ClosedForm, Shape};
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// Each pair of a cluster is in one rank, and no body in two pairs of it; pairs without points are behind all others in heaps, and among them where
/// impacts follow each other.
#[test]
fn what_is_watched_has_ranks_of_its_own_in_heaps() {
    const COUNT: usize = 12;
    let shape = Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1));
    let mut bodies = Bodies::default();
    for i in 0..COUNT {
        bodies.spawn(NewBody {
            shape: shape.clone(),
            density: 1.0,
            motion: Motion::Dynamic,
            pose: Pose { position: i as f64 * DVec3::X, orientation: DQuat::IDENTITY },
            velocity: Velocity::default(),
            contactant: Contactant::new(0.0, 0.5),
        });
    }
    let point = ManifoldPoint {
        anchor_first: DVec3::ZERO,
        anchor_second: DVec3::ZERO,
        rounding: [0.5; 2],
        normal: DVec3::X,
        sample: (true, 0),
        approach: 0.0,
        gap: 0.0,
    };
    // Neighbours touch, and each may be pushed to the one after its neighbour.
    let points = [point];
    let mut manifolds = Vec::new();
    for first in 0..COUNT {
        let others = (first + 1..COUNT).take(2);
        manifolds.extend(others.map(|second| {
            let points: &[ManifoldPoint] = if second == first + 1 { &points } else { &[] };
            Manifold { pair: Pair { first, second }, points, struck: 1.0 }
        }));
    }
    let carried = vec![&[][..]; manifolds.len()];
    let touching = Touching { manifolds: &manifolds, carried: &carried, near: 0.0 };
    let pairs: Vec<usize> = (0..manifolds.len()).collect();
    let mut local = vec![NOWHERE; COUNT];
    for (size, is_heap) in [(pairs.len(), false), (1 << 20, true)] {
        let effort = Effort::of_size(size);
        let (stiffness, settled) = (vec![1.0; manifolds.len()], vec![true; COUNT]);
        let plan = Plan {
            clusters: vec![(pairs.clone(), effort)],
            stiffness,
            settled,
            sleep: Sleep::default(),
            balance: Balance::default(),
        };
        let cluster = Cluster::new(&bodies, touching, &plan, 0, &mut local);
        let mut all: Vec<usize> = cluster.members.iter().map(|member| member.manifold).collect();
        let touch = all.iter().filter(|&&at| !manifolds[at].points.is_empty()).count();
        let are_last = all[touch..].iter().all(|&at| manifolds[at].points.is_empty());
        assert_eq!(are_last, is_heap, "{all:?}");
        all.sort_unstable();
        assert_eq!(all, pairs);
        let mut begin = 0;
        for &end in cluster.rank_ends.iter().flatten() {
            let mut in_rank: Vec<u32> =
                cluster.members[begin..end].iter().flat_map(|member| member.locals).collect();
            in_rank.sort_unstable();
            assert!(begin < end && in_rank.is_sorted_by(|a, b| a < b), "{in_rank:?}");
            begin = end;
        }
        assert_eq!(begin, pairs.len());
    }
}

/// Who could come to rest for some frames, one after the other, has settled, unless it has been pushed since; what is static has, what is driven has not.
#[test]
fn who_could_rest_for_some_frames_has_settled() {
    let shape = Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1));
    let mut bodies = Bodies::default();
    let driven = Motion::Kinematic { linear: DVec3::X, angular: DVec3::ZERO };
    let dynamic = Motion::Dynamic;
    for motion in [Motion::Static, dynamic, dynamic, dynamic, driven] {
        bodies.spawn(NewBody {
            shape: shape.clone(),
            density: 1.0,
            motion,
            pose: Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY },
            velocity: Velocity::default(),
            contactant: Contactant::new(0.0, 0.5),
        });
    }
    let warm = WarmStart::of_parts(
        &bodies,
        (0, vec![]),
        &[u8::MAX, SETTLED_AFTER - 1, SETTLED_AFTER, u8::MAX, u8::MAX],
        &[false; 5],
        &[],
    );
    let settings = crate::StepSettings::default();
    let frame = Frame { dt: 1.0 / 30.0, gravity: -9.81 * DVec3::Y, settings };
    bodies.velocities[3].linear = DVec3::X;
    let nothing = Touching { manifolds: &[], carried: &[], near: 0.0 };
    assert_eq!(plan(&bodies, nothing, &warm, &frame).settled, [true, false, true, false, false]);
    let nobody = plan(&bodies, nothing, &WarmStart::default(), &frame).settled;
    assert_eq!(nobody, [true, false, false, false, false]);
}

/// What moves is solved apart from what has settled, as far as it can be: in other clusters, what may bounce apart from what creeps, and in an island in other ranks.
#[test]
fn who_moves_keeps_nobody_awake() {
    const COUNT: usize = 60;
    let shape = Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1));
    let mut bodies = Bodies::default();
    for i in 0..COUNT {
        // Every sixth pair creeps, and every sixth flies.
        let speed = [0.0, 0.0, 1e-2, 0.0, 0.0, 1.0][i / 2 % 6];
        bodies.spawn(NewBody {
            shape: shape.clone(),
            density: 1.0,
            motion: Motion::Dynamic,
            pose: Pose { position: i as f64 * DVec3::X, orientation: DQuat::IDENTITY },
            velocity: Velocity { linear: speed * DVec3::X, ..Velocity::default() },
            contactant: Contactant::new(0.0, 0.5),
        });
    }
    let pair =
        |first: usize, second: usize| Manifold { pair: Pair { first, second }, points: &[], struck: 0.0 };
    let warm = WarmStart::of_parts(&bodies, (0, vec![]), &[u8::MAX; COUNT], &[false; COUNT], &[]);
    let frame = Frame { dt: 1.0 / 30.0, gravity: -9.81 * DVec3::Y, settings: crate::StepSettings::default() };
    let kind = |i: usize| (i / 2 % 6 == 2, i / 2 % 6 == 5);

    // As islands of their own they are in clusters of their kind.
    let manifolds: Vec<Manifold> = (0..COUNT / 2).map(|at| pair(2 * at, 2 * at + 1)).collect();
    let carried = vec![&[][..]; manifolds.len()];
    let touching = Touching { manifolds: &manifolds, carried: &carried, near: 0.0 };
    let all = plan(&bodies, touching, &warm, &frame);
    assert_eq!(all.clusters.len(), 3);
    for (pairs, _) in &all.clusters {
        assert!(pairs.iter().all(|&at| kind(2 * at) == kind(2 * pairs[0])), "{pairs:?}");
    }

    // In one island they have ranks of their own.
    let every_other = |from: usize| (from..COUNT - 1).step_by(2);
    let manifolds: Vec<Manifold> = every_other(0).chain(every_other(1)).map(|at| pair(at, at + 1)).collect();
    let carried = vec![&[][..]; manifolds.len()];
    let touching = Touching { manifolds: &manifolds, carried: &carried, near: 0.0 };
    let all = plan(&bodies, touching, &warm, &frame);
    let cluster = Cluster::new(&bodies, touching, &all, 0, &mut vec![NOWHERE; COUNT]);
    assert_eq!(cluster.members.len(), COUNT - 1);
    let mut begin = 0;
    for &end in cluster.rank_ends.iter().flatten() {
        let is_settled =
            |member: &Member| member.locals.iter().all(|&at| all.settled[cluster.bodies[at as usize]]);
        let settled = cluster.members[begin..end].iter().filter(|member| is_settled(member)).count();
        assert!(settled == 0 || settled == end - begin, "{settled} of {begin}..{end}");
        begin = end;
    }
}

/// A body of a hundred pairs has one in each rank, whether ranks are taken in order or wherever they are free; and two that share nothing
/// are side by side.
#[test]
fn pairs_of_a_rank_share_no_body() {
    for is_one_region in [true, false] {
        let mut ranks = NextRanks::new(103, is_one_region);
        let of_first: Vec<usize> = (1..101).map(|other| ranks.next([0, other].into_iter())).collect();
        assert_eq!(of_first, (0..100).collect::<Vec<_>>());
        assert_eq!(ranks.next([101, 102].into_iter()), 0);
        let again = ranks.next([50, 101].into_iter());
        assert_eq!(again, if is_one_region { 50 } else { 1 }, "behind both, or where both are free");
        ranks.clear(0);
        ranks.clear(3);
        assert_eq!(ranks.next([0, 3].into_iter()), 0);
    }
}
