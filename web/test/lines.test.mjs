// Lines of the sources fit beside each other in a review.
import assert from "node:assert";
import { readFileSync, readdirSync } from "node:fs";
import test from "node:test";

const LONGEST = 100;

test(`no line of the sources has more than ${LONGEST} characters`, () => {
  const long = [];
  for (const folder of ["../src/", "../npm/src/"]) {
    const root = new URL(folder, import.meta.url);
    for (const name of readdirSync(root, { recursive: true }).filter((it) => it.endsWith(".ts"))) {
      const lines = readFileSync(new URL(name, root), "utf8").split("\n");
      lines.forEach((line, at) => {
        if (line.length > LONGEST) long.push(`${folder}${name}:${at + 1}`);
      });
    }
  }
  assert.deepEqual(long, []);
});
