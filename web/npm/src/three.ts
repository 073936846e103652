// A world in a scene of three.js: two draw calls for each look, however many pieces there are.
import {
  Color, Group, type Intersection, type Material, Matrix4, Mesh, MeshPhysicalMaterial,
  MeshStandardMaterial, PlaneGeometry, Quaternion, Vector3,
} from "three";
import { Batch } from "./batch";
import { type Look, lookOf, tintOf } from "./looks";
import { type Shaded, shaded } from "./normals";
import { type NewBody, type ReadableWorld, WorldReader, type WorldState } from "./reader";

export { type NewBody, type ReadableWorld, WorldReader, type WorldState } from "./reader";

/** Materials of a body's outside and of what cracks make. */
export interface Sides {
  outside: Material;
  inside: Material;
}

export interface FrangibleMeshOptions {
  /**
   * Materials of a body of the scene; its pieces have them too. The same materials for many bodies
   * keep draw calls few. Without it, or where it returns nothing, they come from the body's look.
   */
  materials?: (body: NewBody) => Sides | undefined;
  /** By how much pieces differ in brightness: a factor of what their look says. */
  variation?: number;
  /** Width of the square that is drawn of a half-space [m]; 0 draws none. */
  ground?: number;
}

/** Numbers of a pose. */
const POSE = 7;
const ONE = new Vector3(1, 1, 1);

/** A body that lives. */
interface Shown {
  sides: Sides;
  variation: number;
  parts: (Batch | Mesh)[];
  before: Float32Array;
  now: Float32Array;
  /** Whether its matrix is that of `now`. */
  settled: boolean;
}

export class FrangibleMesh extends Group {
  private readonly bodies = new Map<number, Shown>();
  /** Of outsides, and of insides: a material may be both. */
  private readonly batches = [new Map<Material, Batch>(), new Map<Material, Batch>()] as const;
  /** Of all bodies that ever were: pieces look like what they broke off from. */
  private readonly parents = new Map<number, { sides: Sides; variation: number }>();
  /** Materials made here, by the look. */
  private readonly made = new Map<string, Sides>();
  private readonly reader = new WorldReader();
  private frame = -1;

  /** `world` is left out where states come from a worker. */
  constructor(
    private readonly world: ReadableWorld | null = null,
    private readonly options: FrangibleMeshOptions = {},
  ) {
    super();
    if (world !== null) this.update();
  }

  /** Shows the world as it is now: after `step`, `addBody`, `removeBody`, `restore`. */
  update(): void {
    if (this.world === null)
      throw new Error(
        "FrangibleMesh.update: it was made without a world, must have one; take() shows states",
      );
    this.take(this.reader.read(this.world));
  }

  /** Shows a state that a `WorldReader` read. */
  take(state: WorldState): void {
    const living = new Set(state.ids);
    const follows = state.frame === this.frame + 1;
    this.frame = state.frame;
    for (const id of [...this.bodies.keys()]) if (!living.has(id)) this.takeOut(id);
    // Those that come again are others.
    for (const born of state.born) this.takeOut(born.id);
    for (const born of state.born) this.takeIn(born);
    state.ids.forEach((id, row) => {
      const body = this.bodies.get(id);
      if (body === undefined) return;
      const pose = state.poses.subarray(POSE * row, POSE * (row + 1));
      const fresh = body.now.length === 0;
      const still = !fresh && same(pose, body.now) && same(body.now, body.before);
      if (still) return;
      body.before = follows && !fresh ? body.now : pose.slice();
      body.now = pose.slice();
      body.settled = false;
    });
    this.interpolate(1);
  }

  /** Poses between the last frame but one (0) and the last (1), for screens faster than frames. */
  interpolate(part: number): void {
    for (const [id, body] of this.bodies) {
      if (body.settled) continue;
      place(body, part);
      for (const piece of body.parts) {
        if (piece instanceof Batch) piece.place(id, matrix);
        else matrix.decompose(piece.position, piece.quaternion, piece.scale);
      }
      body.settled = same(body.before, body.now);
    }
  }

  /** The body that a ray hit, of `raycaster.intersectObject(view)`. */
  bodyOf({ object, batchId }: Intersection): number | undefined {
    if (object instanceof Batch) return batchId === undefined ? undefined : object.bodyAt(batchId);
    for (const [id, body] of this.bodies) if (body.parts.includes(object as Mesh)) return id;
    return undefined;
  }

  /** Lets go of what the driver holds; materials that the caller made are the caller's. */
  dispose(): void {
    for (const batches of this.batches) for (const batch of batches.values()) batch.dispose();
    for (const body of this.bodies.values())
      for (const part of body.parts) if (!(part instanceof Batch)) part.geometry.dispose();
    for (const { outside, inside } of this.made.values())
      [outside, inside].forEach((material) => material.dispose());
    this.clear();
    this.bodies.clear();
    for (const batches of this.batches) batches.clear();
    this.parents.clear();
    this.made.clear();
  }

  private takeIn(born: NewBody): void {
    const parent = this.parents.get(born.parent);
    const look = lookOf(born.look, born.motion === "dynamic" || born.parent >= 0, born.id);
    const sides = parent?.sides ?? this.options.materials?.(born) ?? this.sidesOf(born, look);
    const variation = parent?.variation ?? look.variation * (this.options.variation ?? 1);
    const none = new Float32Array();
    const body: Shown = { sides, variation, parts: [], before: none, now: none, settled: false };
    this.bodies.set(born.id, body);
    this.parents.set(born.id, { sides, variation });
    if (born.triangles.length === 0) this.addGround(body);
    else this.addSides(born, body, shaded(born.positions, born.triangles, born.interior));
  }

  private addSides(born: NewBody, body: Shown, surface: Shaded): void {
    const tint = born.parent < 0 ? [1, 1, 1] as const : tintOf(born.id, body.variation);
    const colour = new Color().setRGB(tint[0], tint[1], tint[2]);
    ([[0, body.sides.outside], [1, body.sides.inside]] as const).forEach(([slot, material]) => {
      if (!surface.slots.includes(slot)) return;
      const batch = this.batchOf(material, slot);
      batch.put(born.id, surface, slot, colour);
      body.parts.push(batch);
    });
  }

  private addGround(body: Shown): void {
    const size = this.options.ground ?? 100;
    if (size <= 0) return;
    const mesh = new Mesh(new PlaneGeometry(size, size).rotateX(-Math.PI / 2), body.sides.outside);
    mesh.receiveShadow = true;
    body.parts.push(mesh);
    this.add(mesh);
  }

  private batchOf(material: Material, slot: 0 | 1): Batch {
    const batches = this.batches[slot];
    let batch = batches.get(material);
    if (batch === undefined) {
      batch = new Batch(material);
      batches.set(material, batch);
      this.add(batch);
    }
    return batch;
  }

  private takeOut(id: number): void {
    const body = this.bodies.get(id);
    if (body === undefined) return;
    for (const part of body.parts) {
      if (part instanceof Batch) part.take(id);
      else {
        this.remove(part);
        part.geometry.dispose();
      }
    }
    this.bodies.delete(id);
  }

  private sidesOf(born: NewBody, look: Look): Sides {
    // Without a look they share a few colours, so that draw calls stay few.
    const key = born.look || look.outside.colour.join();
    let sides = this.made.get(key);
    if (sides === undefined) {
      sides = { outside: materialOf(look, "outside"), inside: materialOf(look, "inside") };
      this.made.set(key, sides);
    }
    return sides;
  }
}

const matrix = new Matrix4();
const [place0, place1] = [new Vector3(), new Vector3()];
const [turn0, turn1] = [new Quaternion(), new Quaternion()];

/** Sets `matrix` to a body's pose between its last two. */
function place({ before, now }: Shown, part: number): void {
  place0.fromArray(before).lerp(place1.fromArray(now), part);
  turn0.fromArray(before, 3).slerp(turn1.fromArray(now, 3), part);
  matrix.compose(place0, turn0, ONE);
}

function same(a: Float32Array, b: Float32Array): boolean {
  return a.length === b.length && a.every((part, i) => part === b[i]);
}

/** Roughness of what is no metal, of metal, and of glass. */
const ROUGHNESS = { plain: 0.85, metal: 0.4, clear: 0.05 };

function materialOf(look: Look, side: "outside" | "inside"): Material {
  const { colour, metallic, clear } = look[side];
  const [red, green, blue] = colour as [number, number, number];
  const shared = { color: new Color().setRGB(red, green, blue), metalness: metallic };
  if (clear > 0)
    return new MeshPhysicalMaterial({
      ...shared,
      roughness: ROUGHNESS.clear,
      transparent: true,
      opacity: 1 - clear,
      depthWrite: false,
    });
  return new MeshStandardMaterial({
    ...shared,
    roughness: metallic > 0 ? ROUGHNESS.metal : ROUGHNESS.plain,
  });
}
