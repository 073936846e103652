import { defineConfig } from "vite";

// A package that is linked, not installed, brings its own three.js along: one is enough.
export default defineConfig({ base: "./", resolve: { dedupe: ["three"] } });
