// Energy over time: what there is, and above it what each cause has taken, up to what there was.
import { type Books, CAUSES, type Cause } from "./books";
import { KNOB } from "./marks";
import { quantity } from "./units";

/** What is drawn, from below, with its colour. */
const LAYERS = [
  ["kinetic", "#ff9d5c"],
  ["potential", "#5aa9f0"],
  ["collision", "#e7d27a"],
  ["contact", "#b58be8"],
  ["friction", "#63c08b"],
  ["projection", "#e2749b"],
  ["fracture", "#f2f2f2"],
  ["balance", "#8fa3b8"],
  ["flight", "#5d6878"],
] as const;
type Layer = (typeof LAYERS)[number][0];

/** A layer that never has this part of the highest sum is not named. */
const FAINT = 2e-3;

/** What the layers are after a step [J]. */
type Row = Record<Layer, number> & { frame: number };

export class EnergyGraph {
  private readonly rows: Row[] = [];
  private readonly taken = Object.fromEntries(
    [...CAUSES, "started"].map((cause) => [cause, 0]),
  ) as Record<Cause, number>;
  private lowest = Infinity;
  /** The highest sum, and what is named, of so many rows. */
  private summed = { rows: -1, high: 0, named: [] as Layer[] };
  private drawn: HTMLCanvasElement | null = null;
  private names = "";

  constructor(
    private readonly books: Books,
    private readonly canvas: HTMLCanvasElement,
    /** Where the layers are named, each with its value at the frame shown. */
    private readonly legend: HTMLElement,
    /** Where the same is said in a sentence. */
    private readonly words: HTMLElement,
  ) {}

  /** True if there is nothing to show. */
  get isEmpty(): boolean {
    return this.books.energy.length === 0;
  }

  /**
   * Draw it for so many frames, with a hand at a time; where it is not shown the words are as true.
   */
  show(time: number, frames: number): void {
    this.takeIn();
    if (this.isEmpty) return;
    this.say(time);
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (width === 0 || height === 0) return;
    const context = sized(this.canvas, width, height);
    if (context === null) return;
    this.layers(width, height, frames);
    context.clearRect(0, 0, width, height);
    context.drawImage(this.drawn!, 0, 0, width, height);
    context.fillStyle = "#ffffff";
    context.fillRect(across(width, time, frames) - 0.75, 0, 1.5, height);
  }

  /** Energy at a frame by layer [J], without those that are never much. */
  at(frame: number): [Layer, number][] {
    this.takeIn();
    const row = this.rows[Math.min(Math.max(this.index(frame), 0), this.rows.length - 1)];
    if (row === undefined) return [];
    return this.sums.named.map((layer) => [layer, this.value(row, layer)]);
  }

  private index(frame: number): number {
    return frame - (this.rows[0]?.frame ?? 1);
  }

  private takeIn(): void {
    for (const { frame, kinetic, potential, changes } of this.books.energy.slice(
      this.rows.length,
    )) {
      const row = { frame, kinetic, potential } as Row;
      for (const cause of CAUSES) this.taken[cause] -= changes[cause];
      for (const [layer] of LAYERS.slice(2)) row[layer] = this.taken[layer as Cause];
      this.lowest = Math.min(this.lowest, potential);
      this.rows.push(row);
      this.drawn = null;
    }
  }

  /** Potential energy counts from its lowest; a cause that gave more than it took has no height. */
  private value(row: Row, layer: Layer): number {
    return layer === "potential" ? row.potential - this.lowest : Math.max(row[layer], 0);
  }

  private get sums(): { high: number; named: Layer[] } {
    const { rows } = this;
    if (this.summed.rows === rows.length) return this.summed;
    const total = (row: Row): number =>
      LAYERS.reduce((sum, [layer]) => sum + this.value(row, layer), 0);
    const high = rows.reduce((most, row) => Math.max(most, total(row)), 1e-300);
    const named = LAYERS.map(([layer]) => layer).filter(
      (layer, i) => i < 2 || rows.some((row) => this.value(row, layer) > FAINT * high),
    );
    this.summed = { rows: rows.length, high, named };
    return this.summed;
  }

  private layers(width: number, height: number, frames: number): void {
    const known = this.drawn;
    const name = [width, height, frames, this.rows.length, devicePixelRatio].join();
    if (known !== null && known.dataset["name"] === name) return;
    this.drawn = document.createElement("canvas");
    this.drawn.dataset["name"] = name;
    const context = sized(this.drawn, width, height)!;
    const { high } = this.sums;
    const below = new Float64Array(this.rows.length);
    for (const [layer, colour] of LAYERS) {
      context.beginPath();
      const edge = (row: number): void => {
        context.lineTo(
          across(width, this.rows[row]!.frame, frames),
          height - (height * below[row]!) / high,
        );
      };
      for (let row = 0; row < this.rows.length; row++) edge(row);
      this.rows.forEach((row, index) => (below[index]! += this.value(row, layer)));
      for (let row = this.rows.length - 1; row >= 0; row--) edge(row);
      context.fillStyle = colour;
      context.fill();
    }
  }

  private say(time: number): void {
    const values = this.at(Math.max(Math.round(time), 1));
    const colours = new Map<string, string>(LAYERS);
    const names = values.map(([layer]) => layer).join();
    if (names !== this.names) {
      this.names = names;
      this.legend.replaceChildren(
        ...values.map(([layer]) => {
          const [entry, swatch, value] = ["span", "i", "b"].map((tag) =>
            document.createElement(tag),
          ) as [HTMLElement, HTMLElement, HTMLElement];
          swatch.style.backgroundColor = colours.get(layer)!;
          entry.append(swatch, `${layer} `, value);
          return entry;
        }),
      );
    }
    values.forEach(([, value], i) => {
      const shown = this.legend.children[i]!.lastElementChild!;
      const text = quantity(value, "J");
      if (shown.textContent !== text) shown.textContent = text;
    });
    const [kinetic, potential, ...causes] = values.map(
      ([layer, value]) => `${layer} ${quantity(value, "J")}`,
    );
    const taken = causes.length > 0 ? `; taken so far by ${causes.join(", ")}` : "";
    const text = `Energy: ${kinetic}, ${potential}${taken}.`;
    if (this.words.textContent !== text) this.words.textContent = text;
  }
}

/** Where a frame is on a time line of that width [CSS px]. */
function across(width: number, frame: number, frames: number): number {
  return KNOB + ((width - 2 * KNOB) * frame) / Math.max(frames, 1);
}

function sized(
  canvas: HTMLCanvasElement,
  width: number,
  height: number,
): CanvasRenderingContext2D | null {
  const [w, h] = [Math.round(width * devicePixelRatio), Math.round(height * devicePixelRatio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d");
  context?.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
  return context;
}
