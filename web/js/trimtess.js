/**
 * STEP files to triangles, in a worker.
 *
 *     import * as trimtess from "./trimtess.js";
 *     const prepared = await trimtess.read(bytes);
 *     const mesh = await prepared.tessellate({ chordRel: 1e-3, angle: 20 });
 *     prepared.close();
 *
 * Lengths are millimetres, angles degrees. Errors have the words of the program. Nothing is sent anywhere: the module
 * is fetched from where this file is, and nothing else is.
 */

/**
 * @typedef {object} Diagnostic What was not understood, repaired or lost.
 * @property {"note" | "warning" | "error"} severity
 * @property {string} code Stable name of its kind.
 * @property {string} text
 * @property {boolean} fault The mesh is not what the file states.
 * @property {number} [part]
 * @property {number} [face] Number within the part.
 * @property {number} [edge] Number within the part.
 * @property {number} [entity] Number in the file.
 * @property {[number, number, number]} [place] In the part's coordinates.
 */

/**
 * @typedef {object} Part The triangles of a part.
 * @property {string} name
 * @property {[number, number, number]} centre What positions are relative to, in the part's coordinates.
 * @property {Float32Array} positions Three numbers a vertex.
 * @property {Float32Array} normals Three numbers a vertex, of length 1, outwards.
 * @property {Uint32Array} indices Three vertices a triangle, counter-clockwise seen from outside.
 * @property {Uint32Array} faces The face of each triangle: a number within the part.
 * @property {{ face: number, start: number, count: number, colour?: [number, number, number, number] }[]} groups
 *     Triangles by face, `start` and `count` in triangles, and the face's own colour.
 * @property {{ edge: number, points: Float32Array }[]} edges Polylines, three numbers a point.
 */

/**
 * @typedef {object} Instance A part in its place.
 * @property {string} name
 * @property {number} part
 * @property {number[]} transform 16 numbers by columns, from the part's `positions` to the world.
 * @property {[number, number, number, number]} [colour]
 * @property {number} [assembly] What it stands in: an index into `assemblies` of the model's `info`.
 */

/**
 * @typedef {object} Mesh
 * @property {Part[]} parts
 * @property {Instance[]} instances
 * @property {Diagnostic[]} diagnostics Of reading, preparing and tessellating.
 * @property {number} triangles Those of all parts, each counted once.
 * @property {string} hash Of positions, normals, indices, faces and edges: equal bytes, equal hash.
 */

/**
 * @typedef {object} Tolerance
 * @property {number} [chord] Largest distance between triangles and surface, millimetres.
 * @property {number} [chordRel] The same as a fraction of the model's diagonal. Default 1e-3, without `chord`.
 * @property {number} [angle] Largest turning of the normal across a lattice cell, degrees. Default 20.
 * @property {number} [maxEdge] Longest side of a lattice cell, millimetres.
 */

/**
 * @typedef {object} Options
 * @property {string} [name] Name of the file, for messages.
 * @property {AbortSignal} [signal] Ends the work, at any time.
 * @property {(stage: "read" | "prepare" | "tessellate", done: number, total: number) => void} [onProgress]
 */

/**
 * @typedef {object} Info
 * @property {string} name
 * @property {{ name: string, faces: number }[]} parts
 * @property {{ name: string, parent?: number }[]} assemblies What instances stand in. `parent` is an index into this
 *     list, smaller than the assembly's own.
 * @property {number} faces
 * @property {number} tiles
 * @property {[[number, number, number], [number, number, number]]} [bounds] Lowest and highest corner, in the world.
 * @property {number} diagonal
 * @property {Diagnostic[]} diagnostics Of reading and preparing.
 */

/**
 * Reads and prepares a STEP file.
 * @param {Uint8Array | ArrayBuffer | Blob} source
 * @param {Options} [options]
 * @returns {Promise<Prepared>}
 */
export async function read(source, options = {}) {
  const prepared = new Prepared(options);
  try {
    await prepared.open({ source, name: options.name ?? (source instanceof File ? source.name : "") });
  } catch (error) {
    prepared.close();
    throw error;
  }
  return prepared;
}

/**
 * Prepares a model that the module has built in.
 * @param {string} name One of `teapot`, `trimmed-teapot`, `brake-assembly` and so on.
 * @param {Options} [options]
 * @returns {Promise<Prepared>}
 */
export async function sample(name, options = {}) {
  const prepared = new Prepared(options);
  try {
    await prepared.open({ sample: name });
  } catch (error) {
    prepared.close();
    throw error;
  }
  return prepared;
}

/** A file that has been read, in a worker of its own. `close` returns its memory. */
export class Prepared {
  /** @type {Worker} */ #worker;
  /** @type {Map<number, { resolve: (value: any) => void, reject: (error: unknown) => void }>} */ #calls = new Map();
  #next = 0;
  /** Why the worker has ended. @type {unknown} */ #ended;
  /** @type {Info | null} */ #info = null;

  /** Use `read` or `sample`. @param {Options} options */
  constructor({ signal, onProgress }) {
    signal?.throwIfAborted();
    this.#worker = new Worker(new URL("trimtess-worker.js", import.meta.url), { type: "module", name: "trimtess" });
    this.#worker.onmessage = ({ data: { id, value, error, progress } }) => {
      if (progress) {
        onProgress?.(progress.stage, progress.done, progress.total);
        return;
      }
      const call = this.#calls.get(id);
      this.#calls.delete(id);
      if (error === undefined) call?.resolve(value);
      else call?.reject(new Error(error));
    };
    this.#worker.onerror = ({ message }) => this.#end(new Error(message || "the worker could not be started"));
    signal?.addEventListener("abort", () => this.#end(signal.reason), { once: true });
  }

  /** @param {string} type @param {Record<string, any>} rest @returns {Promise<any>} */
  #call(type, rest) {
    if (this.#ended !== undefined) return Promise.reject(this.#ended);
    return new Promise((resolve, reject) => {
      const id = this.#next++;
      this.#calls.set(id, { resolve, reject });
      this.#worker.postMessage({ ...rest, type, id });
    });
  }

  /** @param {unknown} reason */
  #end(reason) {
    this.#worker.terminate();
    for (const { reject } of this.#calls.values()) reject(reason);
    this.#calls.clear();
    this.#ended ??= reason;
  }

  /** Called by `read` and `sample`. @param {Record<string, any>} what */
  async open(what) {
    this.#info = await this.#call("open", what);
  }

  /** What was read. @returns {Info} */
  get info() {
    if (!this.#info) throw new Error("the file has not been read");
    return this.#info;
  }

  /** @param {Tolerance} [tolerance] @returns {Promise<Mesh>} */
  tessellate(tolerance = {}) {
    return this.#call("tessellate", { tolerance });
  }

  /**
   * The triangles as binary glTF, with the bytes that the program writes.
   * @param {Tolerance} [tolerance]
   * @returns {Promise<Uint8Array>}
   */
  glb(tolerance = {}) {
    return this.#call("glb", { tolerance });
  }

  /** Ends the worker and returns its memory. Meshes stay. */
  close() {
    this.#end(new Error("the file was closed"));
  }
}
