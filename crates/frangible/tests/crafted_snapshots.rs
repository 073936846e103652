//! Snapshots with a right digest and wrong content: refused, or worlds that go on; no panic, no
//! hang. `MUTATIONS=100000 cargo test -p frangible --test crafted_snapshots` tries more.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::{SceneDesc, World, step};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// Mutations in a run of the tests.
const FEW: u64 = 2_000;

/// A restored world's frames may take as long as this [s]: thousands of times the intact world's.
const MOST_SECONDS: f64 = 20.0;

fn scene(bodies: &Value) -> World {
    let mut all = vec![json!({"motion": "static", "shape": {"kind": "half-space"}})];
    all.extend(bodies.as_array().unwrap().iter().cloned());
    let scene = json!({"name": "crafted", "frames_per_second": 30.0, "bodies": all});
    World::build(&serde_json::from_value::<SceneDesc>(scene).unwrap()).unwrap()
}

fn tetrahedron(kind: &Value) -> Value {
    let mut shape = json!({
        "kind": "triangles",
        "positions": [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 0.4, 0.0]],
        "triangles": [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
    });
    shape.as_object_mut().unwrap().extend(kind.as_object().unwrap().clone());
    shape
}

/// Small worlds that hold all kinds of values between them, after some frames.
fn worlds() -> Vec<World> {
    let cube = json!({"kind": "box", "size": [0.4, 0.4, 0.4]});
    let voxels =
        json!({"kind": "box", "size": [0.4, 0.4, 0.4], "resolution": {"voxels": [8, 8, 8]}});
    let voronoi = json!({"kind": "voronoi", "cells": 4});
    let compound = json!({"kind": "compound", "parts": [
        {"kind": "box", "size": [0.4, 0.2, 0.2]},
        {"kind": "box", "size": [0.2, 0.2, 0.4], "position": [0.0, 0.2, 0.0]},
    ]});
    let breaks = |pattern: Value| json!({"strength": 0.1, "pattern": pattern, "generations": 2});
    let falls = |shape: &Value, at: [f64; 3]| json!({"shape": shape, "position": at, "linear_velocity": [0.0, -3.0, 0.0]});
    let with = |mut body: Value, fields: Value| {
        body.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        body
    };
    let breaking = |shape: &Value, at: [f64; 3], pattern: Value| {
        with(falls(shape, at), json!({"breaking": breaks(pattern)}))
    };
    let scenes = [
        json!([
            breaking(&cube, [0.0, 0.25, 0.0], voronoi.clone()),
            falls(&cube, [0.1, 0.7, 0.0]),
            falls(&json!({"kind": "cylinder", "radius": 0.1, "height": 0.3}), [0.0, 1.0, 0.0]),
            with(falls(&compound, [1.0, 0.3, 0.0]), json!({"groups": ["a"]})),
            with(falls(&cube, [1.0, 0.6, 0.0]), json!({"passes_through": ["a"]})),
        ]),
        json!([
            breaking(&voxels, [0.0, 0.25, 0.0], json!({"kind": "concrete", "cells": 4})),
            breaking(&voxels, [1.0, 0.25, 0.0], voronoi),
        ]),
        json!([
            {"shape": voxels, "position": [0.0, 0.25, 0.0], "bonds": {
                "pattern": {"kind": "concrete", "cells": 4},
                "tensile_strength": 1e5, "shear_strength": 1e5}},
            {"shape": compound, "position": [2.0, 0.25, 0.0], "bonds": {
                "tensile_strength": 1e5, "shear_strength": 1e5}},
        ]),
        json!([
            {"motion": "static", "shape": tetrahedron(&json!({}))},
            {"motion": "kinematic", "position": [3.0, 0.0, 0.0],
             "shape": tetrahedron(&json!({"sides": "two"})), "angular_velocity": [0.0, 1.0, 0.0]},
            {"motion": "kinematic", "shape": cube, "path": [
                {"frame": 0.0, "position": [6.0, 1.0, 0.0]},
                {"frame": 30.0, "position": [6.0, 2.0, 0.0]}]},
            with(falls(&cube, [0.0, 0.7, 0.2]), json!({"friction": 0.5})),
            falls(&cube, [3.0, 0.7, 0.2]),
            {"shape": cube, "position": [0.0, 3.0, 0.2], "starts": {"when": "struck"}},
        ]),
    ];
    let after = |bodies: &Value| {
        let mut world = scene(bodies);
        for _ in 0..3 {
            step(&mut world);
        }
        let last = *world.bodies().ids.last().unwrap();
        if world.start(last) {
            world.hold(last, glam::DVec3::ZERO, glam::DVec3::Y, 10.0).unwrap();
        }
        world
    };
    scenes.iter().map(after).collect()
}

/// 64-bit FNV-1a, the digest of snapshots.
fn fnv1a(bytes: &[u8]) -> u64 {
    let add = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, add)
}

/// Where the state begins, after the name, the version and the digest.
fn state_begin(snapshot: &[u8]) -> usize {
    let name = b"frangible world\n".len();
    name + 1 + usize::from(snapshot[name]) + 8
}

/// Changes one to three places.
fn mutate(snapshot: &[u8], random: &mut Pcg64Mcg) -> Vec<u8> {
    const NUMBERS: [f64; 8] =
        [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 0.0, -1.0, 1e-300];
    let begin = state_begin(snapshot);
    let (head, mut state) = (snapshot[..begin - 8].to_vec(), snapshot[begin..].to_vec());
    for _ in 0..random.random_range(1..=3) {
        let at = random.random_range(0..state.len());
        match random.random_range(0..8) {
            0 => state[at] ^= 1 << random.random_range(0..8),
            1 => state[at] = [0, 1, 2, 0x7f, 0x80, 0xff][random.random_range(0..6)],
            2 => state[at] = state[at].wrapping_add(1),
            3 => state[at] = state[at].wrapping_sub(1),
            4 => {
                let number = NUMBERS[random.random_range(0..NUMBERS.len())].to_le_bytes();
                let count = number.len().min(state.len() - at);
                state[at..at + count].copy_from_slice(&number[..count]);
            }
            5 => {
                // A small number becomes a large one: more bytes in the same place.
                let large = [0xff, 0xff, 0xff, 0xff, 0x0f];
                state.splice(at..=at, large[5 - random.random_range(2..=5)..].iter().copied());
            }
            6 => {
                state.remove(at);
            }
            _ => {
                let from = random.random_range(0..state.len());
                let count = random.random_range(1..32).min(state.len() - from.max(at));
                state.copy_within(from..from + count, at);
            }
        }
    }
    [head, fnv1a(&state).to_le_bytes().to_vec(), state].concat()
}

/// Restores a world and asks for all that it has; true if it is one.
fn go_on(bytes: &[u8]) -> bool {
    let Ok(mut world) = World::restore(bytes) else { return false };
    for _ in 0..2 {
        step(&mut world);
    }
    for id in world.bodies().ids.clone().into_iter().skip(1) {
        world.surface(id);
        world.bodies().index_of(id).map(|i| world.bodies().shapes[i].samples().len());
        let _ = world.burst(id, glam::DVec3::ZERO, 1.0);
    }
    step(&mut world);
    world.penetrations();
    world.snapshot().unwrap();
    true
}

#[test]
fn what_is_crafted_is_refused_or_goes_on() {
    let given = std::env::var("MUTATIONS").ok().and_then(|count| count.parse().ok());
    let count: u64 = given.unwrap_or(FEW);
    let snapshots: Vec<Vec<u8>> = worlds().iter().map(|world| world.snapshot().unwrap()).collect();
    for snapshot in &snapshots {
        assert!(go_on(snapshot), "the intact world");
    }
    std::panic::set_hook(Box::new(|panic| {
        println!("{}", panic.location().map_or(String::new(), ToString::to_string));
    }));
    let (mut faults, mut accepted) = (Vec::new(), 0);
    for seed in 0..count {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let bytes = mutate(&snapshots[(seed % snapshots.len() as u64) as usize], &mut random);
        let begin = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| go_on(&bytes))) {
            Ok(is_world) => accepted += u64::from(is_world),
            Err(panic) => {
                let text = panic.downcast_ref::<String>().cloned();
                let text = text.or_else(|| panic.downcast_ref::<&str>().map(|&text| text.into()));
                faults.push(format!("seed {seed}: {}", text.unwrap_or_default()));
            }
        }
        if begin.elapsed().as_secs_f64() > MOST_SECONDS {
            faults.push(format!("seed {seed}: {:?}", begin.elapsed()));
        }
    }
    drop(std::panic::take_hook());
    println!("{count} mutations, {accepted} are worlds");
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults.join("\n"));
    assert!(accepted > count / 50, "{accepted}: the mutations reach no world");
}
