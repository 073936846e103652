// Colours of bodies: those of their materials, or of a quantity.
import { type Motion, generation } from "./motion";
import type { Footage } from "./recording";

export const QUANTITIES = ["material", "piece", "generation", "speed", "age", "force"] as const;
export type Quantity = (typeof QUANTITIES)[number];

/** What a colour means: the numbers at both ends of the scale. */
export interface Scale {
  low: number;
  high: number;
  unit: string;
  isLogarithmic: boolean;
}

/** Scales end where this share of the bodies is below. */
const SHARE = 0.98;
/** So many steps of a recording are asked for its scale. */
const ASKED = 12;
/** Forces are shown over so many powers of ten. */
const DECADES = 4;
/**
 * Of Viridis (S. van der Walt and N. Smith, 2015), sRGB: brightness alone tells the value, for any
 * colour vision.
 */
const VIRIDIS = [0x440154, 0x46327e, 0x365c8d, 0x277f8e, 0x1fa187, 0x4ac16d, 0xa0da39, 0xfde725];
/** Generations, told apart with any colour vision (M. Okabe and K. Ito, 2008), sRGB. */
const GENERATIONS = [
  0xb8bec7, 0x56b4e9, 0xe69f00, 0x009e73, 0xcc79a7, 0xd55e00, 0xf0e442, 0x0072b2,
];
/** What has no value, linear. */
const NONE = [0.1, 0.11, 0.12] as const;
/** Flags of a body's look that the shaders know. */
const OWN = 1;
const PICKED = 2;

/** Numbers of a body's look in the texture: colour and flags, then its grain. */
const LOOK = 8;

export class Colouring {
  private scaled: { quantity: Quantity; frames: number; scale: Scale } | null = null;
  private painted = "";
  private target: Float32Array | null = null;

  constructor(
    private readonly footage: Footage,
    private readonly motion: Motion,
    public quantity: Quantity = "material",
  ) {}

  /** Write the looks at a time, with a body picked or -1; true if they changed. */
  paint(looks: Float32Array, time: number, picked: number): boolean {
    const frame = Math.floor(time + 1e-6);
    const step = this.motion.stepAt(time);
    const moment =
      this.quantity === "age"
        ? frame
        : this.quantity === "speed" || this.quantity === "force"
          ? step
          : 0;
    const state = [
      this.quantity,
      moment,
      picked,
      this.footage.bodies.length,
      this.scale()?.high,
    ].join();
    if (state === this.painted && looks === this.target) return false;
    [this.painted, this.target] = [state, looks];
    this.footage.bodies.forEach((body, row) => {
      const colour = this.colour(row, frame, step);
      looks.set(colour ?? body.tint, LOOK * row);
      looks[LOOK * row + 3] = (colour === null ? 0 : OWN) + (row === picked ? PICKED : 0);
    });
    return true;
  }

  /** The scale of the colours; `null` where they are of no number. */
  scale(): Scale | null {
    const { quantity, footage } = this;
    if (quantity !== "speed" && quantity !== "age" && quantity !== "force") return null;
    const known = this.scaled;
    if (
      known !== null &&
      known.quantity === quantity &&
      (known.frames === footage.frames || footage.frames < 1.3 * known.frames)
    )
      return known.scale;
    this.scaled = { quantity, frames: footage.frames, scale: this.measured(quantity) };
    return this.scaled.scale;
  }

  /** Of a share of the scale, sRGB from 0 to 1. */
  static ramp(share: number): [number, number, number] {
    const place = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
    const [from, to] = [encoded(VIRIDIS[Math.floor(place)]!), encoded(VIRIDIS[Math.ceil(place)]!)];
    return from.map((part, i) => part + (place % 1) * (to[i]! - part)) as [number, number, number];
  }

  private colour(row: number, frame: number, step: number): number[] | null {
    const body = this.footage.bodies[row]!;
    if (this.quantity === "material") return null;
    if (this.quantity === "generation") {
      if (!moves(body)) return [...NONE];
      return encoded(GENERATIONS[generation(this.footage, row) % GENERATIONS.length]!).map(linear);
    }
    if (this.quantity === "piece") return moves(body) ? hue(body.id) : [...NONE];
    const scale = this.scale()!;
    const value = this.value(row, frame, step);
    if (Number.isNaN(value) || !moves(body)) return [...NONE];
    const share = scale.isLogarithmic
      ? Math.log(Math.max(value, scale.low) / scale.low) / Math.log(scale.high / scale.low)
      : value / scale.high;
    return Colouring.ramp(share).map(linear);
  }

  private value(row: number, frame: number, step: number): number {
    if (this.quantity === "speed") return this.motion.speed(row, step);
    if (this.quantity === "force") return this.motion.force(row, step);
    return Math.max(frame - this.footage.bodies[row]!.birth, 0) / this.footage.fps;
  }

  private measured(quantity: "speed" | "age" | "force"): Scale {
    const { footage, motion } = this;
    if (quantity === "age")
      return {
        low: 0,
        high: Math.max(footage.frames, 1) / footage.fps,
        unit: "s",
        isLogarithmic: false,
      };
    const values: number[] = [];
    for (let asked = 1; asked <= ASKED; asked++) {
      const step = motion.stepAt((asked * footage.frames) / ASKED);
      footage.bodies.forEach((body, row) => {
        if (!moves(body)) return;
        const value = quantity === "speed" ? motion.speed(row, step) : motion.force(row, step);
        if (value > 0) values.push(value);
      });
    }
    values.sort((a, b) => a - b);
    const high = values[Math.floor(SHARE * (values.length - 1))] ?? 1;
    if (quantity === "speed") return { low: 0, high, unit: "m/s", isLogarithmic: false };
    return { low: high / 10 ** DECADES, high, unit: "N", isLogarithmic: true };
  }
}

function moves({ mass, parent }: { mass: number; parent: number }): boolean {
  return mass !== Infinity || parent >= 0;
}

/** A colour that differs from those of near ids, linear. */
function hue(id: number): number[] {
  const turn = (id * 0.618033988749895) % 1;
  const light = 0.55 + 0.25 * ((id * 0.7548776662466927) % 1);
  return [0, 8, 4].map((shift) => {
    // HSL to sRGB.
    const k = (shift + turn * 12) % 12;
    return linear(
      light - 0.6 * Math.min(light, 1 - light) * Math.max(-1, Math.min(k - 3, 9 - k, 1)),
    );
  });
}

function encoded(colour: number): [number, number, number] {
  return [(colour >> 16) / 255, ((colour >> 8) & 255) / 255, (colour & 255) / 255];
}

function linear(part: number): number {
  return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
}
