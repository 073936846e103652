// The package as a user has it: imported by its name, from what `npm pack` would take along.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFile } from "node:fs/promises";
import { before, test } from "node:test";
import { fileURLToPath } from "node:url";
import init, { MATERIALS, World, WorldReader, shotScene } from "frangible";
import { FrangibleMesh } from "frangible/three";
import { BatchedMesh, Box3, Matrix4, MeshBasicMaterial, Raycaster, Vector3 } from "three";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const WALL = {
  frames_per_second: 60,
  bodies: [
    { name: "ground", shape: { kind: "half-space" }, motion: "static" },
    { name: "wall", shape: { kind: "box", size: [2, 1.5, 0.2] }, position: [0, 0.75, 0], look: "concrete",
      breaking: { strength: "concrete", pattern: { kind: "voronoi", cells: 40 } } },
  ],
};
const BALL = { name: "ball", shape: { kind: "sphere", radius: 0.2 }, position: [0, 0.8, 1], linear_velocity: [0, 0, -30], density: 7850, look: "metal" };

before(() => init());

const batches = (view) => view.children.filter((child) => child instanceof BatchedMesh);
/** Parts of bodies that all batches draw. */
const drawn = (view) => batches(view).reduce((sum, batch) => sum + batch.instanceCount, 0);

test("a scene is built, stepped and read", () => {
  const world = new World(WALL);
  const ball = world.addBody(BALL);
  const reports = Array.from({ length: 10 }, () => world.step());
  const [fracture] = reports.flatMap(({ fractures }) => fractures);
  assert.ok(fracture.fragments.length > 10 && fracture.striker === ball);
  assert.equal(world.ids().length, reports.at(-1).bodies);
  assert.equal(world.poses().length, 7 * world.ids().length);
  assert.throws(() => new World({ bodies: [{ shape: { kind: "sphere", radius: -1 } }] }), /^Error: bodies\[0\]\.shape\.radius: -1/);
  world.free();
});

test("a shot's scene ends in the same state as its text", () => {
  const scene = shotScene("wall");
  const worlds = [new World(scene), new World(JSON.stringify(scene))];
  for (const world of worlds) for (let frame = 0; frame < 5; frame++) world.step();
  assert.equal(worlds[0].stateHash(), worlds[1].stateHash());
});

test("a view keeps in step through births, deaths and what is undone", () => {
  const world = new World(WALL);
  const view = new FrangibleMesh(world);
  const before = [drawn(view), world.snapshot()];
  assert.equal(before[0], 1);
  world.addBody(BALL);
  for (let frame = 0; frame < 20; frame++) {
    world.step();
    view.update();
  }
  // An outside of the wall and of the ball, an inside of the wall.
  assert.equal(batches(view).length, 3);
  const pieces = world.ids().length - 2;
  const [, outside, inside] = [null, ...batches(view).filter(({ material }) => material.metalness === 0)];
  assert.equal(inside.instanceCount, pieces);
  assert.ok(outside.instanceCount > 0.5 * pieces && outside.instanceCount <= pieces);

  world.restore(before[1]);
  view.update();
  assert.equal(drawn(view), before[0]);
  view.dispose();
});

test("what is drawn stands where the world says", () => {
  const world = new World({ bodies: [{ shape: { kind: "box", size: [1, 2, 3] }, position: [4, 5, 6], linear_velocity: [30, 0, 0] }], gravity: [0, 0, 0] });
  const view = new FrangibleMesh(world);
  world.step();
  view.update();
  const [batch] = batches(view);
  const place = () => new Vector3().setFromMatrixPosition(batch.getMatrixAt(0, new Matrix4())).toArray();
  assert.deepEqual(place(), [5, 5, 6]);
  view.interpolate(0.25);
  assert.deepEqual(place(), [4.25, 5, 6]);
  view.interpolate(1);
  const box = new Box3().setFromObject(view);
  assert.deepEqual([box.min.toArray(), box.max.toArray()], [[4.5, 4, 4.5], [5.5, 6, 7.5]]);
  // A ray finds the body.
  view.updateMatrixWorld(true);
  const [hit] = new Raycaster(new Vector3(5, 5, 20), new Vector3(0, 0, -1)).intersectObject(view);
  assert.equal(hit.distance, 12.5);
  assert.equal(view.bodyOf(hit), world.ids()[0]);
});

test("states that went through a worker's post show the same", () => {
  const world = new World(WALL);
  world.addBody(BALL);
  const [view, reader] = [new FrangibleMesh(), new WorldReader()];
  for (let frame = 0; frame < 10; frame++) {
    world.step();
    view.take(structuredClone(reader.read(world)));
  }
  assert.equal(drawn(view), drawn(new FrangibleMesh(world)));
  assert.throws(() => view.update(), /without a world/);
});

test("materials are the caller's, for pieces too, and a batch that dies is used again", () => {
  const [outside, inside] = [new MeshBasicMaterial(), new MeshBasicMaterial()];
  const world = new World(WALL);
  const view = new FrangibleMesh(world, { materials: () => ({ outside, inside }), ground: 0 });
  const start = world.snapshot();
  world.addBody(BALL);
  const sizes = [0, 1, 2].map(() => {
    for (let frame = 0; frame < 10; frame++) {
      world.step();
      view.update();
    }
    const size = batches(view)[0].geometry.getAttribute("position").count;
    world.restore(start);
    view.update();
    world.addBody(BALL);
    return size;
  });
  assert.deepEqual(batches(view).map(({ material }) => material), [outside, inside]);
  assert.equal(view.children.length, 2);
  assert.equal(new Set(sizes).size, 1);
});

test("a thousand bodies are two draw calls", () => {
  const bodies = Array.from({ length: 1000 }, (_, i) => ({ shape: { kind: "box", size: [1, 1, 1] }, position: [2 * i, 0, 0], look: "brick" }));
  const view = new FrangibleMesh(new World({ bodies }));
  assert.equal(batches(view).length, 1);
  assert.equal(drawn(view), 1000);
});

test("every material breaks that should", () => {
  for (const [name, material] of Object.entries(MATERIALS)) {
    const world = new World({ bodies: [{ ...material, shape: { kind: "box", size: [1, 1, 1] } }, { ...BALL, position: [0, 0, 1], linear_velocity: [0, 0, -80] }] });
    const broken = [0, 1, 2].some(() => world.step().fractures.length > 0);
    assert.equal(broken, name !== "steel", name);
    world.free();
  }
});

test("the types have the fields that the engine knows", async () => {
  const types = await readFile(here("../dist/scene.d.ts"), "utf8");
  const fields = (name) => [...new RegExp(`interface ${name} {([^]*?)\\n}`).exec(types)[1].matchAll(/^(\w+)\??:/gm)].map(([, field]) => field);
  const known = (scene) => {
    try {
      new World(scene);
    } catch ({ message }) {
      return /one of (.*)/.exec(message)[1].split(", ");
    }
    return assert.fail("nothing was thrown");
  };
  const shape = { kind: "sphere", radius: 1 };
  assert.deepEqual(fields("SceneDesc").sort(), known({ bodies: [], none: 0 }).sort());
  const body = known({ bodies: [{ shape, none: 0 }] });
  assert.deepEqual(fields("BodyDesc").sort(), body.sort());
  const breaking = known({ bodies: [{ shape, breaking: { strength: 1, pattern: { kind: "slices" }, none: 0 } }] });
  assert.deepEqual(fields("BreakingDesc").sort(), breaking.sort());
});

test("the package holds what it needs, and no more", async () => {
  const [packed] = JSON.parse(execFileSync("npm", ["pack", "--dry-run", "--json"], { cwd: here(".."), encoding: "utf8" }));
  const files = packed.files.map(({ path }) => path);
  for (const file of ["package.json", "README.md", "LICENSE-MIT", "LICENSE-APACHE", "dist/index.js", "dist/index.d.ts", "dist/node.js",
    "dist/three.js", "dist/three.d.ts", "dist/scene.d.ts", "dist/engine.js", "dist/engine.d.ts", "dist/engine_bg.wasm"])
    assert.ok(files.includes(file), file);
  assert.deepEqual(files.filter((path) => !/^(dist\/\w+\.(js|d\.ts|wasm)|README\.md|LICENSE-\w+|package\.json)$/.test(path)), []);
  const cargo = await readFile(here("../../../Cargo.toml"), "utf8");
  assert.equal(packed.version, /^version = "(.*)"$/m.exec(cargo)[1]);
});

test("the lines of the README run", async () => {
  const readme = await readFile(here("../README.md"), "utf8");
  const lines = /```js\n(import init[^]*?)```/.exec(readme)[1];
  assert.ok(lines.trim().split("\n").length <= 12);
  const said = execFileSync(process.execPath, ["--input-type=module", "--eval", lines], { cwd: here("."), encoding: "utf8" });
  assert.match(said, /broke into \d\d pieces/);
});

test("the compiler completes scenes, and refuses what is none", () => {
  execFileSync(process.execPath, [here("../../node_modules/typescript/bin/tsc"), "-p", here(".")], { stdio: "inherit" });
});
