// The engine in Node: from web/engine, or from the folder that ENGINE names.
import { readFile } from "node:fs/promises";
import { init } from "../dist/playground.mjs";

const folder = new URL(`${process.env["ENGINE"] ?? "../engine"}/`, import.meta.url);

/** Load it once. */
export async function load() {
  await init({ module_or_path: await readFile(new URL("engine_bg.wasm", folder)) });
}
