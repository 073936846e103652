// How bodies move, told from where they are: speeds, and the forces that act on them besides
// gravity.
import { TEXELS } from "./poses";
import type { Footage } from "./recording";

/**
 * The ends of the way from a frame to the next lie that far within it: new pieces are seen there
 * already [frames].
 */
const WITHIN = 1e-3;
/** Ways that are kept: those of a few frames around the one that is shown. */
const KEPT = 6;

export class Motion {
  private readonly ways = new Map<number, Float32Array>();

  constructor(
    private readonly footage: Footage,
    /** Upward acceleration of free flight [m/s^2]; `null` where nobody knows it. */
    private readonly gravity: () => number | null,
  ) {}

  /** The step that led to what is shown at a time: 1 is the first. */
  stepAt(time: number): number {
    return Math.min(Math.max(Math.ceil(time - 1e-6), 1), this.footage.frames);
  }

  /**
   * Mean velocities in a step, three numbers a body [m/s]; not a number for what the step does not
   * show.
   */
  velocities(step: number): Float32Array {
    const { footage, ways } = this;
    const kept = ways.get(step);
    if (kept !== undefined && kept.length === 3 * footage.bodies.length) return kept;
    const found = new Float32Array(3 * footage.bodies.length).fill(NaN);
    if (step >= 1 && step <= footage.frames) {
      const [from, to] = [step - 1 + WITHIN, step - WITHIN].map((time) => {
        const poses = new Float32Array(4 * TEXELS * footage.bodies.length);
        footage.fill(time, 0, footage.camera.target, poses);
        return poses;
      }) as [Float32Array, Float32Array];
      const rate = footage.fps / (1 - 2 * WITHIN);
      footage.bodies.forEach((_, row) => {
        const at = 4 * TEXELS * row;
        if (from[at + 3] !== 1 || to[at + 3] !== 1) return;
        for (let axis = 0; axis < 3; axis++)
          found[3 * row + axis] = (to[at + axis]! - from[at + axis]!) * rate;
      });
    }
    ways.set(step, found);
    if (ways.size > KEPT) ways.delete(ways.keys().next().value!);
    return found;
  }

  /** Of a body in a step [m/s]; not a number where nobody knows. */
  speed(row: number, step: number): number {
    return Math.hypot(...this.velocities(step).subarray(3 * row, 3 * row + 3));
  }

  /**
   * What contacts did to a body in a step, as a mean force [N]; not a number where nobody knows.
   */
  force(row: number, step: number): number {
    const gravity = this.gravity();
    const body = this.footage.bodies[row];
    if (gravity === null || body === undefined) return NaN;
    if (!Number.isFinite(body.mass) || body.mass <= 0) return NaN;
    const [before, after] = [this.velocities(step - 1), this.velocities(step)];
    const { fps } = this.footage;
    const [x, y, z] = [0, 1, 2].map(
      (axis) => (after[3 * row + axis]! - before[3 * row + axis]!) * fps,
    ) as [number, number, number];
    return body.mass * Math.hypot(x, y - gravity, z);
  }
}

/** How often what became a body has broken. */
export function generation(footage: Footage, row: number): number {
  let count = 0;
  for (
    let parent = footage.bodies[row]?.parent ?? -1;
    parent >= 0;
    parent = footage.bodies[parent]!.parent
  )
    count++;
  return count;
}
