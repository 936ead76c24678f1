/** An instance of the module in a worker of its own. Ending it returns its memory. */

/** @typedef {{ stage: "read" | "prepare" | "tessellate", done: number, total: number }} Progress */

export class Instance {
  /** @type {Worker} */ #worker;
  /** @type {Map<number, { resolve: (value: any) => void, reject: (error: unknown) => void }>} */ #calls = new Map();
  #next = 0;
  /** Why the worker has ended. @type {unknown} */ #ended;
  /** @type {(reason: unknown) => void} */ #lost;

  /**
   * @param {(progress: Progress) => void} onProgress
   * @param {(reason: unknown) => void} onLost The worker has ended by itself. Calls to it are rejected, too.
   */
  constructor(onProgress, onLost) {
    this.#lost = onLost;
    this.#worker = new Worker(new URL("trimtess-worker.js", import.meta.url), { type: "module", name: "trimtess" });
    this.#worker.onmessage = ({ data: { id, value, error, progress, lock } }) => {
      if (progress) onProgress(progress);
      else if (lock) this.#watch(lock);
      else {
        const call = this.#calls.get(id);
        this.#calls.delete(id);
        if (error === undefined) call?.resolve(value);
        else call?.reject(new Error(error));
      }
    };
    this.#worker.onerror = ({ message }) => this.#fail(new Error(message || "the worker could not be started"));
  }

  /** A worker holds a lock for as long as it lives: browsers tell nobody when they end one. @param {string} lock */
  #watch(lock) {
    navigator.locks.request(lock, () => this.#fail(new Error("the browser ended a worker")));
  }

  /** @param {unknown} reason */
  #fail(reason) {
    if (this.#ended !== undefined) return;
    this.end(reason);
    this.#lost(reason);
  }

  /**
   * @param {string} type @param {Record<string, any>} rest @param {Transferable[]} [transfer]
   * @returns {Promise<any>}
   */
  call(type, rest, transfer = []) {
    if (this.#ended !== undefined) return Promise.reject(this.#ended);
    return new Promise((resolve, reject) => {
      const id = this.#next++;
      this.#calls.set(id, { resolve, reject });
      this.#worker.postMessage({ ...rest, type, id }, transfer);
    });
  }

  /** Ends the worker, whatever it does. @param {unknown} reason What its calls are rejected with. */
  end(reason) {
    this.#ended ??= reason;
    this.#worker.terminate();
    for (const { reject } of this.#calls.values()) reject(reason);
    this.#calls.clear();
  }
}
