// Messages between the page and the worker that simulates.
import type { WorldState } from "../../npm/src/reader";

/** A body as a scene holds it. */
export type BodyDesc = Record<string, unknown>;

/** What somebody does to a world, with points in the world frame [m] and ids of bodies. */
export type Deed =
  /** A body comes in. */
  | { add: BodyDesc }
  /** A hand pulls a point of a body's own frame to a target, with at most so much force [N]. */
  | { hold: { body: number; point: number[]; target: number[]; force: number } }
  | { letGo: number }
  /** Along the plane through a point, across a normal. */
  | { cut: { body: number; point: number[]; normal: number[] } }
  /** Breaks by its pattern, as struck at a point; its pieces fly apart so fast [m/s]. */
  | { burst: { body: number; point: number[]; speed: number } };

/** A deed before a step: replayed at the same frames, a story ends in the same bits. */
export type Action = Deed & {
  /** Number of frames before it. */
  frame: number;
};

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
  /** Steps so many frames, or as many as are done in a time [ms]. */
  | { kind: "step"; frames: number; patience?: number }
  /** Builds a shot of the engine's. */
  | { kind: "shot"; name: string }
  | { kind: "do"; deed: Deed }
  /** Goes back to before the last deed; a body that was dragged goes back to where it was taken. */
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
