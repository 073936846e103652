// The parts that need no browser: tests run them in Node.
export { Clock } from "./clock";
export { TEXELS, fillPoses } from "./poses";
export { breaks, countAlive } from "./recording";
export { unfold } from "./meshes";
export { CAUSES } from "./books";
export { coarser } from "./coarse";
export { Colouring } from "./colouring";
export { Motion, generation } from "./motion";
export { Picker } from "./picker";
export { quantity } from "./units";
export { Reel, readRecording } from "./reel";
export { blobs, decode, inflate, unpacked } from "./streams";
