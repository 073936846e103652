// Footage of a world that is being simulated: it grows by a frame at a time.
import { Quaternion, Vector3 } from "three";
import { TEXELS } from "../poses";
import type { Body, Footage, Material, Mesh } from "../recording";
import { type Finish, type Look, lookOf, tintOf } from "../../npm/src/looks";
import { shaded } from "../../npm/src/normals";
import type { NewBody } from "../../npm/src/reader";
import type { FrameState } from "./protocol";

/** Of the first view, in degrees. */
const FIELD_OF_VIEW = 35;
/** Towards the eye of the first view. */
const FROM = new Vector3(0.55, 0.4, 1).normalize();
/** Distance of the first view over the size of what moves. */
const DISTANCE = 2.1;
/** Numbers of a pose. */
const POSE = 7;

/** A body of the world, and the last frame that shows it. */
export interface Life extends Body {
  id: number;
  name: string;
  /** [kg]; 0 for what does not move by itself. */
  mass: number;
}

export class LiveFootage implements Footage {
  readonly grows = true;
  readonly materials: Material[] = [];
  readonly meshes: Mesh[] = [];
  readonly bodies: Life[] = [];
  camera: Footage["camera"] = { eye: [4, 3, 7], target: [0, 0, 0], fieldOfView: FIELD_OF_VIEW };
  private readonly states: FrameState[] = [];
  /** Rows of bodies by their ids. */
  private readonly rows = new Map<number, number>();
  /** For each frame, which row of its state each body has. */
  private readonly places: Int32Array[] = [];
  /** Of meshes, for who looks for what is under the pointer. */
  private readonly radii: number[] = [];
  private readonly made = new Map<string, number>();

  constructor(
    readonly shot: string,
    readonly fps: number,
    /** Frame 0. */
    first: FrameState,
  ) {
    this.append(first);
    this.camera = this.firstView();
  }

  get frames(): number {
    return this.states.length - 1;
  }

  /** State of a frame. */
  state(frame: number): FrameState {
    return this.states[Math.min(Math.max(frame, 0), this.frames)]!;
  }

  /** One of its bodies, by its id. */
  body(id: number): Life | undefined {
    return this.bodies[this.rows.get(id) ?? -1];
  }

  /** Of the ball around the origin of a mesh that holds it [m]. */
  radius(mesh: number): number {
    return this.radii[mesh]!;
  }

  /** The next frame; true if there are bodies that were not there before. */
  append(state: FrameState): boolean {
    this.states.push(state);
    state.born.forEach((born) => this.add(born, this.frames));
    const place = new Int32Array(this.bodies.length).fill(-1);
    state.ids.forEach((id, row) => (place[this.rows.get(id)!] = row));
    this.places.push(place);
    this.bodies.forEach((body, row) => {
      if (place[row]! >= 0) body.end = this.frames + 1;
    });
    if (state.born.length > 0) this.pull(state.born);
    return state.born.length > 0;
  }

  /** Forget all frames from one on. */
  cut(frame: number): void {
    this.states.length = this.places.length = frame;
    const gone = this.bodies.findIndex((body) => body.birth >= frame);
    if (gone >= 0) {
      for (const body of this.bodies.splice(gone)) this.rows.delete(body.id);
      this.meshes.length = this.radii.length = this.bodies.length;
    }
    for (const body of this.bodies) body.end = Math.min(body.end, frame);
  }

  fill(time: number, explode: number, origin: readonly number[], into: Float32Array): void {
    const frame = Math.min(Math.floor(time), this.frames);
    const next = Math.min(frame + 1, this.frames);
    const part = time - frame;
    this.bodies.forEach((body, row) => {
      const at = 4 * TEXELS * row;
      const here = this.places[frame]![row] ?? -1;
      into[at + 3] = here >= 0 ? 1 : 0;
      if (here < 0) return;
      const there = this.places[next]![row] ?? -1;
      const from = this.states[frame]!.poses.subarray(POSE * here, POSE * (here + 1));
      const to =
        there < 0 ? from : this.states[next]!.poses.subarray(POSE * there, POSE * (there + 1));
      for (let axis = 0; axis < 3; axis++)
        into[at + axis] =
          from[axis]! +
          part * (to[axis]! - from[axis]!) -
          origin[axis]! +
          explode * body.pull[axis]!;
      // The short way around.
      let cosine = 0;
      for (let axis = 3; axis < POSE; axis++) cosine += from[axis]! * to[axis]!;
      let length = 0;
      for (let axis = 3; axis < POSE; axis++) {
        const value = from[axis]! + part * (Math.sign(cosine || 1) * to[axis]! - from[axis]!);
        into[at + axis + 1] = value;
        length += value * value;
      }
      for (let axis = 0; axis < 4; axis++) into[at + 4 + axis]! /= Math.sqrt(length) || 1;
    });
  }

  /** Half the size of what moves at first, for what is thrown. */
  get size(): number {
    const { eye, target } = this.camera;
    return Math.hypot(...eye.map((part, axis) => part - target[axis]!)) / DISTANCE / 2;
  }

  private add(born: NewBody, frame: number): void {
    const parent = this.rows.get(born.parent) ?? -1;
    const moves = born.motion === "dynamic" || parent >= 0;
    const look = lookOf(born.look, moves, this.made.size);
    this.rows.set(born.id, this.bodies.length);
    this.meshes.push({
      ...shaded(born.positions, born.triangles, born.interior),
      places: null,
      colours: null,
    });
    let radius = 0;
    for (let i = 0; i < born.positions.length; i += 3)
      radius = Math.max(
        radius,
        Math.hypot(born.positions[i]!, born.positions[i + 1]!, born.positions[i + 2]!),
      );
    this.radii.push(radius);
    this.bodies.push({
      id: born.id,
      name: born.name,
      mass: born.motion === "dynamic" ? born.mass : 0,
      birth: frame,
      end: frame + 1,
      parent,
      floor: born.triangles.length === 0,
      mesh: this.meshes.length - 1,
      materials:
        parent >= 0 && born.look === ""
          ? this.bodies[parent]!.materials
          : this.sides(born.look || `body ${born.id}`, look),
      tint: born.parent < 0 ? [1, 1, 1] : tintOf(born.id, look.variation),
      grain: [0, 0, 0, 1],
      pull: [0, 0, 0],
      pose: 0,
      poses: 0,
      lead: false,
      yields: false,
    });
  }

  /** Materials of both sides, made when they are first needed. */
  private sides(name: string, look: Look): number[] {
    return (["outside", "inside"] as const).map((side) => {
      const key = `${name}_${side}`;
      let row = this.made.get(key);
      if (row === undefined) {
        row = this.materials.length;
        this.made.set(key, row);
        this.materials.push(material(key, name, look[side], side === "inside"));
      }
      return row;
    });
  }

  /**
   * By how much pieces move when they are pulled apart: away from the middle of what broke off
   * together.
   */
  private pull(born: NewBody[]): void {
    const families = new Map<number, NewBody[]>();
    for (const body of born)
      if (body.parent >= 0) families.set(body.parent, [...(families.get(body.parent) ?? []), body]);
    for (const [parent, family] of families) {
      const centres = family.map((body) => this.centre(body.id));
      const mass = family.reduce((sum, body) => sum + body.mass, 0);
      const middle = [0, 1, 2].map(
        (axis) =>
          family.reduce((sum, body, i) => sum + body.mass * centres[i]![axis]!, 0) / (mass || 1),
      );
      // The lowest keeps its height.
      middle[1] = Math.min(...centres.map((centre) => centre[1]!));
      const before = this.bodies[this.rows.get(parent) ?? -1]?.pull ?? [0, 0, 0];
      family.forEach((body, i) => {
        this.bodies[this.rows.get(body.id)!]!.pull = [0, 1, 2].map(
          (axis) => centres[i]![axis]! - middle[axis]! + before[axis]!,
        ) as Body["pull"];
      });
    }
  }

  /** Of mass, in the last frame [m]. */
  private centre(id: number): number[] {
    const row = this.places.at(-1)![this.rows.get(id)!]!;
    return Array.from(this.states.at(-1)!.poses.subarray(POSE * row, POSE * row + 3));
  }

  /** Everything that can move, from the front and above. */
  private firstView(): Footage["camera"] {
    const low = new Vector3(Infinity, Infinity, Infinity);
    const high = new Vector3(-Infinity, -Infinity, -Infinity);
    const moving = this.states[0]!.born.filter(
      (body) => body.motion === "dynamic" && body.triangles.length > 0,
    );
    for (const born of moving) {
      const row = this.places[0]![this.rows.get(born.id)!]!;
      const pose = this.states[0]!.poses.subarray(POSE * row, POSE * (row + 1));
      const turn = new Quaternion().fromArray(pose, 3);
      for (let i = 0; i < born.positions.length; i += 3) {
        const corner = new Vector3()
          .fromArray(born.positions, i)
          .applyQuaternion(turn)
          .add(new Vector3().fromArray(pose));
        low.min(corner);
        high.max(corner);
      }
    }
    if (moving.length === 0) [low.set(-1, 0, -1), high.set(1, 1, 1)];
    const target = low.clone().add(high).multiplyScalar(0.5);
    const eye = target.clone().addScaledVector(FROM, DISTANCE * low.distanceTo(high));
    return { eye: eye.toArray(), target: target.toArray(), fieldOfView: FIELD_OF_VIEW };
  }
}

function material(
  name: string,
  look: string,
  { colour, metallic, clear }: Finish,
  inside: boolean,
): Material {
  const [red, green, blue] = colour as [number, number, number];
  return {
    name,
    colour: [red, green, blue],
    metallic,
    clear,
    emission: [0, 0, 0],
    roughness: -1,
    image: -1,
    surfaceImage: -1,
    normalImage: -1,
    emissionImage: -1,
    cutoff: 0,
    blended: false,
    grain: look === "wood" || look === "concrete" ? look : "",
    inside,
  };
}
