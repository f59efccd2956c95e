// @ts-check
// The collision at hand: what was set, why it is refused, and the run that came of it.
import { rounded } from "./parameters.js";

/** @typedef {import("./engine.js").Run} Run @typedef {import("./parameters.js").Values} Values
 * @typedef {import("./parameters.js").Quantities} Quantities */

const INTERVAL = 0.02; // between two recorded outlines, t0

export class Session {
  /**
   * @param {import("./parameters.js").Model} model @param {import("./points.js").Points} points
   * @param {{set: () => void, refused: () => void, arrived: (values: Values, first: boolean) => void}} page what
   * happens when values are set, refused or not, and when their run has come
   */
  constructor(model, points, page) {
    this.model = model;
    this.points = points;
    this.page = page;
    /** What the page shows: everything else follows from it. */
    this.state = {
      values: model.defaults(),
      /** @type {Quantities | null} */
      quantities: null,
      time: 0,
      playing: false,
      map: "",
    };
    /** @type {Run | null} */
    this.run = null;
    /** @type {import("./points.js").Tried | null} */
    this.here = null;
    this.refused = "";
    /** @type {import("./jobs.js").Newest | null} */
    this.newest = null;
  }

  /** Take values, refuse or run them. @param {Values} changes */
  set(changes) {
    const { state, model } = this;
    Object.assign(state.values, changes);
    if (state.quantities && "offset" in changes) state.quantities.offset = rounded(changes.offset * state.quantities.diameter, 6);
    if (state.quantities && ("size_ratio" in changes || "simulation_capillary_number" in changes)) {
      state.quantities = model.quantitiesOf(state.values, state.quantities);
      Object.assign(state.values, model.ofQuantities(state.quantities));
    }
    this.compute();
  }

  /** Take physical quantities, from which the groups follow. @param {Record<string, number>} changes */
  setQuantities(changes) {
    const { state, model } = this;
    state.quantities = { .../** @type {any} */ (state.quantities), ...changes };
    Object.assign(state.values, model.ofQuantities(/** @type {any} */ (state.quantities)));
    this.compute();
  }

  /** Take other values in place of all. @param {Values} values @param {Quantities | null} quantities */
  replace(values, quantities = this.state.quantities) {
    this.state.values = values;
    this.state.quantities = quantities;
    this.compute();
  }

  /** Go over to physical quantities, or back. @param {Quantities} laboratory what the groups do not tell */
  changeUnits(laboratory) {
    const { state, model } = this;
    state.quantities = state.quantities ? null : model.quantitiesOf(state.values, laboratory);
    if (state.quantities) Object.assign(state.values, model.ofQuantities(state.quantities));
    this.compute();
  }

  compute() {
    const { model, state } = this;
    this.refused = model.firstRefusal(state.values);
    this.page.set();
    if (this.refused) return;
    const values = { ...state.values };
    const quantities = state.quantities;
    this.newest?.ask({ job: "run", rows: [model.row(values)], interval: INTERVAL }, ({ runs }) => {
      if (!runs[0].fault) return this.#arrived(values, quantities, runs[0]);
      this.refused = this.#faultText(runs[0].fault, values);
      this.page.refused();
    });
  }

  /** Bring S to a value by moving the droplet's start. @param {Values} changes @param {number} symmetry */
  seek(changes, symmetry) {
    const { model } = this;
    const values = { ...this.state.values, ...changes };
    if (model.firstRefusal(values)) return;
    this.newest?.ask({ job: "seek", row: model.row(values), symmetry }, ({ found, newer }) => {
      if (found.fault || newer) return;
      this.set({ ...changes, offset: rounded(found.offset, 4) });
    });
  }

  /** @param {Values} values @param {Quantities | null} quantities @param {Run} computed */
  #arrived(values, quantities, computed) {
    const first = this.run === null;
    this.run = computed;
    this.here = this.points.add(values, quantities, computed, false);
    this.page.arrived(values, first);
  }

  /** @param {string} field @param {Values} values */
  #faultText(field, values) {
    const name = field in this.state.values ? field : "the model";
    const p = this.model.byName[field];
    return p
      ? `${name} must be ${p.rule}, and fit the other parameters; got ${values[field]}; ${p.advice}`
      : `${field} must be possible; got a row that the engine refuses; change what you changed last`;
  }
}
