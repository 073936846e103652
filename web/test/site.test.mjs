// The site: every link leads somewhere, and pages ask for nothing but what is beside them.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { dirname, extname, join, relative } from "node:path";
import { before, test } from "node:test";
import { fileURLToPath } from "node:url";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const CHROMIUM = process.env["CHROMIUM"] ?? "/usr/bin/chromium";
const WORK = here("../../out/site-test");
const SITE = join(WORK, "site");
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".jpg": "image/jpeg", ".wasm": "application/wasm" };
const skip = existsSync(CHROMIUM) ? false : "Chromium is not installed";

/** HTML by its path in the site, and all of its files. */
const pages = new Map();
const files = new Set();

before(async () => {
  // Simulations take too long for a test: a page with a name stands for each.
  const figures = join(WORK, "figures");
  await mkdir(figures, { recursive: true });
  const shots = Object.values(JSON.parse(await readFile(here("../site/figures.json"), "utf8"))).flatMap(Object.keys);
  for (const shot of shots) await writeFile(join(figures, `${shot}.html`), `<!doctype html><title>${shot}</title><p id="${shot}">`);
  execFileSync(process.execPath, [here("../site/build.mjs"), here("../dist/playground"), figures, SITE]);
  for (const name of await readdir(SITE, { recursive: true })) {
    files.add(name);
    if (name.endsWith(".html")) pages.set(name, await readFile(join(SITE, name), "utf8"));
  }
});

test("every link and picture is there", () => {
  assert.ok(pages.size > 40, `${pages.size} pages`);
  const lost = [];
  for (const [page, html] of pages) {
    for (const [, address] of html.matchAll(/<(?:a|img|script|link|iframe)\b[^>]*?\b(?:href|src)="([^"]*)"/g)) {
      if (/^(https?|mailto|data):/.test(address)) continue;
      const [path, anchor] = address.split("#");
      const target = path === "" ? page : relative(".", join(dirname(page), path));
      if (!files.has(target)) lost.push(`${page}: ${address}`);
      else if (anchor && !pages.get(target)?.includes(`id="${anchor}"`)) lost.push(`${page}: ${address}`);
    }
  }
  assert.deepEqual(lost, []);
});

test("nothing of a page is from elsewhere", () => {
  for (const [page, html] of pages)
    for (const [tag] of html.matchAll(/<(?:img|script|link|iframe|source)\b[^>]*>/g)) assert.ok(!/(?:href|src)="(?:https?:)?\/\//.test(tag), `${page}: ${tag}`);
});

test("each figure of the paper is played under its caption", () => {
  const gallery = pages.get(join("gallery", "index.html"));
  const captions = [...gallery.matchAll(/<strong>Figure (\d)\.<\/strong>[\s\S]*?<\/p>\n(<p class="players">.*)/g)];
  assert.deepEqual(captions.map(([, figure]) => figure).sort(), ["1", "2", "3", "4", "5", "6", "7", "8", "9"]);
  for (const [, figure, players] of captions) assert.match(players, /class="play"/, figure);
});

test("a visitor walks through the site", { skip, timeout: 60_000 }, async () => {
  const asked = [];
  const server = createServer(async (request, response) => {
    const path = new URL(request.url, "http://local").pathname;
    asked.push(path);
    const content = await readFile(join(SITE, path)).catch(() => null);
    if (content === null) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "application/octet-stream" }).end(content);
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const origin = `http://127.0.0.1:${server.address().port}/`;
  const { chromium } = createRequire(new URL("../../tests/tools/", import.meta.url))("playwright-core");
  const browser = await chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox", "--disable-background-networking"] });
  try {
    const page = await browser.newPage({ viewport: { width: 900, height: 700 } });
    const faults = [];
    page.on("pageerror", (error) => faults.push(error.message));
    page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
    page.on("request", (request) => assert.ok(/^data:/.test(request.url()) || request.url().startsWith(origin), request.url()));
    await page.goto(`${origin}index.html`);
    await page.screenshot({ path: join(WORK, "front.png") });
    await page.click("text=Gallery");
    await page.click("a.play[href='pillar.html']");
    await page.frameLocator("iframe").locator("#pillar").waitFor({ state: "attached" });
    await page.screenshot({ path: join(WORK, "gallery.png") });
    await page.goto(`${origin}docs/the_step.html`);
    await page.screenshot({ path: join(WORK, "docs.png") });
    assert.deepEqual(faults, []);
  } finally {
    await browser.close();
    server.close();
  }
  assert.ok(asked.includes("/site.css"));
});
