// A world and its story: what a worker does with what the page orders. Needs no browser.
import { type Snapshot, World, shotScene } from "../../engine/engine.js";
import { WorldReader } from "../../npm/src/reader";
import type { Action, BodyDesc, Deed, Order, Story, Told } from "./protocol";

/** World before each deed that can be undone. */
interface Before {
  frame: number;
  snapshot: Snapshot;
  known: Set<number>;
  /** Number of actions. */
  actions: number;
}

/** Snapshots share their shapes, so that one takes some hundred bytes a body. */
const MOST_UNDOS = 50;

export class Simulator {
  private world: World | null = null;
  private story: Story = { scene: "", actions: [] };
  private reader = new WorldReader();
  private undos: Before[] = [];

  constructor(private readonly tell: (told: Told) => void) {}

  /** Do what the page orders; faults are told. */
  obey(order: Order): void {
    try {
      this.does(order);
    } catch (error) {
      this.tell({
        kind: "fault",
        sentence: error instanceof Error ? error.message : String(error),
      });
    }
    this.tell({ kind: "done", story: this.story });
  }

  private does(order: Order): void {
    switch (order.kind) {
      case "build":
        return this.build(order.story, order.frames);
      case "step":
        return this.step(order.frames, order.patience);
      case "shot":
        return this.build({ scene: shotScene(order.name), actions: [] }, 0);
      case "do":
        return this.act({ ...order.deed, frame: this.needed().frame });
      case "undo":
        return this.undo();
    }
  }

  private needed(): World {
    if (this.world === null) throw new Error("nothing is built yet");
    return this.world;
  }

  private build(story: Story, frames: number): void {
    const world = new World(story.scene);
    this.world?.free();
    for (const undo of this.undos) undo.snapshot.free();
    [this.world, this.reader, this.undos] = [world, new WorldReader(), []];
    this.story = { scene: story.scene, actions: [] };
    this.tell({ kind: "built", framesPerSecond: Math.round(1 / world.dt), story });
    this.show(0);
    for (const action of story.actions) {
      this.step(action.frame - world.frame);
      this.act(action);
    }
    this.step(frames - world.frame);
  }

  private step(frames: number, patience = Infinity): void {
    const world = this.needed();
    const end = performance.now() + patience;
    for (let i = 0; i < frames && performance.now() < end; i++) {
      const start = performance.now();
      world.step();
      this.show(performance.now() - start);
    }
  }

  private act(action: Action): void {
    const world = this.needed();
    const { actions } = this.story;
    const before = {
      frame: world.frame,
      snapshot: world.snapshot(),
      known: new Set(this.reader.known),
      actions: actions.length,
    };
    let changed = false;
    try {
      changed = does(world, action);
    } finally {
      if (!changed) before.snapshot.free();
    }
    if (!changed) return;
    this.story = { ...this.story, actions: [...actions, action] };
    // All of a drag is undone at once, and all that a line cut.
    if (goesOn(action, actions)) return before.snapshot.free();
    this.undos.push(before);
    if (this.undos.length > MOST_UNDOS) this.undos.shift()!.snapshot.free();
  }

  private undo(): void {
    const before = this.undos.pop();
    if (before === undefined) return;
    this.needed().restore(before.snapshot);
    before.snapshot.free();
    this.reader.known = before.known;
    this.story = { ...this.story, actions: this.story.actions.slice(0, before.actions) };
    this.tell({ kind: "undone", frame: before.frame + 1, story: this.story });
  }

  private show(duration: number): void {
    const world = this.needed();
    const [kinetic, potential] = world.energy();
    const energy = kinetic! + potential!;
    const state = this.reader.read(world);
    this.tell({ kind: "frame", state: { ...state, duration, energy, hash: world.stateHash() } });
  }
}

/** Whether it changed anything; throws the rule that a deed breaks. */
function does(world: World, deed: Deed): boolean {
  if ("letGo" in deed) return world.letGo(deed.letGo);
  if ("cut" in deed)
    return world.cut(deed.cut.body, numbers(deed.cut.point), numbers(deed.cut.normal)).length > 0;
  if ("burst" in deed)
    return world.burst(deed.burst.body, numbers(deed.burst.point), deed.burst.speed).length > 0;
  if ("add" in deed) world.addBody(JSON.stringify(deed.add));
  else
    world.hold(
      deed.hold.body,
      numbers(deed.hold.point),
      numbers(deed.hold.target),
      deed.hold.force,
    );
  return true;
}

const numbers = (values: number[]): Float64Array => Float64Array.from(values);

/**
 * Whether an action is part of the drag, or of the line over many pieces, that the ones before
 * began.
 */
function goesOn(action: Action, before: readonly Action[]): boolean {
  if ("cut" in action) {
    const last = before.at(-1);
    return last !== undefined && "cut" in last && last.frame === action.frame;
  }
  const body = "hold" in action ? action.hold.body : "letGo" in action ? action.letGo : -1;
  const isOfIt = (one: Action): boolean =>
    ("hold" in one && one.hold.body === body) || ("letGo" in one && one.letGo === body);
  const last = before.filter(isOfIt).at(-1);
  return last !== undefined && "hold" in last;
}

/** A ball that somebody throws. */
export function ball(
  radius: number,
  from: readonly number[],
  velocity: readonly number[],
  number: number,
): BodyDesc {
  return {
    name: `ball ${number}`,
    shape: { kind: "sphere", radius },
    position: from,
    linear_velocity: velocity,
    density: 7850,
    friction: 0.4,
    restitution: 0.3,
    look: "metal",
  };
}
