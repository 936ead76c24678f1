/** The page in a real browser, once with WebGL2 and once with WebGPU, both drawn in software. */

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import {
  OUT,
  compare,
  data,
  drop,
  dropFile,
  fresh,
  large,
  native,
  number,
  picture,
  program,
  rows,
  settled,
  start,
  workers,
} from "./browser.mjs";

const CUBE = "red_cube_blue_cylinder.step";
const CTC = "nist_ctc05.step";
const NESTED = "nested.step";

/** @typedef {import("./browser.mjs").Session} Session */
/** @typedef {import("playwright-core").Page} Page */

for (const gpu of /** @type {("webgl2" | "webgpu")[]} */ (["webgl2", "webgpu"])) {
  describe(gpu, () => {
    /** @type {Session} */ let session;
    /** @type {Page} */ let page;
    /** Why the tests of this kind are skipped. @type {string | false} */ let missing = false;

    before(async () => {
      session = await start(gpu);
      page = session.page;
      await page.goto(session.url);
      const there = await page.evaluate(async (gpu) => {
        if (gpu === "webgl2") return new OffscreenCanvas(1, 1).getContext("webgl2") !== null;
        return ((await /** @type {any} */ (navigator).gpu?.requestAdapter()) ?? null) !== null;
      }, gpu);
      missing = there ? false : `Chromium has no ${gpu} here`;
    });
    after(() => session.close());

    /** @param {string} name @param {() => Promise<void>} body */
    const check = (name, body) =>
      test(name, async (context) => {
        if (missing) return context.skip(missing);
        session.troubles.length = 0;
        await fresh(session);
        await body();
        assert.deepEqual(session.troubles, []);
        assert.deepEqual(session.foreign, []);
      });

    /** Where the picture is in the window. */
    const area = async () => {
      const box = await page.locator("#stage").boundingBox();
      assert(box);
      return box;
    };
    const middle = async () => {
      const { x, y, width, height } = await area();
      return { x: x + width / 2, y: y + height / 2 };
    };

    for (const [name, from] of [
      [CUBE, "iso"],
      [CTC, "iso"],
      [CTC, "front"],
    ]) {
      check(`${name} from ${from} is drawn as the program draws it`, async () => {
        await dropFile(page, data(name));
        await settled(page, name);
        await page.getByRole("button", { name: from, exact: true }).click();
        await settled(page, name);
        const mine = await picture(page);
        const label = `${gpu}-${name.split(".")[0]}-${from}`;
        writeFileSync(join(OUT, `${label}.png`), mine);
        if (!program) return;
        const { width, height } = await area();
        const output = join(OUT, `${label}-native.png`);
        // The window of the program has its panel to the right.
        const size = `${width + 260}x${height}`;
        const args = ["-q", "view", data(name), "--size", size, "--camera", from, "--edges", "--screenshot", output];
        const run = native(args);
        assert.equal(run.status, 0, run.err);
        const { mean, far } = await compare(session, mine, readFileSync(output));
        assert(mean < 1 && far < 0.01, `${label}: mean ${mean}, far ${far}`);
      });
    }

    check("the pointer turns, moves, zooms and picks", async () => {
      await dropFile(page, data(CUBE));
      await settled(page, CUBE);
      const { x, y } = await middle();
      let last = await picture(page);
      const changed = async () => {
        await settled(page, CUBE);
        const now = await picture(page);
        const { far } = await compare(session, last, now);
        last = now;
        return far;
      };
      const drag = async (/** @type {"left" | "right"} */ button) => {
        await page.mouse.move(x, y);
        await page.mouse.down({ button });
        await page.mouse.move(x + 60, y + 20, { steps: 4 });
        await page.mouse.up({ button });
        return changed();
      };
      assert((await drag("left")) > 0.02, "turned");
      assert((await drag("right")) > 0.02, "moved");
      assert.equal(await page.locator("#picked dd").count(), 0, "a drag is no click");
      await page.mouse.wheel(0, -300);
      assert((await changed()) > 0.02, "zoomed");
      await page.getByRole("button", { name: "fit", exact: true }).click();
      await settled(page, CUBE);
      // The cylinder, which is right of the middle.
      await page.mouse.click(x + 90, y + 60);
      await page.locator("#picked dd").first().waitFor();
      const facts = await rows(page, "picked");
      assert.match(facts.surface, /^(plane|cylinder)$/);
      assert.match(facts.entity, /^#\d+$/);
      assert(facts.part && facts.face && facts.instance);
      assert.equal(await page.locator("#tree .picked").count(), 1);
      await page.keyboard.press("Escape");
      assert.equal(await page.locator("#picked dd").count(), 0);
    });

    check("two fingers move and zoom, one turns", async () => {
      await dropFile(page, data(CUBE));
      await settled(page, CUBE);
      const { x, y } = await middle();
      const client = await session.context.newCDPSession(page);
      const touch = (/** @type {string} */ type, /** @type {[number, number][]} */ ...points) =>
        client.send(
          "Input.dispatchTouchEvent",
          /** @type {any} */ ({
            type,
            touchPoints: points.map(([dx, dy], id) => ({ x: x + dx, y: y + dy, id })),
          }),
        );
      const before = await picture(page);
      await touch("touchStart", [-40, 0], [40, 0]);
      for (const reach of [50, 60, 70, 80]) await touch("touchMove", [-reach, 0], [reach, 0]);
      await touch("touchEnd");
      await settled(page, CUBE);
      const closer = await picture(page);
      assert((await compare(session, before, closer)).far > 0.05, "zoomed");
      await touch("touchStart", [0, 0]);
      for (const dx of [10, 20, 30]) await touch("touchMove", [dx, 0]);
      await touch("touchEnd");
      await settled(page, CUBE);
      assert((await compare(session, closer, await picture(page))).far > 0.02, "turned");
    });

    check("everything works by keyboard", async () => {
      await page.locator("[data-sample]").first().focus();
      await page.keyboard.press("Enter");
      await settled(page, CTC);
      let last = await picture(page);
      const changes = async (/** @type {string} */ key, /** @type {number} */ least) => {
        await page.keyboard.press(key);
        await settled(page, CTC);
        const now = await picture(page);
        const { far } = await compare(session, last, now);
        assert(far > least, `${key} changes ${far} of the picture`);
        last = now;
      };
      await page.locator("#stage").focus();
      for (const key of ["ArrowLeft", "Shift+ArrowUp", "+", "2", "c", "w", "o", "e"]) await changes(key, 0.001);
      await page.keyboard.press("f");
      await page.keyboard.press("Enter");
      await page.locator("#picked dd").first().waitFor();
      assert((await rows(page, "picked")).surface);
    });

    check("hidden parts are not drawn, and all colours differ", async () => {
      await dropFile(page, data(CUBE));
      await settled(page, CUBE);
      const whole = await picture(page);
      const triangles = number((await rows(page, "costs")).triangles);
      const boxes = page.locator("#tree input");
      await boxes.last().uncheck();
      await settled(page, CUBE);
      assert((await compare(session, whole, await picture(page))).far > 0.01);
      assert(number((await rows(page, "costs")).triangles) < triangles);
      await boxes.last().check();
      await settled(page, CUBE);
      assert((await compare(session, whole, await picture(page))).far < 1e-4);
      const seen = [whole];
      for (const by of ["part", "face", "tile", "rate"]) {
        await page.locator("#colours").selectOption(by);
        await settled(page, CUBE);
        const now = await picture(page);
        assert((await compare(session, /** @type {Buffer} */ (seen.at(-1)), now)).far > 0.01, by);
        seen.push(now);
      }
    });

    check("assemblies are nested, and hidden as a whole", async () => {
      await dropFile(page, data(NESTED));
      await settled(page, NESTED);
      const names = (/** @type {string} */ below) =>
        page.locator(`${below} > li > .node > label > span`).allInnerTexts();
      assert.deepEqual(await names("#tree"), ["all"]);
      assert.deepEqual(await names("#tree > li > ul"), ["upper pair", "lower pair"]);
      const triangles = async () => number((await rows(page, "costs")).triangles);
      const [whole, all] = [await picture(page), await triangles()];
      await page.getByLabel("lower pair", { exact: true }).uncheck();
      await settled(page, NESTED);
      assert.equal(await triangles(), all / 2);
      await page.getByRole("button", { name: "Parts of upper pair" }).click();
      await page.getByLabel("left", { exact: true }).uncheck();
      await settled(page, NESTED);
      assert.equal(await triangles(), all / 4);
      await page.getByLabel("all", { exact: true }).uncheck();
      await page.getByLabel("all", { exact: true }).check();
      await settled(page, NESTED);
      assert.equal(await triangles(), all);
      assert((await compare(session, whole, await picture(page))).far < 1e-4);
    });

    check("a section cuts the model open", async () => {
      await dropFile(page, data(CUBE));
      await settled(page, CUBE);
      const whole = await picture(page);
      const cut = async (/** @type {string} */ axis) => {
        await page.locator("#section").selectOption(axis);
        await settled(page, CUBE);
        return picture(page);
      };
      const below = await cut("z");
      assert((await compare(session, whole, below)).far > 0.01);
      await page.locator("#flipped").check();
      await settled(page, CUBE);
      assert((await compare(session, below, await picture(page))).far > 0.01);
      assert((await compare(session, whole, await cut("none"))).far < 1e-4);
    });

    check("a smaller deviation takes more triangles", async () => {
      await dropFile(page, data(CTC));
      await settled(page, CTC);
      const triangles = async (/** @type {string} */ value) => {
        await page.locator("#deviation").fill(value);
        await settled(page, CTC);
        return number((await rows(page, "costs")).triangles);
      };
      const [coarse, fine] = [await triangles("1"), await triangles("-1")];
      assert(fine > 1.5 * coarse, `${coarse} and ${fine} triangles`);
    });

    check("a lost graphics device is replaced, with the camera and what is hidden", async () => {
      await dropFile(page, data(CUBE));
      await settled(page, CUBE);
      await page.locator("#tree input").last().uncheck();
      await page.getByRole("button", { name: "left", exact: true }).click();
      await settled(page, CUBE);
      const before = await picture(page);
      const client = await session.browser.newBrowserCDPSession();
      await client.send("Browser.crashGpuProcess").catch(() => {});
      await page.waitForFunction(() => document.getElementById("stage")?.ariaBusy === "true", undefined, {
        timeout: 10_000,
      });
      await settled(page, CUBE);
      assert((await compare(session, before, await picture(page))).far < 1e-3);
    });

    check("reading is cancelled, and what was shown stays", async () => {
      await dropFile(page, data(CUBE));
      await settled(page, CUBE);
      const before = await picture(page);
      // The page clicks by itself: the file may be read before a click from outside arrives.
      const clicked = page.evaluate(() => {
        const [progress, button] = ["progress", "cancel"].map((id) => /** @type {HTMLElement} */ (document.getElementById(id)));
        /** @param {(visible: boolean) => void} done */
        const click = (done) => {
          const visible = button.checkVisibility();
          button.click();
          done(visible && progress.hidden);
        };
        return new Promise((/** @type {(visible: boolean) => void} */ done) => {
          const watch = new MutationObserver(() => {
            if (progress.hidden) return;
            watch.disconnect();
            setTimeout(click, 100, done);
          });
          watch.observe(progress, { attributes: true });
          setTimeout(done, 10_000, false);
        });
      });
      await drop(page, "large.step", large());
      assert(await clicked, "the button was not visible, or progress still was after the click");
      await settled(page, CUBE);
      assert((await compare(session, before, await picture(page))).far < 1e-4);
      await workers(page, 1);
    });

    check("a broken file is refused in the program's words, and what was shown stays", async () => {
      await dropFile(page, data(CUBE));
      await settled(page, CUBE);
      for (const [name, text] of [
        ["broken.step", "this is no STEP file"],
        ["empty.step", ""],
      ]) {
        await drop(page, name, Buffer.from(text));
        await page.locator("#trouble").waitFor();
        const words = await page.locator("#trouble-words").innerText();
        writeFileSync(join(OUT, name), text);
        if (program)
          assert.equal(
            `error: ${words}`,
            native(["info", join(OUT, name)])
              .err.trim()
              .replace(OUT, ""),
          );
        assert.match(words, /not a STEP file/);
        assert.equal(await page.locator("#name").innerText(), CUBE);
        await page.locator("#dismiss").click();
      }
    });

    check("notes on a file are those of the program, and show their place", async () => {
      await dropFile(page, data(CTC));
      await settled(page, CTC);
      await page.locator("#notes-section summary").click();
      const notes = await page.locator("#notes li").allInnerTexts();
      if (program) {
        const { diagnostics } = JSON.parse(native(["info", "--json", data(CTC)]).out);
        assert.equal(notes.length, diagnostics.length);
        for (const [index, { severity, reason }] of diagnostics.entries()) {
          assert(notes[index].startsWith(severity) && notes[index].includes(reason), notes[index]);
        }
      }
      const before = await picture(page);
      await page.locator("#notes button").first().click();
      await settled(page, CTC);
      assert((await compare(session, before, await picture(page))).far > 0.001);
      assert.match((await rows(page, "picked")).entity, /^#\d+$/);
    });

    check("the triangles are saved as GLB", async () => {
      await dropFile(page, data(CUBE));
      await settled(page, CUBE);
      const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#download").click()]);
      assert.equal(download.suggestedFilename(), "red_cube_blue_cylinder.glb");
      const bytes = readFileSync(await download.path());
      assert.equal(bytes.toString("latin1", 0, 4), "glTF");
      assert.equal(bytes.readUInt32LE(8), bytes.length);
    });

    check("a large assembly is drawn", async () => {
      await drop(page, "large.step", large());
      await settled(page, "large.step", 120_000);
      const counts = await rows(page, "counts");
      assert.equal(number(counts.faces), 156 * number(counts.parts));
      assert(number(counts.parts) > 15 && number((await rows(page, "costs")).triangles) > 10_000);
      writeFileSync(join(OUT, `${gpu}-large.png`), await picture(page));
    });
  });
}
