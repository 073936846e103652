// What a body can be chosen to be.
import { select } from "../element";
import { MATERIALS, PATTERNS, SHAPES, SHOTS } from "./recipe";

/** Menus of shapes, materials and patterns. */
export function fillMenus(): void {
  const fill = (id: string, names: string[]): void =>
    select(id).replaceChildren(...names.map((name) => new Option(name, name)));
  fill("shape", Object.keys(SHAPES));
  const shots = document.createElement("optgroup");
  shots.label = "Scenes";
  shots.append(...Object.entries(SHOTS).map(([name, title]) => new Option(title, name)));
  select("shape").append(shots);
  fill("material", MATERIALS.filter((name) => name !== "steel"));
  // Its steps fit into a frame: those of as many rough pieces of concrete take four times as
  // long.
  select("material").value = "brick";
  fill("pattern", Object.keys(PATTERNS));
}
