/** What comes before what from the drop of a file to its final picture, on both graphics interfaces. */

import assert from "node:assert/strict";
import { after, before, describe, test } from "node:test";
import { data, drop, dropFile, fresh, large, settled, start, workers } from "./browser.mjs";

const CTC = "nist_ctc05.step";
const BRAKE = "brake-assembly";
const STEPS = ["module", "device", "opened", "read", "prepared", "first-picture", "final-picture"];

/** @typedef {import("./browser.mjs").Session} Session */
/** @typedef {import("playwright-core").Page} Page */

/**
 * Waits for the final picture, and returns the page's marks of the file that is shown.
 * @param {Page} page
 */
async function marks(page) {
  const found = await page.waitForFunction(
    (steps) => {
      const marks = steps.map((step) => performance.getEntriesByName(`trimtess:${step}`));
      if (marks.some(({ length }) => length !== 1)) return null;
      return marks.map(([mark]) => ({
        time: mark.startTime,
        ...(/** @type {PerformanceMark} */ (mark).detail ?? { triangles: 0, deferred: 0 }),
      }));
    },
    STEPS,
    { timeout: 60_000 },
  );
  const rows = /** @type {{ time: number, triangles: number, deferred: number }[]} */ (await found.jsonValue());
  return Object.fromEntries(rows.map((row, index) => [STEPS[index], row]));
}

/** @param {Awaited<ReturnType<typeof marks>>} seen @param {string[]} steps */
function assertOrder(seen, steps) {
  const times = steps.map((step) => seen[step].time);
  assert(
    times.every((time, index) => index === 0 || times[index - 1] <= time),
    JSON.stringify(seen),
  );
}

/** Waits until the worker that the page starts with has its device. @param {Page} page */
async function rested(page) {
  await workers(page, 1);
  await page.locator("#stage[data-device=ready]").waitFor({ timeout: 60_000 });
}

for (const gpu of /** @type {("webgl2" | "webgpu")[]} */ (["webgl2", "webgpu"])) {
  describe(`${gpu}: first picture`, () => {
    /** @type {Session} */ let session;
    /** @type {Page} */ let page;
    before(async () => {
      session = await start(gpu);
      page = session.page;
    });
    after(async () => {
      await session.close();
      assert.deepEqual(session.foreign, []);
    });

    test("module and device are there before the first file, and the next file has marks of its own", async () => {
      await fresh(session);
      await rested(page);
      await dropFile(page, data(CTC));
      await settled(page, CTC);
      const first = await marks(page);
      assertOrder(first, STEPS);
      assert(first["final-picture"].triangles > 1000);
      await dropFile(page, data("nested.step"));
      await settled(page, "nested.step");
      const second = await marks(page);
      assertOrder(second, ["opened", "module", "read", "prepared", "first-picture", "final-picture"]);
      assert(second.opened.time > first["final-picture"].time);
      await workers(page, 1);
    });

    test("a model of many triangles has a coarse picture before the final one", async () => {
      await fresh(session);
      await rested(page);
      const slider = page.locator("#deviation");
      await slider.evaluate((/** @type {HTMLInputElement} */ input) => (input.value = input.min));
      await page.locator(`#welcome [data-sample="builtin:${BRAKE}"]`).click();
      const seen = await marks(page);
      assertOrder(seen, STEPS);
      const [coarse, fine] = [seen["first-picture"], seen["final-picture"]];
      assert(coarse.deferred > 0 && fine.deferred === 0, JSON.stringify(seen));
      assert(coarse.triangles > 0 && coarse.triangles < fine.triangles, JSON.stringify(seen));
    });

    test("the coarse picture is closed: nothing shows through it", async () => {
      await fresh(session);
      const seen = await page.evaluate(async ([gpu, name]) => {
        // @ts-ignore: served by the test's server.
        const wasm = await import("/wasm/trimtess_web.js");
        await wasm.default();
        const canvas = new OffscreenCanvas(800, 600);
        const viewer = await wasm.Viewer.create(canvas, gpu);
        const prepared = wasm.sample(name).prepare();
        viewer.show(prepared);
        const background = [0, 0, 1, 1];
        viewer.set({ edges: false, deviationPx: 0.1, background: [background, background] });
        const pixels = async (/** @type {boolean} */ backfaces) => {
          viewer.set({ backfaces });
          const rgba = await viewer.pixels();
          return new Uint32Array(rgba.buffer, rgba.byteOffset, rgba.length / 4);
        };
        /** Pixels of the model, and those that show surfaces from behind, which have a colour of their own. */
        const count = async () => {
          const [plain, marked] = [await pixels(false), await pixels(true)];
          const model = plain.filter((pixel) => pixel !== plain[0]).length;
          return { model, behind: plain.filter((pixel, index) => pixel !== marked[index]).length };
        };
        let step = viewer.step();
        const coarse = { ...(await count()), deferred: step.deferred, triangles: step.triangles };
        while (step.again) step = viewer.step();
        const fine = { ...(await count()), deferred: step.deferred, triangles: step.triangles };
        // The model is seen from behind where a plane of section opens it: the count finds holes.
        viewer.set({ section: { axis: "z", share: 0.5, flipped: false } });
        do step = viewer.step();
        while (step.again);
        return { coarse, fine, open: await count() };
      }, /** @type {[string, string]} */ ([gpu, BRAKE]));
      const told = JSON.stringify(seen);
      const { coarse, fine, open } = seen;
      assert(coarse.deferred > 0 && coarse.triangles < fine.triangles, told);
      assert(fine.model > 50_000 && Math.abs(coarse.model - fine.model) < 1e-3 * fine.model, told);
      assert(Math.abs(coarse.behind - fine.behind) < 2e-3 * fine.model, told);
      assert(open.behind > fine.behind + 0.02 * fine.model, told);
    });

    test("a device that is lost while the file is read is replaced before the first picture", async () => {
      await fresh(session);
      await rested(page);
      await drop(page, "large.step", large());
      await page.getByText(/^reading/).waitFor();
      const client = await session.browser.newBrowserCDPSession();
      await client.send("Browser.crashGpuProcess").catch(() => {});
      await settled(page, "large.step", 120_000);
      const { triangles } = (await marks(page))["final-picture"];
      assert(triangles > 10_000);
    });
  });
}
