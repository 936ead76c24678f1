/** Measures this engine on one file: reading, preparing, tessellating, and handing out typed arrays. */

import init, * as wasm from "/wasm/trimtess_web.js";
import { meshedFaces, openEdges } from "./measure.js";

self.onmessage = async ({ data: { url } }) => {
  try {
    await init();
    const bytes = new Uint8Array(await (await fetch(url)).arrayBuffer());
    const start = performance.now();
    const prepared = wasm.read(bytes, url).prepare();
    const mesh = prepared.tessellate({ chordRel: 1e-3 });
    const parts = Array.from({ length: mesh.partCount() }, (_, part) => mesh.part(part));
    const seconds = (performance.now() - start) / 1e3;

    const { diagonal, parts: stated } = prepared.info();
    const facts = parts.map(({ positions, indices, faces }) => ({
      open: openEdges({ positions, indices, faces: [] }),
      triangles: indices.length / 3,
      meshed: meshedFaces({ positions, indices, faces: faces.map(({ count }) => ({ first: 0, last: count - 1 })) }),
    }));
    const sum = {
      seconds,
      faces: 0,
      meshed: 0,
      triangles: 0,
      open: 0,
      chord: 1e-3 * diagonal,
      memory: wasm.memoryBytes(),
    };
    for (const { part } of mesh.instances()) {
      sum.faces += stated[part].faces;
      sum.meshed += facts[part].meshed;
      sum.triangles += facts[part].triangles;
      sum.open += facts[part].open;
    }
    self.postMessage(sum);
  } catch (error) {
    self.postMessage({ error: String(error) });
  }
};
