import { Instance as Module } from "./instance.js";

/**
 * STEP files to triangles, in workers.
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
 *     Triangles by face, `start` and `count` in triangles, and the face's own colour, else the part's.
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
 * @property {number} [maxEdge] Longest diagonal of a lattice cell, millimetres.
 */

/**
 * @typedef {object} Options
 * @property {string} [name] Name of the file, for messages.
 * @property {AbortSignal} [signal] Ends the work, at any time.
 * @property {number} [workers] Workers that share the model's parts, 1 to 16; default 1. Each reads the file, has
 *     memory of its own, and prepares and tessellates the parts that it owns. The mesh is the same, bit by bit. The
 *     first one gathers it, so the parts of each may take an equal share of what one worker may use. Those that would
 *     own none are ended. Pays for large files of many parts, where cores are idle.
 * @property {(stage: "read" | "prepare" | "tessellate", done: number, total: number) => void} [onProgress] Tells, of
 *     several workers, the earliest stage that any of them is in. `total` grows until all have begun it.
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
  return opened(options, { source, name: options.name ?? (source instanceof File ? source.name : "") });
}

/**
 * Prepares a model that the module has built in.
 * @param {string} name One of `teapot`, `trimmed-teapot`, `brake-assembly` and so on.
 * @param {Options} [options]
 * @returns {Promise<Prepared>}
 */
export async function sample(name, options = {}) {
  return opened(options, { sample: name });
}

/** @param {Options} options @param {Record<string, any>} what @returns {Promise<Prepared>} */
async function opened(options, what) {
  const prepared = new Prepared(options);
  try {
    await prepared.open(what);
  } catch (error) {
    prepared.close();
    throw error;
  }
  return prepared;
}

/** What workers do, in this order. */
const STAGES = /** @type {const} */ (["read", "prepare", "tessellate"]);

/**
 * A file that has been read, in workers of its own. `close` returns their memory. Where there are Web Locks (pages that
 * come by https, or from this machine), calls are rejected once the browser has ended a worker.
 */
export class Prepared {
  /** The first one gathers what the others make. @type {Module[]} */ #instances;
  /** Why the workers have ended. @type {unknown} */ #ended;
  /** Aborted once they have. */
  #deaf = new AbortController();
  /** @type {Info | null} */ #info = null;
  /** Number of the last mesh. */
  #meshes = 0;
  /**
   * What each worker has said last of each stage, up to the one that it is in. None of those that own no part.
   * @type {({ done: number, total: number }[] | undefined)[]}
   */
  #heard = [];

  /** Use `read` or `sample`. @param {Options} options */
  constructor({ signal, onProgress, workers = 1 }) {
    signal?.throwIfAborted();
    if (!(Number.isInteger(workers) && workers >= 1 && workers <= 16)) {
      throw new RangeError(`workers is ${workers}; it must be a whole number from 1 to 16`);
    }
    this.#heard = Array.from({ length: workers }, () => [{ done: 0, total: 0 }]);
    this.#instances = Array.from({ length: workers }, (_, row) => {
      /** @param {import("./instance.js").Progress} progress */
      const heard = (progress) => onProgress?.(...this.#progress(row, progress));
      return new Module(heard, (reason) => this.#end(reason));
    });
    // A signal that lives longer does not keep what was closed.
    signal?.addEventListener("abort", () => this.#end(signal.reason), { signal: this.#deaf.signal });
  }

  /**
   * The earliest stage that any worker is in, and how far all of them are with it.
   * @param {number} row @param {import("./instance.js").Progress} progress Of one of them.
   * @returns {["read" | "prepare" | "tessellate", number, number]}
   */
  #progress(row, { stage, done, total }) {
    const stages = this.#heard[row] ?? [];
    const known = STAGES.indexOf(stage);
    for (let before = stages.length; before < known; before += 1) stages[before] = { done: 0, total: 0 };
    stages[known] = { done, total };
    const all = this.#heard.filter((stages) => stages !== undefined);
    const earliest = Math.min(...all.map(({ length }) => length - 1));
    const sums = { done: 0, total: 0 };
    for (const stages of all) {
      sums.total += stages[earliest].total;
      sums.done += stages.length - 1 > earliest ? stages[earliest].total : stages[earliest].done;
    }
    return [STAGES[earliest], sums.done, sums.total];
  }

  /** Ends all workers: a model without some of its parts is none. @param {unknown} reason */
  #end(reason) {
    this.#deaf.abort();
    this.#ended ??= reason;
    for (const instance of this.#instances) instance.end(this.#ended);
  }

  /** Called by `read` and `sample`. @param {Record<string, any>} what */
  async open(what) {
    const shares = this.#instances.length;
    /** @type {(Info & { ofReading: number } | null)[]} */
    const opened = await Promise.all(
      this.#instances.map(async (instance, share) => {
        const info = await instance.call("open", { ...what, share, shares });
        if (!info) delete this.#heard[share];
        return info;
      }),
    );
    this.#instances = this.#instances.filter((instance, row) => {
      if (opened[row]) return true;
      instance.end(new Error("no part is left for this worker"));
      return false;
    });
    this.#info = merged(opened.filter((info) => info !== null));
  }

  /** What was read. @returns {Info} */
  get info() {
    if (!this.#info) throw new Error("the file has not been read");
    return this.#info;
  }

  /** Workers that share the parts. */
  get workers() {
    return this.#instances.length;
  }

  /** @param {Tolerance} [tolerance] @returns {Promise<Mesh>} */
  async tessellate(tolerance = {}) {
    const { told, mesh } = await this.#make("tessellate", tolerance);
    const diagnostics = [...(this.#info?.diagnostics ?? []), ...byPart(told)];
    return { ...mesh, diagnostics };
  }

  /**
   * The triangles as binary glTF, with the bytes that the program writes.
   * @param {Tolerance} [tolerance]
   * @returns {Promise<Uint8Array>}
   */
  async glb(tolerance = {}) {
    return (await this.#make("glb", tolerance)).mesh;
  }

  /**
   * Has all workers make their parts, and the first one gather them.
   * @param {"tessellate" | "glb"} kind @param {Tolerance} tolerance
   * @returns {Promise<{ told: Diagnostic[], mesh: any }>} What they tell of the parts, and what the first one makes.
   */
  async #make(kind, tolerance) {
    if (this.#ended !== undefined) throw this.#ended;
    const [first] = this.#instances;
    const mesh = this.#meshes++;
    const order = { mesh, tolerance, diagonal: this.info.diagonal };
    for (const stages of this.#heard) stages?.splice(0, STAGES.length, ...STAGES.map(() => ({ done: 0, total: 0 })));
    const made = await Promise.allSettled(
      this.#instances.map((instance, row) => instance.call("make", { ...order, keep: row === 0 })),
    );
    const failed = made.find((one) => one.status === "rejected");
    if (failed) {
      // What the first one has made is not wanted; it may be the one that failed.
      first.call("drop", { mesh }).catch(() => {});
      throw failed.reason;
    }
    const values = made.map((one) => /** @type {PromiseFulfilledResult<any>} */ (one).value);
    const parts = values.flatMap(({ parts }) => parts);
    const arrays = parts.flatMap((part) => Object.values(part).filter((value) => ArrayBuffer.isView(value)));
    const transfer = arrays.map(({ buffer }) => /** @type {ArrayBuffer} */ (buffer));
    return { told: values.flatMap(({ told }) => told), mesh: await first.call(kind, { mesh, parts }, transfer) };
  }

  /** Ends the workers and returns their memory. Meshes stay. */
  close() {
    this.#end(new Error("the file was closed"));
  }
}

/** @param {Diagnostic[]} told @returns {Diagnostic[]} */
const byPart = (told) => told.toSorted((one, other) => (one.part ?? -1) - (other.part ?? -1));

/**
 * What several workers know of the parts that each of them owns.
 * @param {(Info & { ofReading: number })[]} all
 * @returns {Info}
 */
function merged(all) {
  const [{ ofReading, ...first }, ...others] = all;
  if (others.length === 0) return first;
  const boxes = all.flatMap(({ bounds }) => (bounds ? [bounds] : []));
  /** @param {0 | 1} corner @returns {[number, number, number]} */
  const outermost = (corner) => {
    const most = corner === 0 ? Math.min : Math.max;
    const along = (/** @type {number} */ axis) => most(...boxes.map((box) => box[corner][axis]));
    return [along(0), along(1), along(2)];
  };
  const [low, high] = [outermost(0), outermost(1)];
  const [x, y, z] = [high[0] - low[0], high[1] - low[1], high[2] - low[2]];
  const told = others.flatMap((info) => info.diagnostics.slice(ofReading).filter(({ part }) => part !== undefined));
  return {
    ...first,
    tiles: all.reduce((sum, { tiles }) => sum + tiles, 0),
    bounds: boxes.length ? [low, high] : undefined,
    diagonal: boxes.length ? Math.sqrt(x * x + y * y + z * z) : 0,
    diagnostics: [
      ...first.diagnostics.slice(0, ofReading),
      ...byPart([...first.diagnostics.slice(ofReading), ...told]),
    ],
  };
}
