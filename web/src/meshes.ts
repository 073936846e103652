// Surfaces of a recording, as its streams hold them.
import type { Mesh } from "./recording";
import type { Blob32 } from "./streams";

export function readMeshes(blob: Blob32, step: (name: string) => number): Mesh[] {
  const low = blob.columns("mesh_low").map(floats);
  const scale = floats(blob.column("mesh_scale"));
  const counts = (["mesh_corners", "mesh_vertices", "mesh_triangles"] as const).map((name) =>
    blob.column(name),
  );
  const [corners, normals] = [blob.columns("corners"), blob.columns("normals")];
  const [vertices, slots, triangles] = [
    blob.column("vertices"),
    blob.column("vertex_slots"),
    blob.column("triangles"),
  ];
  const [places, colours] = [blob.columns("places"), blob.columns("colours")];
  const normalStep = step("normal");
  let [corner, vertex, index] = [0, 0, 0];
  return Array.from(scale, (size, row) => {
    const [cornerCount, vertexCount, triangleCount] = counts.map((count) => count[row]!) as [
      number,
      number,
      number,
    ];
    const positions = new Float32Array(3 * vertexCount);
    const directions = new Float32Array(3 * vertexCount);
    for (let i = 0; i < vertexCount; i++) {
      const at = corner + vertices[vertex + i]!;
      for (let axis = 0; axis < 3; axis++)
        positions[3 * i + axis] = low[axis]![row]! + size * corners[axis]![at]!;
      const [x, y] = normals as [Int32Array, Int32Array];
      directions.set(unfold(x[vertex + i]! * normalStep, y[vertex + i]! * normalStep), 3 * i);
    }
    const mesh = {
      positions,
      normals: directions,
      slots: slots.subarray(vertex, vertex + vertexCount),
      places: interleaved(places, vertex, vertexCount, (value) => value * step("coordinate")),
      // The share that is missing to white.
      colours: interleaved(colours, vertex, vertexCount, (value) => 1 - value * step("colour")),
      triangles: triangles.subarray(index, index + 3 * triangleCount),
    };
    corner += cornerCount;
    vertex += vertexCount;
    index += 3 * triangleCount;
    return mesh;
  });
}

/** The unit normal of a point of the unfolded octahedron. */
export function unfold(x: number, y: number): [number, number, number] {
  const z = 1 - Math.abs(x) - Math.abs(y);
  const back = Math.max(-z, 0);
  const [a, b] = [x - Math.sign(x) * back, y - Math.sign(y) * back];
  const length = Math.hypot(a, b, z) || 1;
  return [a / length, b / length, z / length];
}

/** Rows of columns, one after the other; `null` if all are 0. */
function interleaved(
  columns: Int32Array[],
  first: number,
  count: number,
  value: (stored: number) => number,
): Float32Array | null {
  if (
    columns.every((column) => column.subarray(first, first + count).every((stored) => stored === 0))
  )
    return null;
  const rows = new Float32Array(columns.length * count);
  columns.forEach((column, index) => {
    for (let row = 0; row < count; row++)
      rows[columns.length * row + index] = value(column[first + row]!);
  });
  return rows;
}

export function scaled(columns: Int32Array[], row: number, step: number): number[] {
  return columns.map((column) => column[row]! * step);
}

/** The single-precision numbers with the same bits. */
export function floats(column: Int32Array): Float32Array {
  return new Float32Array(column.slice().buffer);
}
