// A wall that breaks: press to throw a ball at what is under the pointer.
import init, { World } from "frangible";
import engine from "frangible/engine_bg.wasm?url";
import { FrangibleMesh } from "frangible/three";
import * as THREE from "three";

await init(engine);

const world = new World({
  frames_per_second: 60,
  sleep: true,
  bodies: [
    { name: "ground", shape: { kind: "half-space" }, motion: "static" },
    {
      name: "wall",
      shape: { kind: "box", size: [3, 2, 0.25] },
      position: [0, 1, 0],
      look: "concrete",
      breaking: { strength: "concrete", pattern: { kind: "voronoi", cells: 60 } },
    },
  ],
});

const canvas = document.getElementById("view");
const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
renderer.shadowMap.enabled = true;
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xbfd0dc);
scene.fog = new THREE.Fog(0xbfd0dc, 10, 50);
const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 100);
camera.position.set(2.5, 2, 6);
camera.lookAt(0, 0.9, 0);

const sun = new THREE.DirectionalLight(0xfff2e0, 3);
sun.position.set(4, 8, 5);
sun.castShadow = true;
sun.shadow.mapSize.set(2048, 2048);
Object.assign(sun.shadow.camera, { left: -6, right: 6, top: 6, bottom: -6 });
scene.add(sun, new THREE.HemisphereLight(0xdfefff, 0x807060, 1.5));

const view = new FrangibleMesh(world);
scene.add(view);

const raycaster = new THREE.Raycaster();
canvas.addEventListener("pointerdown", ({ clientX, clientY }) => {
  const pointer = new THREE.Vector2((2 * clientX) / innerWidth - 1, 1 - (2 * clientY) / innerHeight);
  raycaster.setFromCamera(pointer, camera);
  const { origin, direction } = raycaster.ray;
  world.addBody({
    shape: { kind: "sphere", radius: 0.15 },
    position: origin.clone().addScaledVector(direction, 1).toArray(),
    linear_velocity: direction.clone().multiplyScalar(25).toArray(),
    density: 7850,
    look: "metal",
  });
  view.update();
});

function resize() {
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.setSize(innerWidth, innerHeight, false);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}
addEventListener("resize", resize);
resize();

// The world keeps its own frames, whatever the screen's are; it slows down rather than fall behind.
let lag = 0;
let last = performance.now();
renderer.setAnimationLoop((now) => {
  lag = Math.min(lag + (now - last) / 1000, 3 * world.dt);
  last = now;
  for (; lag >= world.dt; lag -= world.dt) {
    world.step();
    view.update();
  }
  view.interpolate(lag / world.dt);
  renderer.render(scene, camera);
  // For who looks after it.
  Object.assign(document.documentElement.dataset, { bodies: world.ids().length, calls: renderer.info.render.calls });
});
