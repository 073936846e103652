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
const [part = id]: Float64Array = world.cut(id, Float64Array.of(0, 0, 0), Float64Array.of(0, 1, 0));
world.hold(part, Float64Array.of(0, 0, 0), Float64Array.of(0, 2, 0), 500);
const work: number = world.applyImpulse(part, Float64Array.of(0, 0, 1), Float64Array.of(0, 0, 0));
const free: boolean = world.letGo(part);
world.burst(part, Float64Array.of(0, 0, 0), 2);
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

export { breaks, empty, free, work, id, pane };
