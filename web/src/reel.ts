// A recording that is read in chunks, each a blob: a whole one from a page, or many from a run that
// goes on.
import { readBooks, type Books } from "./books";
import { readMeshes, scaled } from "./meshes";
import { type Posed, fillPoses } from "./poses";
import type { Body, Footage, Image, Material, Mesh, Path } from "./recording";
import { Blob32 } from "./streams";

/** The version of the data that this player reads. */
const FORMAT = 3;

interface Header {
  format: number;
  shot: string;
  fps: number;
  /** First and last frame of the chunk; the first is the last of the chunk before. */
  first: number;
  frames: number;
  /** Whether no more chunks come. */
  isLast: boolean;
  camera: Footage["camera"];
  gravity: number | null;
  /** Of the bodies that are new. */
  names: string[];
  materials: Material[];
  images: Image[];
  steps: Record<string, number>;
}

/** Frames of a chunk, with a path for each body that is known by then. */
interface Chunk extends Posed {
  first: number;
  last: number;
}

/** The path of a body that a chunk does not show. */
const ABSENT: Path = {
  birth: 0,
  end: 0,
  parent: -1,
  pull: [0, 0, 0],
  pose: 0,
  poses: 0,
  lead: false,
  yields: false,
};

export class Reel implements Footage {
  shot = "";
  fps = 30;
  frames = 0;
  grows = true;
  camera: Footage["camera"] = { eye: [0, 0, 1], target: [0, 0, 0], fieldOfView: 35 };
  readonly materials: Material[] = [];
  readonly meshes: Mesh[] = [];
  readonly bodies: Body[] = [];
  readonly images: Image[] = [];
  readonly books: Books = { energy: [], strikes: [], gravity: null };
  private readonly chunks: Chunk[] = [];

  /** Take in the next inflated blob; true if it has bodies that were not there before. */
  append(bytes: Uint8Array): boolean {
    const blob = new Blob32(bytes);
    const header = blob.header as unknown as Header;
    if (header.format !== FORMAT)
      throw new Error(`the recording has format ${header.format}, and this player reads ${FORMAT}`);
    const step = (name: string): number => header.steps[name] ?? 1;
    const known = this.bodies.length;
    this.readBodies(blob, header, step);
    this.meshes.push(...readMeshes(blob, step));
    this.materials.push(...header.materials);
    this.images.push(...header.images);
    this.readPaths(blob, header, step("position"));
    readBooks(blob, this.books);
    this.books.gravity ??= header.gravity;
    const { shot, fps, frames, camera } = header;
    Object.assign(this, { shot, fps, frames, grows: !header.isLast });
    if (this.chunks.length === 1) this.camera = camera;
    return this.bodies.length > known;
  }

  fill(time: number, explode: number, origin: readonly number[], into: Float32Array): void {
    // A frame that two chunks share is the end of the first.
    let low = 0;
    let high = this.chunks.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.chunks[middle]!.last < time) low = middle + 1;
      else high = middle;
    }
    const chunk = this.chunks[low];
    if (chunk === undefined) return;
    // What is born later is not shown.
    for (let row = chunk.bodies.length; row < this.bodies.length; row++) into[8 * row + 3] = 0;
    fillPoses(chunk, time, explode, origin, into);
  }

  private readBodies(blob: Blob32, header: Header, step: (name: string) => number): void {
    const [low, high] = blob.columns("id") as [Int32Array, Int32Array];
    const [parent, floor, mesh, broke] = columns(blob, "parent", "floor", "mesh", "broke");
    const [slots, material] = columns(blob, "slots", "materials");
    const mass = new Float32Array(blob.column("mass").slice().buffer);
    const [pull, tint, grain] = [blob.columns("pull"), blob.columns("tint"), blob.columns("grain")];
    let slot = 0;
    header.names.forEach((name, row) => {
      this.bodies.push({
        ...ABSENT,
        birth: -1,
        id: 2 ** 32 * (high[row]! >>> 0) + (low[row]! >>> 0),
        name,
        mass: mass[row]!,
        parent: parent![row]!,
        floor: floor![row] === 1,
        mesh: mesh![row]!,
        materials: Array.from(material!.subarray(slot, slot + slots![row]!)),
        tint: scaled(tint, row, step("tint")) as Body["tint"],
        grain: scaled(grain, row, step("orientation")) as Body["grain"],
        pull: scaled(pull, row, step("position")) as Body["pull"],
        broke: broke![row]!,
      });
      slot += slots![row]!;
    });
  }

  private readPaths(blob: Blob32, header: Header, positionStep: number): void {
    const [rows, birth, end] = columns(blob, "row", "birth", "end");
    const [poses, lead, yields] = columns(blob, "poses", "lead", "yields");
    const paths = new Array<Path>(this.bodies.length).fill(ABSENT);
    let pose = 0;
    rows!.forEach((row, index) => {
      const body = this.bodies[row]!;
      const path: Path = {
        birth: birth![index]!,
        end: end![index]!,
        parent: body.parent,
        pull: body.pull,
        pose,
        poses: poses![index]!,
        lead: lead![index] === 1,
        yields: yields![index] === 1,
      };
      pose += path.poses;
      paths[row] = path;
      if (body.birth < 0) body.birth = path.birth;
      body.end = path.end;
    });
    // What rests on its parent's pull needs the parent, alive or not.
    paths.forEach((path, row) => {
      if (path === ABSENT) paths[row] = { ...ABSENT, pull: this.bodies[row]!.pull };
    });
    const [positions, orientations] = [blob.columns("positions"), blob.columns("orientations")];
    this.chunks.push({
      first: header.first,
      last: header.frames,
      bodies: paths,
      positions,
      orientations,
      positionStep,
    });
  }
}

/** The recording of an inflated blob. */
export function readRecording(bytes: Uint8Array): Reel {
  const reel = new Reel();
  reel.append(bytes);
  return reel;
}

function columns(blob: Blob32, ...names: string[]): Int32Array[] {
  return names.map((name) => blob.column(name));
}
