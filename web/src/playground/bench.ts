// The world that is shown, as tools see it.
import { Quaternion, Raycaster, Vector2, Vector3 } from "three";
import { input } from "../element";
import type { Player } from "../player";
import type { LiveFootage } from "./live";
import { type Hit, type Sight, crossed, pick } from "./pick";
import type { Deed, Order } from "./protocol";
import { ball } from "./simulator";
import type { Bench } from "./tools";

/**
 * The worker is ahead of the picture by two frames, so that what is thrown is seen soon; by more
 * where pictures take longer than frames, so that time passes all the same: as many as pass at most
 * from a picture to the next, a quarter of a second.
 */
export const AHEAD = 2;
export const MOST_AHEAD = 15;
/** The farthest pieces of a burst fly so fast: half a metre before they fall as far [m/s]. */
const BURST = 2;

/** What a page shows, and who simulates it. */
export interface Shown {
  readonly footage: LiveFootage | null;
  readonly player: Player | null;
  /** Number of balls. */
  throws: number;
  order(order: Order): void;
}

export class WorldBench implements Bench {
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly shown: Shown,
  ) {}

  sight(x: number, y: number): Sight | null {
    const { player, footage } = this.shown;
    if (player === null || footage === null) return null;
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const caster = new Raycaster();
    player.camera.updateMatrixWorld();
    caster.setFromCamera(
      new Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height),
      player.camera,
    );
    const { ray } = caster;
    return {
      origin: ray.origin.add(new Vector3().fromArray(footage.camera.target)),
      direction: ray.direction,
    };
  }

  /** What is done is done to the last frame. */
  pick(sight: Sight): Hit | null {
    const { player, footage } = this.shown;
    if (player === null || footage === null) return null;
    return pick(footage, this.atEnd(player, footage), sight);
  }

  seen(id: number, pointBody: Vector3): [number, number] | null {
    const { player, footage } = this.shown;
    if (player === null || footage === null) return null;
    const state = footage.state(player.clock.frame);
    const row = state.ids.indexOf(id);
    if (row < 0) return null;
    const place = pointBody
      .clone()
      .applyQuaternion(new Quaternion().fromArray(state.poses, 7 * row + 3));
    place
      .add(new Vector3().fromArray(state.poses, 7 * row))
      .sub(new Vector3().fromArray(footage.camera.target))
      .project(player.camera);
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return [left + (0.5 + 0.5 * place.x) * width, top + (0.5 - 0.5 * place.y) * height];
  }

  forward(): Vector3 {
    return this.shown.player!.camera.getWorldDirection(new Vector3());
  }

  do(deed: Deed): void {
    const { player, footage } = this.shown;
    if (player === null || footage === null) return;
    this.shown.order({ kind: "do", deed });
    this.atEnd(player, footage);
    player.clock.playing = true;
  }

  throwBall({ origin, direction }: Sight): void {
    const { player, footage } = this.shown;
    if (player === null || footage === null) return;
    // It starts nearer than the eye, or a far view waits for it.
    const from = origin
      .clone()
      .addScaledVector(direction, Math.max(0, player.camera.position.length() - 4 * footage.size));
    const velocity = direction.clone().multiplyScalar(input("velocity").valueAsNumber);
    this.shown.throws++;
    this.do({
      add: ball(
        input("radius").valueAsNumber,
        from.toArray(),
        velocity.toArray(),
        this.shown.throws,
      ),
    });
  }

  slice(from: Sight, to: Sight): void {
    const { player, footage } = this.shown;
    if (player === null || footage === null) return;
    const { bodies, normal } = crossed(footage, this.atEnd(player, footage), from, to);
    for (const body of bodies)
      this.do({ cut: { body, point: from.origin.toArray(), normal: normal.toArray() } });
  }

  burst({ body, point }: Hit): void {
    this.do({ burst: { body, point: point.toArray(), speed: BURST } });
  }

  /** Shows the last frames, if earlier ones are looked at; the frame that is shown. */
  private atEnd(player: Player, footage: LiveFootage): number {
    if (player.clock.time < footage.frames - MOST_AHEAD) player.clock.seek(footage.frames);
    return player.clock.frame;
  }
}
