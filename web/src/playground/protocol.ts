// Messages between the page and the worker that simulates.
import type { WorldState } from "../../npm/src/reader";

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

/** State of a world after a frame. */
export interface FrameState extends WorldState {
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
