// A world and its story: what a worker does with what the page orders. Needs no browser.
import { type Snapshot, World } from "../../engine/engine.js";
import { WorldReader } from "../../npm/src/reader";
import type { Action, BodyDesc, Order, Story, Told } from "./protocol";

/** World before each action that can be undone. */
interface Before {
  frame: number;
  snapshot: Snapshot;
  known: Set<number>;
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
      this.tell({ kind: "fault", sentence: error instanceof Error ? error.message : String(error) });
    }
    this.tell({ kind: "done", story: this.story });
  }

  private does(order: Order): void {
    switch (order.kind) {
      case "build":
        return this.build(order.story, order.frames);
      case "step":
        return this.step(order.frames);
      case "add":
        return this.add({ frame: this.needed().frame, add: order.body });
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
      this.add(action);
    }
    this.step(frames - world.frame);
  }

  private step(frames: number): void {
    const world = this.needed();
    for (let i = 0; i < frames; i++) {
      const start = performance.now();
      world.step();
      this.show(performance.now() - start);
    }
  }

  private add(action: Action): void {
    const world = this.needed();
    const before = { frame: world.frame, snapshot: world.snapshot(), known: new Set(this.reader.known) };
    world.addBody(JSON.stringify(action.add));
    this.undos.push(before);
    if (this.undos.length > MOST_UNDOS) this.undos.shift()!.snapshot.free();
    this.story = { ...this.story, actions: [...this.story.actions, action] };
  }

  private undo(): void {
    const before = this.undos.pop();
    if (before === undefined) return;
    this.needed().restore(before.snapshot);
    before.snapshot.free();
    this.reader.known = before.known;
    this.story = { ...this.story, actions: this.story.actions.slice(0, -1) };
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

/** A ball that somebody throws. */
export function ball(radius: number, from: readonly number[], velocity: readonly number[], number: number): BodyDesc {
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
