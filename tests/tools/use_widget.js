// Uses the widget of a notebook in headless Chromium, without a notebook: a page has a model that hands out chunks and
// loses one. Prints what it shows as JSON.
//
//   node use_widget.js PAGE
const { pathToFileURL } = require("url");
const { launch } = require("./layout.js");
const WAIT = { timeout: 120000, polling: 100 };

async function main([path]) {
  const browser = await launch();
  const result = { errors: [] };
  try {
    const page = await browser.newPage({ viewport: { width: 480, height: 400 } });
    page.on("pageerror", (error) => result.errors.push(error.message));
    page.on("console", (message) => message.type() === "error" && result.errors.push(message.text()));
    await page.goto(pathToFileURL(path).href);
    const frame = await (await page.waitForSelector("iframe")).contentFrame();
    const shown = (text) => frame.waitForFunction((text) => document.getElementById("frame").textContent.endsWith(text), text, WAIT);
    await frame.waitForFunction(() => document.documentElement.dataset.frame !== undefined, null, WAIT);
    await page.evaluate(() => window.lose());
    await shown(await page.evaluate(() => window.last));
    result.asked = await page.evaluate(() => window.asked);
    // A pick of the model's, then one of the reader's.
    await page.evaluate(() => window.model.set("picked", window.ids[0]));
    await frame.waitForFunction(() => Number(document.documentElement.dataset.picked) >= 0, null, WAIT);
    result.picked = await frame.evaluate(() => document.getElementById("piece-name").textContent);
    await frame.click("#piece-after");
    await page.waitForFunction(() => window.model.get("picked") !== window.ids[0], null, WAIT);
    result.next = await page.evaluate(() => window.model.get("picked"));
    await frame.click("#piece-close");
    await page.waitForFunction(() => window.model.get("picked") === null, null, WAIT);
  } finally {
    await browser.close();
  }
  console.log(JSON.stringify(result));
}

main(process.argv.slice(2)).catch((error) => {
  console.error(String(error.stack ?? error));
  process.exitCode = 1;
});
