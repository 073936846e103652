// What the page and the worker that simulates say to each other.

/** A body as a scene holds it. */
export type BodyDesc = Record<string, unknown>;

/** What somebody did to a world: replayed at the same frames, it ends in the same bits. */
export interface Action {
  /** Number of frames before it. */
  frame: number;
  /** A body that comes in. */
  add: BodyDesc;
}

/** A world, from its beginning. */
export interface Story {
  /** JSON of a scene. */
  scene: string;
  actions: Action[];
}

/** To the worker. */
export type Order =
  /** Builds the world, replays its story up to a frame, and tells all frames. */
  | { kind: "build"; story: Story; frames: number }
  /** Steps so many frames. */
  | { kind: "step"; frames: number }
  | { kind: "add"; body: BodyDesc }
  /** Goes back to before the last body that came in. */
  | { kind: "undo" };

/** A body that was not there before. */
export interface NewBody {
  id: number;
  /** Of what it broke off from; -1 for none. */
  parent: number;
  name: string;
  look: string;
  motion: string;
  /** [kg] */
  mass: number;
  /** In the body's frame [m]; empty for a half-space. */
  positions: Float32Array;
  triangles: Uint32Array;
  /** 1 where a crack made a triangle. */
  interior: Uint8Array;
}

/** State of a world after a frame. */
export interface FrameState {
  frame: number;
  /** Living bodies, in order of birth. */
  ids: Float64Array;
  /** Seven numbers each: x, y, z [m], and a quaternion x, y, z, w. */
  poses: Float32Array;
  born: NewBody[];
  /** Of the step [ms]. */
  duration: number;
  /** Of all dynamic bodies [J]. */
  energy: number;
  hash: string;
}

/** From the worker. */
export type Told =
  /** A world was built anew: forget all frames. */
  | { kind: "built"; framesPerSecond: number; story: Story }
  | { kind: "frame"; state: FrameState }
  /** Frames from this one on are no more. */
  | { kind: "undone"; frame: number; story: Story }
  /** All that was ordered is done. */
  | { kind: "done"; story: Story }
  | { kind: "fault"; sentence: string };
