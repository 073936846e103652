// What needs no browser: tests run it in Node.
export { Clock } from "./clock";
export { TEXELS, fillPoses } from "./poses";
export { breaks, countAlive, readRecording, unfold } from "./recording";
export { decode, inflate } from "./streams";
