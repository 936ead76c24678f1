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
export function read(source: Uint8Array | ArrayBuffer | Blob, options?: Options): Promise<Prepared>;
/**
 * Prepares a model that the module has built in.
 * @param {string} name One of `teapot`, `trimmed-teapot`, `brake-assembly` and so on.
 * @param {Options} [options]
 * @returns {Promise<Prepared>}
 */
export function sample(name: string, options?: Options): Promise<Prepared>;
/**
 * A file that has been read, in workers of its own. `close` returns their memory. Where there are Web Locks (pages that
 * come by https, or from this machine), calls are rejected once the browser has ended a worker.
 */
export class Prepared {
    /** Use `read` or `sample`. @param {Options} options */
    constructor({ signal, onProgress, workers }: Options);
    /** Called by `read` and `sample`. @param {Record<string, any>} what */
    open(what: Record<string, any>): Promise<void>;
    /** What was read. @returns {Info} */
    get info(): Info;
    /** Workers that share the parts. */
    get workers(): number;
    /** @param {Tolerance} [tolerance] @returns {Promise<Mesh>} */
    tessellate(tolerance?: Tolerance): Promise<Mesh>;
    /**
     * The triangles as binary glTF, with the bytes that the program writes.
     * @param {Tolerance} [tolerance]
     * @returns {Promise<Uint8Array>}
     */
    glb(tolerance?: Tolerance): Promise<Uint8Array>;
    /** Ends the workers and returns their memory. Meshes stay. */
    close(): void;
    #private;
}
/**
 * What was not understood, repaired or lost.
 */
export type Diagnostic = {
    severity: "note" | "warning" | "error";
    /**
     * Stable name of its kind.
     */
    code: string;
    text: string;
    /**
     * The mesh is not what the file states.
     */
    fault: boolean;
    part?: number;
    /**
     * Number within the part.
     */
    face?: number;
    /**
     * Number within the part.
     */
    edge?: number;
    /**
     * Number in the file.
     */
    entity?: number;
    /**
     * In the part's coordinates.
     */
    place?: [number, number, number];
};
/**
 * The triangles of a part.
 */
export type Part = {
    name: string;
    /**
     * What positions are relative to, in the part's coordinates.
     */
    centre: [number, number, number];
    /**
     * Three numbers a vertex.
     */
    positions: Float32Array;
    /**
     * Three numbers a vertex, of length 1, outwards.
     */
    normals: Float32Array;
    /**
     * Three vertices a triangle, counter-clockwise seen from outside.
     */
    indices: Uint32Array;
    /**
     * The face of each triangle: a number within the part.
     */
    faces: Uint32Array;
    /**
     *     Triangles by face, `start` and `count` in triangles, and the face's own colour, else the part's.
     */
    groups: {
        face: number;
        start: number;
        count: number;
        colour?: [number, number, number, number];
    }[];
    /**
     * Polylines, three numbers a point.
     */
    edges: {
        edge: number;
        points: Float32Array;
    }[];
};
/**
 * A part in its place.
 */
export type Instance = {
    name: string;
    part: number;
    /**
     * 16 numbers by columns, from the part's `positions` to the world.
     */
    transform: number[];
    colour?: [number, number, number, number];
    /**
     * What it stands in: an index into `assemblies` of the model's `info`.
     */
    assembly?: number;
};
export type Mesh = {
    parts: Part[];
    instances: Instance[];
    /**
     * Of reading, preparing and tessellating.
     */
    diagnostics: Diagnostic[];
    /**
     * Those of all parts, each counted once.
     */
    triangles: number;
    /**
     * Of positions, normals, indices, faces and edges: equal bytes, equal hash.
     */
    hash: string;
};
export type Tolerance = {
    /**
     * Largest distance between triangles and surface, millimetres.
     */
    chord?: number;
    /**
     * The same as a fraction of the model's diagonal. Default 1e-3, without `chord`.
     */
    chordRel?: number;
    /**
     * Largest turning of the normal across a lattice cell, degrees. Default 20.
     */
    angle?: number;
    /**
     * Longest diagonal of a lattice cell, millimetres.
     */
    maxEdge?: number;
};
export type Options = {
    /**
     * Name of the file, for messages.
     */
    name?: string;
    /**
     * Ends the work, at any time.
     */
    signal?: AbortSignal;
    /**
     * Workers that share the model's parts, 1 to 16; default 1. Each reads the file, has
     * memory of its own, and prepares and tessellates the parts that it owns. The mesh is the same, bit by bit. The
     * first one gathers it, so the parts of each may take an equal share of what one worker may use. Those that would
     * own none are ended. Pays for large files of many parts, where cores are idle.
     */
    workers?: number;
    /**
     * Tells, of
     * several workers, the earliest stage that any of them is in. `total` grows until all have begun it.
     */
    onProgress?: (stage: "read" | "prepare" | "tessellate", done: number, total: number) => void;
};
export type Info = {
    name: string;
    parts: {
        name: string;
        faces: number;
    }[];
    /**
     * What instances stand in. `parent` is an index into this
     * list, smaller than the assembly's own.
     */
    assemblies: {
        name: string;
        parent?: number;
    }[];
    faces: number;
    tiles: number;
    /**
     * Lowest and highest corner, in the world.
     */
    bounds?: [[number, number, number], [number, number, number]];
    diagonal: number;
    /**
     * Of reading and preparing.
     */
    diagnostics: Diagnostic[];
};
