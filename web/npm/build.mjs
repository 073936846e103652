// Builds dist/: the package's scripts and types, the engine, the types of scenes, and the licences.
import { execFileSync } from "node:child_process";
import { copyFile, mkdir, readFile, rm, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { compile } from "json-schema-to-typescript";
import { rolldown } from "rolldown";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const ROOT = "../../";
const SCHEMA = `${ROOT}python/frangible/scene.schema.json`;

await rm(here("dist"), { recursive: true, force: true });
await mkdir(here("dist"));
for (const file of ["engine.js", "engine.d.ts", "engine_bg.wasm"]) await copyFile(here(`../engine/${file}`), here(`dist/${file}`));
for (const file of ["LICENSE-MIT", "LICENSE-APACHE"]) await copyFile(here(ROOT + file), here(file));

const schema = JSON.parse(await readFile(here(SCHEMA), "utf8"));
withoutPython(schema);
await writeFile(here("dist/scene.d.ts"), await compile(plain(schema), "SceneDesc", {
  bannerComment: "// Scenes, as the engine's schema describes them.", additionalProperties: false, format: false,
}));
execFileSync(process.execPath, [here("../node_modules/typescript/bin/tsc"), "-p", here(".")], { stdio: "inherit" });
// Types of a package name files with their endings.
for (const file of ["index", "node", "parts", "descriptions", "three", "batch", "looks", "materials", "normals", "reader"]) {
  const path = here(`dist/${file}.d.ts`);
  await writeFile(path, (await readFile(path, "utf8")).replace(/(from |import )"(\.\/\w+)"/g, '$1"$2.js"'));
}

const bundle = await rolldown({
  input: { index: here("src/index.ts"), node: here("src/node.ts"), three: here("src/three.ts") },
  external: ["three", "./engine.js", /^node:/],
  platform: "neutral",
});
await bundle.write({ dir: here("dist"), format: "esm", chunkFileNames: "[name].js" });
await bundle.close();

/** A schema whose references keep their names: words beside a reference become those of what holds it. */
function plain(part) {
  if (Array.isArray(part)) return part.map(plain);
  if (part === null || typeof part !== "object") return part;
  const { $ref, default: _, ...rest } = part;
  const found = Object.fromEntries(Object.entries(rest).map(([key, value]) => [key, plain(value)]));
  if ($ref === undefined) return found;
  return Object.keys(found).length > 0 ? { ...found, allOf: [{ $ref }] } : { $ref };
}

/** Takes out what only the Python package understands: materials by name, and looks of one's own. */
function withoutPython({ properties, $defs }) {
  delete properties.materials;
  delete $defs.BodyDesc.properties.material;
  const { look } = $defs.BodyDesc.properties;
  look.anyOf = look.anyOf.filter(({ $ref }) => $ref !== "#/$defs/OwnLook");
  for (const name of ["Material", "OwnLook", "Surface"]) delete $defs[name];
}
