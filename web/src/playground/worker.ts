// The worker: the engine beside the page, so that the page stays smooth.
import init from "../../engine/engine.js";
import type { Order, Told } from "./protocol";
import { Simulator } from "./simulator";

const tell = (told: Told): void => {
  postMessage(
    told,
    told.kind === "frame" ? { transfer: [told.state.ids.buffer, told.state.poses.buffer] } : {},
  );
};
const simulator = new Simulator(tell);
const ready = init({ module_or_path: new URL("../../engine/engine_bg.wasm", import.meta.url) });
const explain = (error: unknown): void => {
  const reason = error instanceof Error ? error.message : String(error);
  tell({ kind: "fault", sentence: `The engine cannot be loaded: ${reason}` });
};
addEventListener(
  "message",
  ({ data }: MessageEvent<Order>) => void ready.then(() => simulator.obey(data), explain),
);
