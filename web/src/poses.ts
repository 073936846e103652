// Where everything is between two frames, as the shaders read it.
import type { Path } from "./recording";

/**
 * Paths of bodies and the poses on them: x, y, z as multiples of a step [m], and quaternions up to
 * a factor.
 */
export interface Posed {
  readonly bodies: readonly Path[];
  readonly positions: Int32Array[];
  readonly orientations: Int32Array[];
  readonly positionStep: number;
}

/** Texels of a body in the texture of poses: place and whether it is shown, then its quaternion. */
export const TEXELS = 2;

/**
 * Fill (place, shown) and quaternions, eight numbers a body, for a time in frames; places are
 * relative to an origin [m].
 */
export function fillPoses(
  recording: Posed,
  time: number,
  explode: number,
  origin: readonly number[],
  into: Float32Array,
): void {
  const frame = Math.floor(time);
  const part = time - frame;
  recording.bodies.forEach((body, row) => {
    const at = 4 * TEXELS * row;
    const shown = isShown(body, frame, part);
    into[at + 3] = shown ? 1 : 0;
    if (shown) interpolate(recording, body, frame, part, explode, origin, into, at);
  });
}

/** Fragments part from where they were as soon as the frame before their birth is over. */
function isShown(body: Path, frame: number, part: number): boolean {
  if (part > 0 && body.lead && frame === body.birth - 1) return true;
  if (part > 0 && body.yields && frame === body.end - 1) return false;
  return body.birth <= frame && frame < body.end;
}

function interpolate(
  { bodies, positions, orientations, positionStep }: Posed,
  body: Path,
  frame: number,
  part: number,
  explode: number,
  origin: readonly number[],
  into: Float32Array,
  at: number,
): void {
  // The frame of its death no longer shows a body: on the way there it stays where it was.
  const first = body.lead ? body.birth - 1 : body.birth;
  const last = Math.min(body.poses, body.end - first) - 1;
  const here = body.pose + Math.min(frame - first, last);
  const next = body.pose + Math.min(frame - first + 1, last);
  // A fragment is pulled like its parent at first.
  const own = frame < body.birth ? part : 1;
  const before = bodies[body.parent]?.pull ?? body.pull;
  for (let axis = 0; axis < 3; axis++) {
    const column = positions[axis]!;
    const place = column[here]! + part * (column[next]! - column[here]!);
    const pull = before[axis]! + own * (body.pull[axis]! - before[axis]!);
    into[at + axis] = place * positionStep - origin[axis]! + explode * pull;
  }

  // Neighbours never flip sign, so that the straight way is the short one.
  let length = 0;
  for (let axis = 0; axis < 4; axis++) {
    const column = orientations[axis]!;
    const value = column[here]! + part * (column[next]! - column[here]!);
    into[at + 4 + axis] = value;
    length += value * value;
  }
  const scale = 1 / (Math.sqrt(length) || 1);
  for (let axis = 0; axis < 4; axis++) into[at + 4 + axis]! *= scale;
}
