// The package's door for Node, which reads the engine from the disk.
import { readFile } from "node:fs/promises";
import engine, { type InitInput } from "./engine.js";

/** As that of browsers. */
export default async function init(source?: InitInput | Promise<InitInput>): Promise<void> {
  await engine({
    module_or_path: source ?? readFile(new URL("./engine_bg.wasm", import.meta.url)),
  });
}

export * from "./parts";
