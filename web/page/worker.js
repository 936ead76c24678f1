/**
 * The worker of one file: reads it, prepares it, and draws it on the canvas that the page hands over. Messages come
 * from stage.js; main.js hears what is posted here. Long stages run in one go: the page ends them by ending the worker.
 */

import init, * as wasm from "./wasm/trimtess_web.js";

/** @typedef {import("./stage.js").Message} Message */
/** @typedef {import("./stage.js").Source} Source */
/** @typedef {import("./tree.js").TreeNode} TreeNode */
/** @typedef {{ colours: any, deviation: number, orthographic: boolean, edges: boolean, wireframe: boolean,
 *   backfaces: boolean, section: wasm.SectionSetting, dark: boolean }} Settings */

/** Colours behind the model, top and bottom, by colour scheme. */
const BACKGROUND = {
  light: [
    [0.97, 0.98, 0.99, 1],
    [0.83, 0.86, 0.9, 1],
  ],
  dark: [
    [0.14, 0.16, 0.18, 1],
    [0.08, 0.09, 0.1, 1],
  ],
};

/** What the stages do, in words. */
const STAGES = { read: "reading", prepare: "preparing", tessellate: "making triangles" };

/** Least time between two messages of progress, milliseconds. */
const SPOKEN = 100;

/** @type {wasm.Prepared | undefined} */ let prepared;
/** @type {wasm.Viewer | undefined} */ let viewer;
/** Where a device that was lost looked from. @type {Float64Array | undefined} */ let camera;
/** @type {Settings} */ let settings;
/** @type {[number, number]} */ let size = [1, 1];
let name = "";
/** What reading and preparing took. */
let seconds = 0;
let gpu = "";
/** @type {Set<number>} */ const hidden = new Set();
/** Number of the page's last message that the next picture has in it. */
let turn = 0;
let scheduled = false;
/** The page has said how large the picture is. */
let begun = false;
/** What starts: the module, and then the device. @type {{ module: Promise<void>, device: Promise<void> }} */
let starting;
/** When each step of opening ended, as milliseconds of the page's clock. @type {Record<string, number>} */
const moments = {};

/** @param {any} message @param {Transferable[]} [transfer] */
const post = (message, transfer = []) => self.postMessage(message, { transfer });
/** @param {unknown} error @returns {string} */
function wordsOf(error) {
  if (error instanceof WebAssembly.RuntimeError)
    return `stopped by a lack of memory or a defect of the program (${error.message})`;
  return error instanceof Error ? error.message : String(error);
}

// ---- Opening ----

/** Notes that a step of opening has ended. Workers and pages count time from different moments. @param {string} step */
const ended = (step) => (moments[step] = performance.timeOrigin + performance.now());

/** @param {string} words What it is done to. @returns {wasm.Progress} */
function reporter(words) {
  let last = 0;
  return (stage, done, total) => {
    const now = performance.now();
    if (now - last < SPOKEN) return;
    last = now;
    post({ type: "progress", words: `${STAGES[stage]} ${words}`, done: total > 0 ? done / total : undefined });
  };
}

/** @param {Source} source @returns {Promise<Uint8Array>} */
async function bytesOf(source) {
  if ("file" in source) {
    const refused = wasm.refusal(source.file.size);
    if (refused) throw new Error(refused);
    return new Uint8Array(await source.file.arrayBuffer());
  }
  if ("url" in source) {
    const response = await fetch(source.url);
    if (!response.ok) throw new Error(`the server says ${response.status}`);
    return new Uint8Array(await response.arrayBuffer());
  }
  throw new Error("nothing to read");
}

/**
 * Loads the module and opens the device. What a device lacks is told when a file is opened.
 * @param {Message} message
 */
function start({ canvas, compiled, gpu: kind, size: pixels, settings: wanted }) {
  [gpu, size, settings] = [kind, pixels, wanted];
  const module = load(compiled);
  const device = module.then(() => warm(canvas));
  starting = { module, device };
  // The page starts another worker for the next file: a network may be back by then.
  module.catch((error) => post({ type: "failed", message: wordsOf(error) }));
  device.then(
    () => post({ type: "ready" }),
    () => {},
  );
}

/**
 * Opens the device. Draws a small model before there is a file, so that the first picture finds code and shaders
 * compiled.
 * @param {OffscreenCanvas} canvas
 */
async function warm(canvas) {
  await attach(canvas);
  if (name === "" && viewer) {
    viewer.resize(size[0], size[1]);
    viewer.show(wasm.sample("washer").prepare());
    set(settings);
    viewer.step();
  }
  ended("device");
}

/** @param {WebAssembly.Module | undefined} compiled By another worker. */
async function load(compiled) {
  const url = new URL("wasm/trimtess_web_bg.wasm", import.meta.url);
  const fetched = async () => {
    const response = await fetch(url);
    if (!response.ok) throw new Error(`${url}: the server says ${response.status}`);
    return response;
  };
  // Servers that do not know the type of a module have it compiled once all of it is there.
  const whole = async () => WebAssembly.compile(await (await fetched()).arrayBuffer());
  const module = compiled ?? (await WebAssembly.compileStreaming(fetched()).catch(whole));
  await init({ module_or_path: module });
  if (!compiled) post({ type: "compiled", module });
  ended("module");
}

/** @param {Message} message */
async function open({ source, size: pixels, settings: wanted }) {
  [settings, size] = [wanted, pixels];
  name = "file" in source ? source.file.name : "url" in source ? source.name : `builtin:${source.builtin}`;
  const start = performance.now();
  try {
    post({ type: "progress", words: "starting" });
    await starting.module;
    const report = reporter(name);
    post({ type: "progress", words: `reading ${name}` });
    const model = "builtin" in source ? wasm.sample(source.builtin) : wasm.read(await bytesOf(source), name, report);
    ended("read");
    post({ type: "progress", words: `preparing ${name}` });
    prepared = model.prepare(report);
    ended("prepared");
  } catch (error) {
    post({ type: "failed", message: `${name}: ${wordsOf(error)}` });
    return;
  }
  seconds = (performance.now() - start) / 1e3;
  post({ type: "progress", words: "starting the graphics device" });
  try {
    await starting.device;
    // A device that was lost meanwhile is being replaced, which describes the model.
    describe();
  } catch (error) {
    post({ type: "failed", message: wordsOf(error) });
  }
}

/** Draws on a canvas from now on. @param {OffscreenCanvas} canvas */
async function attach(canvas) {
  const made = await wasm.Viewer.create(canvas, /** @type {any} */ (gpu));
  viewer = made;
  // WebGL tells nobody else.
  canvas.addEventListener("webglcontextlost", () => viewer === made && lose("the browser took it away"));
  // WebGPU tells those who ask, and a picture at rest asks nothing. Once the module has failed, there is nobody to ask.
  const asks = setInterval(() => {
    try {
      if (viewer === made && !isLost(made)) return;
    } catch {}
    clearInterval(asks);
  }, 500);
}

/** Shows the model in a picture of the present size. */
function begin() {
  if (!prepared || !viewer) return;
  viewer.resize(size[0], size[1]);
  viewer.show(prepared);
  if (camera) viewer.setCameraState(camera);
  set(settings);
  for (const instance of hidden) viewer.setVisible(instance, false);
  begun = true;
}

/** Tells the page of the model. */
function describe() {
  if (!prepared || !viewer) return;
  const info = prepared.info();
  const diagnostics = prepared.diagnostics();
  const { backend, name: device } = viewer.adapter();
  post({
    type: "loaded",
    name,
    counts: [
      ["parts", String(info.parts.length)],
      ["instances", String(info.instances.length)],
      ["faces", String(info.faces)],
      ["tiles", String(info.tiles)],
      ["diagonal", `${info.diagonal.toPrecision(6)} mm`],
      ["read in", `${seconds.toFixed(2)} s`],
      ["drawn by", `${backend === "webgpu" ? "WebGPU" : "WebGL 2"}${device ? `, ${device}` : ""}`],
    ],
    tree: treeOf(info),
    instances: info.instances.length,
    diagnostics: diagnostics.map(({ severity, code, text, shown }) => ({ severity, code, message: text, shown })),
    moments,
  });
  post({ type: "progress", words: `drawing ${name}` });
}

/**
 * The file's assemblies with what stands in them. Instances of one part that stand in one assembly share a node, unless
 * nothing else stands there.
 * @param {ReturnType<wasm.Prepared["info"]>} info
 * @returns {TreeNode[]}
 */
function treeOf({ parts, instances, assemblies }) {
  const root = assemblies.length;
  /** What stands in each assembly, and at last outside of all. */
  const standing = Array.from({ length: root + 1 }, () => ({
    assemblies: /** @type {number[]} */ ([]),
    places: /** @type {Map<number, number[]>} */ (new Map()),
  }));
  assemblies.forEach(({ parent }, row) => standing[parent ?? root].assemblies.push(row));
  instances.forEach(({ part, assembly }, instance) => {
    const { places } = standing[assembly ?? root];
    places.get(part)?.push(instance) ?? places.set(part, [instance]);
  });
  const total = (/** @type {TreeNode[]} */ nodes) => nodes.reduce((sum, { faces }) => sum + faces, 0);
  /** @param {number} row @returns {TreeNode[]} */
  const below = (row) => {
    const nodes = standing[row].assemblies.map((child) => {
      const children = below(child);
      return { name: assemblies[child].name, faces: total(children), children };
    });
    const { places } = standing[row];
    const alone = row !== root && nodes.length === 0 && places.size === 1;
    const placed = [...places].flatMap(([part, same]) => {
      const { name, faces } = parts[part];
      const title = name || `part ${part}`;
      if (same.length === 1) return { name: title, faces, instance: same[0], children: [] };
      const leaf = (/** @type {number} */ instance) => ({ name: instances[instance].name || title, faces, instance });
      const children = same.map((instance) => ({ ...leaf(instance), children: [] }));
      return alone ? children : { name: `${title} × ${same.length}`, faces: total(children), children };
    });
    return [...nodes, ...placed];
  };
  return below(root);
}

// ---- Pictures ----

/** Has a picture drawn soon. */
function draw() {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => {
    scheduled = false;
    drawNow();
  });
}

function drawNow() {
  if (!viewer || !begun) return;
  try {
    step(viewer, turn);
  } catch (error) {
    post({ type: "trouble", message: wordsOf(error) });
  }
}

/** @param {wasm.Viewer} viewer @param {number} seen */
function step(viewer, seen) {
  const start = performance.now();
  if (isLost(viewer)) return;
  const frame = viewer.step();
  post({
    type: "frame",
    turn: seen,
    again: frame.again,
    plan: frame.planMs,
    made: frame.makeMs,
    whole: performance.now() - start,
    tiles: frame.tiles,
    deferred: frame.deferred,
    drawn: frame.drawnTiles,
    triangles: frame.triangles,
    sent: frame.sentBytes,
    held: frame.heldBytes,
    memory: wasm.memoryBytes(),
    marker: frame.mark ?? null,
  });
  if (frame.again) draw();
}

/** Whether the device is lost; then gives it up. @param {wasm.Viewer} viewer */
function isLost(viewer) {
  const why = viewer.lost();
  if (why !== undefined) lose(why);
  return why !== undefined;
}

/** @param {string} message */
function lose(message) {
  // A viewer that has shown nothing looks nowhere yet.
  if (begun) camera = viewer?.cameraState() ?? camera;
  viewer = undefined;
  post({ type: "lost", message });
}

/** @param {Settings} wanted */
function set(wanted) {
  settings = wanted;
  viewer?.orthographic(settings.orthographic);
  viewer?.set({
    deviationPx: settings.deviation,
    colourBy: settings.colours,
    wireframe: settings.wireframe,
    edges: settings.edges,
    backfaces: settings.backfaces,
    section: settings.section,
    background: /** @type {any} */ (settings.dark ? BACKGROUND.dark : BACKGROUND.light),
  });
}

/** What the page sends without waiting for an answer. @type {Record<string, (message: Message) => void>} */
const ORDERS = {
  begin(message) {
    size = message.size;
    begin();
  },
  set: (message) => set(message.settings),
  resize(message) {
    size = message.size;
    viewer?.resize(size[0], size[1]);
  },
  press: ({ x, y }) => viewer?.press(x, y),
  orbit: ({ dx, dy }) => viewer?.orbit(dx, dy),
  pan: ({ x0, y0, x1, y1 }) => viewer?.pan(x0, y0, x1, y1),
  zoom: ({ x, y, factor }) => viewer?.zoom(x, y, factor),
  fit: ({ side }) => (side === "fit" ? viewer?.fit() : viewer?.side(side)),
  unpick: () => viewer?.unpick(),
  visible({ instances, visible }) {
    for (const instance of instances) {
      if (visible) hidden.delete(instance);
      else hidden.add(instance);
      viewer?.setVisible(instance, visible);
    }
  },
};

// ---- Questions ----

/** @param {wasm.Pick | undefined} picked */
const factsOf = (picked) => (picked ? { rows: picked.facts, instance: picked.instance } : null);

/** What the page asks and waits for. @type {Record<string, (message: Message) => Promise<any>>} */
const QUESTIONS = {
  async pick({ x, y }) {
    return factsOf(await viewer?.pick(x, y));
  },
  async "show-note"({ index }) {
    if (!prepared || !viewer?.showDiagnostic(index)) return null;
    const { code, part, face, entity } = prepared.diagnostics()[index];
    const rows = Object.entries({ note: code, part, face, entity: entity && `#${entity}` })
      .filter(([, value]) => value !== undefined)
      .map(([name, value]) => [name, String(value)]);
    return { rows, instance: prepared.info().instances.findIndex((instance) => instance.part === part) };
  },
  async glb() {
    if (!prepared) throw new Error("nothing is shown");
    const mesh = prepared.tessellate({ chordRel: 1e-3 });
    try {
      return { data: mesh.glb(), name: `${name.replace(/^builtin:|\.(step|stp|p21)$/gi, "")}.glb` };
    } finally {
      mesh.free();
    }
  },
};

/** @param {Message} message */
async function answer(message) {
  try {
    post({ type: "reply", id: message.id, value: await QUESTIONS[message.type](message) });
  } catch (error) {
    post({ type: "reply", id: message.id, error: wordsOf(error) });
  }
}

/** Goes on with a new canvas after the device was lost. @param {Message} message */
async function replace({ canvas }) {
  try {
    await attach(canvas);
    if (begun) begin();
    else describe();
  } catch (error) {
    lose(wordsOf(error));
  }
}

self.onmessage = async ({ data: message }) => {
  if (message.type === "start") start(message);
  else if (message.type === "open") await open(message);
  else if (message.type === "replace") await replace(message);
  else if (message.type in QUESTIONS) await answer(message);
  else ORDERS[message.type](message);
  turn = Math.max(turn, message.turn);
  // Busy browsers have long frames: the first picture does not wait for the next one.
  if (message.type === "begin") drawNow();
  else draw();
};
