/** A worker of `instance.js`: holds a share of one prepared model, and answers with typed arrays that it hands over. */

import init, * as wasm from "./wasm/trimtess_web.js";

/** Least time between two messages of progress, milliseconds. */
const SPOKEN = 50;

/** @type {wasm.Prepared | undefined} */ let prepared;
/** Meshes that wait for the parts of other workers. @type {Map<number, wasm.Mesh>} */ const meshes = new Map();
let spoken = 0;

/** @param {"read" | "prepare" | "tessellate"} stage @param {number} done @param {number} total */
function report(stage, done, total) {
  const now = performance.now();
  if (now - spoken < SPOKEN && done < total) return;
  spoken = now;
  self.postMessage({ progress: { stage, done, total } });
}

/**
 * Takes a mesh that waits, with the parts of other workers, has it used, and frees it.
 * @template T
 * @param {{ mesh: number, parts: wasm.SharedPart[] }} order @param {(mesh: wasm.Mesh) => T} use @returns {T}
 */
function gathered({ mesh: number, parts }, use) {
  const mesh = meshes.get(number);
  if (!mesh) throw new Error(`there is no mesh ${number}`);
  try {
    for (const part of parts) mesh.gather(part);
    mesh.complete();
    return use(mesh);
  } finally {
    meshes.delete(number);
    mesh.free();
  }
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

/** @param {{ source: any, sample?: string, name: string }} order @returns {Promise<wasm.Model>} */
async function modelOf({ source, sample, name }) {
  if (sample !== undefined) return wasm.sample(sample);
  const refused = wasm.refusal(source.size ?? source.byteLength);
  if (refused) throw new Error(refused);
  const bytes = source instanceof Blob ? await source.arrayBuffer() : source;
  return wasm.read(bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes), name, report);
}

/** @type {Record<string, (message: any) => any>} */
const CALLS = {
  async open({ share, shares, ...order }) {
    await init();
    const model = await modelOf(order);
    if (shares > 1 && !model.keepShare(share, shares) && share > 0) return null;
    prepared = model.prepare(report);
    const { instances, ...info } = prepared.info();
    return { ...info, diagnostics: prepared.diagnostics(), ofReading: prepared.ofReading() };
  },

  /** Makes the parts of this worker: keeps them for those of others, or hands them over. */
  make({ mesh: number, tolerance, diagonal, keep }) {
    if (!prepared) throw new Error("nothing has been read");
    const mesh = prepared.tessellate(tolerance, report, diagonal);
    const told = mesh.diagnostics();
    if (keep) {
      meshes.set(number, mesh);
      return { told, parts: [] };
    }
    try {
      return { told, parts: mesh.share() };
    } finally {
      mesh.free();
    }
  },

  drop({ mesh: number }) {
    meshes.get(number)?.free();
    meshes.delete(number);
  },

  tessellate: (order) =>
    gathered(order, (mesh) => {
      const parts = Array.from({ length: mesh.partCount() }, (_, part) => partOf(mesh.part(part)));
      const instances = mesh.instances().map(({ matrix, ...instance }) => ({
        ...instance,
        transform: translated(matrix, parts[instance.part].centre),
      }));
      return { parts, instances, triangles: mesh.triangles(), hash: mesh.hash() };
    }),

  glb: (order) => gathered(order, (mesh) => mesh.glb()),
};

/**
 * The buffers in an answer, which are handed over rather than copied.
 * @param {any} value
 * @returns {Transferable[]}
 */
function buffers(value) {
  if (value instanceof Uint8Array) return [value.buffer];
  const arrays = (value?.parts ?? []).flatMap((/** @type {Record<string, any>} */ part) => [
    ...Object.values(part),
    ...(part.edges instanceof Array ? part.edges.map(({ points }) => points) : []),
  ]);
  return arrays.filter(ArrayBuffer.isView).map((/** @type {ArrayBufferView} */ { buffer }) => buffer);
}

self.onmessage = async ({ data: { id, type, ...rest } }) => {
  try {
    const value = await CALLS[type](rest);
    self.postMessage({ id, value }, { transfer: buffers(value) });
  } catch (error) {
    self.postMessage({ id, error: error instanceof Error ? error.message : String(error) });
  }
};

// Pages that come neither by https nor from this machine have no locks. There, a worker that the browser ends is not
// noticed.
const lock = `trimtess ${Math.random()} ${performance.timeOrigin} ${performance.now()}`;
navigator.locks?.request(lock, () => {
  self.postMessage({ lock });
  return new Promise(() => {});
});
