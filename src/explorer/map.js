// @ts-check
// Many collisions on all cores: a slice of the diagram, or those of a link.
import { runAll } from "./jobs.js";
import { rounded } from "./parameters.js";
import { MOST_POINTS } from "./points.js";

/** @typedef {import("./parameters.js").Values} Values */

/** Between two looks at the progress, ms: drawing takes time from the cores that compute. */
const DRAWN_EVERY = 200;

export class SliceMap {
  /** @param {import("./session.js").Session} session @param {any} facts @param {(id: string) => any} byId
   * @param {{redraw: () => void, remember: () => void, trouble: (message: string) => void}} page */
  constructor(session, facts, byId, page) {
    this.session = session;
    this.facts = facts;
    this.byId = byId;
    this.page = page;
    /** @type {(() => void) | null} */
    this.cancel = null;
    byId("map").onclick = () => (this.cancel ? this.cancel() : this.map(Number(byId("map-size").value)));
  }

  /** @param {number} side */
  async map(side) {
    const { session } = this;
    if (session.refused || this.cancel) return;
    await this.run(this.#slice(side), true, `${side} × ${side}`);
    session.state.map = String(side);
    this.page.remember();
  }

  /** Run collisions and keep them as points. @param {Values[]} wanted @param {boolean} small @param {string} name */
  async run(wanted, small, name) {
    const { byId, session } = this;
    const { model, points } = session;
    let count = 0;
    let faults = 0;
    const begun = performance.now();
    let shownAt = begun;
    const progress = byId("map-progress");
    const job = runAll(wanted.map((values) => model.row(values)), (k, computed) => {
      ++count;
      if (computed.fault) ++faults;
      else points.add(wanted[k], null, computed, small);
      if (performance.now() - shownAt < DRAWN_EVERY) return;
      shownAt = performance.now();
      progress.value = count / wanted.length;
      byId("map-word").textContent = `${count} of ${wanted.length}`;
      this.page.redraw();
    }, this.page.trouble);
    this.cancel = job.cancel;
    byId("map").textContent = "Cancel";
    progress.hidden = false;
    const whole = await job.done;
    this.cancel = null;
    this.page.redraw();
    progress.hidden = true;
    byId("map").textContent = "Map this slice";
    const seconds = ((performance.now() - begun) / 1000).toFixed(1);
    const lost = (faults ? `, ${faults} refused` : "") + (points.forgotten ? `; the oldest beyond ${MOST_POINTS} are forgotten` : "");
    byId("map-word").textContent = (whole ? `${name}: ${wanted.length} collisions in ${seconds} s` : `cancelled after ${count}`) + lost;
  }

  /** Forget what was mapped. */
  clear() {
    this.cancel?.();
    this.session.state.map = "";
    this.byId("map-word").textContent = "";
  }

  /** Values of a slice: offset from head-on to the last that touches, Ca over the diagram's range.
   * @param {number} side */
  #slice(side) {
    const { model, state } = this.session;
    const { low, high } = /** @type {any} */ (model.byName.simulation_capillary_number);
    const area = model.groups(state.values).area;
    const ofStrength = (/** @type {number} */ strength) => Math.min(high, Math.max(low, strength / area / this.facts.ca_per_ca_sim));
    const [from, to] = [ofStrength(0.02), ofStrength(0.5)];
    const widest = 0.5 + 0.5 / state.values.size_ratio; // farther out there is hardly a contact
    const all = [];
    for (let i = 0; i < side; ++i)
      for (let j = 0; j < side; ++j)
        all.push({
          ...state.values,
          follow_daughters: false, // S and the outcome are known by the first break-up
          simulation_capillary_number: rounded(from * (to / from) ** (i / (side - 1)), 5),
          offset: rounded((widest * j) / (side - 1), 5),
        });
    return all;
  }
}
