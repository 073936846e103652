// Packs the package as for publishing, and uses the file in a project of its own: types by both ways
// in which compilers find them, then the engine.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFile, mkdir, mkdtemp, readFile, rm, symlink, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const folder = await mkdtemp(join(tmpdir(), "frangible-"));
const run = (command, ...given) => execFileSync(command, given, { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });

try {
  const [packed] = JSON.parse(execFileSync("npm", ["pack", "--json", "--pack-destination", folder], { cwd: here("."), encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] }));
  for (const { path, size } of packed.files) console.log(`${String(size).padStart(9)} ${path}`);
  console.log(`${packed.filename}: ${packed.entryCount} files, ${packed.size} bytes, unpacked ${packed.unpackedSize}`);
  const paths = packed.files.map(({ path }) => path);
  for (const path of ["package.json", "README.md", "LICENSE-MIT", "LICENSE-APACHE", "dist/engine_bg.wasm", "dist/index.d.ts"]) assert.ok(paths.includes(path), `${path} is missing`);
  assert.ok(!paths.some((path) => /\.(mjs|ts)$/.test(path) && !path.startsWith("dist/")), "sources are among them");

  // As npm lays it out.
  const modules = join(folder, "node_modules");
  await mkdir(join(modules, "@types"), { recursive: true });
  run("tar", "xzf", packed.filename);
  await symlink(join(folder, "package"), join(modules, "frangible"));
  for (const name of ["three", "@types/three", "@types/webxr", "@types/stats.js", "@tweenjs", "@dimforge", "fflate", "meshoptimizer"])
    await symlink(here(`../node_modules/${name}`), join(modules, name)).catch((error) => assert.equal(error.code, "EEXIST"));
  await copyFile(here("test/consumer.ts"), join(folder, "consumer.ts"));
  await writeFile(join(folder, "package.json"), '{ "type": "module" }');
  for (const [module, resolution] of [["NodeNext", "NodeNext"], ["ESNext", "bundler"]])
    run(process.execPath, here("../node_modules/typescript/bin/tsc"), "--noEmit", "--strict", "--preserveSymlinks", "--skipLibCheck", "--target", "ES2022", "--lib", "ES2022,DOM,DOM.Iterable,ESNext.Disposable", "--module", module, "--moduleResolution", resolution, "consumer.ts");
  await writeFile(join(folder, "use.mjs"), `import init, { World, shotScene } from "frangible";
await init();
const world = new World(shotScene("wall"));
for (let frame = 0; frame < 20; frame++) world.step();
if (world.ids().length < 20) throw new Error("the wall is whole");
console.log(world.stateHash());`);
  console.log(`types resolve in both ways; the wall after 20 frames: ${run(process.execPath, "use.mjs").trim()}`);
  console.log(`the engine as gzip: ${gzipSync(await readFile(here("dist/engine_bg.wasm"))).length} bytes`);
} finally {
  await rm(folder, { recursive: true });
}
