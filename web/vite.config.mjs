// Builds the player into one HTML file that refers to nothing outside itself.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { defineConfig } from "vite";

/** Where the Python package looks for the player. */
const PLAYER = new URL("../python/frangible/player.html", import.meta.url);

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

/** Moves script and style into the page, and allows no others. */
function onePage() {
  return {
    name: "one-page",
    enforce: "post",
    generateBundle(_, bundle) {
      const files = Object.values(bundle);
      const page = files.find((file) => file.fileName === "index.html");
      const script = files.find((file) => file.type === "chunk").code.trim().replaceAll("</script", "<\\/script");
      const style = readFileSync(new URL("src/style.css", import.meta.url), "utf8").trim();
      const policy =
        `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; img-src data: blob:; ` +
        "base-uri 'none'; form-action 'none'";
      const html = page.source
        .replace(/\s*<script type="module"[^>]*><\/script>/, "")
        .replace("<!-- style -->", () => `<meta http-equiv="Content-Security-Policy" content="${policy}">\n<style>${style}</style>`)
        .replace("<!-- script -->", () => `<script>${script}</script>`);
      writeFileSync(PLAYER, html);
    },
  };
}

export default defineConfig({
  build: {
    target: "es2022",
    modulePreload: false,
    outDir: "dist",
    write: false,
    rolldownOptions: { output: { format: "iife" } },
  },
  plugins: [onePage()],
});
