// Normals for drawing: smooth where a surface bends gently, sharp at its edges and cracks; as
// `python/frangible/render/normals.py`.

/** A surface for drawing. */
export interface Shaded {
  positions: Float32Array;
  normals: Float32Array;
  /** Of each corner: 1 on what cracks made, else 0. */
  slots: Int32Array;
  triangles: Int32Array;
}

/** Faces that meet at a flatter angle look like one bent surface; broken edges are far sharper. */
const GENTLE = Math.cos((30 * Math.PI) / 180);

/** A surface whose corners are apart wherever it creases; slot 1 is what cracks made. */
export function shaded(positions: Float32Array, triangles: Uint32Array, interior: Uint8Array): Shaded {
  const count = triangles.length / 3;
  const faces = new Float32Array(3 * count);
  const units = new Float32Array(3 * count);
  for (let face = 0; face < count; face++) faceNormal(positions, triangles, face, faces, units);
  const around = facesAround(positions.length / 3, triangles);

  const corners = { positions: [] as number[], normals: [] as number[], slots: [] as number[] };
  const indices = new Int32Array(triangles.length);
  const made = new Map<string, number>();
  for (let corner = 0; corner < triangles.length; corner++) {
    const face = Math.floor(corner / 3);
    const vertex = triangles[corner]!;
    const normal = mean(around.of(vertex), face, faces, units, interior);
    const key = `${vertex} ${interior[face]} ${normal.map((part) => Math.round(1e3 * part)).join(" ")}`;
    let index = made.get(key);
    if (index === undefined) {
      index = corners.slots.length;
      made.set(key, index);
      corners.positions.push(...positions.subarray(3 * vertex, 3 * vertex + 3));
      corners.normals.push(...normal);
      corners.slots.push(interior[face]!);
    }
    indices[corner] = index;
  }
  return {
    positions: new Float32Array(corners.positions),
    normals: new Float32Array(corners.normals),
    slots: new Int32Array(corners.slots),
    triangles: indices,
  };
}

/** Twice the area along the normal, and the unit normal; a sliver without area takes any. */
function faceNormal(positions: Float32Array, triangles: Uint32Array, face: number, faces: Float32Array, units: Float32Array): void {
  const at = (corner: number, axis: number): number => positions[3 * triangles[3 * face + corner]! + axis]!;
  const [u, v] = [1, 2].map((corner) => [0, 1, 2].map((axis) => at(corner, axis) - at(0, axis))) as [number[], number[]];
  const normal = [u[1]! * v[2]! - u[2]! * v[1]!, u[2]! * v[0]! - u[0]! * v[2]!, u[0]! * v[1]! - u[1]! * v[0]!];
  const length = Math.hypot(...normal);
  faces.set(normal, 3 * face);
  units.set(length > 0 ? normal.map((part) => part / length) : [0, 1, 0], 3 * face);
}

/** The faces at each vertex. */
function facesAround(vertices: number, triangles: Uint32Array): { of: (vertex: number) => Uint32Array } {
  const first = new Uint32Array(vertices + 1);
  for (const vertex of triangles) first[vertex + 1]!++;
  for (let vertex = 0; vertex < vertices; vertex++) first[vertex + 1]! += first[vertex]!;
  const next = first.slice();
  const faces = new Uint32Array(triangles.length);
  triangles.forEach((vertex, corner) => (faces[next[vertex]!++] = Math.floor(corner / 3)));
  return { of: (vertex) => faces.subarray(first[vertex], first[vertex + 1]) };
}

/** Mean over the faces on the same side of every crease. */
function mean(around: Uint32Array, face: number, faces: Float32Array, units: Float32Array, interior: Uint8Array): number[] {
  const sum = [0, 0, 0];
  for (const other of around) {
    let cosine = 0;
    for (let axis = 0; axis < 3; axis++) cosine += units[3 * face + axis]! * units[3 * other + axis]!;
    if (cosine <= GENTLE || interior[other] !== interior[face]) continue;
    for (let axis = 0; axis < 3; axis++) sum[axis]! += faces[3 * other + axis]!;
  }
  const length = Math.hypot(...sum);
  return length > 0 ? sum.map((part) => part / length) : Array.from(units.subarray(3 * face, 3 * face + 3));
}
