// What changes in a world: poses in every frame, and each body's surface once. Plain data, which a
// worker can send to its page.

/** A body that was not there before. */
export interface NewBody {
  id: number;
  /** Of what it broke off from; -1 for none. */
  parent: number;
  name: string;
  /** Empty if the scene gives it none. */
  look: string;
  /** `"dynamic"`, `"kinematic"` or `"static"`. */
  motion: string;
  /** [kg] */
  mass: number;
  /** In the body's frame [m]; empty for a half-space. */
  positions: Float32Array;
  triangles: Uint32Array;
  /** 1 where a crack made a triangle. */
  interior: Uint8Array;
}

/** State of a world after a frame. */
export interface WorldState {
  frame: number;
  /** Living bodies, in order of birth. */
  ids: Float64Array;
  /** Seven numbers each: x, y, z [m], and a quaternion x, y, z, w. */
  poses: Float32Array;
  /** Bodies that the states before did not have. */
  born: NewBody[];
}

/** The part of a world that is read. */
export interface ReadableWorld {
  readonly frame: number;
  ids(): Float64Array;
  poses(): Float32Array;
  masses(): Float64Array;
  name(id: number): string;
  look(id: number): string | undefined;
  motion(id: number): string;
  parent(id: number): number | undefined;
  surface(id: number): {
    positions(): Float32Array;
    triangles(): Uint32Array;
    interior(): Uint8Array;
    free(): void;
  };
}

/** Reads one world, frame after frame. After `world.restore` read at once: ids may come again. */
export class WorldReader {
  /** Ids whose surfaces were read. */
  known = new Set<number>();

  read(world: ReadableWorld): WorldState {
    const ids = world.ids();
    const masses = world.masses();
    const born: NewBody[] = [];
    ids.forEach((id, row) => {
      if (!this.known.has(id)) born.push(newBody(world, id, masses[row]!));
    });
    this.known = new Set(ids);
    return { frame: world.frame, ids, poses: world.poses(), born };
  }
}

function newBody(world: ReadableWorld, id: number, mass: number): NewBody {
  const surface = world.surface(id);
  const body = {
    id,
    parent: world.parent(id) ?? -1,
    name: world.name(id),
    look: world.look(id) ?? "",
    motion: world.motion(id),
    mass,
    positions: surface.positions(),
    triangles: surface.triangles(),
    interior: surface.interior(),
  };
  surface.free();
  return body;
}
