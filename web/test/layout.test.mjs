// Where panels and controls of the playground are, at windows of many sizes.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { mkdir, readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { extname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const CHROMIUM = process.env["CHROMIUM"] ?? "/usr/bin/chromium";
const PAGE = fileURLToPath(new URL("../dist/playground", import.meta.url));
const PICTURES = fileURLToPath(new URL("../../out/playground", import.meta.url));
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };
const PANELS = ["#caption", "#recipe", "#controls"];
const skip = existsSync(CHROMIUM) ? false : "Chromium is not installed";

test("panels and controls lie apart and in the window, and fingers find them", { skip, timeout: 400_000 }, async () => {
  const { launch, faults, atEachSize, drawLittle } = createRequire(new URL("../../tests/tools/", import.meta.url))("./layout.js");
  const server = createServer(async (request, response) => {
    const path = new URL(request.url, "http://local").pathname;
    const content = await readFile(join(PAGE, path)).catch(() => null);
    if (content === null) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "text/plain" }).end(content);
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  await mkdir(PICTURES, { recursive: true });
  const browser = await launch();
  const open = async (context) => {
    const page = await context.newPage();
    await page.goto(`http://127.0.0.1:${server.address().port}/playground.html`);
    // Pictures to look at need a while.
    if (!process.env["PICTURES"]) await drawLittle(page);
    await page.waitForFunction(() => Number(document.documentElement.dataset.bodies) > 20, null, { timeout: 200_000, polling: 100 });
    return page;
  };
  const places = (page) => page.evaluate(() => [...document.querySelectorAll("#controls button")].map((button) => button.getBoundingClientRect().toJSON()));
  try {
    const found = [];
    await atEachSize(browser, open, async (page, size, finger) => {
      // A word more or less on a button moves no other one.
      await page.waitForFunction(() => document.getElementById("play").textContent === "Pause", null, { polling: 100 });
      const before = await places(page);
      await page.click("#play");
      await page.waitForFunction(() => document.getElementById("play").textContent === "Play", null, { polling: 100 });
      assert.deepEqual(await places(page), before, size);
      for (const open of [false, true]) {
        await page.evaluate((open) => (document.getElementById("recipe").open = open), open);
        await page.waitForFunction((open) => document.body.classList.contains("chooses") === open, open, { polling: 100 });
        for (const fault of await faults(page, PANELS, finger)) found.push(`${size}, menu ${open}: ${fault}`);
        if (process.env["PICTURES"]) await page.screenshot({ path: join(PICTURES, `layout_${size}${open ? "_menu" : ""}.png`), timeout: 120_000 });
      }
      await page.click("#play");
    });
    assert.deepEqual(found, []);
  } finally {
    await browser.close();
    server.close();
  }
});
