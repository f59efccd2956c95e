// @ts-check
// The compiled engine behind its C interface (engine.cpp): one collision at a time.

/**
 * A collision as it went: outlines at equal intervals, in flat arrays.
 *
 * Droplet k of all frames has `INFO` numbers from k * INFO in `info`, and its vertices x, y from
 * 2 * first[k] in `vertices`; frame f holds the droplets from frames[f] to frames[f + 1].
 * @typedef {{times: Float64Array, frames: Int32Array, first: Int32Array, info: Float64Array,
 *   vertices: Float32Array}} Recording
 *
 * @typedef {{time: number, droplet: number, symmetry: number, impact: number, speed: number, x: number,
 *   y: number, vx: number, vy: number}} Contact
 *
 * @typedef {{time: number, droplet: number, daughters: number[], areas: number[], neck: number,
 *   ends: number[]}} Breakup
 *
 * @typedef {{fault: string, row: Float64Array, result: Record<string, number>, guard: string,
 *   contacts: Contact[], breakups: Breakup[], recording: Recording | null, milliseconds: number}} Run
 */

/** Numbers about a droplet: id, generation, vertices, area, perimeter, shape parameter, neck, ends. */
export const INFO = 11;
export const [ID, , COUNT, AREA, , SHAPE, NECK, ENDS] = Array(INFO).keys();

const OUTCOMES = ["slipped", "broke", "captured", "failed"];

export class Engine {
  /** @param {BufferSource} code */
  static async make(code) {
    // The engine writes nothing and reads nothing: what its C library could ask for is refused.
    const refuse = () => 8;
    const system = { fd_close: refuse, fd_seek: refuse, fd_write: refuse };
    const { instance } = await WebAssembly.instantiate(code, { wasi_snapshot_preview1: system });
    return new Engine(/** @type {any} */ (instance.exports));
  }

  /** @param {any} exports */
  constructor(exports) {
    this.exports = exports;
    exports._initialize();
    this.fields = this.#names(exports.field_names());
    this.results = this.#names(exports.result_names());
    this.guards = ["", ...this.#names(exports.guard_names())];
  }

  /** @param {number} place */
  #names(place) {
    const bytes = new Uint8Array(this.exports.memory.buffer, place);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0))).trim().split(" ");
  }

  /**
   * Numbers in the engine's memory: a copy, for the memory may grow with the next call.
   * @param {number} place @param {number} count
   */
  #copy(place, count) {
    return new Float64Array(this.exports.memory.buffer, place, count).slice();
  }

  /** @param {number} count */
  #asked(count) {
    return this.#copy(this.exports.numbers(), count);
  }

  /**
   * Write a row; a time step that is no number becomes the automatic one.
   * @param {ArrayLike<number>} row
   * @returns {string} the field for which the row is refused, or nothing
   */
  prepare(row) {
    new Float64Array(this.exports.memory.buffer, this.exports.row(), this.fields.length).set(row);
    const automatic = Number.isNaN(row[this.fields.indexOf("time_step")]);
    const field = automatic ? this.exports.set_automatic_step() : 0;
    return this.fields[(field || this.exports.start()) - 1] ?? "";
  }

  row() {
    return this.#copy(this.exports.row(), this.fields.length);
  }

  /**
   * Fluid velocity at a point for the obstacle of the row that was written last.
   * @param {number} x @param {number} y
   */
  velocity(x, y) {
    return this.#asked(this.exports.fluid_velocity(x, y));
  }

  result() {
    const numbers = this.#copy(this.exports.result(), this.results.length);
    return Object.fromEntries(this.results.map((name, k) => [name, numbers[k]]));
  }

  /**
   * Run the collision of a row to its end.
   * @param {ArrayLike<number>} row
   * @param {number} interval between records, t0; 0 records nothing
   * @returns {Run}
   */
  run(row, interval = 0) {
    const begun = performance.now();
    const fault = this.prepare(row);
    const recording = fault || !interval ? null : this.#record(interval);
    if (!fault) while (this.exports.advance(Infinity));
    const result = fault ? {} : this.result();
    return {
      fault,
      row: this.row(),
      result,
      guard: fault ? "" : this.guards[result.guard],
      contacts: fault ? [] : this.#contacts(),
      breakups: fault ? [] : this.#breakups(),
      recording,
      milliseconds: performance.now() - begun,
    };
  }

  /**
   * Offset at which the first contact has a symmetry, by halving; S falls from head-on outwards.
   * @param {ArrayLike<number>} row @param {number} symmetry @param {number} tolerance of S
   * @returns {{fault: string, offset: number, symmetry: number}}
   */
  seek(row, symmetry, tolerance = 0.002) {
    const offsetPlace = this.fields.indexOf("offset");
    const limitPlace = this.fields.indexOf("time_limit");
    const trial = Float64Array.from(row);
    let low = 0;
    let high = trial[this.fields.indexOf("obstacle_radius")] + 0.5;
    let found = { fault: "", offset: 0, symmetry: NaN };
    for (let k = 0; k < 24; ++k) {
      trial[offsetPlace] = k ? 0.5 * (low + high) : Math.abs(row[offsetPlace]);
      const fault = this.prepare(trial);
      if (fault) return { fault, offset: NaN, symmetry: NaN };
      const reached = this.#contactSymmetry(trial[limitPlace]);
      found = { fault: "", offset: trial[offsetPlace], symmetry: reached };
      if (Math.abs(reached - symmetry) <= tolerance || high - low < 1e-5) break;
      if (reached > symmetry) low = Math.max(low, trial[offsetPlace]);
      else high = Math.min(high, trial[offsetPlace]);
    }
    return found;
  }

  /** @param {number} limit */
  #contactSymmetry(limit) {
    for (let time = 0; time < limit; time += 0.1) {
      if (!this.exports.advance(time) || this.exports.contacts()) break;
    }
    return this.#contacts()[0]?.symmetry ?? 0;
  }

  /** @param {number} interval @returns {Recording} */
  #record(interval) {
    /** @type {number[][]} */
    const [times, frames, first, info, vertices] = [[], [0], [0], [], []];
    for (let going = 1; going; going = this.exports.advance(this.exports.present_time() + interval)) {
      this.#look(times, frames, first, info, vertices);
    }
    this.#look(times, frames, first, info, vertices);
    return {
      times: Float64Array.from(times),
      frames: Int32Array.from(frames),
      first: Int32Array.from(first),
      info: Float64Array.from(info),
      vertices: Float32Array.from(vertices),
    };
  }

  /** @param {number[]} times @param {number[]} frames @param {number[]} first @param {number[]} info
   *  @param {number[]} vertices */
  #look(times, frames, first, info, vertices) {
    const time = this.exports.present_time();
    if (time <= (times.at(-1) ?? -1)) return;
    const all = this.#asked(this.exports.outlines());
    times.push(time);
    for (let at = 0; at < all.length; ) {
      const end = at + INFO + 2 * all[at + COUNT];
      for (let k = 0; k < INFO; ++k) info.push(all[at + k]);
      for (let k = at + INFO; k < end; ++k) vertices.push(all[k]);
      first.push(vertices.length / 2);
      at = end;
    }
    frames.push(first.length - 1);
  }

  /** @returns {Contact[]} */
  #contacts() {
    const all = this.#asked(this.exports.contacts());
    return parts(all, 12).map(([time, droplet, , symmetry, impact, speed, , , x, y, vx, vy]) => ({
      time, droplet, symmetry, impact, speed, x, y, vx, vy,
    }));
  }

  /** @returns {Breakup[]} */
  #breakups() {
    const all = this.#asked(this.exports.breakups());
    return parts(all, 11).map(([time, droplet, a, b, areaA, areaB, neck, ...ends]) => ({
      time, droplet, daughters: [a, b], areas: [areaA, areaB], neck, ends,
    }));
  }
}

/** @param {Float64Array} all @param {number} size */
function parts(all, size) {
  return Array.from({ length: all.length / size }, (_, k) => Array.from(all.subarray(k * size, (k + 1) * size)));
}

/** @param {Run} run */
export function outcomeOf(run) {
  return OUTCOMES[run.result.outcome] ?? "failed";
}
