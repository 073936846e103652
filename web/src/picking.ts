// Picking a body, with a press or by keys, and saying its numbers.
import { element } from "./element";
import type { Motion } from "./motion";
import { type Fact, PiecePanel, factsOf, titleOf } from "./piece_panel";
import type { Player } from "./player";
import type { Strike } from "./recording";

/** A press that moves further turns the view [CSS px]. */
const STILL = 4;

export class Picking {
  /** Called with the row that is picked, or -1. */
  onPick: (row: number) => void = () => {};
  private readonly panel = new PiecePanel(element("piece-name"), element("piece-facts"));
  private readonly section = element("piece");

  constructor(
    private readonly player: Player,
    canvas: HTMLCanvasElement,
    private readonly motion: Motion,
    private readonly strikes: readonly Strike[],
  ) {
    let from: [number, number] | null = null;
    canvas.addEventListener(
      "pointerdown",
      (event) =>
        (from = event.isPrimary && event.button === 0 ? [event.offsetX, event.offsetY] : null),
    );
    canvas.addEventListener("pointerup", (event) => {
      if (from === null || Math.hypot(event.offsetX - from[0], event.offsetY - from[1]) > STILL)
        return;
      this.pick(this.player.bodyAt(event.offsetX, event.offsetY));
    });
    for (const [id, step] of [["piece-before", -1], ["piece-after", 1]] as const)
      element(id).addEventListener("click", () => this.next(step));
    element("piece-close").addEventListener("click", () => this.pick(-1));
    element("piece-focus").addEventListener("click", () => this.player.focus());
    this.section.addEventListener("keydown", (event) => this.key(event));
  }

  /** Of the body that is picked; empty without one. */
  get facts(): Fact[] {
    const { picked, footage, clock } = this.player;
    return factsOf(footage, this.strikes, this.motion, picked, clock.time);
  }

  /** In words, for those who do not see it. */
  get sentence(): string {
    if (this.player.picked < 0) return "";
    const facts = this.facts.map(([name, value]) => `${name} ${value}`);
    return `Picked: ${titleOf(this.player.footage, this.player.picked)}, ${facts.join(", ")}.`;
  }

  /** -1 for none. */
  pick(row: number): void {
    this.player.picked = row;
    if (row < 0 && this.section.contains(document.activeElement)) element("view").focus();
    this.show();
    this.onPick(row);
  }

  /**
   * The next body that is seen, or the one before; at first the one in the middle of the picture.
   */
  next(step: number): void {
    const { footage, picked, poses } = this.player;
    const seen = footage.bodies
      .map((_, row) => row)
      .filter((row) => poses[8 * row + 3] === 1 && !footage.bodies[row]!.floor);
    if (seen.length === 0) return;
    if (picked < 0) {
      const view = element("view");
      const middle = this.player.bodyAt(view.clientWidth / 2, view.clientHeight / 2);
      return this.pick(middle >= 0 ? middle : seen[0]!);
    }
    const after = seen.findIndex((row) => row > picked);
    const index =
      step > 0
        ? after < 0
          ? 0
          : after
        : (after < 0 ? seen.length : after) - (seen.includes(picked) ? 2 : 1);
    this.pick(seen.at(index % seen.length)!);
  }

  /** What the picked body broke off from, or the first piece that broke off from it. */
  family(down: boolean): void {
    const { footage, picked } = this.player;
    const found = down
      ? footage.bodies.findIndex(({ parent }) => parent === picked)
      : (footage.bodies[picked]?.parent ?? -1);
    if (found >= 0) this.pick(found);
  }

  /** Say the numbers of what is drawn. */
  show(): void {
    const { picked, footage } = this.player;
    this.section.hidden = picked < 0;
    document.documentElement.dataset["picked"] = String(picked);
    if (picked >= 0) this.panel.show(titleOf(footage, picked), this.facts);
  }

  /** Arrows go through pieces while the panel has the focus. */
  private key(event: KeyboardEvent): void {
    if (event.shiftKey || event.ctrlKey || event.metaKey || event.altKey) return;
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.next(-1),
      ArrowRight: () => this.next(1),
      ArrowUp: () => this.family(false),
      ArrowDown: () => this.family(true),
    };
    const action = actions[event.key];
    if (action === undefined) return;
    event.preventDefault();
    action();
  }
}
