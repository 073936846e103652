// What a pointer does to the world: throw, drag, slice, burst. One pointer works; another one, and
// the pointer beside all bodies, turn the view.
import { Plane, Ray, Vector3 } from "three";
import type { Hit, Sight } from "./pick";
import type { Deed } from "./protocol";

export const TOOLS = ["throw", "drag", "slice", "burst"] as const;
export type Tool = (typeof TOOLS)[number];

/** A press that moves further turns the view, and a shorter line cuts nothing [CSS px]. */
const STILL = 5;
/**
 * A hand lifts twenty times what it holds, so that pieces follow it, but no more than two tonnes: a
 * wall is dragged, not waved [m/s^2, N].
 */
const LIFTS = 20 * 9.81;
const MOST_FORCE = 2e4;
/** Targets are rounded to millimetres, so that links stay short [1/m]. */
const TO_MILLIMETRES = 1000;

/** What tools work on. */
export interface Bench {
  /**
   * The way from the eye through a place of the window [CSS px]; `null` before there is a world.
   */
  sight(x: number, y: number): Sight | null;
  pick(sight: Sight): Hit | null;
  /** Where a point of a body's own frame is seen [CSS px]; `null` if the body is no more. */
  seen(body: number, pointBody: Vector3): [number, number] | null;
  throwBall(sight: Sight): void;
  slice(from: Sight, to: Sight): void;
  burst(hit: Hit): void;
  /** Towards what the camera looks at. */
  forward(): Vector3;
  do(deed: Deed): void;
}

interface Place {
  x: number;
  y: number;
}

interface Drag {
  kind: "drag";
  hit: Hit;
  /** The hand stays at the distance at which it took the body. */
  plane: Plane;
  /** Not ordered yet. */
  target: number[] | null;
}

type Stroke = { pointer: number; from: Place; to: Place } & (
  Drag | { kind: "slice" } | { kind: "press" }
);

export class Tools {
  tool: Tool = "throw";
  private stroke: Stroke | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly line: SVGLineElement,
    private readonly bench: Bench,
  ) {
    // Before the camera's own listeners.
    addEventListener("pointerdown", (event) => event.target === canvas && this.down(event), {
      capture: true,
    });
    addEventListener("pointermove", (event) => this.move(event));
    addEventListener("pointerup", (event) => this.up(event));
    addEventListener(
      "pointercancel",
      (event) => this.stroke?.pointer === event.pointerId && this.drop(),
    );
  }

  /** Do what the tool does, at the middle of the picture. */
  use(): void {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const [x, y] = [left + width / 2, top + height / 2];
    if (this.tool === "slice")
      this.slice({ x, y: top + 0.1 * height }, { x, y: top + 0.9 * height });
    else this.press({ x, y });
  }

  /** The body that is dragged. */
  get dragged(): number | null {
    return this.stroke?.kind === "drag" ? this.stroke.hit.body : null;
  }

  /** Order what the hand wants before the next step. */
  order(): void {
    if (this.stroke?.kind !== "drag" || this.stroke.target === null) return;
    const { hit, target } = this.stroke;
    this.stroke.target = null;
    const force = Math.min(LIFTS * hit.mass, MOST_FORCE);
    this.bench.do({ hold: { body: hit.body, point: hit.pointBody.toArray(), target, force } });
  }

  /** Let go, and forget what was begun. */
  drop(): void {
    const body = this.dragged;
    this.stroke = null;
    this.show();
    if (body !== null) this.bench.do({ letGo: body });
  }

  /** The line from what is held to the hand, or the one that cuts. */
  show(): void {
    const { stroke } = this;
    const begin =
      stroke?.kind === "drag"
        ? this.bench.seen(stroke.hit.body, stroke.hit.pointBody)
        : stroke && [stroke.from.x, stroke.from.y];
    const shown = stroke !== null && stroke.kind !== "press" && begin !== null;
    this.line.toggleAttribute("hidden", !shown);
    if (!shown) return;
    const ends = { x1: begin![0], y1: begin![1], x2: stroke.to.x, y2: stroke.to.y };
    for (const [name, value] of Object.entries(ends)) this.line.setAttribute(name, String(value));
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0) return;
    // A second finger is for the view.
    if (this.stroke !== null) return this.drop();
    const place = { x: event.clientX, y: event.clientY };
    const stroke = { pointer: event.pointerId, from: place, to: place };
    const sight = this.bench.sight(place.x, place.y);
    if (sight === null) return;
    const hit = this.tool === "drag" ? this.bench.pick(sight) : null;
    if (hit !== null && hit.mass > 0) {
      const plane = new Plane().setFromNormalAndCoplanarPoint(this.bench.forward(), hit.point);
      this.stroke = { ...stroke, kind: "drag", hit, plane, target: rounded(hit.point) };
    } else if (this.tool === "slice") {
      this.stroke = { ...stroke, kind: "slice" };
    } else {
      this.stroke = { ...stroke, kind: "press" };
      return;
    }
    event.stopPropagation();
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.focus({ preventScroll: true });
    this.show();
  }

  private move(event: PointerEvent): void {
    const { stroke } = this;
    if (stroke?.pointer !== event.pointerId) return;
    stroke.to = { x: event.clientX, y: event.clientY };
    if (stroke.kind === "drag") {
      const sight = this.bench.sight(stroke.to.x, stroke.to.y);
      const target =
        sight && new Ray(sight.origin, sight.direction).intersectPlane(stroke.plane, new Vector3());
      if (target) stroke.target = rounded(target);
    }
    this.show();
  }

  private up(event: PointerEvent): void {
    const { stroke } = this;
    if (stroke?.pointer !== event.pointerId) return;
    if (stroke.kind === "drag") {
      this.order();
      return this.drop();
    }
    this.drop();
    const to = { x: event.clientX, y: event.clientY };
    const moved = Math.hypot(to.x - stroke.from.x, to.y - stroke.from.y) > STILL;
    if (stroke.kind === "slice" && moved) this.slice(stroke.from, to);
    if (stroke.kind === "press" && !moved) this.press(to);
  }

  private press({ x, y }: Place): void {
    const sight = this.bench.sight(x, y);
    if (sight === null) return;
    if (this.tool === "throw") return this.bench.throwBall(sight);
    const hit = this.bench.pick(sight);
    if (this.tool === "burst" && hit !== null) this.bench.burst(hit);
  }

  private slice(from: Place, to: Place): void {
    const sights = [from, to].map(({ x, y }) => this.bench.sight(x, y));
    if (sights[0] && sights[1]) this.bench.slice(sights[0], sights[1]);
  }
}

const rounded = (point: Vector3): number[] =>
  point.toArray().map((part) => Math.round(part * TO_MILLIMETRES) / TO_MILLIMETRES);
