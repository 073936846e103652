// Scenes from what somebody chooses in the playground.
import materials from "../../npm/src/materials.json";
import type { BodyDesc } from "./protocol";

export type MaterialName = keyof typeof materials.presets;
export const MATERIALS = Object.keys(materials.presets) as MaterialName[];

/** Patterns by what a menu calls them; none is the material's own. */
export const PATTERNS: Record<string, Record<string, unknown> | null> = {
  "of the material": null,
  "radial, as glass": { kind: "radial", spokes: 16, rings: 4 },
  "Voronoi cells": { kind: "voronoi", cells: 40 },
  rubble: { kind: "natural", cells: 40 },
  slices: { kind: "slices" },
  bricks: { kind: "bricks" },
  splinters: { kind: "splinters" },
  "rough concrete": { kind: "concrete", cells: 60 },
};

/** Shapes of a metre or two, and the height of their middle over the ground [m]. */
export const SHAPES: Record<string, { shape: Record<string, unknown>; height: number }> = {
  wall: { shape: { kind: "box", size: [2.4, 1.6, 0.25] }, height: 0.8 },
  cube: { shape: { kind: "box", size: [1, 1, 1] }, height: 0.5 },
  pane: { shape: { kind: "box", size: [2, 1.5, 0.02] }, height: 0.75 },
  ball: { shape: { kind: "sphere", radius: 0.6 }, height: 0.6 },
  column: { shape: { kind: "cylinder", radius: 0.25, height: 2 }, height: 1 },
};

/** Shots of the engine's that a page steps fast enough to play with, and what they are. */
export const SHOTS: Record<string, string> = {
  pillar: "a pillar falls apart",
  masonry: "a mortared wall",
  timber: "a wooden plank",
  "bonded-pillar": "a glued pillar",
  refracture: "a wall, struck twice",
  stack: "a stack of boxes",
  arch: "an arch of stones",
  pyramid: "a pyramid of cubes",
};

/** A mesh that somebody dropped. */
export interface Dropped {
  name: string;
  positions: number[][];
  triangles: number[][];
}

export interface Choice {
  /** A name of `SHAPES`, or a mesh. */
  shape: string | Dropped;
  material: MaterialName;
  /** A name of `PATTERNS`. */
  pattern: string;
  /** About so many; 0 leaves it to the pattern. */
  pieces: number;
  /** Factor of the material's strength. */
  strength: number;
}

/** Frames that the playground simulates in a second. */
export const FRAMES_PER_SECOND = 60;
/** Size to which a dropped mesh is scaled: its longest side [m]. */
const LONGEST_SIDE = 1.5;

/** JSON of a scene: the body on the ground. */
export function sceneOf(choice: Choice): string {
  const { strength, pattern, ...preset } = materials.presets[choice.material] as Record<
    string,
    unknown
  >;
  const [shape, height, name] =
    typeof choice.shape === "string"
      ? [SHAPES[choice.shape]!.shape, SHAPES[choice.shape]!.height, choice.shape]
      : [...standing(choice.shape), choice.shape.name];
  const body: BodyDesc = { ...preset, name, shape, position: [0, height, 0] };
  const chosen = PATTERNS[choice.pattern] ?? pattern;
  if (strength !== undefined && chosen !== undefined) {
    body["breaking"] = {
      strength: scaled(String(strength), choice.strength),
      pattern: chosen,
      ...(choice.pieces > 1 ? { pieces: choice.pieces } : {}),
    };
  }
  const ground = {
    name: "ground",
    shape: { kind: "half-space" },
    motion: "static",
    restitution: 1,
  };
  return JSON.stringify({
    name,
    frames_per_second: FRAMES_PER_SECOND,
    sleep: true,
    bodies: [ground, body],
  });
}

/** A material of the engine's table, or one that is so many times as strong. */
function scaled(name: string, factor: number): unknown {
  const material = (materials.strengths as Record<string, { tensile_strength: number }>)[name];
  if (factor === 1 || material === undefined) return name;
  return { ...material, tensile_strength: factor * material.tensile_strength };
}

/** A mesh, scaled, that stands on the ground, and the height of its origin. */
function standing({ positions, triangles }: Dropped): [Record<string, unknown>, number] {
  const [low, high] = [Math.min, Math.max].map((extreme) =>
    [0, 1, 2].map((axis) =>
      positions.reduce((found, point) => extreme(found, point[axis]!), positions[0]![axis]!),
    ),
  ) as [number[], number[]];
  const factor = LONGEST_SIDE / Math.max(...high.map((top, axis) => top - low[axis]!), 1e-9);
  const middle = [0, 1, 2].map((axis) => 0.5 * (low[axis]! + high[axis]!));
  const shape = {
    kind: "triangles",
    positions: positions.map((point) => point.map((part, axis) => factor * (part - middle[axis]!))),
    triangles,
  };
  return [shape, 0.5 * factor * (high[1]! - low[1]!)];
}
