/** The JavaScript interface for other pages, and the example that uses it. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { OUT, ROOT, compare, data, native, program, start, workers } from "./browser.mjs";

const CUBE = "red_cube_blue_cylinder.step";
const CTC = "nist_ctc05.step";

describe("interface", () => {
  /** @type {import("./browser.mjs").Session} */ let session;
  /** @type {import("playwright-core").Page} */ let page;
  before(async () => {
    session = await start("webgl2");
    page = session.page;
    await page.route("**/data/*", (route) =>
      route.fulfill({ path: data(/[^/]*$/.exec(route.request().url())?.[0] ?? "") }),
    );
    await page.goto(`${session.url}examples/three.html`);
  });
  after(async () => {
    await session.close();
    assert.deepEqual(session.troubles, []);
    assert.deepEqual(session.foreign, []);
  });

  for (const input of [CUBE, CTC]) {
    test(`${input} has the bytes of the program`, async (context) => {
      if (!program) return context.skip("the program has not been built");
      const output = join(OUT, "native.glb");
      const run = native(["-q", "tessellate", data(input), "-o", output, "--chord-rel", "1e-3", "--angle", "20"]);
      assert([0, 3].includes(run.status), run.err);
      const text = await page.evaluate(async (input) => {
        // @ts-ignore: served by the test's server.
        const trimtess = await import("/trimtess.js");
        const prepared = await trimtess.read(await (await fetch(`/data/${input}`)).blob(), { name: input });
        const glb = await prepared.glb({ chordRel: 1e-3, angle: 20 });
        prepared.close();
        return btoa(Array.from(glb, (/** @type {number} */ byte) => String.fromCharCode(byte)).join(""));
      }, input);
      assert(Buffer.from(text, "base64").equals(readFileSync(output)));
    });
  }

  test("meshes are sound typed arrays, with a face for each triangle", async () => {
    const facts = await page.evaluate(async (input) => {
      // @ts-ignore: served by the test's server.
      const trimtess = await import("/trimtess.js");
      /** @type {string[]} */
      const stages = [];
      const bytes = new Uint8Array(await (await fetch(`/data/${input}`)).arrayBuffer());
      const prepared = await trimtess.read(bytes, {
        name: input,
        onProgress: (/** @type {string} */ stage) => stages.push(stage),
      });
      const mesh = await prepared.tessellate({ chordRel: 1e-3, angle: 20 });
      const again = await prepared.tessellate({ chordRel: 1e-3, angle: 20 });
      const finer = await prepared.tessellate({ chordRel: 1e-4, angle: 10 });
      const { info } = prepared;
      prepared.close();
      let [low, high] = [
        [Infinity, Infinity, Infinity],
        [-Infinity, -Infinity, -Infinity],
      ];
      for (const { part, transform: m } of mesh.instances) {
        const { positions: p } = mesh.parts[part];
        for (let k = 0; k < p.length; k += 3) {
          const at = [0, 1, 2].map(
            (row) => m[row] * p[k] + m[4 + row] * p[k + 1] + m[8 + row] * p[k + 2] + m[12 + row],
          );
          low = low.map((value, axis) => Math.min(value, at[axis]));
          high = high.map((value, axis) => Math.max(value, at[axis]));
        }
      }
      const parts = mesh.parts.map((/** @type {any} */ { positions, normals, indices, faces, groups, edges }) => ({
        arrays: [positions, normals, indices, faces].map((array) => array.constructor.name),
        lengths: positions.length === normals.length && indices.length === 3 * faces.length,
        inside: indices.every((/** @type {number} */ index) => index < positions.length / 3),
        unit: normals.every(
          (/** @type {number} */ _, /** @type {number} */ k) =>
            k % 3 || Math.abs(Math.hypot(normals[k], normals[k + 1], normals[k + 2]) - 1) < 1e-3,
        ),
        faces: new Set(faces).size,
        groups: groups.length,
        edges: edges.length,
      }));
      return {
        stages: [...new Set(stages)],
        parts,
        info,
        low,
        high,
        hash: mesh.hash,
        again: again.hash,
        finer: finer.triangles,
        triangles: mesh.triangles,
        counted: mesh.parts.reduce((/** @type {number} */ sum, /** @type {any} */ part) => sum + part.faces.length, 0),
        notes: mesh.diagnostics.length,
      };
    }, CTC);
    const [part] = facts.parts;
    assert.deepEqual(part.arrays, ["Float32Array", "Float32Array", "Uint32Array", "Uint32Array"]);
    assert(part.lengths && part.inside && part.unit);
    assert.equal(part.faces, 156);
    assert.equal(part.edges, 331);
    assert.equal(facts.counted, facts.triangles);
    assert(facts.finer > facts.triangles);
    assert.match(facts.hash, /^[0-9a-f]{16}$/);
    assert.equal(facts.hash, facts.again);
    assert(facts.stages.includes("read") && facts.stages.includes("tessellate"), facts.stages.join());
    assert(facts.notes >= facts.info.diagnostics.length && facts.info.diagnostics.length === 4);
    const { bounds } = facts.info;
    assert(bounds);
    for (const [axis, value] of [...facts.low, ...facts.high].entries()) {
      const stated = bounds[axis < 3 ? 0 : 1][axis % 3];
      assert(Math.abs(value - stated) < 1.5, `corner ${axis}: ${value}, the model's box: ${stated}`);
    }
  });

  test("a number of the file that JavaScript does not have is left out", async () => {
    const told = await page.evaluate(async () => {
      // @ts-ignore: served by the test's server.
      const trimtess = await import("/trimtess.js");
      const face = (/** @type {string} */ id) => `#${id}=ADVANCED_FACE('',(),#3,.T.);`;
      const text = `ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');
        FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;${face("9007199254740991")}${face("9007199254740993")}
        ENDSEC;END-ISO-10303-21;`;
      const prepared = await trimtess.read(new TextEncoder().encode(text));
      const { diagnostics } = prepared.info;
      prepared.close();
      const faces = diagnostics.filter((/** @type {any} */ row) => row.code === "step-face-left-out");
      return faces.map((/** @type {any} */ row) => row.entity);
    });
    assert.deepEqual(told, [9007199254740991, undefined]);
  });

  test("what cannot be done is told, and an abort ends the worker", async () => {
    const seen = await page.evaluate(async (input) => {
      // @ts-ignore: served by the test's server.
      const trimtess = await import("/trimtess.js");
      const words = (/** @type {Promise<any>} */ promise) =>
        promise.then(
          () => "done",
          (error) => String(error.message ?? error),
        );
      const bytes = new Uint8Array(await (await fetch(`/data/${input}`)).arrayBuffer());
      const controller = new AbortController();
      const aborted = words(trimtess.read(bytes, { signal: controller.signal }));
      controller.abort(new Error("enough"));
      const prepared = await trimtess.read(bytes);
      const result = {
        broken: await words(trimtess.read(new TextEncoder().encode("no STEP file"))),
        aborted: await aborted,
        before: await words(trimtess.read(bytes, { signal: AbortSignal.abort(new Error("too late")) })),
        zero: await words(prepared.tessellate({ chord: 0 })),
        nan: await words(prepared.tessellate({ angle: NaN })),
        negative: await words(prepared.tessellate({ angle: -20 })),
        sample: await words(trimtess.sample("no such model")),
      };
      prepared.close();
      return { ...result, closed: await words(prepared.tessellate()) };
    }, CTC);
    assert.match(seen.broken, /not a STEP file/);
    assert.equal(seen.aborted, "enough");
    assert.equal(seen.before, "too late");
    assert.equal(seen.negative, "angle is -20; it must be a finite number above 0");
    assert.equal(seen.closed, "the file was closed");
    for (const words of [seen.zero, seen.nan, seen.sample]) assert(words !== "done" && words.length > 10, words);
    await workers(page, 0);
  });

  test("the three.js example draws a file, and tells the face that is clicked", async () => {
    const before = await page.locator("canvas").screenshot();
    await page.locator("input").setInputFiles(data(CUBE));
    await page.waitForFunction(() => document.querySelector("output")?.value === "Click a face.", undefined, {
      timeout: 10_000,
    });
    let far = 0;
    for (let wait = 0; wait < 50 && far < 0.05; wait += 1) {
      await page.waitForTimeout(200);
      ({ far } = await compare(
        session,
        before,
        await page.locator("canvas").screenshot({ path: join(OUT, "three.png") }),
      ));
    }
    assert(far >= 0.05, `${far}`);
    const box = await page.locator("canvas").boundingBox();
    assert(box);
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    assert.match(await page.locator("output").innerText(), /^face \d+ of /);
  });

  test("the package has what its list says, and the version of the library", () => {
    const stated = JSON.parse(readFileSync(join(ROOT, "web/js/package.json"), "utf8"));
    assert.equal(stated.version, /^version = "(.*)"$/m.exec(readFileSync(join(ROOT, "Cargo.toml"), "utf8"))?.[1]);
    const [{ files }] = JSON.parse(
      execFileSync("npm", ["pack", "--dry-run", "--json"], { cwd: join(ROOT, "web/dist"), stdio: "pipe" }).toString(),
    );
    const names = files.map((/** @type {{ path: string }} */ { path }) => path);
    for (const name of [
      "trimtess.js",
      "trimtess.d.ts",
      "trimtess-worker.js",
      "instance.js",
      "wasm/trimtess_web.js",
      "wasm/trimtess_web_bg.wasm",
    ]) {
      assert(names.includes(name), name);
    }
  });
});
