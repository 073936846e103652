// One side of all bodies with the same look: one draw call, which grows.
import {
  BatchedMesh, BufferAttribute, BufferGeometry, type Color, type Material, type Matrix4,
} from "three";
import type { Shaded } from "./normals";

/** Room at first: bodies, corners, and corners of triangles. It doubles when it is used up. */
const ROOM = [64, 4096, 8192] as const;

export class Batch extends BatchedMesh {
  /** Geometry and instance of each body. */
  private readonly parts = new Map<number, { geometry: number; instance: number }>();
  private readonly geometryRoom: [number, number] = [ROOM[1], ROOM[2]];

  constructor(material: Material) {
    super(...ROOM, material);
    // It is culled piece by piece; a sphere around all would have to follow them.
    this.frustumCulled = false;
    // Sorting thousands of pieces costs more than it saves, but glass needs its order.
    this.sortObjects = material.transparent;
    this.castShadow = this.receiveShadow = true;
  }

  /** Takes in one side of a body, if it has any of it. */
  put(id: number, shaded: Shaded, slot: number, colour: Color): void {
    const geometry = sideOf(shaded, slot);
    if (geometry === null) return;
    this.reserve(geometry.getAttribute("position").count, geometry.getIndex()!.count);
    const part = this.addGeometry(geometry);
    const instance = this.addInstance(part);
    this.setColorAt(instance, colour);
    this.parts.set(id, { geometry: part, instance });
  }

  take(id: number): void {
    const part = this.parts.get(id);
    if (part === undefined) return;
    this.deleteGeometry(part.geometry);
    this.parts.delete(id);
  }

  place(id: number, matrix: Matrix4): void {
    const part = this.parts.get(id);
    if (part !== undefined) this.setMatrixAt(part.instance, matrix);
  }

  /** The body of an instance, as a ray that hits the batch tells it. */
  bodyAt(instance: number): number | undefined {
    for (const [id, part] of this.parts) if (part.instance === instance) return id;
    return undefined;
  }

  private reserve(vertices: number, indices: number): void {
    if (this.instanceCount + 1 > this.maxInstanceCount)
      this.setInstanceCount(2 * this.maxInstanceCount);
    if (this.unusedVertexCount >= vertices && this.unusedIndexCount >= indices) return;
    // What the dead leave is used first.
    this.optimize();
    const free = [this.unusedVertexCount, this.unusedIndexCount] as const;
    if (free[0] >= vertices && free[1] >= indices) return;
    [vertices, indices].forEach((wanted, which) => {
      const used = this.geometryRoom[which]! - free[which]!;
      while (this.geometryRoom[which]! < used + wanted) this.geometryRoom[which]! *= 2;
    });
    this.setGeometrySize(...this.geometryRoom);
  }
}

/** The triangles of a slot. */
function sideOf(
  { positions, normals, slots, triangles }: Shaded,
  slot: number,
): BufferGeometry | null {
  const corners: number[] = [];
  const rows = new Map<number, number>();
  const indices: number[] = [];
  for (const corner of triangles) {
    if (slots[corner] !== slot) continue;
    let row = rows.get(corner);
    if (row === undefined) {
      row = corners.push(corner) - 1;
      rows.set(corner, row);
    }
    indices.push(row);
  }
  if (indices.length === 0) return null;
  const picked = (from: Float32Array): BufferAttribute => {
    const into = new Float32Array(3 * corners.length);
    corners.forEach((corner, row) => {
      for (let axis = 0; axis < 3; axis++) into[3 * row + axis] = from[3 * corner + axis]!;
    });
    return new BufferAttribute(into, 3);
  };
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", picked(positions));
  geometry.setAttribute("normal", picked(normals));
  geometry.setIndex(indices);
  return geometry;
}
