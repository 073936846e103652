// The page to break things in, in headless Chromium, as a visitor has it.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { mkdir, readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { extname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { encode } from "../dist/playground.mjs";

const CHROMIUM = process.env["CHROMIUM"] ?? "/usr/bin/chromium";
const FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--disable-background-networking"];
const PAGE = fileURLToPath(new URL("../dist/playground", import.meta.url));
/** Pictures that were taken, to be looked at. */
const PICTURES = fileURLToPath(new URL("../../out/playground", import.meta.url));
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };
const skip = existsSync(CHROMIUM) ? false : "Chromium is not installed";

let browser;
let server;
let address;
/** What the pages asked for. */
const asked = [];

before(async () => {
  if (skip) return;
  server = createServer(async (request, response) => {
    const path = new URL(request.url, "http://local").pathname;
    asked.push(path);
    try {
      const content = await readFile(join(PAGE, path));
      response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "text/plain" }).end(content);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  address = `http://127.0.0.1:${server.address().port}/playground.html`;
  const require = createRequire(new URL("../../tests/tools/", import.meta.url));
  browser = await require("playwright-core").chromium.launch({ executablePath: CHROMIUM, args: FLAGS });
  await mkdir(PICTURES, { recursive: true });
});

after(async () => {
  await browser?.close();
  server?.close();
});

/** A page of its own, whose faults fail the test. */
async function open(hash = "", context = null) {
  const page = context === null ? await browser.newPage({ viewport: { width: 480, height: 300 } }) : await context.newPage();
  page.faults = [];
  page.on("pageerror", (error) => page.faults.push(error.message));
  page.on("console", (message) => message.type() === "error" && page.faults.push(message.text()));
  page.on("request", (request) => {
    if (!/^(data|blob):/.test(request.url())) assert.ok(request.url().startsWith(address.replace(/\/[^/]*$/, "/")), request.url());
  });
  await page.goto(address + hash);
  return page;
}

/** Waits until what the page says of itself fulfils a condition, and returns it. */
async function until(page, condition) {
  for (let tries = 0; tries < 2400; tries++) {
    const found = await data(page);
    if (condition(found)) return found;
    await page.waitForTimeout(50);
  }
  throw new Error(`${condition}: ${JSON.stringify(await data(page))}, ${page.faults}`);
}

/** The pointer goes from one place to another, and stays there for some pictures. */
async function stroke(page, from, to, { rest = 0 } = {}) {
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move(...to, { steps: 6 });
  for (let wait = 0; wait < rest; wait++) await page.waitForTimeout(50);
  await page.mouse.up();
}

const data = (page) => page.evaluate(() => ({ ...document.documentElement.dataset }));

test("a visitor sees a wall that breaks, throws a ball, undoes it, and shares the world", { skip, timeout: 400_000 }, async () => {
  const page = await open();
  await until(page, ({ bodies }) => Number(bodies) > 20);
  await page.screenshot({ path: join(PICTURES, "wall.png") });

  // A press throws a ball.
  const count = (found) => Number(found.bodies);
  await page.click("#play");
  const before = await until(page, ({ busy }) => busy === "0");
  await page.mouse.click(240, 130);
  await until(page, ({ bodies }) => Number(bodies) > count(before));
  await page.keyboard.press("u");
  await until(page, ({ bodies }) => Number(bodies) === count(before));

  // What is shared is the same elsewhere.
  await page.click("#play");
  await until(page, ({ busy }) => busy === "0");
  await page.click("#use");
  await until(page, ({ bodies }) => Number(bodies) > count(before));

  // A line over the wall cuts what it crosses, and a press breaks a piece's neighbour.
  await page.click("#slice");
  await stroke(page, [120, 130], [360, 170]);
  await until(page, ({ cuts }) => Number(cuts) > 0);
  // A piece follows the pointer.
  await page.click("#drag");
  // Where pieces lie by then depends on how fast pictures are.
  for (const place of [[240, 150], [240, 185], [210, 200], [270, 200], [180, 210], [300, 210], [240, 215], [240, 170]]) {
    await stroke(page, place, [240, 60], { rest: 12 });
    if (Number((await data(page)).drags) > 0) break;
  }
  await until(page, ({ drags }) => Number(drags) > 0);
  await page.screenshot({ path: join(PICTURES, "sliced.png") });
  await page.click("#play");
  await until(page, ({ busy }) => busy === "0");
  await page.click("#share");
  const shared = await until(page, ({ shared }) => shared !== undefined);
  await page.focus("#timeline");
  await page.keyboard.press("End");
  const here = await until(page, ({ frame }) => frame === shared.shared);
  const other = await open(new URL(page.url()).hash);
  const there = await until(other, ({ frame }) => frame === shared.shared);
  assert.equal(there.hash, here.hash);
  assert.deepEqual([...page.faults, ...other.faults], []);
  await page.close();
  await other.close();
});

test("a visitor's first picture is a cheap one, and the engine does not wait for it", { skip, timeout: 400_000 }, async () => {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 } });
  // A page whose pictures are drawn when the test says so, and what its worker tells.
  await context.addInitScript(() => {
    const later = [];
    window.requestAnimationFrame = (draw) => later.push(draw);
    window.drawn = () => later.splice(0).forEach((draw) => draw(performance.now()));
    window.told = [];
    window.Worker = class extends Worker {
      constructor(...all) {
        super(...all);
        this.addEventListener("message", ({ data }) => window.told.push(data));
      }
    };
  });
  const page = await open("", context);
  const frames = () => page.evaluate(() => window.told.filter(({ kind }) => kind === "frame").length);
  await page.waitForFunction(() => window.told.filter(({ kind }) => kind === "done").length === 2, null, { polling: 50, timeout: 120_000 });
  assert.ok((await frames()) > 1, "nothing is simulated before the first picture");
  assert.equal((await data(page)).frame, undefined);
  await page.evaluate(() => window.drawn());
  const first = await data(page);
  // The lamp's map, surfaces, ground, backdrop, film and its copy: no ambient occlusion.
  assert.deepEqual([first.level, first.calls], ["4", "6"]);
  assert.deepEqual(page.faults, []);
  await context.close();
});

test("fingers throw, cut and burst", { skip, timeout: 400_000 }, async () => {
  const context = await browser.newContext({ viewport: { width: 400, height: 640 }, hasTouch: true, isMobile: true });
  const page = await open("", context);
  await until(page, ({ frames }) => Number(frames) > 0);
  const actions = async () => Number((await data(page)).actions);
  const first = await until(page, ({ busy, actions }) => busy === "0" && actions === "1");
  await page.touchscreen.tap(200, 300);
  await until(page, ({ actions }) => actions === "2");
  await page.tap("#slice");
  const session = await context.newCDPSession(page);
  const touch = (type, x, y) => session.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x, y }] });
  // How far the wall has fallen by then depends on how fast pictures are.
  for (const height of [300, 320, 340, 360]) {
    await touch("touchStart", 60, height - 10);
    for (let x = 80; x <= 340; x += 20) await touch("touchMove", x, height);
    await touch("touchEnd");
    await page.waitForTimeout(1500);
    if (Number((await data(page)).cuts) > 0) break;
  }
  await until(page, ({ cuts }) => Number(cuts) > 0);
  const camera = (await data(page)).eye;
  assert.equal(camera, first.eye, "a cut does not turn the view");
  assert.ok((await actions()) >= 3);
  await page.screenshot({ path: join(PICTURES, "touch.png") });
  assert.deepEqual(page.faults, []);
  await context.close();
});

test("a visitor takes pieces and a film home", { skip, timeout: 400_000 }, async () => {
  const page = await open();
  await until(page, ({ bodies }) => Number(bodies) > 20);
  const [file] = await Promise.all([page.waitForEvent("download", { timeout: 120_000 }), page.click("#gltf")]);
  const content = await readFile(await file.path());
  assert.equal(content.toString("latin1", 0, 4), "glTF");
  const length = content.readUInt32LE(12);
  const { nodes, meshes } = JSON.parse(content.toString("utf8", 20, 20 + length));
  assert.ok(meshes.length > 20 && nodes.length > 20, `${meshes.length} meshes`);
  // Slow, so that a machine that draws little has something to encode. Small windows hide the menu.
  await page.evaluate(() => {
    const speed = document.getElementById("speed");
    speed.value = "0.25";
    speed.dispatchEvent(new Event("change"));
  });
  const [movie] = await Promise.all([page.waitForEvent("download", { timeout: 120_000 }), page.click("#film")]);
  assert.match(movie.suggestedFilename(), /\.(webm|mp4)$/);
  const { length: bytes } = await readFile(await movie.path());
  assert.ok(bytes > 1000, `a film of ${bytes} bytes`);
  assert.deepEqual(page.faults, []);
  await page.close();
});

for (const file of ["story.json", "deeds.json"])
  test(`${file}: a link shows the state that the native engine ends in`, { skip, timeout: 400_000 }, async () => {
    const { frames, hash, ...story } = JSON.parse(await readFile(new URL(file, import.meta.url), "utf8"));
    const page = await open(`#frames=${frames}&story=${await encode(story)}`);
    const found = await until(page, ({ frame }) => frame === String(frames));
    assert.equal(found.hash, hash);
    await page.screenshot({ path: join(PICTURES, file.replace("json", "png")) });
    // Begun again it is the world of the link, also by a key while a button has the focus.
    await page.focus("#share");
    await page.keyboard.press("r");
    const start = await until(page, ({ frame, bodies }) => Number(frame) < frames && Number(bodies) < Number(found.bodies));
    assert.ok(Number(start.bodies) >= JSON.parse(story.scene).bodies.length);
    assert.deepEqual(page.faults, []);
    await page.close();
  });

test("a mesh that is dropped breaks", { skip, timeout: 400_000 }, async () => {
  const page = await open();
  await until(page, ({ frames }) => Number(frames) > 0);
  // A cube with a notch: eight corners of a box, one of them pushed in.
  const cube = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 1.2 1.2 1.2\nv 0 2 2\n" +
    "f 4 3 2 1\nf 5 6 7\nf 5 7 8\nf 1 2 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5 8\n";
  await page.setInputFiles("#file", { name: "notch.obj", mimeType: "text/plain", buffer: Buffer.from(cube) });
  await until(page, ({ bodies }) => bodies === "3");
  const found = await until(page, ({ bodies }) => Number(bodies) > 10);
  assert.ok(Number(found.bodies) > 10);
  await page.screenshot({ path: join(PICTURES, "notch.png") });
  // A glTF file with its buffer in itself: a tetrahedron.
  const corners = Buffer.from(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]).buffer);
  const sides = Buffer.from(new Uint16Array([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]).buffer);
  const uri = `data:application/octet-stream;base64,${Buffer.concat([corners, sides]).toString("base64")}`;
  const gltf = {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 4, type: "VEC3", min: [0, 0, 0], max: [1, 1, 1] },
      { bufferView: 1, componentType: 5123, count: 12, type: "SCALAR" },
    ],
    bufferViews: [{ buffer: 0, byteLength: 48 }, { buffer: 0, byteOffset: 48, byteLength: 24 }],
    buffers: [{ uri, byteLength: 72 }],
  };
  await page.setInputFiles("#file", { name: "embedded.gltf", mimeType: "model/gltf+json", buffer: Buffer.from(JSON.stringify(gltf)) });
  await until(page, ({ bodies }) => bodies === "3");
  await page.setInputFiles("#file", { name: "empty.obj", mimeType: "text/plain", buffer: Buffer.from("v 0 0 0\n") });
  await page.waitForFunction(() => document.getElementById("message").textContent === "empty.obj: holds no triangles, must be a mesh");
  assert.deepEqual(page.faults, []);
  await page.close();
});

test("nothing is asked for but the files of the page", { skip }, () => {
  const kinds = asked.map((path) => extname(path));
  assert.deepEqual([...new Set(kinds)].sort(), [".css", ".html", ".js", ".wasm"]);
});
