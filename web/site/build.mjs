// Puts the site together: node build.mjs PLAYGROUND FIGURES TO. PLAYGROUND is what `make web` builds,
// FIGURES a folder with a page of the player for each shot of figures.json.
import { cp, mkdir, readFile, readdir, rm, stat, writeFile } from "node:fs/promises";
import { basename, dirname, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { Marked } from "marked";

const HERE = dirname(fileURLToPath(import.meta.url));
const ROOT = resolve(HERE, "../..");
const POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; frame-src 'self'; base-uri 'none'; form-action 'none'";
/** Pages that are not in docs/. */
const TOP = ["README.md", "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md"];

const [playground, figures, to] = process.argv.slice(2).map((path) => resolve(path));
if (to === undefined) throw new Error("node build.mjs PLAYGROUND FIGURES TO");

const shots = JSON.parse(await readFile(join(HERE, "figures.json"), "utf8"));
const sources = [...TOP, ...(await markdownIn("docs"))];
/** Where the page of a file of the repository is; files that have none keep their name. */
const pages = new Map(sources.map((source) => [source, join("docs", source.replace(/^docs\//, "").replace(/\.md$/, ".html"))]));

await rm(to, { recursive: true, force: true });
await mkdir(join(to, "gallery"), { recursive: true });
await cp(playground, join(to, "playground"), { recursive: true });
await cp(join(ROOT, "docs/images"), join(to, "docs/images"), { recursive: true });
for (const name of ["site.css", "site.js"]) await cp(join(HERE, name), join(to, name));
for (const shot of Object.values(shots).flatMap(Object.keys)) await cp(join(figures, `${shot}.html`), join(to, "gallery", `${shot}.html`));

for (const source of sources) await write(pages.get(source), titleOf(await text(source), source), await body(source));
await write("gallery/index.html", "Gallery", withPlayers(await body("docs/gallery.md", "gallery/index.html")));
await write("docs/index.html", "Documentation", await contents());
await write("index.html", "Frangible", await readFile(join(HERE, "front.html"), "utf8"));

async function text(source) {
  return readFile(join(ROOT, source), "utf8");
}

async function markdownIn(folder) {
  const names = await readdir(join(ROOT, folder), { recursive: true });
  return names.filter((name) => name.endsWith(".md")).sort().map((name) => join(folder, name));
}

/** HTML of a file of the repository, with links to where its neighbours are on the site. */
async function body(source, page = pages.get(source)) {
  const used = new Map();
  const link = (href) => {
    if (/^[a-z]+:/.test(href) || href.startsWith("#")) return href;
    const [path, anchor] = href.split("#");
    const target = join(dirname(source), path).replace(/\/$/, "");
    const found = pages.get(target) ?? (target.startsWith("docs/images/") ? target : target === "docs/adr" ? "docs/index.html" : null);
    return found && relative(dirname(page), found) + (anchor === undefined ? "" : `#${anchor}`);
  };
  const marked = new Marked({
    renderer: {
      heading({ tokens, depth, text }) {
        const name = text.toLowerCase().replace(/[^\p{L}\p{N}\- _]/gu, "").replaceAll(" ", "-");
        const count = used.get(name) ?? 0;
        used.set(name, count + 1);
        return `<h${depth} id="${name}${count === 0 ? "" : `-${count}`}">${this.parser.parseInline(tokens)}</h${depth}>\n`;
      },
      // What the site does not have, of the source, is named and not linked.
      link({ href, tokens }) {
        const [found, inner] = [link(href), this.parser.parseInline(tokens)];
        return found === null ? inner : `<a href="${escaped(found)}">${inner}</a>`;
      },
      image({ href, text }) {
        const found = link(href);
        return found === null ? "" : `<img src="${escaped(found)}" alt="${escaped(text)}" loading="lazy">`;
      },
    },
  });
  return marked.parse(await text(source));
}

/** The gallery's captions, each with the players of its figure. */
function withPlayers(html) {
  return html.replace(/<p><strong>Figure (\d)\.<\/strong>[\s\S]*?<\/p>/g, (caption, figure) => {
    const links = Object.entries(shots[figure]).map(([shot, title]) => `<a class="play" href="${shot}.html">${title}</a>`);
    return `${caption}\n<p class="players">Play: ${links.join(" ")}</p>`;
  });
}

async function contents() {
  const list = async (sources) => {
    const rows = await Promise.all(sources.map(async (source) => `<li><a href="${relative("docs", pages.get(source))}">${escaped(titleOf(await text(source), source))}</a></li>`));
    return `<ul>\n${rows.join("\n")}\n</ul>`;
  };
  const isDecision = (source) => source.startsWith("docs/adr/");
  const guides = sources.filter((source) => !isDecision(source));
  return `<h1>Documentation</h1>\n${await list(guides)}\n<h2>Decisions</h2>\n${await list(sources.filter(isDecision))}`;
}

function titleOf(markdown, source) {
  return (/^# (.+)$/m.exec(markdown)?.[1] ?? basename(source, ".md")).replace(/[`*]/g, "");
}

async function write(page, title, content) {
  const up = relative(dirname(page), ".") || ".";
  const file = join(to, page);
  await mkdir(dirname(file), { recursive: true });
  await writeFile(file, `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="${POLICY}">
<title>${escaped(title)}</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="${up}/site.css">
<script type="module" src="${up}/site.js"></script>
</head>
<body>
<nav aria-label="Site"><a href="${up}/index.html">Frangible</a> <a href="${up}/playground/playground.html">Playground</a> <a href="${up}/gallery/index.html">Gallery</a> <a href="${up}/docs/index.html">Documentation</a></nav>
<main>
${content}</main>
</body>
</html>
`);
}

function escaped(words) {
  return words.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll('"', "&quot;");
}

const size = (await Promise.all((await readdir(to, { recursive: true })).map((name) => stat(join(to, name))))).reduce((sum, { size }) => sum + size, 0);
console.log(`${to}: ${sources.length} pages of text, ${(size / 1e6).toFixed(1)} MB`);
