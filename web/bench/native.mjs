/**
 * The module in Node next to the native program, one thread each, in turn. Prints a table in Markdown: seconds of every
 * file, and how many times those of the program the module takes.
 *
 *     node web/bench/native.mjs PROGRAM FILE-OR-FOLDER…
 *
 * The chord is 1e-3 of the model's diagonal, the angle 20°. The module: from the bytes of the file to typed arrays, the
 * least of three rounds in one process ("compiled"), and the first file of a process ("first", the least of two), in
 * which the JavaScript engine compiles the code on the way. The program: its start, and a GLB in the folder for temporary
 * files ($TMPDIR: name a memory disk), included.
 */

import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";

const ROUNDS = 3;
const WASM = new URL("../dist/wasm/", import.meta.url);

/** Seconds from the bytes of a file to typed arrays. @param {Uint8Array} bytes @param {any} wasm */
function meshed(bytes, wasm) {
  const start = performance.now();
  // `prepare` consumes the model.
  const prepared = wasm.read(bytes, "", undefined).prepare(undefined);
  const mesh = prepared.tessellate({ chordRel: 1e-3, angle: Math.PI / 9 }, undefined, undefined);
  mesh.complete();
  for (let part = 0; part < mesh.partCount(); part += 1) mesh.part(part);
  const seconds = (performance.now() - start) / 1000;
  mesh.free();
  prepared.free();
  return seconds;
}

async function module() {
  const wasm = await import(new URL("trimtess_web.js", WASM).href);
  await wasm.default({ module_or_path: readFileSync(new URL("trimtess_web_bg.wasm", WASM)) });
  return wasm;
}

const [program, ...paths] = process.argv.slice(2);
if (program === "--once") {
  console.log(meshed(readFileSync(paths[0]), await module()));
  process.exit(0);
}
const files = paths.flatMap((path) =>
  statSync(path).isDirectory()
    ? readdirSync(path).filter((name) => /\.(step|stp)$/i.test(name)).map((name) => join(path, name))
    : [path],
);
const folder = mkdtempSync(join(tmpdir(), "trimtess-native-"));
/** @param {() => number} seconds */
const least = (rounds, seconds) => Math.min(...Array.from({ length: rounds }, seconds));
/** @param {string} file */
function native(file) {
  const how = ["--workers", "1", "--chord-rel", "1e-3", "-q", "-o", join(folder, "out.glb")];
  const start = performance.now();
  const { status } = spawnSync(program, ["tessellate", file, ...how], { env: { ...process.env, RAYON_NUM_THREADS: "1" } });
  if (status !== 0 && status !== 3) throw new Error(`the program's status is ${status}`);
  return (performance.now() - start) / 1000;
}

/** @param {string} file */
function once(file) {
  const { status, stdout } = spawnSync(process.execPath, [fileURLToPath(import.meta.url), "--once", file]);
  if (status !== 0) throw new Error(`a process for one file ended with ${status}`);
  return Number(stdout);
}

const wasm = await module();
const rows = [];
console.log("| File | program: s | compiled: s | times | first: s | times |\n|---|---|---|---|---|---|");
for (const file of files) {
  try {
    const bytes = readFileSync(file);
    const one = least(ROUNDS, () => native(file));
    const compiled = least(ROUNDS, () => meshed(bytes, wasm));
    const first = least(2, () => once(file));
    rows.push([one, compiled, first]);
    const told = [one, compiled, compiled / one, first, first / one].map((number) => number.toFixed(3));
    console.log(`| ${basename(file)} | ${told.join(" | ")} |`);
  } catch (error) {
    console.log(`| ${basename(file)} | ${error} |`);
  }
}
rmSync(folder, { recursive: true });
const sum = (k) => rows.reduce((total, row) => total + row[k], 0);
for (const [k, name] of [[1, "compiled"], [2, "first"]]) {
  const ratios = rows.map((row) => row[k] / row[0]).sort((a, b) => a - b);
  const [median, worst] = [ratios[ratios.length >> 1], ratios[ratios.length - 1]];
  const within = ratios.filter((ratio) => ratio <= 2.5).length;
  console.log(
    `${name}: ${rows.length} files, ${(sum(k) / sum(0)).toFixed(2)} times the program's ${sum(0).toFixed(1)} s in sum, ` +
      `median file ${median.toFixed(2)}, worst ${worst.toFixed(2)}; ${within} within 2.5`,
  );
}
