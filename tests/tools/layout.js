// Where the panels and controls of a page are, at windows of many sizes: none may lie over another one, or beyond the
// window, and a finger finds each.
//
//   node layout.js PLAYER [FOLDER]
//
// PLAYER is a page with a recording; pictures go to FOLDER. Prints a line for each fault.
const { chromium } = require("playwright-core");
const { pathToFileURL } = require("url");

const FLAGS = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
/** Windows of telephones, upright and lying, and of desks [CSS px]. */
const TOUCHED = [[320, 568], [390, 844], [844, 390]];
const POINTED = [[640, 400], [800, 600], [1280, 720], [1920, 1080]];
/** What fingers need [CSS px]. */
const FINGER = 40;

const launch = () => chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });

/** What is wrong with a page as it is: sentences. `panels` are selectors of what must lie apart. */
function faults(page, panels, finger) {
  return page.evaluate(([panels, finger]) => {
    const found = [];
    const box = (element) => {
      const { left, top, right, bottom } = element.getBoundingClientRect();
      return { name: element.id || element.textContent.trim() || element.tagName, left, top, right, bottom };
    };
    const isShown = (element) => element.checkVisibility() && element.getBoundingClientRect().width > 1;
    // Half a pixel is rounding.
    const overlap = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 0.5 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 0.5;
    const apart = (boxes) => boxes.forEach((one, i) => boxes.slice(i + 1).forEach((other) => overlap(one, other) && found.push(`${one.name} lies over ${other.name}`)));
    const within = (inner, { left, top, right, bottom }, where, sides) => {
      const beyond = [left - inner.left, inner.right - right, ...(sides ? [] : [top - inner.top, inner.bottom - bottom])];
      if (Math.max(...beyond) > 0.5) found.push(`${inner.name} lies beyond ${where}`);
    };

    const all = panels.flatMap((selector) => [...document.querySelectorAll(selector)]).filter(isShown);
    const frame = { left: 0, top: 0, right: innerWidth, bottom: innerHeight };
    apart(all.map(box));
    for (const panel of all) {
      within(box(panel), frame, "the window");
      const controls = [...panel.querySelectorAll("button, select, input, summary")].filter(isShown);
      apart(controls.map(box));
      for (const control of controls) {
        // The menu and the numbers of a piece may be scrolled to; buttons may not.
        within(box(control), box(panel), panel.id, panel.id !== "controls");
        const { width, height } = control.getBoundingClientRect();
        if (Math.min(width, height) < finger - 0.5) found.push(`${box(control).name} is ${width.toFixed(0)} x ${height.toFixed(0)}`);
        if (control.matches("button") && control.scrollWidth > control.clientWidth) found.push(`${box(control).name} has no room for its word`);
      }
    }
    return found;
  }, [panels, finger]);
}

/** Draw next to nothing: panels are where they are without a picture. */
const drawLittle = (page) => page.evaluate(() => Object.assign(document.getElementById("view").style, { width: "64px", height: "36px" }));

/** Bring a page to each size, and call with its name and what a finger needs there. */
async function atEachSize(browser, open, look) {
  for (const [sizes, options, finger] of [[TOUCHED, { hasTouch: true, isMobile: true }, FINGER], [POINTED, {}, 0]]) {
    const [width, height] = sizes[0];
    const context = await browser.newContext({ viewport: { width, height }, ...options });
    const page = await open(context);
    for (const [width, height] of sizes) {
      await page.setViewportSize({ width, height });
      await page.waitForFunction(([width, height]) => innerWidth === width && innerHeight === height, [width, height], { polling: 100 });
      await look(page, `${width}x${height}`, finger);
    }
    await context.close();
  }
}

async function main([player, folder]) {
  const browser = await launch();
  const panels = ["#caption", "#piece", "#controls"];
  const open = async (context) => {
    const page = await context.newPage();
    await page.goto(`${pathToFileURL(player).href}#frame=8&pick=4&quality=4`);
    if (!folder) await drawLittle(page);
    await page.waitForFunction(() => document.documentElement.dataset.picked === "4", null, { timeout: 120000, polling: 100 });
    return page;
  };
  try {
    await atEachSize(browser, open, async (page, size, finger) => {
      // With and without the graph, then with the keys.
      for (const key of ["g", "g", "?"]) {
        await page.keyboard.press(key);
        await page.waitForTimeout(100);
        for (const fault of await faults(page, panels, finger)) console.log(`${size}, ${key}: ${fault}`);
        if (folder) await page.screenshot({ path: `${folder}/player_${size}_${key === "?" ? "keys" : (await page.isVisible("#energy")) ? "graph" : "plain"}.png`, timeout: 120000 });
      }
      await page.keyboard.press("?");
    });
  } finally {
    await browser.close();
  }
}

module.exports = { launch, faults, atEachSize, drawLittle };
if (require.main === module)
  main(process.argv.slice(2)).catch((error) => {
    console.error(String(error.stack ?? error));
    process.exitCode = 1;
  });
