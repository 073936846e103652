import assert from "node:assert/strict";
import { test } from "node:test";
import { Clock, TEXELS, breaks, countAlive, decode, fillPoses, unfold } from "../dist/model.mjs";

/** Fold and split whole numbers as `python/frangible/io/page_streams.py` does. */
function encode(columns, order) {
  const folded = columns.flatMap((column) => {
    let values = column;
    for (let pass = 0; pass < order; pass++) values = values.map((value, i) => (value - (values[i - 1] ?? 0)) | 0);
    return values.map((value) => ((value << 1) ^ (value >> 31)) >>> 0);
  });
  const bytes = [0, 1, 2, 3].flatMap((plane) => folded.map((value) => (value >>> (8 * plane)) & 255));
  return [Uint8Array.from(bytes), { offset: 0, rows: columns[0].length, columns: columns.length, bytes: 4, order }];
}

for (const order of [0, 1, 2])
  test(`whole numbers of order ${order} are read back, the largest too`, () => {
    const columns = [[0, 1, -1, 7, 7, 7], [2147483647, -2147483647, 5, -300, 65536, 0]];
    assert.deepEqual(decode(...encode(columns, order)).map((column) => [...column]), columns);
  });

test("points of the unfolded octahedron are unit normals", () => {
  for (const [point, normal] of [[[0, 0], [0, 0, 1]], [[1, 0], [1, 0, 0]], [[0, -1], [0, -1, 0]], [[1, 1], [0, 0, -1]]])
    unfold(...point).forEach((part, axis) => assert.ok(Math.abs(part - normal[axis]) < 1e-12));
});

/** A bar that breaks at frame 2 into one piece, which turns by a right angle and moves on. */
const body = (rest) => ({
  birth: 0, end: 2, parent: -1, floor: false, pull: [0, 0, 0], pose: 0, poses: 1,
  lead: false, yields: false, ...rest,
});
const recording = {
  fps: 30,
  frames: 4,
  bodies: [body({}), body({ birth: 2, end: 5, parent: 0, pull: [0, 1, 0], pose: 1, poses: 2 })],
  positions: [[5, 0, 10], [0, 0, 0], [0, 0, 0]].map((column) => Int32Array.from(column)),
  orientations: [[0, 0, 0], [0, 0, 7071], [0, 0, 0], [10000, 10000, 7071]].map((column) => Int32Array.from(column)),
  positionStep: 0.5,
};
const at = (time, explode = 0) => {
  const poses = new Float32Array(4 * TEXELS * 2);
  fillPoses(recording, time, explode, [1, 0, 0], poses);
  return [poses.subarray(0, 8), poses.subarray(8)];
};

test("each frame shows who is alive", () => {
  for (const [time, shown] of [[0, [1, 0]], [1.9, [1, 0]], [2, [0, 1]], [4, [0, 1]]])
    assert.deepEqual(at(time).map((pose) => pose[3]), shown, `at ${time}`);
  assert.deepEqual([0, 1, 2, 4].map((frame) => countAlive(recording, frame)), [1, 1, 1, 1]);
  assert.deepEqual(breaks(recording), [{ frame: 2, pieces: 1 }]);
});

test("between two frames bodies move and turn evenly, and rest after their last pose", () => {
  const places = [2, 2.5, 3, 4].map((time) => at(time)[1][0]);
  assert.deepEqual(places, [-1, 1.5, 4, 4]);
  const [, half] = at(2.5);
  assert.ok(Math.abs(2 * Math.atan2(half[5], half[7]) - Math.PI / 4) < 1e-4);
  assert.equal(at(1.5)[0][0], 1.5);
});

test("pieces part from where their parent was, which makes way for them", () => {
  const parent = body({ yields: true });
  const piece = body({ birth: 2, end: 5, parent: 0, pull: [0, 1, 0], poses: 3, lead: true });
  const broken = {
    ...recording,
    bodies: [parent, piece],
    positions: [[0, 4, 10], [0, 0, 0], [0, 0, 0]].map((column) => Int32Array.from(column)),
  };
  const at = (time, explode = 0) => {
    const poses = new Float32Array(4 * TEXELS * 2);
    fillPoses(broken, time, explode, [0, 0, 0], poses);
    return [poses[3], poses[11], poses[8], poses[9]];
  };
  // Shown: parent, piece; then where the piece is.
  assert.deepEqual(at(1), [1, 0, 0, 0]);
  assert.deepEqual(at(0.5).slice(0, 2), [1, 0]);
  assert.deepEqual(at(1.25, 1), [0, 1, 0.5, 0.25]);
  assert.deepEqual(at(2, 1), [0, 1, 2, 1]);
  assert.deepEqual(at(2.5), [0, 1, 3.5, 0]);
  assert.deepEqual(at(4), [0, 1, 5, 0]);
});

test("pieces are pulled apart, and what did not break is not", () => {
  assert.equal(at(2, 2)[1][1], 2);
  assert.equal(at(1, 2)[0][1], 0);
});

test("the clock stops at the end, and plays anew from the start", () => {
  const clock = new Clock({ frames: 60, fps: 30, grows: false });
  clock.toggle();
  clock.speed = 0.5;
  clock.advance(1);
  assert.equal(clock.time, 15);
  clock.advance(10);
  assert.deepEqual([clock.time, clock.playing], [60, false]);
  clock.toggle();
  assert.deepEqual([clock.time, clock.playing], [0, true]);
});

test("steps go to whole frames and stay within the recording", () => {
  const clock = new Clock({ frames: 60, fps: 30, grows: false });
  clock.seek(3.4);
  clock.step(1);
  assert.equal(clock.time, 4);
  clock.seek(3.4);
  clock.step(-1);
  assert.equal(clock.time, 3);
  for (const [from, by, to] of [[0, -1, 0], [60, 1, 60], [5, 1, 6], [5, -1, 4]]) {
    clock.seek(from);
    clock.step(by);
    assert.equal(clock.time, to);
  }
});

test("a clock waits at the end of what grows", () => {
  const film = { frames: 2, fps: 30, grows: true };
  const clock = new Clock(film);
  clock.toggle();
  clock.advance(1);
  assert.deepEqual([clock.time, clock.playing], [2, true]);
  film.frames = 60;
  clock.advance(0.1);
  assert.equal(clock.time, 5);
});
