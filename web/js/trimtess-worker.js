/** The worker of `trimtess.js`: holds one prepared model and answers with typed arrays, which it hands over. */

import init, * as wasm from "./wasm/trimtess_web.js";

/** Least time between two messages of progress, milliseconds. */
const SPOKEN = 50;

/** @type {wasm.Prepared | undefined} */ let prepared;
let spoken = 0;

/** @param {"read" | "prepare" | "tessellate"} stage @param {number} done @param {number} total */
function report(stage, done, total) {
  const now = performance.now();
  if (now - spoken < SPOKEN && done < total) return;
  spoken = now;
  self.postMessage({ progress: { stage, done, total } });
}

/** @returns {wasm.Prepared} */
function model() {
  if (!prepared) throw new Error("nothing has been read");
  return prepared;
}

/** @param {import("./trimtess.js").Tolerance} tolerance In degrees. @returns {wasm.Mesh} */
function meshOf({ angle = 20, ...lengths }) {
  return model().tessellate({ ...lengths, angle: (angle * Math.PI) / 180 }, report);
}

/**
 * A matrix by columns, times a translation.
 * @param {ArrayLike<number>} matrix @param {ArrayLike<number>} by
 * @returns {number[]}
 */
function translated(matrix, by) {
  const product = Array.from(matrix);
  for (let row = 0; row < 4; row += 1) {
    product[12 + row] += matrix[row] * by[0] + matrix[4 + row] * by[1] + matrix[8 + row] * by[2];
  }
  return product;
}

/** @param {ReturnType<wasm.Mesh["part"]>} part @returns {import("./trimtess.js").Part} */
function partOf({ faces: groups, ...part }) {
  const faces = new Uint32Array(part.indices.length / 3);
  for (const { face, start, count } of groups) faces.fill(face, start, start + count);
  return { ...part, faces, groups };
}

/** @type {Record<string, (message: any) => Promise<any>>} */
const CALLS = {
  async open({ source, sample, name }) {
    await init();
    if (sample === undefined) {
      const refused = wasm.refusal(source.size ?? source.byteLength);
      if (refused) throw new Error(refused);
      const bytes =
        source instanceof Uint8Array
          ? source
          : new Uint8Array(source instanceof Blob ? await source.arrayBuffer() : source);
      prepared = wasm.read(bytes, name, report).prepare(report);
    } else {
      prepared = wasm.sample(sample).prepare(report);
    }
    const { instances, ...info } = prepared.info();
    return { ...info, diagnostics: prepared.diagnostics() };
  },

  async tessellate({ tolerance }) {
    const mesh = meshOf(tolerance);
    try {
      const parts = Array.from({ length: mesh.partCount() }, (_, part) => partOf(mesh.part(part)));
      const instances = mesh.instances().map(({ matrix, ...instance }) => ({
        ...instance,
        transform: translated(matrix, parts[instance.part].centre),
      }));
      return { parts, instances, diagnostics: mesh.diagnostics(), triangles: mesh.triangles(), hash: mesh.hash() };
    } finally {
      mesh.free();
    }
  },

  async glb({ tolerance }) {
    const mesh = meshOf(tolerance);
    try {
      return mesh.glb();
    } finally {
      mesh.free();
    }
  },
};

/**
 * The buffers in an answer, which are handed over rather than copied.
 * @param {any} value
 * @returns {Transferable[]}
 */
function buffers(value) {
  if (value instanceof Uint8Array) return [value.buffer];
  if (value.hash === undefined) return [];
  return value.parts.flatMap((/** @type {import("./trimtess.js").Part} */ part) =>
    [part.positions, part.normals, part.indices, part.faces, ...part.edges.map(({ points }) => points)].map(
      ({ buffer }) => buffer,
    ),
  );
}

self.onmessage = async ({ data: { id, type, ...rest } }) => {
  try {
    const value = await CALLS[type](rest);
    self.postMessage({ id, value }, { transfer: buffers(value) });
  } catch (error) {
    self.postMessage({ id, error: error instanceof Error ? error.message : String(error) });
  }
};
