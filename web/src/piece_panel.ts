// The numbers of the body that is picked, as text.
import { type Motion, generation } from "./motion";
import type { Footage, Strike } from "./recording";
import { quantity } from "./units";

export type Fact = readonly [name: string, value: string];

/** What is known of a body at a time in frames. */
export function factsOf(
  footage: Footage,
  strikes: readonly Strike[],
  motion: Motion,
  row: number,
  time: number,
): Fact[] {
  const body = footage.bodies[row];
  if (body === undefined) return [];
  const frame = Math.floor(time + 1e-6);
  const step = motion.stepAt(time);
  const isShown = body.birth <= frame && frame < body.end;
  const facts: Fact[] = [["mass", quantity(body.mass, "kg")]];
  if (!isShown) facts.push(["state", frame < body.birth ? "not yet there" : "broken"]);
  else {
    facts.push(["speed", quantity(motion.speed(row, step), "m/s")]);
    facts.push([
      "contact force",
      Number.isFinite(body.mass) ? quantity(motion.force(row, step), "N") : "unknown",
    ]);
  }
  const parent = footage.bodies[body.parent];
  facts.push(["parent", parent === undefined ? "none" : parent.name]);
  if (parent === undefined) {
    if (body.birth > 0) facts.push(["came", when(footage, body.birth)]);
  } else {
    const strike = strikes[body.broke ?? -1];
    const striker = footage.bodies[strike?.striker ?? -1];
    facts.push(["generation", String(generation(footage, row))]);
    facts.push(["broke off", when(footage, body.birth)]);
    facts.push(["struck by", striker?.name ?? "unknown"]);
    if (strike !== undefined) facts.push(["blow", quantity(strike.impulse, "N s")]);
  }
  if (body.end <= footage.frames) facts.push(["broke", when(footage, body.end)]);
  return facts;
}

/** The name of a body, which others may have too. */
export function titleOf(footage: Footage, row: number): string {
  return footage.bodies[row]?.name || `body ${row}`;
}

function when({ fps }: Footage, frame: number): string {
  return `frame ${frame}, ${(frame / fps).toFixed(2)} s`;
}

/** Shows facts in a list of definitions; what did not change is not touched. */
export class PiecePanel {
  private shown = "";

  constructor(
    private readonly title: HTMLElement,
    private readonly list: HTMLElement,
  ) {}

  show(title: string, facts: readonly Fact[]): void {
    const text = [title, ...facts.flat()].join("\n");
    if (text === this.shown) return;
    this.shown = text;
    this.title.textContent = title;
    this.list.replaceChildren(
      ...facts.flatMap(([name, value]) => {
        const [term, definition] = [document.createElement("dt"), document.createElement("dd")];
        [term.textContent, definition.textContent] = [name, value];
        return [term, definition];
      }),
    );
  }
}
