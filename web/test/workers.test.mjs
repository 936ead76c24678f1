/** A model whose parts are shared by several workers, each with an instance of the module. */

import assert from "node:assert/strict";
import { after, before, describe, test } from "node:test";
import { data, large, resident, start, workers } from "./browser.mjs";

describe("several workers", () => {
  /** @type {import("./browser.mjs").Session} */ let session;
  /** @type {import("playwright-core").Page} */ let page;
  before(async () => {
    session = await start("webgl2");
    page = session.page;
    const copies = large(3e6);
    await page.route("**/data/copies.step", (route) => route.fulfill({ body: copies }));
    await page.route("**/data/one.step", (route) => route.fulfill({ path: data("nist_ctc05.step") }));
    await page.goto(`${session.url}examples/three.html`);
    await page.evaluate(async () => {
      const global = /** @type {any} */ (window);
      // @ts-ignore: served by the test's server.
      global.trimtess = await import("/trimtess.js");
      global.fetched = async (/** @type {string} */ name) =>
        new Uint8Array(await (await fetch(`/data/${name}`)).arrayBuffer());
      global.words = (/** @type {Promise<any>} */ promise) =>
        promise.then(
          () => "done",
          (error) => String(error.message ?? error),
        );
    });
  });
  after(async () => {
    await session.close();
    assert.deepEqual(session.troubles, []);
    assert.deepEqual(session.foreign, []);
  });

  test("the mesh, the file, the diagnostics and the facts are those of one worker", async () => {
    const [one, ...others] = await page.evaluate(async () => {
      const { trimtess, fetched } = /** @type {any} */ (window);
      const digest = async (/** @type {Uint8Array<ArrayBuffer>} */ bytes) =>
        Array.from(new Uint8Array(await crypto.subtle.digest("SHA-256", bytes))).join();
      const bytes = await fetched("copies.step");
      const all = [];
      for (const workers of [1, 2, 3, 16]) {
        const prepared = await trimtess.read(bytes, { name: "copies.step", workers });
        // Two at once, with tolerances of their own.
        const [mesh, glb] = await Promise.all([
          prepared.tessellate({ chordRel: 1e-3 }),
          prepared.glb({ chordRel: 2e-3, angle: 30 }),
        ]);
        const { hash, triangles, diagnostics, instances, parts } = mesh;
        const arrays = parts.flatMap((/** @type {any} */ { positions, normals, indices, faces, edges }) => [
          positions,
          normals,
          indices,
          faces,
          ...edges.map((/** @type {any} */ { points }) => points),
        ]);
        const joined = new Uint8Array(await new Blob(arrays).arrayBuffer());
        all.push({
          workers: prepared.workers,
          facts: {
            ...{ hash, triangles, diagnostics, instances, info: prepared.info },
            ...{ parts: parts.map((/** @type {any} */ { name, centre, groups }) => ({ name, centre, groups })) },
            ...{ arrays: await digest(joined), glb: await digest(glb) },
          },
        });
        prepared.close();
      }
      return all;
    });
    assert.equal(one.workers, 1);
    assert(one.facts.info.parts.length >= 3 && one.facts.triangles > 10_000 && one.facts.diagnostics.length >= 8);
    // No worker stays that owns no part.
    assert.deepEqual(
      others.map(({ workers }) => workers),
      [2, 3, Math.min(16, one.facts.info.parts.length)],
    );
    for (const { facts } of others) assert.deepEqual(facts, one.facts);
    await workers(page, 0);
  });

  test("stages follow each other, whichever worker is ahead", async () => {
    const seen = await page.evaluate(async () => {
      const { trimtess, fetched } = /** @type {any} */ (window);
      /** @type {[string, number, number][]} */
      const seen = [];
      const onProgress = (/** @type {[string, number, number]} */ ...told) => seen.push(told);
      const prepared = await trimtess.read(await fetched("copies.step"), { workers: 3, onProgress });
      await prepared.tessellate();
      await prepared.tessellate({ chordRel: 5e-4 });
      prepared.close();
      return seen;
    });
    const stages = seen.map(([stage]) => stage).filter((stage, row, all) => stage !== all[row - 1]);
    assert.deepEqual(stages, ["read", "prepare", "tessellate"]);
    for (const [stage, done, total] of seen) assert(done <= total, `${stage}: ${done} of ${total}`);
    for (const stage of ["read", "prepare", "tessellate"]) {
      const most = Math.max(...seen.filter(([name]) => name === stage).map(([, done]) => done));
      assert(most > 0, `${stage}: ${most}`);
    }
  });

  test("one part has one worker, and files have one unless told", async () => {
    const counts = await page.evaluate(async () => {
      const { trimtess, fetched } = /** @type {any} */ (window);
      const counts = [];
      for (const [name, workers] of [["one.step", 3], ["copies.step"]]) {
        const prepared = await trimtess.read(await fetched(name), { workers });
        counts.push(prepared.workers);
        prepared.close();
      }
      return counts;
    });
    assert.deepEqual(counts, [1, 1]);
    await workers(page, 0);
  });

  test("a refused file, a wrong number, a bad tolerance and an abort are told, and no worker stays", async () => {
    const seen = await page.evaluate(async () => {
      const { trimtess, fetched, words } = /** @type {any} */ (window);
      const bytes = await fetched("copies.step");
      const told = [];
      told.push(await words(trimtess.read(new TextEncoder().encode("no STEP file"), { workers: 3 })));
      for (const workers of [0, 1.5, 17, NaN]) told.push(await words(trimtess.read(bytes, { workers })));
      const reading = new AbortController();
      const stop = () => reading.abort(new Error("enough"));
      told.push(await words(trimtess.read(bytes, { workers: 3, signal: reading.signal, onProgress: stop })));
      const making = new AbortController();
      const prepared = await trimtess.read(bytes, {
        workers: 3,
        signal: making.signal,
        onProgress: (/** @type {string} */ stage) => stage === "tessellate" && making.abort(new Error("no more")),
      });
      told.push(await words(prepared.tessellate({ chord: -1 })));
      told.push(await words(prepared.tessellate({ chordRel: 1e-4 })));
      return told;
    });
    assert.match(seen[0], /not a STEP file/);
    for (const words of seen.slice(1, 5)) assert.match(words, /^workers is .* from 1 to 16$/);
    assert.equal(seen[5], "enough");
    assert.match(seen[6], /^chord is -1/);
    assert.equal(seen[7], "no more");
    await workers(page, 0);
  });

  test("a worker that dies is told, and all of the model goes", async () => {
    await page.evaluate(async () => {
      const global = /** @type {any} */ (window);
      global.prepared = await global.trimtess.read(await global.fetched("copies.step"), { workers: 3 });
    });
    await workers(page, 3);
    const victim = page.workers()[1];
    const words = page.evaluate(() => {
      const { prepared, words } = /** @type {any} */ (window);
      return words(new Promise((resolve) => setTimeout(resolve, 1000)).then(() => prepared.tessellate()));
    });
    await victim.evaluate(() => self.close());
    assert.equal(await words, "the browser ended a worker");
    await workers(page, 0);
  });

  test("a worker that dies at work ends the call", async () => {
    await page.evaluate(async () => {
      const global = /** @type {any} */ (window);
      global.prepared = await global.trimtess.read(await global.fetched("copies.step"), { workers: 2 });
    });
    await workers(page, 2);
    const words = page.evaluate(() => {
      const { prepared, words } = /** @type {any} */ (window);
      return words(prepared.tessellate({ chordRel: 1e-6, angle: 1 }));
    });
    await page.workers()[1].evaluate(() => self.close());
    assert.match(await words, /^the browser ended a worker$/);
    await workers(page, 0);
  });

  test("memory of several workers comes back", async () => {
    const held = [];
    for (let round = 0; round < 6; round += 1) {
      await page.evaluate(async () => {
        const { trimtess, fetched } = /** @type {any} */ (window);
        const prepared = await trimtess.read(await fetched("copies.step"), { workers: 3 });
        await prepared.tessellate();
        prepared.close();
      });
      await workers(page, 0);
      await page.requestGC();
      await page.waitForTimeout(500);
      held.push(await resident(session, "renderer"));
    }
    const told = held.map((size) => (size / 1e6).toFixed(0)).join(", ");
    assert(held[5] < 1.3 * held[1], `MB after each round: ${told}`);
  });
});
