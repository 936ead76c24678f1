/**
 * A file on the screen: one worker, which reads it and draws it, and the canvas that the worker draws to.
 * A stage shows one file, and may be started before there is one. Ending it returns all of its memory: that of the
 * worker, of the module, and of the device.
 */

/**
 * @typedef {{ file: File } | { url: string, name: string } | { builtin: string }} Source Where a model comes from.
 * @typedef {{ type: string } & Record<string, any>} Message
 */

/** What the first worker has compiled, for later ones. @type {WebAssembly.Module | undefined} */
let compiled;

export class Stage {
  /** @type {Worker} */ #worker;
  /** @type {HTMLElement} */ #parent;
  /** @type {Map<number, { resolve: (value: any) => void, reject: (error: Error) => void }>} */ #calls = new Map();
  #nextCall = 0;
  /** Number of the last message sent. */
  turn = 0;
  #ended = false;

  /**
   * Starts a worker, which loads the module and opens a graphics device.
   * @param {HTMLElement} parent Element that the canvas is put into, hidden until `show`.
   * @param {{ gpu: string, size: [number, number], settings: Record<string, any> }} options
   * @param {(stage: Stage, message: Message) => void} heard Called for every message of the worker.
   */
  constructor(parent, options, heard) {
    this.#parent = parent;
    this.#worker = new Worker(new URL("worker.js", import.meta.url), { type: "module", name: "trimtess" });
    this.#worker.onmessage = ({ data }) => {
      if (this.#ended) return;
      if (data.type === "reply") this.#reply(data);
      else if (data.type === "compiled") compiled = data.module;
      else heard(this, data);
    };
    this.#worker.onerror = (event) => {
      event.preventDefault();
      if (!this.#ended) heard(this, { type: "failed", message: event.message || "the worker could not be started" });
    };
    this.canvas = this.#hand({ type: "start", compiled, ...options });
    this.canvas.className = "waiting";
  }

  /**
   * Has the worker read a source.
   * @param {Source} source
   * @param {{ size: [number, number], settings: Record<string, any> }} options
   */
  open(source, options) {
    this.send({ type: "open", source, ...options });
  }

  /** Makes a canvas and sends it to the worker with a message. @param {Message} message @returns {HTMLCanvasElement} */
  #hand(message) {
    const made = document.createElement("canvas");
    this.#parent.prepend(made);
    const canvas = made.transferControlToOffscreen();
    this.turn += 1;
    this.#worker.postMessage({ ...message, canvas, turn: this.turn }, [canvas]);
    return made;
  }

  /** Gives the worker a new canvas, and with it a new graphics device. */
  replaceCanvas() {
    const old = this.canvas;
    this.canvas = this.#hand({ type: "replace" });
    this.canvas.className = old.className;
    old.remove();
  }

  /** @param {Message} reply */
  #reply({ id, value, error }) {
    const call = this.#calls.get(id);
    this.#calls.delete(id);
    if (error === undefined) call?.resolve(value);
    else call?.reject(new Error(error));
  }

  /** Sends a message. The frame that has it in it tells its number. @param {Message} message */
  send(message) {
    this.turn += 1;
    this.#worker.postMessage({ ...message, turn: this.turn });
  }

  /**
   * Sends a message and waits for the answer.
   * @param {string} type
   * @param {Record<string, any>} [rest]
   * @returns {Promise<any>}
   */
  call(type, rest = {}) {
    const id = this.#nextCall++;
    return new Promise((resolve, reject) => {
      this.#calls.set(id, { resolve, reject });
      this.send({ ...rest, type, id });
    });
  }

  /** Makes the canvas visible. */
  show() {
    this.canvas.classList.remove("waiting");
  }

  /** Stops the worker, whatever it is doing, and removes the canvas. */
  end() {
    this.#ended = true;
    this.#worker.terminate();
    this.canvas.remove();
    for (const { reject } of this.#calls.values()) reject(new Error("the file was closed"));
    this.#calls.clear();
  }
}
