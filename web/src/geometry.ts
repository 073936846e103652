// All corners of all bodies in one set of buffers, and the tables that the shaders look bodies up
// in.
import { BufferAttribute, BufferGeometry, DataTexture, FloatType, RGBAFormat } from "three";
import { coarser } from "./coarse";
import { TEXELS } from "./poses";
import type { Footage } from "./recording";
import { TABLE_WIDTH } from "./shaders/place";

/**
 * Fewer triangles than these are drawn in 10 ms without a graphics card: coarser ones are not worth
 * their gaps.
 */
const MANY = 15_000;

/** What each kind of grain is for the shaders. */
const GRAINS = ["", "wood", "concrete"];

/** One solid and one clear surface, whatever the number of bodies. */
export class Geometries {
  readonly solid = new BufferGeometry();
  /** What lets light pass. */
  readonly glass = new BufferGeometry();
  hasGlass = false;
  /** Whether there are so many triangles that fewer are worth while. */
  isLarge = false;
  private indices: Record<"fine" | "coarse", Partial<Record<"solid" | "glass", BufferAttribute>>> =
    { fine: {}, coarse: {} };
  private isCoarse = false;
  private ends: Record<"fine" | "coarse", Record<"solid" | "glass", Uint32Array>> | null = null;
  private bodies = 0;

  /** `skinned` says whether corners have a place in an image, and a colour. */
  constructor(readonly skinned: boolean) {}

  /** Take in all bodies; what is smaller than a cell [m] may be left out where it is coarse. */
  fill(footage: Footage, cell: number): void {
    const merged = mergeBodies(footage, this.skinned, cell);
    this.hasGlass = merged.fine.glass.length > 0;
    this.isLarge = merged.fine.solid.length + merged.fine.glass.length > 3 * MANY;
    for (const part of ["solid", "glass"] as const) {
      const geometry = this[part];
      // What the driver has of the bodies before is let go.
      geometry.dispose();
      for (const [name, attribute] of Object.entries(merged.attributes))
        geometry.setAttribute(name, attribute);
      for (const detail of ["fine", "coarse"] as const)
        this.indices[detail][part] = new BufferAttribute(Uint32Array.from(merged[detail][part]), 1);
    }
    this.ends = merged.ends;
    this.bodies = footage.bodies.length;
    this.choose(this.isCoarse, this.bodies);
  }

  /** Draw fewer triangles of each body, or all, and so many of the bodies. */
  choose(isCoarse: boolean, bodies: number = this.bodies): void {
    [this.isCoarse, this.bodies] = [isCoarse, bodies];
    const detail = isCoarse ? "coarse" : "fine";
    for (const part of ["solid", "glass"] as const) {
      this[part].setIndex(this.indices[detail][part] ?? null);
      this[part].setDrawRange(0, this.ends?.[detail][part][bodies - 1] ?? 0);
    }
  }
}

/** True if a mesh's file gives its corners places in images, or colours. */
export function isSkinned({ meshes }: Footage): boolean {
  return meshes.some((mesh) => mesh.places !== null || mesh.colours !== null);
}

interface Merged {
  attributes: Record<string, BufferAttribute>;
  /** Corners of triangles, three each. */
  fine: Triangles;
  coarse: Triangles;
  /** Where those of each body end. */
  ends: Record<"fine" | "coarse", Record<"solid" | "glass", Uint32Array>>;
}

interface Triangles {
  solid: number[];
  glass: number[];
}

/** All corners of all bodies. */
function mergeBodies(
  { bodies, meshes, materials }: Footage,
  skinned: boolean,
  cell: number,
): Merged {
  const count = bodies.reduce((sum, body) => sum + meshes[body.mesh]!.slots.length, 0);
  const positions = new Float32Array(3 * count);
  const normals = new Int16Array(4 * count);
  const ids = new Uint32Array(2 * count);
  const fine: Triangles = { solid: [], glass: [] };
  const coarse: Triangles = { solid: [], glass: [] };
  const made = (): Record<"solid" | "glass", Uint32Array> => ({
    solid: new Uint32Array(bodies.length),
    glass: new Uint32Array(bodies.length),
  });
  const ends = { fine: made(), coarse: made() };
  const coarseMeshes = new Map<number, Int32Array>();
  const places = skinned ? new Float32Array(2 * count) : null;
  const colours = skinned ? new Uint8Array(4 * count).fill(255) : null;
  let first = 0;
  bodies.forEach((body, row) => {
    const mesh = meshes[body.mesh]!;
    positions.set(mesh.positions, 3 * first);
    if (mesh.places !== null) places?.set(mesh.places, 2 * first);
    if (mesh.colours !== null)
      colours?.set(
        mesh.colours.map((part) => Math.round(255 * part)),
        4 * first,
      );
    mesh.slots.forEach((slot, vertex) => {
      const at = first + vertex;
      for (let axis = 0; axis < 3; axis++)
        normals[4 * at + axis] = Math.round(32767 * mesh.normals[3 * vertex + axis]!);
      ids[2 * at] = row;
      ids[2 * at + 1] = body.materials[slot] ?? 0;
    });
    if (!coarseMeshes.has(body.mesh)) coarseMeshes.set(body.mesh, coarser(mesh, cell));
    for (const [triangles, all] of [
      [mesh.triangles, fine],
      [coarseMeshes.get(body.mesh)!, coarse],
    ] as const)
      for (let i = 0; i < triangles.length; i += 3) {
        const material = materials[ids[2 * (first + triangles[i]!) + 1]!]!;
        const into = material.clear > 0 || material.blended ? all.glass : all.solid;
        for (let corner = 0; corner < 3; corner++) into.push(first + triangles[i + corner]!);
      }
    first += mesh.slots.length;
    for (const part of ["solid", "glass"] as const)
      [ends.fine[part][row], ends.coarse[part][row]] = [fine[part].length, coarse[part].length];
  });

  const attributes: Record<string, BufferAttribute> = {
    position: new BufferAttribute(positions, 3),
    normal: new BufferAttribute(normals, 4, true),
    ids: new BufferAttribute(ids, 2),
  };
  if (places !== null && colours !== null) {
    attributes["place"] = new BufferAttribute(places, 2);
    attributes["cornerColour"] = new BufferAttribute(colours, 4, true);
  }
  return { attributes, fine, coarse, ends };
}

/** A texture of single-precision numbers, four to a texel. */
export function table(texels: number): DataTexture {
  const height = Math.max(1, Math.ceil(texels / TABLE_WIDTH));
  const texture = new DataTexture(
    new Float32Array(4 * TABLE_WIDTH * height),
    TABLE_WIDTH,
    height,
    RGBAFormat,
    FloatType,
  );
  texture.needsUpdate = true;
  return texture;
}

/** The numbers of a table. */
export function numbers(texture: DataTexture): Float32Array {
  return texture.image.data as Float32Array;
}

/** Tint and grain of every body. */
export function pieceTable({ bodies }: Footage): DataTexture {
  const texture = table(TEXELS * bodies.length);
  bodies.forEach((body, row) =>
    numbers(texture).set([...body.tint, 0, ...body.grain], 4 * TEXELS * row),
  );
  return texture;
}

/**
 * Of every material: colour and clearness; how metallic it is, its grain, whether it is an inside,
 * its image; what it shines with, and its cutoff, or 2 where opacity lets light through; roughness
 * and the other images.
 */
export function materialTable({ materials }: Footage): DataTexture {
  const texture = table(4 * materials.length);
  materials.forEach((material, row) => {
    const grain = Math.max(GRAINS.indexOf(material.grain), 0);
    const finish = [material.metallic, grain, material.inside ? 1 : 0, material.image];
    const shine = [...material.emission, material.blended ? 2 : material.cutoff];
    const { roughness, surfaceImage, normalImage, emissionImage } = material;
    const more = [roughness, surfaceImage, normalImage, emissionImage];
    const colour = [...material.colour, material.clear];
    numbers(texture).set([...colour, ...finish, ...shine, ...more], 16 * row);
  });
  return texture;
}
