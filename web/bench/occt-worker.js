/** Measures occt-import-js on one file: reading and tessellating, to arrays. */

import { meshedFaces, openEdges } from "./measure.js";

const FOLDER = "/node_modules/occt-import-js/dist/";

/** The package is a script of the old kind, which a module worker cannot import. */
async function load() {
  const text = await (await fetch(`${FOLDER}occt-import-js.js`)).text();
  const make = new Function(`${text}; return occtimportjs;`)();
  return make({ locateFile: (/** @type {string} */ file) => FOLDER + file });
}

self.onmessage = async ({ data: { url, chord } }) => {
  try {
    const occt = await load();
    const bytes = new Uint8Array(await (await fetch(url)).arrayBuffer());
    const start = performance.now();
    const result = occt.ReadStepFile(bytes, {
      linearUnit: "millimeter",
      linearDeflectionType: "absolute_value",
      linearDeflection: chord,
      angularDeflection: (20 * Math.PI) / 180,
    });
    const seconds = (performance.now() - start) / 1e3;
    if (!result.success) throw new Error("refused");

    const sum = { seconds, faces: 0, meshed: 0, triangles: 0, open: 0 };
    for (const { attributes, index, brep_faces: faces } of result.meshes) {
      const solid = { positions: attributes.position.array, indices: index.array, faces };
      sum.faces += faces.length;
      sum.meshed += meshedFaces(solid);
      sum.triangles += index.array.length / 3;
      sum.open += openEdges(solid);
    }
    self.postMessage(sum);
  } catch (error) {
    self.postMessage({ error: String(error) });
  }
};
