// @ts-check
// A worker: one engine, one job after the other.
import { Engine } from "./engine.js";

/** @type {Promise<Engine> | undefined} */
let engine;

self.onmessage = async ({ data }) => {
  if (data.code) {
    engine = Engine.make(data.code);
    return;
  }
  try {
    const ready = /** @type {Engine} */ (await engine);
    if (data.job === "seek") self.postMessage({ id: data.id, found: ready.seek(data.row, data.symmetry) });
    else self.postMessage({ id: data.id, runs: data.rows.map((/** @type {Float64Array} */ row) => ready.run(row, data.interval)) });
  } catch (error) {
    self.postMessage({ id: data.id, error: String(error) });
  }
};
