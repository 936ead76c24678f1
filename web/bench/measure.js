/** Counts that hold for any mesh of any engine, so that both are measured by the same ruler. */

/**
 * @typedef {{ positions: ArrayLike<number>, indices: ArrayLike<number>,
 *   faces: { first: number, last: number }[] }} Solid
 *     `faces` are ranges of triangles, `last` included; a range whose last is before its first has none.
 */

/**
 * Edges of triangles that no other triangle of the solid uses the other way round. Vertices are one where their
 * coordinates, rounded to single precision, have the same bits; triangles with two corners in one place are left out.
 * @param {Solid} solid
 * @returns {number}
 */
export function openEdges({ positions, indices }) {
  const single = Float32Array.from(positions, (coordinate) => coordinate + 0);
  const bits = new Uint32Array(single.buffer);
  /** @type {Map<string, number>} */
  const places = new Map();
  const corner = new Uint32Array(single.length / 3);
  for (let vertex = 0; vertex < corner.length; vertex += 1) {
    const key = `${bits[3 * vertex]},${bits[3 * vertex + 1]},${bits[3 * vertex + 2]}`;
    const known = places.get(key);
    corner[vertex] = known ?? places.size;
    if (known === undefined) places.set(key, places.size);
  }
  /** @type {Map<number, number>} */
  const uses = new Map();
  for (let first = 0; first < indices.length; first += 3) {
    const [a, b, c] = [corner[indices[first]], corner[indices[first + 1]], corner[indices[first + 2]]];
    if (a === b || b === c || c === a) continue;
    for (const [from, to] of [
      [a, b],
      [b, c],
      [c, a],
    ]) {
      const key = from < to ? from * places.size + to : to * places.size + from;
      uses.set(key, (uses.get(key) ?? 0) + (from < to ? 1 : -1));
    }
  }
  let open = 0;
  for (const balance of uses.values()) open += Math.abs(balance);
  return open;
}

/** Faces that have triangles. @param {Solid} solid @returns {number} */
export const meshedFaces = ({ faces }) => faces.filter(({ first, last }) => last >= first).length;
