import assert from "node:assert/strict";
import { test } from "node:test";
import { Clock, Colouring, Motion, Picker, TEXELS, blobs, breaks, coarser, countAlive, decode, fillPoses, quantity, unfold } from "../dist/model.mjs";

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

test("a clock that loops begins anew", () => {
  const clock = new Clock({ frames: 30, fps: 30, grows: false });
  clock.loop = true;
  clock.toggle();
  clock.advance(2);
  assert.deepEqual([clock.time, clock.playing], [0, true]);
});

/** A body of 2 kg that falls by g = -10 for three steps of 0.1 s, and is held in the fourth. */
const falling = {
  fps: 10,
  frames: 4,
  bodies: [{ ...body({ end: 5 }), mass: 2, mesh: 0, name: "ball", id: 7, tint: [1, 1, 1] }, { ...body({ end: 5 }), mass: Infinity, mesh: 0, tint: [1, 1, 1] }],
  meshes: [],
  camera: { target: [0, 0, 0] },
  fill: (time, _, __, into) => {
    const heights = [10, 9.9, 9.7, 9.4, 9.1];
    const frame = Math.min(Math.floor(time), 3);
    into.set([0, heights[frame] + (time - frame) * (heights[frame + 1] - heights[frame]), 0, 1, 0, 0, 0, 1, 5, 0, 0, 1, 0, 0, 0, 1]);
  },
};

test("speeds and forces are told from where bodies are", () => {
  const motion = new Motion(falling, () => -10);
  const near = (found, expected) => assert.ok(Math.abs(found - expected) < 0.02, `${found}, not ${expected}`);
  [1, 2, 3, 3].forEach((speed, index) => near(motion.speed(0, index + 1), speed));
  // In free flight nothing holds it; then it no longer gets faster, which takes its weight.
  near(motion.force(0, 2), 0);
  near(motion.force(0, 4), 20);
  assert.ok(Number.isNaN(motion.force(0, 1)) && Number.isNaN(motion.force(1, 2)));
  assert.ok(Number.isNaN(new Motion(falling, () => null).force(0, 2)));
  assert.deepEqual([0, 0.5, 1, 1.5, 4].map((time) => motion.stepAt(time)), [1, 1, 1, 2, 4]);
});

test("colours follow a quantity, and glow where something is picked", () => {
  const colouring = new Colouring(falling, new Motion(falling, () => -10));
  const looks = new Float32Array(16);
  assert.equal(colouring.paint(looks, 0, -1), true);
  assert.deepEqual([...looks.subarray(0, 4)], [1, 1, 1, 0]);
  assert.equal(colouring.paint(looks, 1, -1), false);
  colouring.quantity = "speed";
  assert.equal(colouring.paint(looks, 4, 0), true);
  // The fastest has the brightest colour; what is picked has both flags, what cannot move is grey.
  assert.ok(looks[0] > 0.8 && looks[1] > 0.7 && looks[2] < 0.1);
  assert.deepEqual([looks[3], looks[11]], [3, 1]);
  assert.ok(Math.abs(looks[8] - looks[9]) < 0.02);
  assert.ok(Math.abs(colouring.scale().high - 3) < 0.02);
  assert.equal(colouring.paint(looks, 4, 0), false);
});

test("a ray meets the nearest body, turned as it is", () => {
  // A square of 2 m across the z axis; the second one is turned so that the ray passes it.
  const square = { positions: Float32Array.of(-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0), triangles: Int32Array.of(0, 1, 2, 0, 2, 3) };
  const picker = new Picker({ bodies: [0, 1, 2].map(() => ({ mesh: 0 })), meshes: [square] });
  const quarter = Math.SQRT1_2;
  const poses = Float32Array.of(0, 0, -3, 1, 0, 0, 0, 1, 0.1, 0, 3, 1, 0, quarter, 0, quarter, 0, 0, -1, 0, 0, 0, 0, 1);
  assert.deepEqual(picker.pick(poses, [0, 0, 10], [0, 0, -1]), { row: 0, distance: 13 });
  poses[23 - 4] = 1;
  assert.deepEqual(picker.pick(poses, [0, 0, 10], [0, 0, -1]), { row: 2, distance: 11 });
  assert.equal(picker.pick(poses, [3, 0, 10], [0, 0, -1]), null);
  assert.equal(picker.pick(poses, [0, 0, 10], [0, 0, 1]), null);
  assert.ok(Math.abs(picker.radius(0) - Math.SQRT2) < 1e-6);
});

test("coarser triangles keep what is larger than a cell", () => {
  const mesh = {
    positions: Float32Array.of(0, 0, 0, 0.01, 0, 0, 1, 0, 0, 0, 1, 0),
    normals: Float32Array.of(0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1),
    slots: Int32Array.of(0, 0, 0, 0),
    triangles: Int32Array.of(0, 1, 3, 1, 2, 3),
  };
  assert.deepEqual([...coarser(mesh, 0.1)], [0, 2, 3]);
  assert.deepEqual([...coarser(mesh, 1e-4)], [0, 1, 3, 1, 2, 3]);
});

test("quantities are read with a unit", () => {
  const pairs = [[0.006178, "kg", "0.006178 kg"], [23040.4, "kg", "23040 kg"], [93512, "J", "93.5 kJ"], [0, "J", "0 J"], [0.18, "N", "180 mN"], [NaN, "N", "unknown"], [Infinity, "kg", "cannot be moved"], [5.0631, "m/s", "5.06 m/s"]];
  for (const [value, unit, text] of pairs) assert.equal(quantity(value, unit), text);
});

test("blobs are cut out of a stream, wherever it is torn", async () => {
  const whole = [3, 0, 0, 0, 1, 2, 3, 1, 0, 0, 0, 9, 4, 0, 0, 0, 7];
  for (const size of [1, 4, 5, 17]) {
    const stream = new ReadableStream({
      start(controller) {
        for (let at = 0; at < whole.length; at += size) controller.enqueue(Uint8Array.from(whole.slice(at, at + size)));
        controller.close();
      },
    });
    const found = [];
    for await (const blob of blobs(stream)) found.push([...blob]);
    assert.deepEqual(found, [[1, 2, 3], [9]]);
  }
});
