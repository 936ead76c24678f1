/** What the tests share: the server, Chromium, the native program, files dropped on the page, and pictures compared. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync } from "node:fs";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";
import { serve } from "../server.mjs";

export const ROOT = fileURLToPath(new URL("../../", import.meta.url));
/** Pictures of a test run, to look at. */
export const OUT = fileURLToPath(new URL("out/", import.meta.url));
mkdirSync(OUT, { recursive: true });

/** A file of this checkout. @param {string} name */
export const data = (name) => join(ROOT, "tests/data", name);

/** Flags that draw in software, so that pictures do not depend on the machine. */
const SOFTWARE = {
  webgl2: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  // Canvases of a software device are composed by Vulkan alone.
  webgpu: [
    "--enable-unsafe-webgpu",
    "--use-webgpu-adapter=swiftshader",
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--use-angle=vulkan",
  ],
};

/**
 * Starts the server and Chromium.
 * @param {"webgl2" | "webgpu"} gpu
 * @param {{ colorScheme?: "light" | "dark", viewport?: { width: number, height: number }, deviceScaleFactor?: number,
 *   hasTouch?: boolean }} [options]
 */
export async function start(gpu, options = {}) {
  const server = await serve(0);
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: [...SOFTWARE[gpu], "--disable-domain-blocking-for-3d-apis", "--enable-precise-memory-info"],
  });
  const context = await browser.newContext({ viewport: { width: 900, height: 520 }, ...options });
  /** @type {string[]} */
  const troubles = [];
  /** @type {string[]} */
  const foreign = [];
  context.on("request", (request) => {
    const url = request.url();
    if (!url.startsWith(server.url) && !url.startsWith("blob:") && !url.startsWith("data:")) foreign.push(url);
  });
  const page = await context.newPage();
  context.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) troubles.push(message.text());
  });
  page.on("pageerror", (error) => troubles.push(String(error)));
  return {
    url: server.url,
    gpu,
    browser,
    context,
    page,
    /** Errors and warnings of the console, and errors that nobody caught. */
    troubles,
    /** Requests to anywhere but the server. */
    foreign,
    async close() {
      await browser.close();
      server.close();
    },
  };
}

/** @typedef {Awaited<ReturnType<typeof start>>} Session */
/** @typedef {import("playwright-core").Page} Page */

/** Opens the page anew. @param {Session} session */
export async function fresh({ page, url, gpu }) {
  await page.goto(`${url}?gpu=${gpu}`);
  await page.locator("#welcome").waitFor();
}

/** Drops a file on the page. @param {Page} page @param {string} name @param {Buffer} bytes */
export async function drop(page, name, bytes) {
  const transfer = await page.evaluateHandle(
    ([name, text]) => {
      const file = new File([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))], name);
      const transfer = new DataTransfer();
      transfer.items.add(file);
      return transfer;
    },
    [name, bytes.toString("base64")],
  );
  await page.dispatchEvent("#drop", "drop", { dataTransfer: transfer });
  await transfer.dispose();
}

/** Drops a file of the disk. @param {Page} page @param {string} path */
export const dropFile = (page, path) => drop(page, basename(path), readFileSync(path));

/** Waits until a model is shown and its picture is finished. @param {Page} page @param {string} name @param {number} [most] */
export async function settled(page, name, most = 60_000) {
  await page.waitForFunction(
    (name) => {
      const trouble = document.getElementById("trouble");
      if (trouble && !trouble.hidden) throw new Error(trouble.innerText);
      return (
        document.getElementById("name")?.textContent === name &&
        document.getElementById("progress")?.hidden &&
        document.getElementById("stage")?.ariaBusy === "false"
      );
    },
    name,
    { timeout: most },
  );
}

/** The rows of a list of names and values. @param {Page} page @param {string} id @returns {Promise<Record<string, string>>} */
export function rows(page, id) {
  return page.locator(`#${id}`).evaluate((list) => {
    const texts = [...list.children].map((child) => child.textContent ?? "");
    return Object.fromEntries(texts.flatMap((text, index) => (index % 2 ? [[texts[index - 1], text]] : [])));
  });
}

/** Waits until so many workers run: ended ones are told a while later. @param {Page} page @param {number} count */
export async function workers(page, count) {
  for (let wait = 0; wait < 100 && page.workers().length !== count; wait += 1) await page.waitForTimeout(100);
  assert.equal(page.workers().length, count, "workers");
}

/** Digits of a text as a number. @param {string} text */
export const number = (text) => Number(text.replaceAll(/[^0-9.]/g, ""));

/** The native program; null where it has not been built. */
export const program =
  [process.env.TRIMTESS_PROGRAM, join(process.env.CARGO_TARGET_DIR ?? join(ROOT, "target"), "release/trimtess")].find(
    (path) => path && existsSync(path),
  ) ?? null;

/**
 * Runs the native program.
 * @param {string[]} args
 * @returns {{ status: number, out: string, err: string }}
 */
export function native(args) {
  try {
    return {
      status: 0,
      out: execFileSync(/** @type {string} */ (program), args, { encoding: "utf8", stdio: "pipe" }),
      err: "",
    };
  } catch (error) {
    const { status, stdout, stderr } = /** @type {any} */ (error);
    return { status: status ?? -1, out: String(stdout), err: String(stderr) };
  }
}

/** The picture alone, without what lies over it. @param {Page} page @returns {Promise<Buffer>} */
export async function picture(page) {
  await page.locator("#marker").evaluate((marker) => marker.classList.add("hidden-for-test"));
  return page.locator("#stage canvas:not(.waiting)").screenshot();
}

/**
 * Compares two pictures of the same height. What one has to the right of the other is left out.
 * @param {Session} session @param {Buffer} one @param {Buffer} other
 * @returns {Promise<{ mean: number, far: number }>} The mean difference of channels, 0 to 255, and the share of pixels
 *     that differ by more than 32 in a channel.
 */
export async function compare(session, one, other) {
  const page = await session.context.newPage();
  try {
    return await page.evaluate(
      async (texts) => {
        const bitmaps = await Promise.all(
          texts.map((text) => {
            const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
            return createImageBitmap(new Blob([bytes], { type: "image/png" }));
          }),
        );
        const width = Math.min(...bitmaps.map((bitmap) => bitmap.width));
        const [a, b] = bitmaps.map((bitmap) => {
          const context = new OffscreenCanvas(width, bitmap.height).getContext("2d");
          context?.drawImage(bitmap, 0, 0);
          return /** @type {ImageData} */ (context?.getImageData(0, 0, width, bitmap.height));
        });
        if (a.height !== b.height) throw new Error(`${a.height} and ${b.height} pixels high`);
        let [sum, far] = [0, 0];
        for (let pixel = 0; pixel < a.data.length; pixel += 4) {
          let most = 0;
          for (let channel = pixel; channel < pixel + 3; channel += 1) {
            const difference = Math.abs(a.data[channel] - b.data[channel]);
            sum += difference;
            most = Math.max(most, difference);
          }
          if (most > 32) far += 1;
        }
        const pixels = a.data.length / 4;
        return { mean: sum / pixels / 3, far: far / pixels };
      },
      [one.toString("base64"), other.toString("base64")],
    );
  } finally {
    await page.close();
  }
}

/** Resident memory of the browser's processes of a kind, in bytes. @param {Session} session @param {string} kind */
export async function resident(session, kind) {
  const client = await session.browser.newBrowserCDPSession();
  const { processInfo } = await client.send("SystemInfo.getProcessInfo");
  await client.detach();
  const sizes = processInfo
    .filter(({ type }) => type === kind)
    .map(({ id }) => {
      const pages = readFileSync(`/proc/${id}/statm`, "utf8").split(" ")[1];
      return Number(pages) * 4096;
    });
  return sizes.reduce((sum, size) => sum + size, 0);
}

/** A large file: copies of the sample next to each other. @param {number} [size] Bytes, at least. @returns {Buffer} */
export function large(size = 16e6) {
  const text = readFileSync(data("nist_ctc05.step"), "latin1");
  const start = text.indexOf("DATA;") + "DATA;".length;
  const end = text.lastIndexOf("ENDSEC;");
  const body = text.slice(start, end);
  const most = Math.max(...[...body.matchAll(/^\s*#(\d+)\s*=/gm)].map((found) => Number(found[1])));
  const copies = Array.from({ length: Math.ceil(size / body.length) }, (_, copy) => {
    // Inches.
    const [dx, dy] = [25 * (copy % 5), 25 * Math.floor(copy / 5)];
    return body
      .replaceAll(/#(\d+)/g, (_all, id) => `#${Number(id) + copy * (most + 1)}`)
      .replaceAll(
        /(CARTESIAN_POINT\s*\(\s*'[^']*'\s*,\s*\()([^,()]+),([^,()]+),([^,()]+)\)/g,
        (_all, head, x, y, z) => `${head}${(Number(x) + dx).toFixed(9)},${(Number(y) + dy).toFixed(9)},${z})`,
      );
  });
  return Buffer.from(text.slice(0, start) + copies.join("\n") + text.slice(end), "latin1");
}
