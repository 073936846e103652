// Which body a ray meets first.
import { TEXELS } from "./poses";
import type { Footage, Mesh } from "./recording";

export type Vector = readonly [number, number, number];

export interface Hit {
  /** Of the body. */
  row: number;
  /** Along the ray, in lengths of its direction. */
  distance: number;
}

export class Picker {
  /** Radius around the origin of each mesh [m]. */
  private readonly radii = new Map<Mesh, number>();

  constructor(private readonly footage: Footage) {}

  /** Radius of a body around its place [m]. */
  radius(row: number): number {
    const mesh = this.footage.meshes[this.footage.bodies[row]?.mesh ?? -1];
    if (mesh === undefined) return 0;
    let radius = this.radii.get(mesh);
    if (radius === undefined) {
      radius = 0;
      for (let i = 0; i < mesh.positions.length; i += 3)
        radius = Math.max(
          radius,
          Math.hypot(mesh.positions[i]!, mesh.positions[i + 1]!, mesh.positions[i + 2]!),
        );
      this.radii.set(mesh, radius);
    }
    return radius;
  }

  /** The body that a ray meets first, of those that poses show; `null` if it meets none. */
  pick(poses: Float32Array, from: Vector, direction: Vector): Hit | null {
    const length2 = dot(direction, direction);
    let best: Hit | null = null;
    this.footage.bodies.forEach((body, row) => {
      const at = 4 * TEXELS * row;
      if (poses[at + 3] !== 1 || body.floor) return;
      // A ball around it first.
      const away: Vector = [
        from[0] - poses[at]!,
        from[1] - poses[at + 1]!,
        from[2] - poses[at + 2]!,
      ];
      const along = -dot(away, direction) / length2;
      const radius = this.radius(row);
      const miss2 = dot(away, away) - along * along * length2;
      if (miss2 > radius * radius || along + radius / Math.sqrt(length2) < 0) return;
      if (best !== null && along - radius / Math.sqrt(length2) > best.distance) return;
      const [x, y, z, w] = [-poses[at + 4]!, -poses[at + 5]!, -poses[at + 6]!, poses[at + 7]!];
      const distance = meet(
        this.footage.meshes[body.mesh]!,
        turned([x, y, z, w], away),
        turned([x, y, z, w], direction),
      );
      if (distance < (best?.distance ?? Infinity)) best = { row, distance };
    });
    return best;
  }
}

/**
 * Where a ray in the body frame meets a mesh first (Moeller and Trumbore 1997); infinite if it does
 * not.
 */
function meet({ positions, triangles }: Mesh, from: Vector, direction: Vector): number {
  let best = Infinity;
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((corner) => 3 * triangles[i + corner]!) as [
      number,
      number,
      number,
    ];
    const edge1: Vector = [
      positions[b]! - positions[a]!,
      positions[b + 1]! - positions[a + 1]!,
      positions[b + 2]! - positions[a + 2]!,
    ];
    const edge2: Vector = [
      positions[c]! - positions[a]!,
      positions[c + 1]! - positions[a + 1]!,
      positions[c + 2]! - positions[a + 2]!,
    ];
    const p = cross(direction, edge2);
    const volume = dot(edge1, p);
    if (volume === 0) continue;
    const away: Vector = [
      from[0] - positions[a]!,
      from[1] - positions[a + 1]!,
      from[2] - positions[a + 2]!,
    ];
    const u = dot(away, p) / volume;
    if (u < 0 || u > 1) continue;
    const q = cross(away, edge1);
    const v = dot(direction, q) / volume;
    if (v < 0 || u + v > 1) continue;
    const distance = dot(edge2, q) / volume;
    if (distance > 0 && distance < best) best = distance;
  }
  return best;
}

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** A vector, rotated by a unit quaternion x, y, z, w. */
function turned(q: readonly [number, number, number, number], v: Vector): Vector {
  const axis: Vector = [q[0], q[1], q[2]];
  const once = cross(axis, v);
  const inner: Vector = [once[0] + q[3] * v[0], once[1] + q[3] * v[1], once[2] + q[3] * v[2]];
  const twice = cross(axis, inner);
  return [v[0] + 2 * twice[0], v[1] + 2 * twice[1], v[2] + 2 * twice[2]];
}
