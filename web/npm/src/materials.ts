// Materials by name, as the fields of a body that they decide.
import materials from "./materials.json";
import type { BodyDesc } from "./scene";

export type MaterialName = keyof typeof materials.presets;

interface Preset extends Omit<BodyDesc, "shape" | "breaking"> {
  strength?: NonNullable<BodyDesc["breaking"]>["strength"];
  pattern?: NonNullable<BodyDesc["breaking"]>["pattern"];
}

/** What bodies of a material have: `{ ...MATERIALS.glass, shape }` is a body. */
export const MATERIALS = Object.fromEntries(Object.entries(materials.presets).map(([name, preset]) => [name, fields(preset as Preset)])) as Record<
  MaterialName,
  Omit<BodyDesc, "shape">
>;

function fields({ strength, pattern, ...rest }: Preset): Omit<BodyDesc, "shape"> {
  return strength === undefined || pattern === undefined ? rest : { ...rest, breaking: { strength, pattern } };
}
