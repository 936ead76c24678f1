/**
 * This engine next to occt-import-js, in the same Chromium, each in a fresh worker on one thread, in turn. Prints a
 * table in Markdown.
 *
 *     node web/bench/compare.mjs [--rounds N] FILE-OR-FOLDER…
 *
 * The chord is 1e-3 of the model's diagonal, in millimetres, for both, the angle 20°. Seconds are from the bytes of the
 * file to typed arrays, the least of N rounds, 3 unless told; loading the modules is not in them. Faces count in every
 * place of their part. "Lost" are faces of the file without triangles. "Open" are sides of triangles that no triangle of
 * the same solid or part uses the other way round, which also counts the borders of files that are open.
 */

import { readdirSync, statSync } from "node:fs";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import { chromium } from "../test/node_modules/playwright-core/index.mjs";
import { serve } from "../server.mjs";

/** An engine gives a file up after this long, milliseconds. */
const MOST = 120_000;
/** A file that takes the other engine longer, seconds, is measured once. */
const SLOW = 10;

/** @typedef {{ seconds: number, faces: number, meshed: number, triangles: number, open: number, chord?: number,
 *   memory?: number, error?: string }} Measured */

const { values, positionals } = parseArgs({
  options: { rounds: { type: "string", default: "3" } },
  allowPositionals: true,
});
const rounds = Number(values.rounds);
const paths = positionals.flatMap((path) =>
  statSync(path).isDirectory()
    ? readdirSync(path)
        .filter((name) => /\.(step|stp)$/i.test(name))
        .sort()
        .map((name) => join(path, name))
    : [path],
);
if (paths.length === 0 || !(rounds >= 1)) {
  console.error("node web/bench/compare.mjs [--rounds N] FILE-OR-FOLDER…");
  process.exit(2);
}

// occt-import-js makes functions from text, which the policy of the page forbids.
const policy = "default-src 'self' 'unsafe-eval' 'wasm-unsafe-eval'";
const server = await serve(0, { folders: [["/bench/", fileURLToPath(new URL(".", import.meta.url))]], policy });
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium" });
const page = await browser.newPage();
await page.goto(`${server.url}bench/`);

/** @param {string} engine @param {Record<string, any>} order @returns {Promise<Measured>} */
const measure = (engine, order) =>
  page.evaluate(
    ([engine, order, most]) =>
      new Promise((resolve) => {
        const worker = new Worker(`/bench/${engine}-worker.js`, { type: "module" });
        const end = (/** @type {any} */ result) => {
          worker.terminate();
          resolve(result);
        };
        worker.onmessage = ({ data }) => end(data);
        worker.onerror = ({ message }) => end({ error: message });
        setTimeout(() => end({ error: `more than ${most / 1e3} s` }), most);
        worker.postMessage(order);
      }),
    /** @type {[string, Record<string, any>, number]} */ ([engine, order, MOST]),
  );

/** @typedef {{ seconds: number, triangles: number, lost: number, open: number }} Row */

/** @param {Row} row @param {number} digits */
const cells = ({ seconds, triangles, lost, open }, digits) =>
  `${seconds.toFixed(digits)} | ${triangles} | ${lost} | ${open}`;

/** @param {Measured} measured @param {number} faces Those that the file has. @returns {Row} */
const rowOf = ({ seconds, triangles, meshed, open }, faces) => ({ seconds, triangles, lost: faces - meshed, open });

/**
 * Measures both engines in turn, and keeps the fastest round of each.
 * @param {string} url
 * @returns {Promise<[Measured, Measured]>}
 */
async function race(url) {
  /** @param {Measured} one @param {Measured} other */
  const faster = (one, other) => (other.seconds < one.seconds ? other : one);
  let mine = await measure("trimtess", { url });
  // A file that this engine refuses has no diagonal.
  const order = { url, chord: mine.chord ?? 0.1 };
  let theirs = await measure("occt", order);
  for (let round = 1; round < rounds; round += 1) {
    if (mine.error || theirs.error || theirs.seconds > SLOW) break;
    mine = faster(mine, await measure("trimtess", { url }));
    theirs = faster(theirs, await measure("occt", order));
  }
  return [mine, theirs];
}

console.log("| File | trimtess: s | triangles | lost | open | occt-import-js: s | triangles | lost | open |");
console.log("|---|---|---|---|---|---|---|---|---|");
/** @returns {Row} */
const nothing = () => ({ seconds: 0, triangles: 0, lost: 0, open: 0 });
const sums = [nothing(), nothing()];
let both = 0;
for (const path of paths) {
  const name = basename(path);
  await page.route(`**/corpus/${name}`, (route) => route.fulfill({ path }));
  const measured = await race(`/corpus/${name}`);
  const { faces } = measured[0];
  const told = measured.map((each) =>
    each.error ? `${each.error.replaceAll("|", "/").slice(0, 60)} | – | – | –` : cells(rowOf(each, faces), 3),
  );
  console.log(`| ${name} | ${told.join(" | ")} |`);
  if (measured.some(({ error }) => error)) continue;
  both += 1;
  for (const [engine, each] of measured.entries()) {
    const row = rowOf(each, faces);
    for (const key of /** @type {(keyof Row)[]} */ (Object.keys(row))) sums[engine][key] += row[key];
  }
}
console.log(`| all ${both} that both read | ${cells(sums[0], 2)} | ${cells(sums[1], 2)} |`);
await browser.close();
server.close();
