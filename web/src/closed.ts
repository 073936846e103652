// Which surfaces are closed: of those nobody sees the backs of triangles, which then need not be drawn.
import type { Mesh } from "./recording";

/** Rounded corners move the volume by less than that share of it, and a missing side by more. */
const TOLERANCE = 0.05;

/**
 * Whether a mesh bounds a volume, from outside. By Gauss's theorem the integral of x n^T over a closed
 * surface is its volume times the identity; a sheet, a tube without ends and a surface turned
 * inside out have another one, or none that stays where the mesh moves.
 */
export function isClosed({ positions, triangles }: Pick<Mesh, "positions" | "triangles">): boolean {
  const [sum, area] = [new Float64Array(9), new Float64Array(3)];
  const [a, b, c] = [new Float64Array(3), new Float64Array(3), new Float64Array(3)];
  let reach = 0;
  for (let i = 0; i < triangles.length; i += 3) {
    for (let axis = 0; axis < 3; axis++) {
      a[axis] = positions[3 * triangles[i]! + axis]!;
      b[axis] = positions[3 * triangles[i + 1]! + axis]!;
      c[axis] = positions[3 * triangles[i + 2]! + axis]!;
      reach = Math.max(reach, Math.abs(a[axis]!));
    }
    for (let k = 0; k < 3; k++) {
      const [u, v] = [(k + 1) % 3, (k + 2) % 3];
      const part = 0.5 * ((b[u]! - a[u]!) * (c[v]! - a[v]!) - (b[v]! - a[v]!) * (c[u]! - a[u]!));
      area[k]! += part;
      for (let axis = 0; axis < 3; axis++) sum[3 * axis + k]! += (part * (a[axis]! + b[axis]! + c[axis]!)) / 3;
    }
  }
  const volume = (sum[0]! + sum[4]! + sum[8]!) / 3;
  const most = TOLERANCE * volume;
  const differs = sum.some((entry, at) => Math.abs(entry - (at % 4 === 0 ? volume : 0)) > most);
  return triangles.length === 0 || (volume > 0 && !differs && Math.hypot(...area) * reach <= most);
}
