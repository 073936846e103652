// The parts that need no browser: tests run them in Node.
export { Clock } from "./clock";
export { TEXELS, fillPoses } from "./poses";
export { breaks, countAlive, readRecording, unfold } from "./recording";
export { decode, inflate } from "./streams";
