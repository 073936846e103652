// A recording as the player draws it: materials, meshes, bodies and where they were at every frame.
import type { Frames } from "./clock";

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
  /**
   * Texture coordinates, two a vertex, v up, and factors of the colour, four a vertex; `null` where
   * none matters.
   */
  places: Float32Array | null;
  colours: Float32Array | null;
  /** Three vertices a triangle. */
  triangles: Int32Array;
}

/** The life of a body, and where its poses are. */
export interface Path {
  /** First frame that shows it, and the first that no longer does. */
  birth: number;
  end: number;
  /** Index of what it broke off from; -1 for the bodies of the scene. */
  parent: number;
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

export interface Body extends Path {
  id: number;
  name: string;
  /** [kg]; infinite for what contacts do not move: it stands still, or moves as its scene says. */
  mass: number;
  /** Whether it is everything below the plane y = 0 of its own frame. */
  floor: boolean;
  mesh: number;
  /** Material of each slot of its mesh. */
  materials: number[];
  /** Factor of its colours. */
  tint: [number, number, number];
  /** Rotation from the body frame to that of its grain, x, y, z, w. */
  grain: [number, number, number, number];
  /** Index of the break that made it; -1 or nothing if nobody knows of one. */
  broke?: number;
}

/** What is drawn, and where it is at a time. */
export interface Footage extends Frames {
  readonly shot: string;
  readonly camera: {
    eye: [number, number, number];
    target: [number, number, number];
    fieldOfView: number;
  };
  readonly materials: Material[];
  readonly meshes: Mesh[];
  readonly bodies: Body[];
  /**
   * Fills (place, shown) and quaternions, eight numbers a body, for a time in frames, with pieces
   * pulled apart so far; places are relative to an origin [m].
   */
  fill(time: number, explode: number, origin: readonly number[], into: Float32Array): void;
}

/** A break as the report of its frame tells it. */
export interface Strike {
  frame: number;
  /** What broke, and what struck it: rows of bodies, -1 for what no frame showed. */
  body: number;
  striker: number;
  pieces: number;
  /** That would have stopped the blow [N s]. */
  impulse: number;
  /** That its cracks took [J]. */
  energy: number;
}

/** A break: how many pieces appeared at a frame. */
export interface Break {
  frame: number;
  pieces: number;
}

/** The breaks, in order. */
export function breaks(footage: Footage): Break[] {
  const pieces = new Map<number, number>();
  for (const body of footage.bodies)
    if (body.parent >= 0) pieces.set(body.birth, (pieces.get(body.birth) ?? 0) + 1);
  return [...pieces]
    .map(([frame, count]) => ({ frame, pieces: count }))
    .sort((a, b) => a.frame - b.frame);
}

/** How many bodies a frame shows. */
export function countAlive(footage: Footage, frame: number): number {
  return footage.bodies.filter((body) => body.birth <= frame && frame < body.end).length;
}
