// A recording as the player draws it: materials, meshes, bodies and where they were at every frame.
import type { Frames } from "./clock";
import { fillPoses } from "./poses";
import { Blob32 } from "./streams";

/** The version of the data that this player reads. */
const FORMAT = 2;

export interface Material {
  name: string;
  /** Linear RGB. */
  colour: [number, number, number];
  metallic: number;
  /** Share of the light that passes. */
  clear: number;
  /** What it shines with, linear RGB. */
  emission: [number, number, number];
  /** 0 mirrors, 1 is matt; -1 shines as pictures show it. */
  roughness: number;
  /** Index of the image that is laid on it; -1 without one. */
  image: number;
  /** Of that whose green is roughness and whose blue is metallic, of normals, and of light. */
  surfaceImage: number;
  normalImage: number;
  emissionImage: number;
  /** Of what has less opacity than that, nothing is drawn. */
  cutoff: number;
  /** Whether the opacity of image and corners lets light through. */
  blended: boolean;
  /** What is drawn on it by position: "wood", "concrete" or nothing. */
  grain: string;
  /** Whether cracks laid it bare. */
  inside: boolean;
}

/** An image as its file holds it. */
export interface Image {
  mime: string;
  /** Base64. */
  data: string;
}

/** A surface in the body frame [m]. */
export interface Mesh {
  /** Three numbers a vertex. */
  positions: Float32Array;
  normals: Float32Array;
  /** Which of the body's materials each vertex has. */
  slots: Int32Array;
  /** Texture coordinates, two a vertex, v up, and factors of the colour, four a vertex; `null` where none matters. */
  places: Float32Array | null;
  colours: Float32Array | null;
  /** Three vertices a triangle. */
  triangles: Int32Array;
}

export interface Body {
  /** First frame that shows it, and the first that no longer does. */
  birth: number;
  end: number;
  /** Index of what it broke off from; -1 for the bodies of the scene. */
  parent: number;
  /** Whether it is everything below the plane y = 0 of its own frame. */
  floor: boolean;
  mesh: number;
  /** Material of each slot of its mesh. */
  materials: number[];
  /** Factor of its colours. */
  tint: [number, number, number];
  /** Rotation from the body frame to that of its grain, x, y, z, w. */
  grain: [number, number, number, number];
  /** By how much it moves when pieces are pulled apart to twice their distance [m]. */
  pull: [number, number, number];
  /** Its first pose, and how many it has; the last one holds on. */
  pose: number;
  poses: number;
  /** Whether its first pose is that of the frame before its birth, as a part of its parent. */
  lead: boolean;
  /** Whether such fragments are seen in its place on the way to its last frame. */
  yields: boolean;
}

/** What is drawn, and where it is at a time. */
export interface Footage extends Frames {
  readonly shot: string;
  readonly camera: { eye: [number, number, number]; target: [number, number, number]; fieldOfView: number };
  readonly materials: Material[];
  readonly meshes: Mesh[];
  readonly bodies: Body[];
  /**
   * Fills (place, shown) and quaternions, eight numbers a body, for a time in frames, with pieces
   * pulled apart so far; places are relative to an origin [m].
   */
  fill(time: number, explode: number, origin: readonly number[], into: Float32Array): void;
}

/** Footage from its beginning, frame 0 before the first step, to its end. */
export interface Recording extends Footage {
  images: Image[];
  /** All poses: x, y, z as multiples of the step, and quaternions up to a factor. */
  positions: Int32Array[];
  orientations: Int32Array[];
  /** What positions are multiples of [m]. */
  positionStep: number;
}

/** A break: how many pieces appeared at a frame. */
export interface Break {
  frame: number;
  pieces: number;
}

/** Read an inflated blob. */
export function readRecording(bytes: Uint8Array): Recording {
  const blob = new Blob32(bytes);
  const header = blob.header as unknown as Recording & { format: number; steps: Record<string, number> };
  if (header.format !== FORMAT) throw new Error(`the recording has format ${header.format}, and this player reads ${FORMAT}`);
  const step = (name: string): number => header.steps[name] ?? 1;
  const recording: Recording = {
    shot: header.shot,
    fps: header.fps,
    frames: header.frames,
    grows: false,
    camera: header.camera,
    materials: header.materials,
    images: header.images,
    meshes: readMeshes(blob, step),
    bodies: readBodies(blob, step),
    positions: blob.columns("positions"),
    orientations: blob.columns("orientations"),
    positionStep: step("position"),
    fill: (time, explode, origin, into) => fillPoses(recording, time, explode, origin, into),
  };
  return recording;
}

/** The breaks, in order. */
export function breaks(footage: Footage): Break[] {
  const pieces = new Map<number, number>();
  for (const body of footage.bodies)
    if (body.parent >= 0) pieces.set(body.birth, (pieces.get(body.birth) ?? 0) + 1);
  return [...pieces].map(([frame, count]) => ({ frame, pieces: count })).sort((a, b) => a.frame - b.frame);
}

/** How many bodies a frame shows. */
export function countAlive(footage: Footage, frame: number): number {
  return footage.bodies.filter((body) => body.birth <= frame && frame < body.end).length;
}

function readBodies(blob: Blob32, step: (name: string) => number): Body[] {
  const [birth, end, parent, floor, mesh] = columns(blob, "birth", "end", "parent", "floor", "mesh");
  const [poses, lead, yields] = columns(blob, "poses", "lead", "yields");
  const [slots, material] = columns(blob, "slots", "materials");
  const [pull, tint, grain] = [blob.columns("pull"), blob.columns("tint"), blob.columns("grain")];
  let pose = 0;
  let slot = 0;
  return Array.from(birth!, (first, row) => {
    const body: Body = {
      birth: first,
      end: end![row]!,
      parent: parent![row]!,
      floor: floor![row] === 1,
      mesh: mesh![row]!,
      materials: Array.from(material!.subarray(slot, slot + slots![row]!)),
      tint: scaled(tint, row, step("tint")) as Body["tint"],
      grain: scaled(grain, row, step("orientation")) as Body["grain"],
      pull: scaled(pull, row, step("position")) as Body["pull"],
      pose,
      poses: poses![row]!,
      lead: lead![row] === 1,
      yields: yields![row] === 1,
    };
    pose += body.poses;
    slot += slots![row]!;
    return body;
  });
}

function columns(blob: Blob32, ...names: string[]): Int32Array[] {
  return names.map((name) => blob.column(name));
}

function readMeshes(blob: Blob32, step: (name: string) => number): Mesh[] {
  const low = blob.columns("mesh_low").map(floats);
  const scale = floats(blob.column("mesh_scale"));
  const counts = (["mesh_corners", "mesh_vertices", "mesh_triangles"] as const).map((name) => blob.column(name));
  const [corners, normals] = [blob.columns("corners"), blob.columns("normals")];
  const [vertices, slots, triangles] = [blob.column("vertices"), blob.column("vertex_slots"), blob.column("triangles")];
  const [places, colours] = [blob.columns("places"), blob.columns("colours")];
  const normalStep = step("normal");
  let [corner, vertex, index] = [0, 0, 0];
  return Array.from(scale, (size, row) => {
    const [cornerCount, vertexCount, triangleCount] = counts.map((count) => count[row]!) as [number, number, number];
    const positions = new Float32Array(3 * vertexCount);
    const directions = new Float32Array(3 * vertexCount);
    for (let i = 0; i < vertexCount; i++) {
      const at = corner + vertices[vertex + i]!;
      for (let axis = 0; axis < 3; axis++) positions[3 * i + axis] = low[axis]![row]! + size * corners[axis]![at]!;
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
function interleaved(columns: Int32Array[], first: number, count: number, value: (stored: number) => number): Float32Array | null {
  if (columns.every((column) => column.subarray(first, first + count).every((stored) => stored === 0))) return null;
  const rows = new Float32Array(columns.length * count);
  columns.forEach((column, index) => {
    for (let row = 0; row < count; row++) rows[columns.length * row + index] = value(column[first + row]!);
  });
  return rows;
}

function scaled(columns: Int32Array[], row: number, step: number): number[] {
  return columns.map((column) => column[row]! * step);
}

/** The single-precision numbers with the same bits. */
function floats(column: Int32Array): Float32Array {
  return new Float32Array(column.slice().buffer);
}
