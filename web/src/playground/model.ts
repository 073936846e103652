// The parts that need no browser: tests run them in Node.
export { default as init, World, shotScene } from "../../engine/engine.js";
export { LiveFootage } from "./live";
export { shaded } from "../../npm/src/normals";
export { MATERIALS, PATTERNS, SHAPES, SHOTS, sceneOf } from "./recipe";
export { crossed, pick } from "./pick";
export { scene } from "./pieces";
export { decode, encode } from "./share";
export { Simulator, ball } from "./simulator";
