/**
 * The page at a desktop's and a phone's width, light and dark, with a face picked: pictures to look at, in web/test/out.
 *
 *     node web/test/screenshots.mjs [FILE] [webgl2 | webgpu]
 */

import { basename, join } from "node:path";
import { OUT, data, dropFile, fresh, settled, start } from "./browser.mjs";

const [path = data("nist_ctc05.step"), gpu = "webgl2"] = process.argv.slice(2);
const name = path.startsWith("builtin:") ? path : basename(path);

for (const [device, viewport, deviceScaleFactor] of /** @type {const} */ ([
  ["desktop", { width: 1280, height: 800 }, 1],
  ["phone", { width: 390, height: 844 }, 2],
])) {
  for (const colorScheme of /** @type {const} */ (["light", "dark"])) {
    const session = await start(/** @type {"webgl2" | "webgpu"} */ (gpu), { viewport, deviceScaleFactor, colorScheme });
    const { page } = session;
    await fresh(session);
    if (path.startsWith("builtin:")) await page.locator(`#welcome [data-sample="${path}"]`).click();
    else await dropFile(page, path);
    await settled(page, name, 300_000);
    const box = await page.locator("#stage").boundingBox();
    if (box) await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    await page.waitForTimeout(500);
    await settled(page, name);
    const file = join(OUT, `${device}-${colorScheme}.png`);
    await page.screenshot({ path: file });
    console.log(file);
    await session.close();
  }
}
