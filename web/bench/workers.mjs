/**
 * One worker next to several that share a model's parts, in Chromium, in turn. Prints a table in Markdown: seconds from
 * the bytes of the file to typed arrays (chord 1e-3 of the diagonal, 20°), least of three rounds.
 *
 *     node web/bench/workers.mjs FILE…
 */

import { basename } from "node:path";
import { start } from "../test/browser.mjs";

const ROUNDS = 3;
const WORKERS = [1, 2, 3];

const session = await start("webgl2");
const { page } = session;
await page.goto(`${session.url}examples/three.html`);
console.log(`| File | ${WORKERS.map((workers) => `${workers}: read, prepared | all`).join(" | ")} |`);
console.log(`|---|${"---|---|".repeat(WORKERS.length)}`);
for (const path of process.argv.slice(2)) {
  const name = basename(path);
  await page.route(`**/corpus/${name}`, (route) => route.fulfill({ path }));
  const best = WORKERS.map(() => [Infinity, Infinity]);
  for (let round = 0; round < ROUNDS; round += 1) {
    for (const [row, workers] of WORKERS.entries()) {
      const seconds = await page.evaluate(
        async ([name, workers]) => {
          // @ts-ignore: served by the test's server.
          const trimtess = await import("/trimtess.js");
          const blob = await (await fetch(`/corpus/${name}`)).blob();
          const start = performance.now();
          const prepared = await trimtess.read(blob, { workers });
          const read = performance.now();
          await prepared.tessellate();
          const end = performance.now();
          prepared.close();
          return [(read - start) / 1e3, (end - start) / 1e3];
        },
        /** @type {[string, number]} */ ([name, workers]),
      );
      best[row] = best[row].map((least, column) => Math.min(least, seconds[column]));
    }
  }
  console.log(`| ${name} | ${best.flat().map((time) => time.toFixed(2)).join(" | ")} |`);
}
await session.close();
