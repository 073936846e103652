// What the colours mean.
import { Colouring } from "./colouring";
import { quantity } from "./units";

/** Of the strip [px]. */
const [WIDTH, HEIGHT] = [160, 10];

export class Legend {
  private readonly strip = document.createElement("canvas");
  private readonly ends = [document.createElement("span"), document.createElement("span")] as const;

  constructor(private readonly holder: HTMLElement) {
    Object.assign(this.strip, { width: WIDTH, height: HEIGHT });
    this.strip.setAttribute("aria-hidden", "true");
    const context = this.strip.getContext("2d");
    for (let x = 0; context !== null && x < WIDTH; x++) {
      context.fillStyle = `rgb(${Colouring.ramp(x / (WIDTH - 1))
        .map((part) => Math.round(255 * part))
        .join()})`;
      context.fillRect(x, 0, 1, HEIGHT);
    }
    holder.append(this.ends[0], this.strip, this.ends[1]);
  }

  /** Show the ends of the scale, if there is one. */
  show(colouring: Colouring): void {
    const scale = colouring.scale();
    this.holder.hidden = scale === null;
    if (scale === null) return;
    const texts = [quantity(scale.low, scale.unit), `${quantity(scale.high, scale.unit)}`];
    texts.forEach((text, i) => {
      if (this.ends[i]!.textContent !== text) this.ends[i]!.textContent = text;
    });
  }
}
