/** What a page goes through in a day: many files, files too large, a lost graphics device, a narrow window. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, describe, test } from "node:test";
import { POLICY } from "../server.mjs";
import { ROOT, compare, data, dropFile, fresh, picture, resident, settled, start, workers } from "./browser.mjs";

const CUBE = "red_cube_blue_cylinder.step";
const CTC = "nist_ctc05.step";

describe("life", () => {
  /** @type {import("./browser.mjs").Session} */ let session;
  /** @type {import("playwright-core").Page} */ let page;
  before(async () => {
    session = await start("webgl2");
    page = session.page;
  });
  after(() => session.close());

  test("memory comes back: twenty files take no more than five", async () => {
    await fresh(session);
    const held = [];
    for (let file = 1; file <= 20; file += 1) {
      const name = file % 2 ? CTC : CUBE;
      await dropFile(page, data(name));
      await settled(page, name);
      await workers(page, 1);
      if (file % 5 === 0) {
        await page.requestGC();
        await page.waitForTimeout(1000);
        held.push({ file, renderer: await resident(session, "renderer"), device: await resident(session, "GPU") });
      }
    }
    const told = held
      .map(
        ({ file, renderer, device }) =>
          `after ${file} files ${(renderer / 1e6).toFixed(0)} and ${(device / 1e6).toFixed(0)} MB`,
      )
      .join(", ");
    console.log(`page and graphics process: ${told}`);
    const [first, last] = [held[0], held[held.length - 1]];
    assert(last.renderer < 1.3 * first.renderer && last.device < 1.3 * first.device, told);
  });

  test("a file too large for 32-bit memory is refused by its size, before it is read", async () => {
    await fresh(session);
    await page.evaluate(() => {
      const block = new Blob([new Uint8Array(64 << 20)]);
      const transfer = new DataTransfer();
      transfer.items.add(new File(Array(66).fill(block), "huge.step"));
      document.getElementById("drop")?.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true }));
    });
    await page.locator("#trouble").waitFor({ timeout: 5000 });
    assert.match(
      await page.locator("#trouble-words").innerText(),
      /^huge\.step: the file has 4429185024 bytes or more, the limit is \d+/,
    );
    await page.locator("#dismiss").click();
    await page.locator("#welcome").waitFor();
  });

  test("a phone's width has no sideways scrolling, and every control is in reach", async () => {
    await page.setViewportSize({ width: 360, height: 740 });
    await fresh(session);
    await dropFile(page, data(CTC));
    await settled(page, CTC);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert(wide <= 360, `${wide}`);
    for (const control of await page.locator("button:visible, input:visible, select:visible").all()) {
      await control.scrollIntoViewIfNeeded();
      const box = await control.boundingBox();
      assert(box && box.x >= 0 && box.x + box.width <= 361, await control.evaluate((element) => element.outerHTML));
    }
    await page.setViewportSize({ width: 900, height: 520 });
  });

  test("every control has a name", async () => {
    await fresh(session);
    await dropFile(page, data(CUBE));
    await settled(page, CUBE);
    const client = await session.context.newCDPSession(page);
    const { nodes } = await client.send("Accessibility.getFullAXTree");
    const controls = ["button", "checkbox", "combobox", "slider", "application", "progressbar"];
    const nameless = nodes.filter(
      ({ role, name, ignored }) => !ignored && controls.includes(role?.value) && !name?.value,
    );
    assert.deepEqual(
      nameless.map(({ role }) => role?.value),
      [],
    );
  });

  test("the page states the policy that the server sends", () => {
    const stated = /Content-Security-Policy" content="([^"]*)"/.exec(
      readFileSync(`${ROOT}/web/page/index.html`, "utf8"),
    );
    assert.equal(`${stated?.[1]}; frame-ancestors 'none'`, POLICY);
  });
});
