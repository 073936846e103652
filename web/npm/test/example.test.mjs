// The starter, built and played in headless Chromium: a press breaks the wall.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { copyFile, mkdir, readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { extname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { build } from "vite";

const CHROMIUM = process.env["CHROMIUM"] ?? "/usr/bin/chromium";
const FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--disable-background-networking"];
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };
const here = (path) => fileURLToPath(new URL(path, import.meta.url));
/** Inside the package, whose name its files may use. */
const COPY = here("../out/throw");

async function built() {
  await mkdir(COPY, { recursive: true });
  for (const file of ["index.html", "main.js"]) await copyFile(here(`../../../examples/throw/${file}`), join(COPY, file));
  await build({ root: COPY, configFile: false, base: "./", logLevel: "error", build: { target: "es2022", minify: false } });
  return join(COPY, "dist");
}

test("the starter's wall breaks under a press, in few draw calls", { skip: existsSync(CHROMIUM) ? false : "Chromium is not installed", timeout: 200_000 }, async () => {
  const folder = await built();
  const server = createServer(async ({ url }, response) => {
    const path = url === "/" ? "/index.html" : url;
    response.setHeader("content-type", TYPES[extname(path)] ?? "text/plain").end(await readFile(join(folder, path)));
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const require = createRequire(new URL("../../../tests/tools/", import.meta.url));
  const browser = await require("playwright-core").chromium.launch({ executablePath: CHROMIUM, args: FLAGS });
  try {
    const page = await browser.newPage({ viewport: { width: 480, height: 300 } });
    const faults = [];
    page.on("pageerror", ({ message }) => faults.push(message));
    page.on("console", (message) => ["error", "warning"].includes(message.type()) && faults.push(message.text()));
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    const bodies = (least) => page.waitForFunction((number) => Number(document.documentElement.dataset.bodies) >= number, least, { timeout: 90_000 });
    await bodies(2);
    await page.mouse.click(232, 142);
    await bodies(15);
    await page.waitForFunction(() => Number(document.documentElement.dataset.calls) > 4);
    // Ground, ball, outside and inside of the wall; all but the ground in the shadow map too.
    const { calls } = await page.evaluate(() => ({ ...document.documentElement.dataset }));
    assert.ok(Number(calls) <= 7, `${calls} draw calls`);
    // Of a driver that stalls while a picture is taken.
    assert.deepEqual(faults.filter((fault) => !fault.includes("GPU stall")), []);
    await page.screenshot({ path: join(COPY, "broken.png") });
  } finally {
    await browser.close();
    server.close();
  }
});
