// Opens a page that plays a recording in headless Chromium, as a user would, and prints what it shows as JSON.
//
//   node play_page.js PAGE [--size WxH] [--frames F,F] [--picture HASH=FILE.png]...
//
// It waits until the page plays by itself, steps to frames with the keyboard, and takes pictures of addresses
// (#frame=14&explode=0.5) once they are settled.
const { chromium } = require("playwright-core");
const { pathToFileURL } = require("url");

const FLAGS = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", ...(process.env.GL_FLAGS ?? "--use-angle=swiftshader --enable-unsafe-swiftshader --ignore-gpu-blocklist").split(" ")];

function options(list) {
  const found = { frames: [], pictures: [], size: [480, 270] };
  for (let i = 0; i < list.length; i += 2) {
    const value = list[i + 1];
    if (list[i] === "--size") found.size = value.split("x").map(Number);
    else if (list[i] === "--frames") found.frames = value.split(",").map(Number);
    else if (list[i] === "--picture") found.pictures.push([value.slice(0, value.lastIndexOf("=")), value.slice(value.lastIndexOf("=") + 1)]);
    else throw new Error(`unknown option ${list[i]}`);
  }
  return found;
}

const caption = (page) =>
  page.evaluate(() => ({
    shot: document.getElementById("shot").textContent,
    ...Object.fromEntries(["frame", "time", "bodies"].map((id) => [id, document.getElementById(id).textContent])),
  }));

const stateIs = (page, state, frame) =>
  page.waitForFunction(
    ([state, frame]) => document.documentElement.dataset.state === state && (frame === null || document.documentElement.dataset.frame === String(frame)),
    [state, frame ?? null],
    { timeout: 120000 },
  );

async function main([path, ...rest]) {
  const { frames, pictures, size } = options(rest);
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });
  const result = { errors: [], requests: [], played: [], steps: [] };
  try {
    const page = await browser.newPage({ viewport: { width: size[0], height: size[1] } });
    page.on("console", (message) => ["error", "warning"].includes(message.type()) && result.errors.push(message.text()));
    page.on("pageerror", (error) => result.errors.push(error.message));
    page.on("request", (request) => /^(file|data|blob):/.test(request.url()) || result.requests.push(request.url()));
    const address = pathToFileURL(path).href;

    // It plays by itself.
    await page.goto(address);
    const begun = () =>
      document.documentElement.dataset.state === "playing" || document.getElementById("message").textContent.includes("cannot be played");
    await page.waitForFunction(begun, null, { timeout: 60000 }).catch(() => {});
    if ((await page.evaluate(() => document.documentElement.dataset.state)) !== "playing") {
      throw new Error(`the page does not play: ${await page.locator("#message").textContent()} ${result.errors.join(" ")}`);
    }
    result.played.push(await caption(page));
    await page.waitForFunction(() => Number(document.documentElement.dataset.frame) >= 2, null, { timeout: 60000 });
    result.played.push(await caption(page));

    // Pause, go to the first frame, and step.
    await page.keyboard.press("Home");
    await stateIs(page, "settled", 0);
    result.first = await caption(page);
    result.controls = await page.locator("#controls").evaluate((controls) => controls.getBoundingClientRect());
    for (const frame of frames) {
      const input = page.locator("#timeline");
      await input.evaluate((slider, frame) => { slider.value = String(frame - 1); slider.dispatchEvent(new Event("input")); }, frame);
      await page.keyboard.press("ArrowRight");
      await stateIs(page, "settled", frame);
      result.steps.push(await caption(page));
    }

    // Pictures of addresses.
    for (const [hash, file] of pictures) {
      await page.goto("about:blank");
      await page.goto(`${address}#${hash}`);
      await stateIs(page, "settled");
      if (process.env.PATIENCE) await page.waitForTimeout(Number(process.env.PATIENCE));
      await page.screenshot({ path: file, timeout: 60000 });
    }
  } finally {
    await browser.close();
  }
  console.log(JSON.stringify(result));
}

main(process.argv.slice(2)).catch((error) => {
  console.error(String(error.message ?? error));
  process.exitCode = 1;
});
