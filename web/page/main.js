/** The page: opens files, forwards hands and settings to the worker that shows one, and writes down what it says. */

import { listen, movement } from "./gestures.js";
import { markOpening, markPicture, markSteps } from "./moments.js";
import { Stage } from "./stage.js";
import { bytes, element, fill, milliseconds, thousands } from "./text.js";
import { Tree } from "./tree.js";

/** @typedef {import("./stage.js").Source} Source */
/** @typedef {import("./stage.js").Message} Message */

/** How often a lost graphics device is replaced within a while, milliseconds, before the page gives up. */
const [RECOVERIES, RECENT] = [3, 60_000];

/** @template {HTMLElement} [T=HTMLElement] @param {string} id @returns {T} */
const at = (id) => /** @type {T} */ (document.getElementById(id));
const view = at("stage");
const dark = matchMedia("(prefers-color-scheme: dark)");
const gpu = new URLSearchParams(location.search).get("gpu") ?? "";

/** @type {Stage | null} */ let shown = null;
/** @type {Stage | null} */ let loading = null;
/** Started with the page: the first file finds the module and the graphics device running. @type {Stage | null} */
let idle = null;
/** When the graphics device was lost. @type {number[]} */
let losses = [];
/** Nothing more is to come of the last picture. */
let still = true;
let startedAt = 0;
let words = "";
/** What the worker said of the model that was read last. @type {Message | null} */
let model = null;

const tree = new Tree(at("tree"), (instances, visible) => send({ type: "visible", instances, visible }));

/** @returns {[number, number]} */
const size = () => [
  Math.max(1, Math.round(view.clientWidth * devicePixelRatio)),
  Math.max(1, Math.round(view.clientHeight * devicePixelRatio)),
];

/** Sends a message to the model that is shown. @param {Message} message */
function send(message) {
  shown?.send(message);
  still = shown === null;
  busy();
}

/** Asks the model that is shown about a face. @param {string} type @param {Record<string, any>} rest */
function ask(type, rest) {
  if (!shown) return;
  still = false;
  busy();
  shown.call(type, rest).then(facts, complain);
}

// ---- Files ----

/** Tells assistive software, and tests, whether the picture is still going to change. */
function busy() {
  view.setAttribute("aria-busy", String(loading !== null || !still));
}

/** Ends the file that is being read. What was shown before stays. */
function cancel() {
  loading?.end();
  loading = null;
  busy();
  at("progress").hidden = true;
  at("welcome").hidden = shown !== null;
  at("panel").hidden = shown === null;
}

/** @param {number | undefined} done Part that is done, 0 to 1, if known. */
function progress(done) {
  const bar = /** @type {HTMLProgressElement} */ (at("bar"));
  if (done === undefined) bar.removeAttribute("value");
  else bar.value = done;
  tick();
}

/** Tells what is being done, and for how long. */
function tick() {
  at("stage-words").textContent = words;
  at("seconds").textContent = `${((performance.now() - startedAt) / 1e3).toFixed(0)} s`;
}
setInterval(() => loading && tick(), 500);

/** Shows an error, or hides it. @param {string | null} text */
function tell(text) {
  at("trouble").hidden = text === null;
  at("trouble-words").textContent = text;
}

/** @param {Stage} stage @param {Message} message */
function heard(stage, message) {
  if (stage === idle) {
    // Tests wait for it.
    if (message.type === "ready") {
      view.dataset.device = "ready";
      return;
    }
    // The first file starts another one, and tells what is wrong.
    stage.end();
    idle = null;
    return;
  }
  switch (message.type) {
    case "progress":
      words = message.words;
      progress(message.done);
      break;
    case "loaded":
      // The panel takes its room before the first picture, which is made for what is left.
      model = message;
      markSteps(message.moments);
      at("panel").hidden = false;
      stage.send({ type: "begin", size: size() });
      break;
    case "failed":
    case "trouble":
      if (stage === loading) cancel();
      tell(message.message);
      break;
    case "frame":
      if (stage === loading) swap(stage);
      still = !message.again && message.turn === stage.turn;
      busy();
      if (!loading) markPicture(/** @type {any} */ (message), still);
      mark(message.marker);
      fill(at("costs"), costs(message));
      break;
    case "lost":
      recover(stage, message.message);
      break;
  }
}

/** Shows a model that has its first picture in place of the last one. @param {Stage} stage */
function swap(stage) {
  shown?.end();
  [shown, loading] = [stage, null];
  cancel();
  stage.show();
  if (model) describe(model);
}

/** Goes on with a new graphics device. @param {Stage} stage @param {string} reason */
function recover(stage, reason) {
  const now = performance.now();
  losses = [...losses.filter((time) => now - time < RECENT), now];
  if (losses.length > RECOVERIES) {
    if (stage === loading) cancel();
    tell(`The graphics device was lost: ${reason}. Open the file again to go on.`);
    return;
  }
  still = false;
  busy();
  // The browser takes a moment to start its graphics process again.
  setTimeout(() => (stage === shown || stage === loading) && stage.replaceCanvas(), 300 * losses.length);
}

const start = () => new Stage(view, { gpu, size: size(), settings: settings() }, heard);

/** Opens a model. What is shown stays until it has been read. @param {Source} source */
function open(source) {
  loading?.end();
  tell(null);
  markOpening();
  startedAt = performance.now();
  words = "starting";
  at("welcome").hidden = true;
  at("progress").hidden = false;
  progress(undefined);
  loading = idle ?? start();
  idle = null;
  loading.open(source, { size: size(), settings: settings() });
  busy();
}

/** Writes down what the worker says of a model that it has read. @param {Message} model */
function describe(model) {
  document.body.classList.add("has-model");
  document.title = `${model.name} – trimtess`;
  at("name").textContent = model.name;
  /** @type {HTMLButtonElement} */ (at("download")).disabled = false;
  fill(at("counts"), model.counts);
  tree.fill(model.tree);
  at("parts-count").textContent = thousands(model.instances);
  facts(null);
  notes(model.diagnostics);
}

/** @param {Message} frame @returns {[string, string][]} */
function costs(frame) {
  return [
    ["plan", milliseconds(frame.plan)],
    ["tiles made", `${thousands(frame.tiles)} in ${milliseconds(frame.made)}`],
    ["picture", `${thousands(frame.drawn)} tiles in ${milliseconds(frame.whole)}`],
    ["triangles", thousands(frame.triangles)],
    ["sent", bytes(frame.sent)],
    ["held", bytes(frame.held)],
    ["memory of the module", bytes(frame.memory)],
  ];
}

/** @param {[number, number] | null} place In pixels of the canvas. */
function mark(place) {
  const marker = at("marker");
  marker.hidden = !place;
  if (place) marker.style.transform = `translate(${place[0] / devicePixelRatio}px, ${place[1] / devicePixelRatio}px)`;
}

// ---- Facts ----

/** @param {{ rows: [string, string][], instance: number } | null} picked */
function facts(picked) {
  at("unpick").hidden = !picked;
  at("pick-hint").hidden = !!picked;
  fill(at("picked"), picked?.rows ?? []);
  tree.pick(picked?.instance ?? null);
}

/** @param {{ severity: string, code: string, message: string, shown: boolean }[]} diagnostics */
function notes(diagnostics) {
  at("notes-count").textContent = diagnostics.length ? thousands(diagnostics.length) : "none";
  const section = /** @type {HTMLDetailsElement} */ (at("notes-section"));
  section.open = diagnostics.some((note) => note.severity !== "note");
  const items = diagnostics.slice(0, 500).map((note, index) => {
    const severity = element("span", { class: `severity ${note.severity}` }, note.severity);
    const item = element("li", {}, severity, ` ${note.message} `);
    item.title = note.code;
    if (note.shown) {
      const show = element("button", { type: "button", class: "small" }, "Show me");
      show.onclick = () => ask("show-note", { index });
      item.append(show);
    }
    return item;
  });
  if (diagnostics.length > items.length) {
    items.push(element("li", {}, `and ${thousands(diagnostics.length - items.length)} more`));
  }
  at("notes").replaceChildren(...items);
}

/** @param {Error} error */
const complain = (error) => tell(error.message);

// ---- Settings ----

const choices = ["orthographic", "edges", "wireframe", "backfaces"];
/** @param {string} id */
const box = (id) => /** @type {HTMLInputElement} */ (at(id));
const deviation = () => 10 ** Number(box("deviation").value);

function settings() {
  return {
    ...Object.fromEntries(choices.map((id) => [id, box(id).checked])),
    colours: box("colours").value,
    deviation: deviation(),
    section: { axis: box("section").value, share: Number(box("share").value), flipped: box("flipped").checked },
    dark: dark.matches,
  };
}

function set() {
  const pixels = deviation();
  const text = pixels < 1 ? pixels.toFixed(2) : pixels.toFixed(1);
  at("deviation-value").textContent = `${text} px`;
  box("deviation").setAttribute("aria-valuetext", `${text} pixels`);
  const percent = Math.round(100 * Number(box("share").value));
  at("share-value").textContent = `${percent} %`;
  box("share").setAttribute("aria-valuetext", `${percent} percent`);
  at("cut").hidden = box("section").value === "none";
  send({ type: "set", settings: settings() });
  loading?.send({ type: "set", settings: settings() });
}

for (const id of [...choices, "colours", "deviation", "section", "share", "flipped"]) box(id).addEventListener("input", set);
dark.addEventListener("change", set);

const SIDES = ["front", "back", "left", "right", "top", "bottom", "iso"];
at("sides").replaceChildren(
  ...[...SIDES, "fit"].map((side, index) => {
    const button = element("button", { type: "button", title: `key ${index < 7 ? index + 1 : "F"}` }, side);
    button.onclick = () => from(side);
    return button;
  }),
);

/** @param {string} side A name in SIDES, or "fit" for the present side. */
const from = (side) => send({ type: "fit", side });

/** @returns {Promise<void>} */
async function download() {
  if (!shown) return;
  const button = /** @type {HTMLButtonElement} */ (at("download"));
  button.disabled = true;
  try {
    const { data, name } = await shown.call("glb");
    const url = URL.createObjectURL(new Blob([data], { type: "model/gltf-binary" }));
    element("a", { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), 60_000);
  } catch (error) {
    complain(/** @type {Error} */ (error));
  } finally {
    button.disabled = false;
  }
}

// ---- Hands ----

/** @type {import("./gestures.js").Hands} */
const hands = {
  press: (x, y) => send({ type: "press", x, y }),
  orbit: (dx, dy) => send({ type: "orbit", dx, dy }),
  pan: (x0, y0, x1, y1) => send({ type: "pan", x0, y0, x1, y1 }),
  zoom: (x, y, factor) => send({ type: "zoom", x, y, factor }),
  pick: (x, y) => ask("pick", { x, y }),
};
listen(view, hands);

function unpick() {
  send({ type: "unpick" });
  facts(null);
}

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const target = /** @type {HTMLElement} */ (event.target);
  if (target.closest("select, input[type=range]")) return;
  if (event.key === "Escape") {
    if (loading) cancel();
    else unpick();
    return;
  }
  if (target === view) {
    const move = movement(event, size());
    if (move) {
      event.preventDefault();
      move(hands);
      return;
    }
  }
  const key = event.key.toLowerCase();
  const choice = { o: "orthographic", e: "edges", w: "wireframe", b: "backfaces" }[key];
  if (choice) {
    box(choice).checked = !box(choice).checked;
    set();
  } else if (key === "c" || key === "s") {
    const list = /** @type {HTMLSelectElement} */ (at(key === "c" ? "colours" : "section"));
    list.selectedIndex = (list.selectedIndex + 1) % list.length;
    set();
  } else if (key === "f") {
    from("fit");
  } else if (/^[1-7]$/.test(key)) {
    from(SIDES[Number(key) - 1]);
  }
});

const main = at("drop");
document.addEventListener("dragover", (event) => {
  event.preventDefault();
  main.classList.add("dragging");
});
document.addEventListener("dragleave", (event) => {
  if (!event.relatedTarget) main.classList.remove("dragging");
});
document.addEventListener("drop", (event) => {
  event.preventDefault();
  main.classList.remove("dragging");
  const file = event.dataTransfer?.files[0];
  if (file) open({ file });
});

box("file").addEventListener("change", () => {
  const file = box("file").files?.[0];
  if (file) open({ file });
  // The same file can be chosen again.
  box("file").value = "";
});
for (const button of document.querySelectorAll("[data-sample]")) {
  const sample = /** @type {HTMLElement} */ (button).dataset.sample ?? "";
  const builtin = sample.startsWith("builtin:") ? sample.slice("builtin:".length) : null;
  button.addEventListener("click", () => open(builtin ? { builtin } : { url: `samples/${sample}`, name: sample }));
}
at("cancel").onclick = cancel;
at("dismiss").onclick = () => tell(null);
at("unpick").onclick = unpick;
at("download").onclick = download;
const resized = () => {
  send({ type: "resize", size: size() });
  loading?.send({ type: "resize", size: size() });
};
new ResizeObserver(resized).observe(view);
// A screen of another pixel ratio does not change the size of the element.
const onNextRatio = () =>
  matchMedia(`(resolution: ${devicePixelRatio}dppx)`).addEventListener(
    "change",
    () => {
      resized();
      onNextRatio();
    },
    { once: true },
  );
onNextRatio();
idle = start();
