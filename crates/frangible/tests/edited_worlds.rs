//! Random worlds that are edited as they run: whatever a caller does between frames, nothing is
//! lost, nothing makes energy, and no frame stalls. `make edited-worlds WORLDS=1000` runs more, and
//! prints what it finds.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::bodies::Motion;
use frangible::{BodyDesc, SceneDesc, StepReport, World, step};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Worlds in a run of the tests, and frames of each.
const FEW: u64 = 6;
const FRAMES: u64 = 40;

/// A frame stalls that takes so many times the world's median, and so long [s] of processor time.
const TIMES_MEDIAN: f64 = 50.0;
const LONG: f64 = 0.1;

/// Processor time after which a world is not stepped further [s].
const MOST_TIME: f64 = 1.0;

/// Largest gain of energy of a frame, and change of momentum, in units of what is in play [1].
const MOST_GAIN: f64 = 1e-9;

/// Processor time of this thread [s]; the wall's where it is not told.
fn seconds() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(
        || std::time::UNIX_EPOCH.elapsed().unwrap().as_secs_f64(),
        |nanoseconds| 1e-9 * nanoseconds,
    )
}

struct Draw(Pcg64Mcg);

impl Draw {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        if low < high { self.0.random_range(low..high) } else { low }
    }

    /// Evenly in the logarithm.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn one(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    fn happens(&mut self, chance: f64) -> bool {
        self.between(0.0, 1.0) < chance
    }

    fn vector(&mut self, size: f64) -> [f64; 3] {
        [0; 3].map(|_| size * self.between(-1.0, 1.0))
    }

    fn rotation(&mut self) -> [f64; 4] {
        [0; 4].map(|_| self.between(-1.0, 1.0) + 0.01)
    }
}

/// A closed prism of triangles around the z axis, as a drum.
fn drum(draw: &mut Draw, radius: f64, length: f64, sides: &str) -> Value {
    let count = 6 + draw.one(7);
    let at = |n: usize, z: f64| {
        let angle = TAU * n as f64 / count as f64;
        json!([radius * angle.cos(), radius * angle.sin(), z])
    };
    let ends = [-0.5 * length, 0.5 * length];
    let positions: Vec<Value> =
        ends.into_iter().flat_map(|z| (0..count).map(move |n| at(n, z))).collect();
    let mut triangles = Vec::new();
    for a in 0..count {
        let b = (a + 1) % count;
        triangles.extend([[a, b, b + count], [a, b + count, a + count]]);
    }
    for a in 1..count - 1 {
        triangles.extend([[0, a + 1, a], [count, count + a, count + a + 1]]);
    }
    if sides == "one" {
        triangles.iter_mut().for_each(|corners| corners.reverse());
    }
    json!({"kind": "triangles", "positions": positions, "triangles": triangles, "sides": sides})
}

/// A body of about a size [m].
fn body(draw: &mut Draw, size: f64, at: [f64; 3], speed: f64) -> Value {
    let thin = [1.0, 1.0, 0.2, 0.03][draw.one(4)];
    let shape = match draw.one(7) {
        0 => json!({"kind": "sphere", "radius": 0.5 * size}),
        1 => json!({"kind": "cylinder", "radius": 0.4 * size, "height": thin * size}),
        2 => json!({"kind": "capsule", "radius": 0.2 * size, "height": 0.5 * size}),
        3 => json!({"kind": "compound", "parts": [
            {"kind": "box", "size": [size, 0.2 * size, 0.2 * size]},
            {"kind": "box", "size": [0.2 * size, 0.8 * size, 0.2 * size]}]}),
        4 => {
            let points: Vec<[f64; 3]> = (0..12).map(|_| draw.vector(0.5 * size)).collect();
            json!({"kind": "hull", "points": points})
        }
        _ => json!({"kind": "box", "size": [size, thin * size, 0.7 * size]}),
    };
    let is_convex = shape["kind"] != "compound";
    let mut body = json!({
        "shape": shape, "position": at, "orientation": draw.rotation(),
        "density": draw.scale(50.0, 2e4), "friction": ([0.0, 0.5, 2.0][draw.one(3)]),
        "restitution": ([0.0, 0.5, 1.0][draw.one(3)]), "linear_velocity": draw.vector(speed),
        "angular_velocity": draw.vector(20.0),
    });
    if is_convex && draw.happens(0.4) {
        let pattern = match draw.one(3) {
            0 => json!({"kind": "voronoi", "cells": 2 + draw.one(30)}),
            1 => json!({"kind": "splinters"}),
            _ => json!({"kind": "radial"}),
        };
        body["breaking"] = json!({
            "pattern": pattern, "generations": 1 + draw.one(3),
            "strength": draw.scale(1e-3, 1e3) * size.powi(3),
        });
    } else if is_convex && draw.happens(0.2) {
        body["bonds"] = json!({"pattern": {"kind": "voronoi", "cells": 6},
            "tensile_strength": draw.scale(1e3, 1e7), "shear_strength": draw.scale(1e3, 1e7)});
    }
    body
}

/// A scene, its size [m], and whether it is closed.
fn scene(draw: &mut Draw) -> (SceneDesc, f64, bool) {
    let size = draw.scale(1e-3, 30.0);
    let rates = [10.0, 15.0, 24.0, 30.0, 60.0, 240.0];
    let rate = rates[draw.one(rates.len())];
    // What crosses half of its own size in a frame, or less.
    let speed = (2.0 * size * rate).min(20.0);
    let is_drum = draw.happens(0.5);
    let mut bodies = Vec::new();
    if is_drum {
        let sides = ["one", "two"][draw.one(2)];
        let shape = drum(draw, 6.0 * size, 12.0 * size, sides);
        let turns = if draw.happens(0.5) { draw.between(0.0, 4.0) } else { 0.0 };
        bodies.push(json!({"motion": "kinematic", "shape": shape, "restitution": 1.0,
                           "angular_velocity": [0.0, 0.0, turns]}));
    } else {
        bodies.push(json!({"motion": "static", "shape": {"kind": "half-space"},
                           "position": [0.0, -6.0 * size, 0.0]}));
        let plate = json!({"kind": "box", "size": [12.0 * size, size, 12.0 * size]});
        bodies.push(json!({"motion": "kinematic", "shape": plate,
            "position": [0.0, 9.0 * size, 0.0], "linear_velocity": [0.0, -3.0 * size, 0.0]}));
    }
    for _ in 0..3 + draw.one(25) {
        let (own, at) = (size * draw.scale(0.1, 1.5), draw.vector(3.0 * size));
        bodies.push(body(draw, own, at, speed));
    }
    let scene = json!({"name": "edited", "frames_per_second": rate, "bodies": bodies});
    (serde_json::from_value(scene).unwrap(), size, is_drum)
}

/// Does something to a world between two frames.
fn edit(world: &mut World, draw: &mut Draw, size: f64) {
    let all = world.bodies();
    let dynamic: Vec<_> =
        (0..all.len()).filter(|&i| all.motions[i] == Motion::Dynamic).map(|i| all.ids[i]).collect();
    if dynamic.is_empty() {
        return;
    }
    let id = dynamic[draw.one(dynamic.len())];
    let at = world.bodies().poses[world.bodies().index_of(id).unwrap()].position;
    let random = DVec3::from_array(draw.vector(size));
    // What cannot be is refused; that is an answer.
    match draw.one(8) {
        0 => {
            let own = size * draw.scale(0.1, 1.0);
            let new = body(draw, own, random.to_array(), 0.0);
            let _ = world.add_body(&serde_json::from_value::<BodyDesc>(new).unwrap());
        }
        1 => world.remove_body(id).unwrap(),
        2 => {
            let _ = world.cut(id, at, random);
        }
        3 => {
            let _ = world.burst(id, at, draw.scale(1e-3, 10.0));
        }
        4 => {
            let _ = world.hold(id, at, at + random, draw.scale(1e-3, 1e3));
        }
        5 => {
            world.let_go(id);
        }
        6 => *world = World::restore(&world.snapshot().unwrap()).unwrap(),
        _ => {
            let _ = world.apply_impulse(id, random * draw.scale(1e-3, 1e2), at);
        }
    }
}

/// What is wrong with a report of a frame.
fn faults(report: &StepReport, in_play: f64) -> Vec<String> {
    let mut faults = Vec::new();
    if !report.quarantined.is_empty() {
        faults.push(format!("{:?}", report.quarantined));
    }
    if report.energy.gain.is_nan() || report.energy.gain > MOST_GAIN * in_play {
        faults.push(format!("gains {:e} of {in_play:e} J", report.energy.gain));
    }
    let momentum = report.momentum.linear_error.max(report.momentum.angular_error);
    if momentum.is_nan() || momentum > 1e-6 {
        faults.push(format!("momentum {momentum:e}"));
    }
    for fracture in &report.fractures {
        if fracture.imbalance.mass.is_nan() || fracture.imbalance.mass.abs() > 1e-6 {
            faults.push(format!("mass {:e}", fracture.imbalance.mass));
        }
    }
    faults
}

/// What one world did.
#[derive(Default)]
struct Found {
    faults: Vec<String>,
    stalls: Vec<String>,
    frames: usize,
    short: usize,
}

fn run(seed: u64) -> Found {
    let mut draw = Draw(Pcg64Mcg::seed_from_u64(seed));
    let (scene, size, is_drum) = scene(&mut draw);
    let mut found = Found::default();
    let Ok(mut world) = World::build(&scene) else { return found };
    let edits = draw.happens(0.7);
    let (mut times, mut in_play) = (Vec::new(), 0.0_f64);
    for frame in 0..FRAMES {
        if edits && draw.happens(0.3) {
            edit(&mut world, &mut draw, size);
        }
        let begin = seconds();
        let report = step(&mut world);
        times.push(seconds() - begin);
        in_play = in_play.max(report.energy.kinetic).max(report.energy.potential.abs());
        found.short += usize::from(report.short_of_impacts > 0);
        let of_frame = faults(&report, in_play).into_iter();
        found.faults.extend(of_frame.map(|fault| format!("frame {frame}: {fault}")));
        let bodies = world.bodies();
        let lost = |i: usize| {
            let away = bodies.poses[i].position.length();
            is_drum && bodies.motions[i] == Motion::Dynamic && away > 12.0 * size
        };
        if let Some(i) = (0..bodies.len()).find(|&i| lost(i)) {
            found.faults.push(format!("frame {frame}: {} is lost", world.labels()[i].name));
            break;
        }
        if times.iter().sum::<f64>() > MOST_TIME {
            break;
        }
    }
    found.frames = times.len();
    let mut sorted = times.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    for (frame, &time) in times.iter().enumerate() {
        if time > LONG && time > TIMES_MEDIAN * median {
            let bodies = world.bodies().len();
            found
                .stalls
                .push(format!("frame {frame}: {time:.3} s, median {median:.4} s, {bodies} bodies"));
        }
    }
    found
}

#[test]
fn edits_lose_nothing_and_stall_nothing() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let (first, count) = (number("FIRST").unwrap_or(0), number("WORLDS").unwrap_or(FEW));
    let (mut faults, mut stalls, mut frames, mut short) = (Vec::new(), Vec::new(), 0, 0);
    for seed in first..first + count {
        match catch_unwind(AssertUnwindSafe(|| run(seed))) {
            Ok(found) => {
                frames += found.frames;
                short += found.short;
                faults.extend(found.faults.iter().take(2).map(|fault| format!("{seed}: {fault}")));
                stalls.extend(found.stalls.iter().map(|stall| format!("{seed}: {stall}")));
            }
            Err(_) => faults.push(format!("{seed}: panics")),
        }
    }
    println!(
        "{count} worlds, {frames} frames, {short} short of impacts\nstalls:\n{}",
        stalls.join("\n")
    );
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // A share of few frames says nothing.
    assert!(frames < 1000 || 100 * short <= frames, "{short} of {frames} are short of impacts");
}

/// Drums of triangles that are solid on both sides keep all that is in them, at rest and turning, at
/// any rate.
#[test]
fn closed_sheets_keep_what_is_in_them() {
    for seed in 0..12 {
        let mut draw = Draw(Pcg64Mcg::seed_from_u64(seed));
        let radius = draw.between(0.3, 2.0);
        let shape = drum(&mut draw, radius, radius, "two");
        let spin = if seed % 2 == 0 { 0.0 } else { draw.between(0.0, 4.0) };
        let mut bodies = vec![json!({"motion": "kinematic", "shape": shape, "restitution": 1.0,
                                     "angular_velocity": [0.0, 0.0, spin]})];
        for number in 0..9 {
            // Beside each other, so that nothing is pushed at the start.
            let at = [number % 3 - 1, number / 3 - 1].map(|n| 0.35 * radius * f64::from(n));
            let size = draw.scale(1e-3, 0.15 * radius);
            let mut body = body(&mut draw, size, [at[0], at[1], 0.0], 5.0);
            body.as_object_mut().unwrap().retain(|key, _| key != "breaking" && key != "bonds");
            bodies.push(body);
        }
        let rate = [10.0, 15.0, 24.0, 30.0, 60.0][seed as usize % 5];
        let scene = json!({"name": "drum", "frames_per_second": rate, "bodies": bodies});
        let scene = serde_json::from_value::<SceneDesc>(scene).unwrap();
        let mut world = World::build(&scene).unwrap();
        for frame in 0..(2.0 * rate) as u32 {
            step(&mut world);
            let bodies = world.bodies();
            let away = bodies.poses.iter().map(|pose| pose.position.length());
            let furthest = away.fold(0.0, f64::max);
            assert!(
                furthest < 1.3 * radius,
                "drum {seed}, frame {frame}: {furthest} of {radius} m"
            );
        }
    }
}
