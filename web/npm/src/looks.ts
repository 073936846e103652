// Looks of bodies: colours of their outside and of what cracks made.
import looks from "./looks.json";

/** Colours of both sides, and by how much pieces differ. */
export interface Look {
  outside: Finish;
  inside: Finish;
  variation: number;
}

export interface Finish {
  /** Red, green, blue; linear. */
  colour: number[];
  metallic: number;
  /** Part of the light that passes. */
  clear: number;
}

/** Steps of the two-dimensional golden-ratio sequence, which fills a square evenly. */
const GOLDEN = [0.7548776662466927, 0.5698402909980532] as const;

/** Of a name that scenes know, or one of the others, numbered, for what has none. */
export function lookOf(name: string, moves: boolean, number: number): Look {
  const own = (looks.looks as Record<string, Look>)[name];
  if (own !== undefined) return own;
  const colour = moves ? looks.outside[number % looks.outside.length]! : looks.scenery;
  return {
    outside: { colour, metallic: 0, clear: 0 },
    inside: { colour: looks.inside, metallic: 0, clear: 0 },
    variation: looks.variation,
  };
}

/** Factor of a piece's colours, by its id: neighbours differ. */
export function tintOf(id: number, variation: number): [number, number, number] {
  const shade = 1 + variation * (((id * GOLDEN[0]) % 1) - 0.53);
  const warmth = 0.3 * variation * (((id * GOLDEN[1]) % 1) - 0.5);
  return [shade * (1 + warmth), shade, shade * (1 - 1.2 * warmth)];
}
