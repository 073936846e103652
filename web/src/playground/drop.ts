// Meshes that somebody drops: OBJ, STL, PLY and glTF, as triangles.
import { BufferGeometry, Matrix4, Mesh, type Object3D, Vector3 } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { PLYLoader } from "three/examples/jsm/loaders/PLYLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { mergeVertices } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { Dropped } from "./recipe";

/** Larger ones take the engine minutes [triangles]. */
const MOST = 200_000;

/** Throws a sentence for what is no mesh. */
export async function readMesh(name: string, content: ArrayBuffer): Promise<Dropped> {
  const ending = name.slice(name.lastIndexOf(".") + 1).toLowerCase();
  const text = (): string => new TextDecoder().decode(content);
  const geometries = await readers[ending]?.(content, text);
  if (geometries === undefined)
    throw new Error(`must end with .${Object.keys(readers).join(", .")}`);
  const dropped: Dropped = {
    name: name.slice(0, name.lastIndexOf(".")),
    positions: [],
    triangles: [],
  };
  for (const geometry of geometries) append(dropped, geometry);
  if (dropped.triangles.length === 0) throw new Error("holds no triangles, must be a mesh");
  if (dropped.triangles.length > MOST)
    throw new Error(`has ${dropped.triangles.length} triangles, must have at most ${MOST}`);
  return dropped;
}

const readers: Record<
  string,
  (content: ArrayBuffer, text: () => string) => BufferGeometry[] | Promise<BufferGeometry[]>
> = {
  obj: (_, text) => geometriesOf(new OBJLoader().parse(text())),
  stl: (content) => [new STLLoader().parse(content)],
  ply: (content) => [new PLYLoader().parse(content)],
  glb: (content) => gltf(content),
  gltf: (content) => gltf(content),
};

async function gltf(content: ArrayBuffer): Promise<BufferGeometry[]> {
  return geometriesOf((await new GLTFLoader().parseAsync(content, "")).scene);
}

/** Geometries of all meshes below an object, in its frame. */
function geometriesOf(root: Object3D): BufferGeometry[] {
  const found: BufferGeometry[] = [];
  root.updateMatrixWorld(true);
  root.traverse((object) => {
    if (object instanceof Mesh)
      found.push(
        (object.geometry as BufferGeometry).clone().applyMatrix4(object.matrixWorld as Matrix4),
      );
  });
  return found;
}

function append(dropped: Dropped, geometry: BufferGeometry): void {
  // Corners of the same place are one: the engine needs to know what is closed.
  for (const name of Object.keys(geometry.attributes))
    if (name !== "position") geometry.deleteAttribute(name);
  const merged = mergeVertices(geometry);
  const position = merged.getAttribute("position");
  const first = dropped.positions.length;
  for (let i = 0; i < position.count; i++)
    dropped.positions.push(new Vector3().fromBufferAttribute(position, i).toArray());
  const index = merged.getIndex()!;
  for (let i = 0; i + 2 < index.count; i += 3)
    dropped.triangles.push([0, 1, 2].map((corner) => first + index.getX(i + corner)));
}
