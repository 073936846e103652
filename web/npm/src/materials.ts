// Materials by name, as the fields of a body that they decide.
import materials from "./materials.json";
import type { BodyDesc } from "./scene";

export type MaterialName = "concrete" | "glass" | "brick" | "masonry" | "wood" | "ice" | "steel";

interface Preset extends Omit<BodyDesc, "shape" | "breaking"> {
  strength?: NonNullable<BodyDesc["breaking"]>["strength"];
  pattern?: NonNullable<BodyDesc["breaking"]>["pattern"];
}

const presets: Record<MaterialName, unknown> = materials.presets;

/** What bodies of a material have: `{ ...MATERIALS.glass, shape }` is a body. */
export const MATERIALS = Object.fromEntries(
  Object.entries(presets).map(([name, preset]) => [name, fields(preset as Preset)]),
) as Record<MaterialName, Omit<BodyDesc, "shape">>;

function fields({ strength, pattern, ...rest }: Preset): Omit<BodyDesc, "shape"> {
  return strength === undefined || pattern === undefined
    ? rest
    : { ...rest, breaking: { strength, pattern } };
}
