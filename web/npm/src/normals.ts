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
export function shaded(
  positions: Float32Array,
  triangles: Uint32Array,
  interior: Uint8Array,
): Shaded {
  const count = triangles.length / 3;
  const faces = new Float32Array(3 * count);
  const units = new Float32Array(3 * count);
  for (let face = 0; face < count; face++) faceNormal(positions, triangles, face, faces, units);
  const around = facesAround(positions.length / 3, triangles);

  const made = { positions: [] as number[], normals: [] as number[], slots: [] as number[] };
  // Of each vertex the corner that was made last, and of each corner the one before.
  const last = new Int32Array(positions.length / 3).fill(-1);
  const before: number[] = [];
  const indices = new Int32Array(triangles.length);
  const normal = [0, 0, 0];
  for (let corner = 0; corner < triangles.length; corner++) {
    const face = Math.floor(corner / 3);
    const vertex = triangles[corner]!;
    mean(around.of(vertex), face, faces, units, interior, normal);
    let index = last[vertex]!;
    while (
      index >= 0 &&
      !(made.slots[index] === interior[face] && isNear(made.normals, 3 * index, normal))
    )
      index = before[index]!;
    if (index < 0) {
      index = made.slots.length;
      before.push(last[vertex]!);
      last[vertex] = index;
      for (let axis = 0; axis < 3; axis++) {
        made.positions.push(positions[3 * vertex + axis]!);
        made.normals.push(normal[axis]!);
      }
      made.slots.push(interior[face]!);
    }
    indices[corner] = index;
  }
  return {
    positions: new Float32Array(made.positions),
    normals: new Float32Array(made.normals),
    slots: new Int32Array(made.slots),
    triangles: indices,
  };
}

/** Whether two normals are one: a thousandth is not seen. */
function isNear(normals: number[], at: number, normal: number[]): boolean {
  for (let axis = 0; axis < 3; axis++)
    if (Math.abs(normals[at + axis]! - normal[axis]!) > 1e-3) return false;
  return true;
}

/** Twice the area along the normal, and the unit normal; a sliver without area takes any. */
function faceNormal(
  positions: Float32Array,
  triangles: Uint32Array,
  face: number,
  faces: Float32Array,
  units: Float32Array,
): void {
  const [a, b, c] = [
    3 * triangles[3 * face]!,
    3 * triangles[3 * face + 1]!,
    3 * triangles[3 * face + 2]!,
  ];
  const [u0, u1, u2] = [
    positions[b]! - positions[a]!,
    positions[b + 1]! - positions[a + 1]!,
    positions[b + 2]! - positions[a + 2]!,
  ];
  const [v0, v1, v2] = [
    positions[c]! - positions[a]!,
    positions[c + 1]! - positions[a + 1]!,
    positions[c + 2]! - positions[a + 2]!,
  ];
  const [x, y, z] = [u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0];
  const length = Math.hypot(x, y, z);
  faces.set([x, y, z], 3 * face);
  units.set(length > 0 ? [x / length, y / length, z / length] : [0, 1, 0], 3 * face);
}

/** The faces at each vertex. */
function facesAround(
  vertices: number,
  triangles: Uint32Array,
): { of: (vertex: number) => Uint32Array } {
  const first = new Uint32Array(vertices + 1);
  for (const vertex of triangles) first[vertex + 1]!++;
  for (let vertex = 0; vertex < vertices; vertex++) first[vertex + 1]! += first[vertex]!;
  const next = first.slice();
  const faces = new Uint32Array(triangles.length);
  triangles.forEach((vertex, corner) => (faces[next[vertex]!++] = Math.floor(corner / 3)));
  return { of: (vertex) => faces.subarray(first[vertex], first[vertex + 1]) };
}

/** Mean over the faces on the same side of every crease. */
function mean(
  around: Uint32Array,
  face: number,
  faces: Float32Array,
  units: Float32Array,
  interior: Uint8Array,
  into: number[],
): void {
  into.fill(0);
  for (const other of around) {
    let cosine = 0;
    for (let axis = 0; axis < 3; axis++)
      cosine += units[3 * face + axis]! * units[3 * other + axis]!;
    if (cosine <= GENTLE || interior[other] !== interior[face]) continue;
    for (let axis = 0; axis < 3; axis++) into[axis]! += faces[3 * other + axis]!;
  }
  const length = Math.hypot(into[0]!, into[1]!, into[2]!);
  for (let axis = 0; axis < 3; axis++)
    into[axis] = length > 0 ? into[axis]! / length : units[3 * face + axis]!;
}
