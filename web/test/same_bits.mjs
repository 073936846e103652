// Runs shots in a module and compares their last states with those that the native engine ends in:
// node same_bits.mjs MODULE.wasm STATES.txt, as `make test-wasm` does.

import { readFile } from "node:fs/promises";

// As in crates/shots/tests/same_bits.rs.
const FRAMES = 300;

const [modulePath, statesPath] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(await readFile(modulePath));
const { memory, name_room, build, step, state_hash } = instance.exports;

function stateAfter(shot) {
  const name = new TextEncoder().encode(shot);
  const room = name_room(name.length);
  new Uint8Array(memory.buffer, room, name.length).set(name);
  if (!build()) throw new Error(`${shot} cannot be built`);
  for (let frame = 0; frame < FRAMES; frame++) step();
  return BigInt.asUintN(64, state_hash()).toString(16).padStart(16, "0");
}

const recorded = (await readFile(statesPath, "utf8")).trim().split("\n");
for (const line of recorded) {
  const [shot, expected] = line.split(" ");
  const start = performance.now();
  const state = stateAfter(shot);
  const seconds = ((performance.now() - start) / 1000).toFixed(1);
  console.log(`${shot} ${state} in ${seconds} s${state === expected ? "" : `, not ${expected}`}`);
  if (state !== expected) process.exitCode = 1;
}
