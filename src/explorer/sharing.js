// @ts-check
// Out of the page and back: links that hold its state, texts to copy, pictures and tables to save.
import { copyText, saveBlob, savePng } from "./export.js";
import { fragmentOf, MOST_LINKED, OF_POINTS, readFragment } from "./link.js";
import { QUANTITIES } from "./parameters.js";

/** @typedef {import("./parameters.js").Values} Values */

const QUANTITY_NAMES = QUANTITIES.map(([name]) => name);
const LINK_AFTER = 400; // ms without a change

export class Sharing {
  /** @param {import("./session.js").Session} session @param {import("./diagram.js").Diagram} diagram
   * @param {(id: string) => any} byId */
  constructor(session, diagram, byId) {
    this.session = session;
    this.diagram = diagram;
    this.byId = byId;
    this.timer = 0;
    byId("copy-link").onclick = () => this.#copyLink();
    byId("copy-command").onclick = () => this.#copy("command", "command");
    byId("copy-python").onclick = () => this.#copy("python", "program");
  }

  /** @param {import("./scene.js").Scene} scene @param {any} facts */
  offerFiles(scene, facts) {
    const { byId, diagram } = this;
    const { points } = this.session;
    byId("save-scene").onclick = async () => this.#say(await savePng(scene.canvas, "collision.png", byId("summary").textContent));
    byId("save-diagram").onclick = async () => this.#say(await savePng(diagram.canvas, "diagram.png", `${points.all.length} collisions, pinchoff ${facts.version}`));
    byId("save-points").onclick = () => {
      saveBlob(new Blob([points.csv()], { type: "text/csv" }), "collisions.csv");
      this.#say(`collisions.csv has ${points.all.length} rows; pinchoff fit reads it.`);
    };
  }

  /** Put the state into the address, once nothing has changed for a while. */
  remember() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      try {
        history.replaceState(null, "", this.#fragment());
      } catch {
        // Some browsers refuse it for files; the link is copied from what we know.
      }
    }, LINK_AFTER);
  }

  /** Take the state of a link; returns what else is in it, and what in it cannot be. @param {string} fragment */
  restore(fragment) {
    const { model, state } = this.session;
    const { state: found, wrong } = readFragment(fragment, model, QUANTITY_NAMES);
    Object.assign(state, { values: found.values, quantities: found.quantities, time: found.time });
    if (found.quantities) Object.assign(state.values, model.ofQuantities(/** @type {any} */ (found.quantities)));
    this.diagram.logarithmic = this.byId("log-symmetry").checked = found.logarithmic;
    if (new URLSearchParams(fragment.slice(1)).has("without") || fragment.length > 1) this.diagram.without = new Set(found.without);
    return { found, wrong };
  }

  /** @returns {import("./link.js").Linked} */
  #linked() {
    const { model, state, points } = this.session;
    const same = (/** @type {Values} */ values) => model.parameters.every(({ name }) => OF_POINTS.includes(name) || values[name] === state.values[name]);
    const byHand = points.all.filter((tried) => !tried.small && same(tried.values));
    return {
      values: state.values,
      quantities: state.quantities,
      time: state.time,
      logarithmic: this.diagram.logarithmic,
      without: [...this.diagram.without],
      map: state.map,
      tried: byHand.slice(-MOST_LINKED).map(({ values }) => OF_POINTS.map((name) => values[name])),
    };
  }

  #fragment() {
    return fragmentOf(this.#linked(), this.session.model);
  }

  async #copyLink() {
    const all = this.session.points.all.filter((tried) => !tried.small).length;
    const kept = this.#linked().tried.length;
    const left = all > kept ? ` ${all - kept} of ${all} points are not in it: only the newest ${MOST_LINKED} with these constants are.` : "";
    const copied = await copyText(location.href.split("#")[0] + this.#fragment());
    this.#say((copied ? "The link is copied." : "Copy the address of this page.") + left);
  }

  /** @param {string} id of what is copied @param {string} name */
  async #copy(id, name) {
    const copied = await copyText(this.byId(id).textContent);
    this.#say(copied ? `The ${name} is copied.` : `Mark the ${name} and copy it.`);
  }

  /** @param {string} text */
  #say(text) {
    this.byId("said").textContent = text;
  }
}
