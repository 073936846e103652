// The page: its worker loads the engine while the page loads what draws.
const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
const { open } = await import("./playground");
await open(worker);
export {};
