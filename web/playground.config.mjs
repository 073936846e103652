// Builds the playground: a page, its script, the worker and the engine, as files of one folder.
import { defineConfig } from "vite";

export default defineConfig({
  // The folder may be put anywhere.
  base: "./",
  build: {
    target: "es2022",
    modulePreload: false,
    outDir: "dist/playground",
    emptyOutDir: true,
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 1000,
    rolldownOptions: { input: "playground.html" },
  },
  worker: { format: "es" },
});
