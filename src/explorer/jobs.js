// @ts-check
// Work in other threads: one worker for the collision at hand, as many as cores for a map.

/** @typedef {import("./engine.js").Run} Run */

/** A run that takes longer than this gives way to a newer one, ms. */
const PATIENCE = 300;
const BATCH = 4;

/** @type {{code: Uint8Array, url: string} | undefined} */
let sources;

/** @param {Uint8Array} code of the engine @param {string} script of the worker */
export function prepareWorkers(code, script) {
  sources = { code, url: URL.createObjectURL(new Blob([script], { type: "text/javascript" })) };
}

/** @param {(message: string) => void} onTrouble */
function newWorker(onTrouble) {
  if (!sources) throw new Error("prepareWorkers must come first");
  const worker = new Worker(sources.url);
  worker.onerror = (event) => onTrouble(event.message || "the worker could not be started");
  worker.postMessage({ code: sources.code });
  return worker;
}

/** One worker that always works on the newest job; those between are dropped. */
export class Newest {
  /** @param {(message: string) => void} onTrouble */
  constructor(onTrouble) {
    this.onTrouble = onTrouble;
    this.worker = newWorker(onTrouble);
    this.id = 0;
    this.begun = 0;
    this.busy = false;
    /** @type {{message: any, done: (data: any) => void} | undefined} */
    this.waiting = undefined;
    /** @type {((data: any) => void) | undefined} */
    this.done = undefined;
  }

  /**
   * @param {any} message @param {(data: any) => void} done not called if a newer job comes first
   */
  ask(message, done) {
    this.waiting = { message, done };
    if (!this.busy) return this.#next();
    const spent = performance.now() - this.begun;
    setTimeout(() => this.#giveWay(), Math.max(0, PATIENCE - spent));
  }

  #giveWay() {
    if (!this.busy || !this.waiting || performance.now() - this.begun < PATIENCE) return;
    this.worker.terminate();
    this.worker = newWorker(this.onTrouble);
    this.#next();
  }

  #next() {
    const job = this.waiting;
    this.waiting = undefined;
    this.busy = job !== undefined;
    if (!job) return;
    const id = ++this.id;
    this.begun = performance.now();
    this.worker.onmessage = ({ data }) => {
      if (data.id !== id) return;
      const newer = this.waiting !== undefined;
      this.#next();
      if (data.error) this.onTrouble(data.error);
      // What was asked for is shown even while something newer is computed: the picture follows the hand.
      else job.done({ ...data, newer });
    };
    this.worker.postMessage({ ...job.message, id });
  }
}

/**
 * Run many rows on all cores.
 * @param {Float64Array[]} rows
 * @param {(index: number, run: Run) => void} onRun
 * @param {(message: string) => void} onTrouble
 * @returns {{done: Promise<boolean>, cancel: () => void}} whether all were run
 */
export function runAll(rows, onRun, onTrouble) {
  const count = Math.max(1, Math.min(navigator.hardwareConcurrency || 2, rows.length));
  const workers = Array.from({ length: count }, () => newWorker((message) => stop(message)));
  let next = 0;
  let open = rows.length;
  /** @type {(whole: boolean) => void} */
  let finish;
  const done = new Promise((resolve) => (finish = resolve));
  /** @param {string} message */
  function stop(message) {
    workers.forEach((worker) => worker.terminate());
    if (message) onTrouble(message);
    finish(open === 0);
  }
  /** @param {Worker} worker */
  function feed(worker) {
    if (next >= rows.length) return;
    const first = next;
    next = Math.min(rows.length, next + BATCH);
    worker.postMessage({ job: "run", id: first, rows: rows.slice(first, next), interval: 0 });
  }
  for (const worker of workers) {
    worker.onmessage = ({ data }) => {
      if (data.error) return stop(data.error);
      feed(worker);
      data.runs.forEach((/** @type {Run} */ run, /** @type {number} */ k) => onRun(data.id + k, run));
      open -= data.runs.length;
      if (!open) stop("");
    };
    feed(worker);
    feed(worker); // one in hand, one waiting: no worker idles between two batches
  }
  if (!rows.length) stop("");
  return { done, cancel: () => stop("") };
}
