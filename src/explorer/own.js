// @ts-check
// The user's own collisions: points in the diagram, filters, and the measured droplet beside a simulated one.
import { label, surface } from "./canvas.js";
import { rounded, shown } from "./parameters.js";
import { drawFluid, drawOutline, drawPillar, Plane } from "./shapes.js";

/**
 * A filmed passage, times and lengths in t0 = D0/v and D0, about the pillar's centre, along the flow.
 * @typedef {{times: number[], radius: number, unit: number, counts: number[][], vertices: string}} Film
 * unit: D0 of 1 in `vertices`, base64 of 16-bit integers; counts: vertices of each droplet of each frame
 *
 * @typedef {{title: string, words: string[], columns: {name: string, unit: string, meaning: string, kind: string}[],
 *   values: Record<string, any[]>, films: Record<string, Film>, thumbnails: Record<string, string>}} Payload
 *
 * @typedef {{own: number, strength: number, symmetry: number, outcome: string, small: boolean}} OwnPoint
 */

/** Columns worth a line in the hover, where the table has them. */
const TOLD = ["clip", "source", "collision_id", "symmetry", "capillary_number", "size_ratio", "breakup_number", "speed_mm_s", "area_um2", "daughter_area_ratio", "reject_reason"];

/** @type {Payload} */
const NOTHING = { title: "", words: [], columns: [], values: {}, films: {}, thumbnails: {} };

export class OwnData {
  /**
   * @param {Payload | null} payload @param {import("./parameters.js").Model} model
   * @param {(id: string) => any} byId
   * @param {{redraw: () => void, simulate: (changes: Record<string, number>, symmetry: number) => void}} page
   */
  constructor(payload, model, byId, page) {
    this.payload = payload ?? NOTHING;
    this.model = model;
    this.byId = byId;
    this.page = page;
    /** @type {OwnPoint[]} */
    this.points = [];
    /** @type {Record<string, any>} conditions by column */
    this.filters = {};
    this.chosen = -1;
    this.version = 0; // changes with the points
    /** @type {{film: Film, frames: Float32Array[][]} | null} */
    this.film = null;
    this.count = Object.values(this.payload.values)[0]?.length ?? 0;
    if (!payload) return;
    byId("own").hidden = false;
    byId("own-title").textContent = `Your data: ${payload.title}`;
    this.#buildFilters();
    this.#filter();
  }

  /** @param {string} name @param {number} row @returns {any} not a number where not measured */
  #value(name, row) {
    return this.payload.values[name]?.[row] ?? NaN;
  }

  get chosenPoint() {
    return this.points.find((point) => point.own === this.chosen) ?? null;
  }

  #filter() {
    const passes = (/** @type {number} */ row) =>
      Object.entries(this.filters).every(([name, condition]) => {
        const value = this.payload.values[name]?.[row] ?? null;
        if (typeof condition === "string") return String(value) === condition;
        const { low, high } = condition;
        return value === null ? low === -Infinity && high === Infinity : value >= low && value <= high;
      });
    ++this.version;
    this.points = [];
    let unplaced = 0;
    for (let row = 0; row < this.count; ++row) {
      if (!passes(row)) continue;
      const strength = this.#value("capillary_number", row) * this.#value("normalized_area", row) * this.#value("normalized_thickness", row);
      const symmetry = this.#value("symmetry", row);
      if (!(strength > 0) || !Number.isFinite(symmetry)) ++unplaced;
      this.points.push({ own: row, strength, symmetry, outcome: this.#outcome(row), small: this.count > 400 });
    }
    const words = [`${this.points.length.toLocaleString("en")} of ${this.count.toLocaleString("en")} collisions`];
    if (unplaced) words.push(`${unplaced} without a place in the diagram, because S or Ca Ã z̃ is not known`);
    this.byId("own-word").textContent = [words.join("; "), ...this.payload.words].join(". ") + ".";
    this.page.redraw();
  }

  /** @param {number} row */
  #outcome(row) {
    const broke = this.payload.values.broke?.[row];
    if (broke === true) return "broke";
    const outcome = this.payload.values.outcome?.[row];
    if (outcome) return outcome;
    return broke === false ? "slipped" : "failed";
  }

  #buildFilters() {
    const box = this.byId("own-filters");
    const add = document.createElement("select");
    add.setAttribute("aria-label", "Filter by a column");
    add.append(new Option("filter by …", ""));
    for (const column of this.payload.columns) add.append(new Option(column.name, column.name));
    add.onchange = () => {
      if (add.value) this.#addFilter(add.value, add);
      add.value = "";
    };
    box.append(add);
    if (this.payload.values.accepted?.includes(false)) this.#addFilter("accepted", add, "true");
  }

  /** @param {string} name @param {HTMLElement} before @param {string} [value] */
  #addFilter(name, before, value) {
    if (name in this.filters) return;
    const column = /** @type {any} */ (this.payload.columns.find((each) => each.name === name));
    const box = document.createElement("fieldset");
    const legend = document.createElement("legend");
    const close = Object.assign(document.createElement("button"), { type: "button", textContent: "×" });
    legend.textContent = column.unit && column.unit !== "1" ? `${name} [${column.unit}]` : name;
    legend.title = column.meaning;
    close.setAttribute("aria-label", `No longer filter by ${name}`);
    close.onclick = () => {
      box.remove();
      delete this.filters[name];
      this.#filter();
    };
    box.append(legend, ...(column.kind === "number" ? this.#range(name) : this.#choice(name, value)), close);
    before.before(box);
    this.#filter();
  }

  /** @param {string} name */
  #range(name) {
    const condition = (this.filters[name] = { low: -Infinity, high: Infinity });
    const numbers = this.payload.values[name].filter((value) => value !== null);
    const ends = numbers.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
    return /** @type {const} */ (["low", "high"]).map((end, k) => {
      const field = Object.assign(document.createElement("input"), { type: "number", step: "any", placeholder: numbers.length ? shown(ends[k]) : "" });
      field.setAttribute("aria-label", `${name}, ${k ? "at most" : "at least"}`);
      field.oninput = () => {
        condition[end] = Number.isFinite(field.valueAsNumber) ? field.valueAsNumber : [-Infinity, Infinity][k];
        this.#filter();
      };
      return field;
    });
  }

  /** @param {string} name @param {string} [value] */
  #choice(name, value) {
    const words = [...new Set(this.payload.values[name].map(String))].sort().slice(0, 500);
    const select = document.createElement("select");
    const told = (/** @type {string} */ word) => (word === "null" ? "(not known)" : word.length > 40 ? `${word.slice(0, 39)}…` : word || "(empty)");
    select.append(...words.map((word) => new Option(told(word), word)));
    select.value = value !== undefined && words.includes(value) ? value : words[0] ?? "";
    this.filters[name] = select.value;
    select.onchange = () => {
      this.filters[name] = select.value;
      this.#filter();
    };
    return [select];
  }

  /** Lines about a row. @param {number} row */
  #lines(row) {
    const known = this.payload.columns.filter(({ name }) => TOLD.includes(name));
    const lines = known.map(({ name, unit }) => {
      const value = this.payload.values[name]?.[row];
      if (value === null || value === undefined || value === "") return "";
      return `${name} = ${typeof value === "number" ? shown(value) : value}${unit && unit !== "1" ? ` ${unit}` : ""}`;
    });
    return [this.#outcome(row) === "failed" ? "outcome unknown" : this.#outcome(row), ...lines.filter(Boolean)];
  }

  /** @param {number} row @param {HTMLElement} tip */
  describe(row, tip) {
    tip.replaceChildren(document.createTextNode(this.#lines(row).join("\n")));
    const picture = this.#picture(row);
    if (picture) tip.append(picture);
  }

  /** @param {number} row */
  #picture(row) {
    const src = this.payload.thumbnails[row];
    return src ? Object.assign(document.createElement("img"), { src, alt: `Frames of collision ${row}` }) : null;
  }

  /** @param {number} row */
  choose(row) {
    this.chosen = row;
    const box = this.byId("own-one");
    box.hidden = false;
    const text = document.createElement("p");
    text.textContent = this.#lines(row).join(" · ");
    const button = Object.assign(document.createElement("button"), { type: "button", className: "primary", textContent: "Simulate this one" });
    const why = document.createElement("p");
    why.className = "hint";
    const problem = this.#missing(row);
    button.disabled = problem !== "";
    why.textContent = problem || "A droplet of the same S, Ca and D0/R.";
    button.onclick = () => this.#simulate(row);
    box.replaceChildren(...[this.#picture(row), text, button, why].filter((element) => element !== null));
    const film = this.payload.films[row];
    this.film = film ? { film, frames: unpacked(film) } : null;
    this.byId("measured-stage").hidden = !film;
    this.byId("measured-badge").textContent = `measured: ${this.#outcome(row)}`;
    this.page.redraw();
    if (!problem) this.#simulate(row);
  }

  /** @param {number} row */
  #groups(row) {
    const ratio = this.#value("size_ratio", row);
    const area = this.#value("normalized_area", row);
    const said = this.#value("ca_per_ca_sim", row); // by tables of simulations
    const perSim = Number.isFinite(said) ? said : this.model.facts.ca_per_ca_sim;
    return {
      symmetry: this.#value("symmetry", row),
      size_ratio: Number.isFinite(ratio) ? ratio : Math.sqrt((4 * area) / Math.PI),
      simulation_capillary_number: rounded(this.#value("capillary_number", row) / perSim, 6),
    };
  }

  /** Why a row cannot be simulated, or nothing. @param {number} row */
  #missing(row) {
    const groups = /** @type {Record<string, number>} */ (this.#groups(row));
    const unknown = Object.keys(groups).filter((name) => !Number.isFinite(groups[name]));
    if (unknown.length) return `It cannot be simulated: ${unknown.join(" and ")} not known.`;
    return ["size_ratio", "simulation_capillary_number"].map((name) => this.model.refusal(name, groups[name])).find(Boolean) ?? "";
  }

  /** @param {number} row */
  #simulate(row) {
    const { symmetry, ...changes } = this.#groups(row);
    this.page.simulate(changes, symmetry);
  }

  /** @param {Plane} v of the simulated scene @param {number} time since contact, t0 */
  draw(v, time) {
    if (!this.film) return;
    const { film, frames } = this.film;
    const canvas = this.byId("measured");
    const { context, width, height, font } = surface(canvas);
    const plane = new Plane(v.left, v.scale, width, height);
    drawFluid(context, plane);
    drawPillar(context, plane, film.radius);
    let nearest = 0;
    film.times.forEach((each, k) => {
      if (Math.abs(each - time) < Math.abs(film.times[nearest] - time)) nearest = k;
    });
    for (const outline of frames[nearest]) drawOutline(context, plane, outline);
    context.textAlign = "right";
    const [first, last] = [film.times[0], /** @type {number} */ (film.times.at(-1))];
    const word = time < first - 0.05 ? "before the film" : time > last + 0.05 ? "after the film" : "";
    label(context, `${word} t = contact ${time < 0 ? "−" : "+"} ${Math.abs(time).toFixed(2)} D0/v`.trim(), width - 14, height - 12 - font, "faint");
  }
}

/** @param {Film} film @returns {Float32Array[][]} outlines of each frame */
function unpacked(film) {
  const bytes = Uint8Array.from(atob(film.vertices), (letter) => letter.charCodeAt(0));
  const numbers = new Int16Array(bytes.buffer);
  let at = 0;
  return film.counts.map((frame) =>
    frame.map((count) => {
      const outline = Float32Array.from(numbers.subarray(at, at + 2 * count), (value) => value * film.unit);
      at += 2 * count;
      return outline;
    }),
  );
}
