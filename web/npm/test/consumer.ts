// What a user writes: the compiler checks it against the package's types.
import init, { type BodyDesc, type Fracture, MATERIALS, type SceneDesc, World, WorldReader, shotScene } from "frangible";
import { FrangibleMesh } from "frangible/three";
import { MeshStandardMaterial, Scene } from "three";

await init();
const wall: BodyDesc = {
  shape: { kind: "box", size: [2, 1.5, 0.2] },
  position: [0, 0.75, 0],
  breaking: { strength: "concrete", pattern: { kind: "voronoi", cells: 40 } },
};
const scene: SceneDesc = { frames_per_second: 60, bodies: [{ shape: { kind: "half-space" }, motion: "static" }, wall] };
const world = new World(scene);
const id: number = world.addBody({ shape: { kind: "sphere", radius: 0.2 }, linear_velocity: [0, 0, -20] });
const breaks: Fracture[] = world.step().fractures;
const view = new FrangibleMesh(world, { materials: () => ({ outside: new MeshStandardMaterial(), inside: new MeshStandardMaterial() }) });
new Scene().add(view);
view.take(new WorldReader().read(world));
new World(shotScene("wall")).free();

const pane: BodyDesc = { ...MATERIALS.glass, shape: { kind: "box", size: [1, 1, 0.01] } };
// @ts-expect-error: no such material
void MATERIALS.cheese;
// @ts-expect-error: bodies have shapes
const empty: BodyDesc = {};
// @ts-expect-error: a sphere has a radius
world.addBody({ shape: { kind: "sphere", size: [1, 1, 1] } });
// @ts-expect-error: no such motion
world.addBody({ shape: { kind: "sphere", radius: 1 }, motion: "dynamical" });

export { breaks, empty, id, pane };
