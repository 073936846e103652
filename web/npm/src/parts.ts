// Exports of both entries, for browsers and for Node.
import { World as Engine, shotScene as shotText } from "./engine.js";
import type { BodyDesc, SceneDesc } from "./scene";

/** Bodies, and the engine that moves and breaks them. */
export class World extends Engine {
  /** Checks a scene and builds it; throws the first rule that it breaks. */
  constructor(scene: SceneDesc | string) {
    super(text(scene));
  }

  /**
   * Adds a body, as in a scene, behind all others; returns its id. Throws the first rule that it
   * breaks.
   */
  override addBody(body: BodyDesc | string): number {
    return super.addBody(text(body));
  }
}

/**
 * The scene of a built-in shot; throws for a name that no shot has, and for shots that need files.
 */
export function shotScene(name: string): SceneDesc {
  return JSON.parse(shotText(name)) as SceneDesc;
}

function text(description: object | string): string {
  return typeof description === "string" ? description : JSON.stringify(description);
}

export type { Fracture, InitInput, Snapshot, StepReport, Surface } from "./engine.js";
export { MATERIALS, type MaterialName } from "./materials";
export { type NewBody, type ReadableWorld, WorldReader, type WorldState } from "./reader";
export type * from "./descriptions";
