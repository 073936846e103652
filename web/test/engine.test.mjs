import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { before, test } from "node:test";
import { LiveFootage, MATERIALS, PATTERNS, SHAPES, SHOTS, Simulator, World, ball, crossed, decode, encode, pick, scene, sceneOf, shaded, shotScene } from "../dist/playground.mjs";
import { Box3, Vector3 } from "three";
import { load } from "./engine.mjs";

before(load);

const read = (path) => readFile(new URL(path, import.meta.url), "utf8");

/** What a simulator tells. */
function listener() {
  const told = [];
  const simulator = new Simulator((word) => told.push(word));
  const states = () => told.filter(({ kind }) => kind === "frame").map(({ state }) => state);
  const faults = () => told.filter(({ kind }) => kind === "fault").map(({ sentence }) => sentence);
  return { told, simulator, states, faults, last: () => states().at(-1) };
}

const CHOICE = { shape: "wall", material: "concrete", pattern: "Voronoi cells", pieces: 20, strength: 1 };
const STORY = { scene: sceneOf(CHOICE), actions: [{ frame: 0, add: ball(0.2, [0, 0.9, 2], [0, 0, -20], 1) }] };

test("shots end in the states that the native engine ends in", async () => {
  for (const line of (await read("../../crates/shots/tests/same_bits.txt")).trim().split("\n")) {
    const [shot, expected] = line.split(" ");
    const world = new World(shotScene(shot));
    for (let frame = 0; frame < 120; frame++) world.step();
    assert.equal(world.stateHash(), expected, shot);
    world.free();
  }
});

for (const file of ["story.json", "deeds.json"])
  test(`${file} ends in the state that the native engine ends in`, async () => {
    const { frames, hash, ...story } = JSON.parse(await read(file));
    const { simulator, last, faults } = listener();
    simulator.obey({ kind: "build", story: await decode(await encode(story)), frames });
    assert.deepEqual(faults(), []);
    assert.deepEqual([last().frame, last().hash], [frames, hash]);
  });

test("a story that was played with ends in the same state when it is told again", async () => {
  const played = listener();
  played.simulator.obey({ kind: "build", story: STORY, frames: 0 });
  played.simulator.obey({ kind: "step", frames: 12 });
  played.simulator.obey({ kind: "do", deed: { add: ball(0.1, [0.5, 1, 2], [0, 0, -25], 2) } });
  played.simulator.obey({ kind: "step", frames: 20 });
  assert.deepEqual(played.faults(), []);
  assert.ok(played.last().ids.length > 10, "the wall is whole");

  const story = await decode(await encode(played.told.at(-1).story));
  const again = listener();
  again.simulator.obey({ kind: "build", story, frames: 32 });
  assert.equal(again.last().hash, played.last().hash);
});

test("a world that is slow is not stepped longer than somebody is patient", () => {
  const { simulator, states, faults } = listener();
  simulator.obey({ kind: "build", story: STORY, frames: 0 });
  simulator.obey({ kind: "step", frames: 100_000, patience: 50 });
  assert.deepEqual(faults(), []);
  assert.ok(states().length > 1 && states().length < 100_000, `${states().length} frames`);
});

test("what is undone has not happened", () => {
  const { simulator, told, last, states } = listener();
  simulator.obey({ kind: "build", story: STORY, frames: 5 });
  const { hash, frame } = last();
  simulator.obey({ kind: "do", deed: { add: ball(0.1, [0, 1, 1], [0, 0, -25], 2) } });
  simulator.obey({ kind: "step", frames: 10 });
  const changed = last().hash;
  simulator.obey({ kind: "undo" });
  assert.equal(told.at(-2).frame, frame + 1);
  simulator.obey({ kind: "step", frames: 10 });
  const plain = listener();
  plain.simulator.obey({ kind: "build", story: STORY, frames: 15 });
  assert.equal(last().hash, plain.last().hash);
  assert.notEqual(last().hash, changed);
  assert.ok(states().some((state) => state.hash === hash));
  // Pieces that are made anew are told anew.
  const born = new Set(plain.states().flatMap((state) => state.born.map(({ id }) => id)));
  const toldBorn = states().slice(-10).flatMap((state) => state.born.map(({ id }) => id));
  for (const id of last().ids) assert.ok(born.has(id));
  assert.ok(toldBorn.length >= last().ids.length - 4);
});

test("a drag is undone at once, and what changes nothing is no deed", () => {
  const { simulator, told, last, faults } = listener();
  simulator.obey({ kind: "build", story: { scene: sceneOf(CHOICE), actions: [] }, frames: 2 });
  const before = last();
  const wall = before.ids[1];
  const does = (deed) => simulator.obey({ kind: "do", deed });
  const hold = (y) => does({ hold: { body: wall, point: [0.5, 0, 0], target: [0.5, y, 0], force: 6e4 } });
  for (const y of [1, 1.5, 2]) {
    hold(y);
    simulator.obey({ kind: "step", frames: 5 });
  }
  does({ letGo: wall });
  does({ letGo: wall });
  does({ cut: { body: wall, point: [0, 9, 0], normal: [0, 1, 0] } });
  assert.deepEqual(faults(), []);
  assert.equal(told.at(-1).story.actions.length, 4);
  assert.ok(last().poses[8] > 1, `lifted to ${last().poses[8]} m`);
  simulator.obey({ kind: "undo" });
  assert.equal(told.at(-1).story.actions.length, 0);
  simulator.obey({ kind: "step", frames: 1 });
  assert.equal(last().frame, before.frame + 1);
  assert.ok(last().poses[8] < 0.81);
  simulator.obey({ kind: "undo" });
  assert.equal(told.at(-1).kind, "done");
});

test("what is under the pointer is found, and what a line crosses", () => {
  const { simulator, states, last } = listener();
  simulator.obey({ kind: "build", story: STORY, frames: 1 });
  const footage = new LiveFootage("", 60, states()[0]);
  footage.append(last());
  const from = (x, y, z) => ({ origin: new Vector3(x, y, z), direction: new Vector3(0, 0, -1) });
  // The wall is 2.4 x 1.6 x 0.25 m and stands on the ground; the ball is before it.
  const hit = pick(footage, 0, from(0.7, 0.5, 5));
  assert.deepEqual([hit.name, hit.body], ["wall", last().ids[1]]);
  assert.ok(hit.point.distanceTo(new Vector3(0.7, 0.5, 0.125)) < 1e-5 && hit.pointBody.distanceTo(new Vector3(0.7, -0.3, 0.125)) < 1e-5);
  assert.equal(pick(footage, 1, from(0, 0.9, 5)).name, "ball 1");
  assert.equal(pick(footage, 0, from(3, 0.5, 5)), null);
  const eye = new Vector3(0, 0.8, 5);
  const towards = (x, y) => ({ origin: eye, direction: new Vector3(x, y, 0).sub(eye).normalize() });
  const { bodies, normal } = crossed(footage, 0, towards(-2, 1.2), towards(2, 1.2));
  assert.deepEqual(bodies, [hit.body]);
  // The plane holds the eye and the line.
  assert.ok(Math.abs(normal.dot(towards(0.3, 1.2).direction)) < 1e-9);
  simulator.obey({ kind: "do", deed: { cut: { body: bodies[0], point: eye.toArray(), normal: normal.toArray() } } });
  simulator.obey({ kind: "step", frames: 1 });
  assert.equal(last().ids.length, states()[1].ids.length + 1);
});

test("pieces that are taken home are where they were seen", () => {
  const { simulator, states } = listener();
  simulator.obey({ kind: "build", story: STORY, frames: 12 });
  const [first, ...rest] = states();
  const footage = new LiveFootage("", 60, first);
  for (const state of rest) footage.append(state);
  const group = scene(footage, 12);
  assert.equal(group.children.length, footage.state(12).ids.length - 1);
  const box = new Box3().setFromObject(group, true);
  assert.ok(box.min.y > -0.01 && box.max.y < 2 && box.max.x < 2, JSON.stringify(box));
  for (const { geometry, material } of group.children)
    for (const { materialIndex, count } of geometry.groups) assert.ok(material[materialIndex] !== undefined && count % 3 === 0);
});

test("scenes of the menu are the engine's", () => {
  for (const name of Object.keys(SHOTS)) assert.ok(JSON.parse(shotScene(name)).bodies.length > 1, name);
  const { simulator, last, faults } = listener();
  simulator.obey({ kind: "shot", name: "stack" });
  assert.deepEqual(faults(), []);
  assert.ok(last().ids.length > 2);
});

test("faults are sentences", () => {
  const { simulator, faults } = listener();
  simulator.obey({ kind: "step", frames: 1 });
  simulator.obey({ kind: "build", story: { scene: '{"bodies": [{"shape": {"kind": "sphere", "radius": -1}}]}', actions: [] }, frames: 1 });
  simulator.obey({ kind: "build", story: STORY, frames: 1 });
  simulator.obey({ kind: "do", deed: { add: { shape: { kind: "sphere" } } } });
  assert.equal(faults()[0], "nothing is built yet");
  assert.match(faults()[1], /^bodies\[0\]\.shape\.radius: -1/);
  assert.match(faults()[2], /^body\.shape/);
  assert.equal(faults().length, 3);
});

test("every choice of the menus breaks", () => {
  const choices = [
    ...Object.keys(SHAPES).map((shape) => ({ ...CHOICE, shape })),
    ...MATERIALS.filter((name) => name !== "steel").map((material) => ({ ...CHOICE, material, shape: "cube" })),
    ...Object.keys(PATTERNS).map((pattern) => ({ ...CHOICE, pattern, shape: "cube" })),
  ];
  for (const choice of choices) {
    const { simulator, last, faults } = listener();
    const actions = [{ frame: 0, add: ball(0.2, [0, 0.7, 1.6], [0, 0, -40], 1) }];
    simulator.obey({ kind: "build", story: { scene: sceneOf({ ...choice, strength: 0.1 }), actions }, frames: 8 });
    assert.deepEqual(faults(), []);
    assert.ok(last().ids.length > 4, `${JSON.stringify(choice)}: ${last().ids.length} bodies`);
  }
});

test("a dropped mesh stands on the ground, and breaks", () => {
  const mesh = new World(JSON.stringify({ bodies: [{ shape: { kind: "cylinder", radius: 3, height: 9 } }] })).surface(0);
  const rows = (flat) => Array.from({ length: flat.length / 3 }, (_, i) => [...flat.subarray(3 * i, 3 * i + 3)]);
  const shape = { name: "own", positions: rows(mesh.positions()), triangles: rows(mesh.triangles()) };
  const { simulator, last, faults } = listener();
  simulator.obey({ kind: "build", story: { scene: sceneOf({ ...CHOICE, shape }), actions: [] }, frames: 10 });
  assert.deepEqual(faults(), []);
  assert.ok(Math.abs(last().poses[8] - 0.75) < 0.01, `its middle stands at ${last().poses[8]} m`);
  simulator.obey({ kind: "do", deed: { add: ball(0.2, [0, 0.8, 1], [0, 0, -40], 1) } });
  simulator.obey({ kind: "step", frames: 6 });
  assert.ok(last().ids.length > 10);
});

test("a strength of the menu is the table's", () => {
  for (const material of ["concrete", "glass", "brick", "wood", "ice"]) {
    const hashes = [1, 1 + 1e-16].map((strength) => {
      const scene = JSON.parse(sceneOf({ ...CHOICE, material, shape: "cube", strength: 2 }));
      const breaking = scene.bodies[1].breaking;
      // The table's own numbers, written out, or by name.
      breaking.strength = strength === 1 ? material : { ...breaking.strength, tensile_strength: breaking.strength.tensile_strength / 2 };
      const { simulator, last } = listener();
      const actions = [{ frame: 0, add: ball(0.2, [0, 0.7, 1.2], [0, 0, -40], 1) }];
      simulator.obey({ kind: "build", story: { scene: JSON.stringify(scene), actions }, frames: 5 });
      return last().hash;
    });
    assert.equal(hashes[0], hashes[1], material);
  }
});

test("normals are sharp at edges and smooth on curves", () => {
  const world = new World(JSON.stringify({ bodies: [{ shape: { kind: "box", size: [1, 2, 3] } }, { shape: { kind: "sphere", radius: 2 }, position: [9, 0, 0] }] }));
  const [box, round] = [0, 1].map((id) => {
    const surface = world.surface(id);
    return shaded(surface.positions(), surface.triangles(), surface.interior());
  });
  assert.equal(box.slots.length, 24);
  for (const part of box.normals) assert.ok([0, 1].includes(Math.abs(part)));
  for (let i = 0; i < round.positions.length; i++) assert.ok(Math.abs(round.positions[i] / 2 - round.normals[i]) < 0.05);
});

test("all that a line cuts is undone at once", () => {
  const { simulator, told, last } = listener();
  simulator.obey({ kind: "build", story: { scene: sceneOf(CHOICE), actions: [] }, frames: 2 });
  const [, wall] = last().ids;
  const cut = (body, height) => simulator.obey({ kind: "do", deed: { cut: { body, point: [0, height, 0], normal: [0, 1, 0] } } });
  cut(wall, 0.5);
  simulator.obey({ kind: "step", frames: 1 });
  const two = last();
  assert.equal(two.ids.length, 3);
  // Another line crosses both halves.
  for (const half of two.ids.slice(1)) simulator.obey({ kind: "do", deed: { cut: { body: half, point: [0.2, 0.5, 0], normal: [1, 0, 0] } } });
  simulator.obey({ kind: "step", frames: 1 });
  assert.equal(last().ids.length, 5);
  simulator.obey({ kind: "undo" });
  assert.equal(told.at(-1).story.actions.length, 1);
  simulator.obey({ kind: "step", frames: 1 });
  assert.equal(last().ids.length, 3);
});
test("footage shows each frame as the world told it, and forgets what is undone", () => {
  const { simulator, states } = listener();
  simulator.obey({ kind: "build", story: STORY, frames: 12 });
  const [first, ...rest] = states();
  const footage = new LiveFootage("", 60, first);
  for (const state of rest) footage.append(state);
  const fill = (time) => {
    const into = new Float32Array(8 * footage.bodies.length);
    footage.fill(time, 0, [0, 0, 0], into);
    return into;
  };
  const shown = (into) => footage.bodies.filter((_, row) => into[8 * row + 3] === 1).map(({ id }) => id);
  for (const state of states()) assert.deepEqual(shown(fill(state.frame)).sort(), [...state.ids].sort());
  const ball = footage.bodies.findIndex(({ name }) => name === "ball 1");
  const z = [1, 1.5, 2].map((time) => fill(time)[8 * ball + 2]);
  assert.ok(Math.abs(z[1] - 0.5 * (z[0] + z[2])) < 1e-5);
  const count = footage.bodies.length;
  footage.cut(3);
  assert.equal(footage.frames, 2);
  assert.ok(footage.bodies.length < count);
  for (const state of rest.slice(2)) footage.append(state);
  assert.equal(footage.bodies.length, count);
});

test("a link that unpacks to much more than a story is refused before it is unpacked", async () => {
  const text = await encode({ scene: " ".repeat(200 * 1024 * 1024), actions: [] });
  const before = process.memoryUsage().arrayBuffers;
  await assert.rejects(decode(text), /too long/);
  assert.ok(process.memoryUsage().arrayBuffers - before < 64 * 1024 * 1024);
});

test("a damaged link is refused", async () => {
  const text = await encode(STORY);
  for (const bad of [text.slice(0, -9), "", "%%%", await encode({ scene: 3, actions: [] }), ...(await Promise.all([{ frame: -1, add: {} }, { frame: 1 }, { frame: 1, add: {}, letGo: 3 }, { frame: 1, jump: 3 }, { frame: 1, cut: { body: 1, point: [0, 1], normal: [0, 1, 0] } }].map((action) => encode({ scene: "{}", actions: [action] }))))])
    await assert.rejects(decode(bad));
});
