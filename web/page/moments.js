/**
 * When the steps of opening a file ended, as marks of `performance`: `trimtess:opened` (the file was dropped or
 * chosen), `module` (the WebAssembly module runs), `read`, `prepared`, `device` (the graphics device runs),
 * `first-picture` and `final-picture`. Those of pictures have `detail`: `triangles` of the picture, and `deferred`
 * tiles that get finer in later ones. Opening another file removes the marks of the last one.
 */

/** @param {string} step */
const nameOf = (step) => `trimtess:${step}`;
const STEPS = ["opened", "module", "read", "prepared", "device", "first-picture", "final-picture"];

/** Pictures that have been marked since a file was opened. @type {Set<string>} */
const marked = new Set();
/** Number of files that have been opened. */
let files = 0;

/** Marks that a file was dropped or chosen. */
export function markOpening() {
  files += 1;
  marked.clear();
  for (const step of STEPS) performance.clearMarks(nameOf(step));
  performance.mark(nameOf("opened"));
}

/**
 * Marks what the worker does before the first picture. It tells so again after it has lost a graphics device.
 * @param {Record<string, number>} moments
 */
export function markSteps(moments) {
  for (const [step, time] of Object.entries(moments)) {
    performance.clearMarks(nameOf(step));
    performance.mark(nameOf(step), { startTime: Math.max(0, time - performance.timeOrigin) });
  }
}

/**
 * Marks a picture that the worker has drawn.
 * @param {{ triangles: number, deferred: number }} picture
 * @param {boolean} still Nothing more is to come.
 */
export function markPicture({ triangles, deferred }, still) {
  const of = files;
  for (const step of still ? ["first-picture", "final-picture"] : ["first-picture"]) {
    if (marked.has(step)) continue;
    marked.add(step);
    // The first callback comes before the browser shows the picture, the second one after that.
    requestAnimationFrame(() =>
      requestAnimationFrame(() => of === files && performance.mark(nameOf(step), { detail: { triangles, deferred } })),
    );
  }
}
