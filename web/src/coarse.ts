// Fewer triangles for slow renderers: corners that lie within a pixel or two become one.
import type { Mesh } from "./recording";

/** Normals whose axes fall into the same of so many steps are alike. */
const NORMAL_STEPS = 2;

/**
 * For each vertex the one that stands for it, where those in the same cell, with the same material
 * and about the same normal, are one.
 */
export function representatives(mesh: Mesh, cell: number): Int32Array {
  const found = new Int32Array(mesh.slots.length);
  const first = new Map<string, number>();
  for (let vertex = 0; vertex < found.length; vertex++) {
    const at = 3 * vertex;
    let key = String(mesh.slots[vertex]);
    for (let axis = 0; axis < 3; axis++) {
      const place = Math.floor(mesh.positions[at + axis]! / cell + 0.5);
      key += `,${place},${Math.round(NORMAL_STEPS * mesh.normals[at + axis]!)}`;
    }
    const known = first.get(key);
    if (known === undefined) first.set(key, vertex);
    found[vertex] = known ?? vertex;
  }
  return found;
}

/** Triangles of those vertices, without those that have become lines. */
export function coarser(mesh: Mesh, cell: number): Int32Array {
  const standIn = representatives(mesh, cell);
  const kept: number[] = [];
  for (let i = 0; i < mesh.triangles.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((corner) => standIn[mesh.triangles[i + corner]!]!) as [
      number,
      number,
      number,
    ];
    if (a !== b && b !== c && c !== a) kept.push(a, b, c);
  }
  return Int32Array.from(kept);
}
