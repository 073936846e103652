// Writes the Stanford bunny, which the package `bunny` holds for tests, as OBJ.
import { createRequire } from "node:module";

const { positions, cells } = createRequire(new URL("../../tests/tools/", import.meta.url))("bunny");
const lines = [...positions.map((point) => `v ${point.join(" ")}`), ...cells.map((cell) => `f ${cell.map((corner) => corner + 1).join(" ")}`)];
process.stdout.write(`${lines.join("\n")}\n`);
