// The package's door for browsers and workers.
import engine, { type InitInput } from "./engine.js";

/**
 * Loads the engine; await it before anything else. Without an argument its module is looked for
 * beside this file; else it is an address, a response, bytes or a compiled module.
 */
export default async function init(source?: InitInput | Promise<InitInput>): Promise<void> {
  await engine({ module_or_path: source ?? new URL("./engine_bg.wasm", import.meta.url) });
}

export * from "./parts";
