// Uses the player in headless Chromium, with the keyboard alone but for one press, and prints what it shows as JSON.
//
//   node use_player.js ADDRESS LIVE NOTEBOOK PICTURE
//
// ADDRESS is of a recording that `frangible view` serves, LIVE of a run, NOTEBOOK a file with a frame in it.
const { chromium } = require("playwright-core");
const { pathToFileURL } = require("url");

const FLAGS = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
const WAIT = { timeout: Number(process.env.PATIENCE ?? 120000) };

const data = (page) => page.evaluate(() => ({ ...document.documentElement.dataset }));
// The picture of what was just asked for has been drawn.
const drawn = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
const text = (page, id) => page.locator(`#${id}`).textContent();
const dataIs = (page, name, value) =>
  page.waitForFunction(([name, value]) => document.documentElement.dataset[name] === String(value), [name, value], WAIT);
const facts = (page) =>
  page.evaluate(() => ({
    name: document.getElementById("piece-name").textContent,
    ...Object.fromEntries([...document.querySelectorAll("#piece-facts dt")].map((term) => [term.textContent, term.nextSibling.textContent])),
  }));

async function opened(browser, address, result) {
  const page = await browser.newPage({ viewport: { width: 480, height: 440 } });
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && result.errors.push(message.text()));
  page.on("pageerror", (error) => result.errors.push(error.message));
  page.on("request", (request) => result.requests.push(request.url()));
  // Little is drawn: what is drawn is looked at elsewhere.
  await page.goto(`${address}#quality=4`);
  // It plays by itself.
  await page.waitForFunction(() => Number(document.documentElement.dataset.frame) > 0, null, WAIT);
  return page;
}

async function useRecording(page, result, picture) {
  // Stop, go back, and step to a frame after the break.
  await page.keyboard.press("Home");
  await dataIs(page, "frame", 0);
  await page.keyboard.press("b");
  await page.waitForFunction(() => Number(document.documentElement.dataset.frame) > 0, null, WAIT);
  result.broken = Number((await data(page)).frame);
  await page.keyboard.press("ArrowRight");
  await dataIs(page, "frame", result.broken + 1);

  // Pick a body, go on to others, and to what one broke off from.
  await page.keyboard.press("p");
  await page.waitForFunction(() => Number(document.documentElement.dataset.picked) >= 0, null, WAIT);
  for (let tries = 0; tries < 200; tries++) {
    result.picked = { row: Number((await data(page)).picked), ...(await facts(page)) };
    if (result.picked["broke off"] !== undefined) break;
    await page.keyboard.press("p");
  }
  await page.waitForFunction((name) => document.getElementById("spoken").textContent.includes(`Picked: ${name},`), result.picked.name, WAIT);
  result.spoken = await text(page, "spoken");
  await page.keyboard.press("f");
  await page.keyboard.press("g");
  for (let i = 0; i < 3; i++) await page.keyboard.press("c");
  await page.waitForFunction(() => !document.getElementById("legend").hidden, null, WAIT);
  result.colour = await page.locator("#colour").inputValue();
  result.legend = await text(page, "legend");
  result.energy = await text(page, "graph-words");
  await dataIs(page, "state", "settled");
  await page.screenshot({ path: picture, timeout: 240000 });
  result.calls = Number((await data(page)).calls);
  await page.keyboard.press("o");
  result.parent = await facts(page);
  await page.keyboard.press("Escape");
  await dataIs(page, "picked", -1);

  // Everything has the focus in turn, and shows it.
  const focused = new Set();
  for (let i = 0; i < 20; i++) {
    await page.keyboard.press("Tab");
    focused.add(await page.evaluate(() => document.activeElement.id));
  }
  result.focused = [...focused];
  await page.keyboard.press("?");
  result.keys = await page.locator("#keys li").allTextContents();
  await page.keyboard.press("Escape");

  // A press picks what is under it. What is looked at lies in the middle; where something hides it, that is picked, and looked at.
  await page.evaluate(() => document.activeElement.blur());
  const middle = (await page.evaluate(() => document.getElementById("controls").getBoundingClientRect().top)) / 2;
  result.pressed = [];
  for (const steps of [1, 20]) {
    for (let i = 0; i < steps; i++) await page.keyboard.press("p");
    await page.waitForFunction(() => Number(document.documentElement.dataset.picked) >= 0, null, WAIT);
    let looked, pressed = Number((await data(page)).picked);
    for (let tries = 0; tries < 8 && pressed !== looked; tries++) {
      looked = pressed;
      await page.keyboard.press("f");
      await drawn(page);
      await page.mouse.click(240, middle);
      await drawn(page);
      pressed = Number((await data(page)).picked);
    }
    result.pressed.push({ looked, pressed });
    await page.keyboard.press("Escape");
    await dataIs(page, "picked", -1);
  }
}

async function main([recorded, live, notebook, picture]) {
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });
  const result = { errors: [], requests: [] };
  try {
    const page = await opened(browser, recorded, result);
    await useRecording(page, result, picture);
    await page.close();

    // A run comes frame by frame, and ends.
    const running = await opened(browser, live, result);
    await running.waitForFunction(() => document.getElementById("live").hidden, null, WAIT);
    await running.keyboard.press("g");
    await running.keyboard.press("End");
    await running.waitForFunction(() => document.documentElement.dataset.state !== "playing", null, WAIT);
    result.live = { frame: await text(running, "frame"), bodies: await text(running, "bodies"), energy: await text(running, "graph-words") };
    await running.close();

    // In a notebook it plays in a frame of its own.
    const book = await browser.newPage({ viewport: { width: 480, height: 560 } });
    book.on("pageerror", (error) => result.errors.push(error.message));
    await book.goto(pathToFileURL(notebook).href);
    const frame = await (await book.locator("iframe").elementHandle()).contentFrame();
    await frame.waitForFunction(() => ["playing", "settled", "paused"].includes(document.documentElement.dataset.state), null, WAIT);
    result.notebook = await frame.locator("#shot").textContent();
  } finally {
    await browser.close();
  }
  console.log(JSON.stringify(result));
}

main(process.argv.slice(2)).catch((error) => {
  console.error(String(error.stack ?? error));
  process.exitCode = 1;
});
