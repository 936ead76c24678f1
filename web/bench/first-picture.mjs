/**
 * Seconds from the drop of a file on the page to its pictures, in Chromium, headless, drawn in software. Prints a table
 * in Markdown for each graphics interface that starts.
 *
 *     node web/bench/first-picture.mjs FILE-OR-FOLDER…
 *
 * Of folders it takes the STEP files below 2 MB. Each file is dropped on a fresh page that has come to rest. Columns
 * are moments since the drop, as the page's marks have them (web/page/moments.js): the file has been read, prepared,
 * the first and the final picture are shown. "Triangles" are those of both pictures.
 */

import { readdirSync, statSync } from "node:fs";
import { basename, join } from "node:path";
import { dropFile, fresh, start } from "../test/browser.mjs";

/** A file of a folder is small below this size, bytes. */
const SMALL = 2e6;
const STEPS = ["read", "prepared", "first-picture", "final-picture"];

/** @typedef {{ seconds: number[], triangles: number[] }} Moments */

const paths = process.argv.slice(2).flatMap((path) =>
  statSync(path).isDirectory()
    ? readdirSync(path)
        .filter((name) => /\.(step|stp)$/i.test(name))
        .sort()
        .map((name) => join(path, name))
        .filter((file) => statSync(file).size < SMALL)
    : [path],
);
if (paths.length === 0) {
  console.error("node web/bench/first-picture.mjs FILE-OR-FOLDER…");
  process.exit(2);
}

/**
 * Drops a file on a fresh page.
 * @param {import("../test/browser.mjs").Session} session @param {string} path
 * @returns {Promise<Moments | string>} The words of the page if it refuses the file.
 */
async function measure(session, path) {
  const { page } = session;
  await fresh(session);
  await page.waitForLoadState("networkidle");
  await dropFile(page, path);
  const outcome = await page.waitForFunction(
    (steps) => {
      const trouble = document.getElementById("trouble");
      if (trouble && !trouble.hidden) return trouble.innerText;
      const marks = ["opened", ...steps].map((step) => performance.getEntriesByName(`trimtess:${step}`)[0]);
      if (marks.some((mark) => !mark)) return null;
      const [opened, ...rest] = marks.map(({ startTime }) => startTime / 1e3);
      const [first, last] = marks.slice(-2).map((mark) => /** @type {PerformanceMark} */ (mark).detail);
      return {
        seconds: rest.map((time) => time - opened),
        triangles: [first.triangles, last.triangles],
      };
    },
    STEPS,
    { timeout: 60_000 },
  );
  return /** @type {Moments | string} */ (await outcome.jsonValue());
}

for (const gpu of /** @type {("webgl2" | "webgpu")[]} */ (["webgl2", "webgpu"])) {
  const session = await start(gpu);
  console.log(`\n${gpu}\n\n| File | kB | ${STEPS.join(" | ")} | triangles |`);
  console.log(`|---|---|${"---|".repeat(STEPS.length + 1)}`);
  const firsts = [];
  for (const path of paths) {
    const measured = await measure(session, path);
    const row = `| ${basename(path)} | ${(statSync(path).size / 1e3).toFixed(0)} |`;
    if (typeof measured === "string") {
      console.log(`${row} refused: ${measured.replace(/\s+/g, " ").slice(0, 80)} |${" |".repeat(STEPS.length)}`);
      continue;
    }
    const { seconds, triangles } = measured;
    firsts.push(seconds[STEPS.indexOf("first-picture")]);
    console.log(`${row} ${seconds.map((time) => time.toFixed(2)).join(" | ")} | ${triangles.join(" → ")} |`);
  }
  firsts.sort((one, other) => one - other);
  const late = firsts.filter((time) => time > 1).length;
  const [middle, worst] = [firsts[firsts.length >> 1], firsts[firsts.length - 1]];
  const words = `median ${middle.toFixed(2)} s, worst ${worst.toFixed(2)} s, ${late} above 1 s`;
  console.log(`\n${firsts.length} files: ${words}`);
  await session.close();
}
