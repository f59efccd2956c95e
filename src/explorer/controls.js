// @ts-check
// Sliders and number fields for what decides a collision.
import { QUANTITIES, rounded } from "./parameters.js";

/** @typedef {import("./parameters.js").Model} Model @typedef {import("./parameters.js").Values} Values
 * @typedef {import("./parameters.js").Quantities} Quantities */

/** What the sliders span; the number fields beside them take the whole range of the model. */
const SPANS = {
  offset: { label: "offset y", symbol: "D0", low: 0, high: 0.7, log: false, digits: 4 },
  simulation_capillary_number: { label: "flow Ca_sim", symbol: "", low: 2, high: 200, log: true, digits: 4 },
  size_ratio: { label: "size D0/R", symbol: "", low: 1, high: 12, log: true, digits: 4 },
};
const PHYSICAL_SPANS = {
  offset: { label: "offset y", symbol: "µm", low: 0, high: 350, log: false, digits: 4 },
  speed: { label: "speed v", symbol: "mm/s", low: 0.05, high: 10, log: true, digits: 4 },
  diameter: { label: "droplet D0", symbol: "µm", low: 50, high: 1200, log: true, digits: 4 },
};
const STEPS = 1000;

/** The three sliders below the scene: dimensionless, or in the laboratory's units. */
export class SliderRow {
  /** @param {HTMLElement} box @param {Model} model @param {(changes: Values) => void} set
   * @param {(changes: Record<string, number>) => void} setQuantities */
  constructor(box, model, set, setQuantities) {
    this.box = box;
    this.model = model;
    this.set = set;
    this.setQuantities = setQuantities;
    this.physical = /** @type {boolean | null} */ (null);
    /** @type {Record<string, {range: HTMLInputElement, field: HTMLInputElement, span: any}>} */
    this.rows = {};
  }

  /** @param {Values} values @param {Quantities | null} quantities */
  show(values, quantities) {
    const physical = quantities !== null;
    if (physical !== this.physical) this.#build(physical);
    const source = /** @type {Record<string, number>} */ (quantities ?? values);
    for (const [name, { range, field, span }] of Object.entries(this.rows)) {
      if (document.activeElement !== range) range.value = String(STEPS * shareOf(source[name], span));
      if (document.activeElement !== field) field.value = String(rounded(source[name], 6));
      range.setAttribute("aria-valuetext", `${rounded(source[name], 4)} ${span.symbol}`);
      field.setAttribute("aria-invalid", String(!physical && this.model.refusal(name, source[name]) !== ""));
    }
  }

  /** @param {boolean} physical */
  #build(physical) {
    this.physical = physical;
    this.rows = {};
    this.box.replaceChildren();
    for (const [name, span] of Object.entries(physical ? PHYSICAL_SPANS : SPANS)) {
      const id = name === "offset" ? "offset" : `slider-${name}`;
      const label = document.createElement("label");
      label.htmlFor = id;
      label.textContent = span.label;
      const range = Object.assign(document.createElement("input"), { type: "range", id, min: "0", max: String(STEPS), step: "1" });
      const field = Object.assign(document.createElement("input"), { type: "number", step: "any" });
      field.setAttribute("aria-label", `${span.label} as a number`);
      const unit = Object.assign(document.createElement("span"), { className: "unit", textContent: span.symbol });
      const take = (/** @type {number} */ value) => (physical ? this.setQuantities({ [name]: value }) : this.set({ [name]: value }));
      range.oninput = () => take(rounded(valueOf(Number(range.value) / STEPS, span), span.digits));
      takeNumber(field, take, physical && name !== "offset");
      this.rows[name] = { range, field, span };
      this.box.append(label, range, field, unit);
    }
  }
}

/** A label with its field. @param {HTMLElement} field @param {(string | HTMLElement)[]} words */
function labelled(field, ...words) {
  const [label, text] = ["label", "span"].map((tag) => document.createElement(tag));
  text.append(...words);
  label.append(text, field);
  return label;
}

/** Take what is typed into a field, if it is a number, above 0 where that must be.
 * @param {HTMLInputElement} field @param {(value: number) => void} take @param {boolean} positive */
function takeNumber(field, take, positive) {
  field.onchange = () => {
    const value = field.valueAsNumber;
    const good = Number.isFinite(value) && (!positive || value > 0);
    field.setAttribute("aria-invalid", String(!good));
    if (good) take(value);
  };
}

/** @param {number} share @param {any} span */
function valueOf(share, span) {
  return span.log ? span.low * (span.high / span.low) ** share : span.low + share * (span.high - span.low);
}

/** @param {number} value @param {any} span */
function shareOf(value, span) {
  const share = span.log ? Math.log(value / span.low) / Math.log(span.high / span.low) : (value - span.low) / (span.high - span.low);
  return Math.min(1, Math.max(0, share));
}

/** Every parameter, with its limits and meaning as Python states them. */
export class ParameterForm {
  /** @param {HTMLElement} box @param {Model} model @param {(changes: Values) => void} set */
  constructor(box, model, set) {
    this.model = model;
    /** @type {Record<string, HTMLInputElement | HTMLSelectElement>} */
    this.fields = {};
    for (const p of model.parameters) {
      const choices = p.choices ?? (typeof p.default === "boolean" ? ["true", "false"] : null);
      const field = choices ? document.createElement("select") : document.createElement("input");
      if (field instanceof HTMLSelectElement) field.replaceChildren(.../** @type {string[]} */ (choices).map((name) => new Option(name, name)));
      else Object.assign(field, { type: "text", inputMode: "decimal" });
      const small = document.createElement("small");
      small.textContent = `${p.meaning}; ${p.rule}`;
      // A long name goes on in the next line after one of its words.
      const name = p.name.split("_").flatMap((word, k) => (k ? ["_", document.createElement("wbr"), word] : [word]));
      box.append(labelled(field, ...name, small));
      field.onchange = () => set({ [p.name]: model.read(p.name, field.value) });
      this.fields[p.name] = field;
    }
  }

  /** @param {Values} values */
  show(values) {
    for (const [name, field] of Object.entries(this.fields)) {
      if (document.activeElement !== field || field instanceof HTMLSelectElement) field.value = values[name] === null ? "" : String(values[name]);
      field.setAttribute("aria-invalid", String(this.model.refusal(name, values[name], values) !== ""));
      field.disabled = !this.model.means(values, name);
      if (field instanceof HTMLInputElement) field.placeholder = String(this.model.value(values, name) ?? "");
    }
  }
}

/** The laboratory's quantities. */
export class QuantityForm {
  /** @param {HTMLElement} box @param {(changes: Record<string, number>) => void} set */
  constructor(box, set) {
    /** @type {Record<string, HTMLInputElement>} */
    this.fields = {};
    for (const [name, meaning, unit] of QUANTITIES) {
      const field = Object.assign(document.createElement("input"), { type: "number", step: "any" });
      box.append(labelled(field, `${meaning} [${unit}]`));
      takeNumber(field, (value) => set({ [name]: value }), name !== "offset");
      this.fields[name] = field;
    }
  }

  /** @param {Quantities | null} quantities */
  show(quantities) {
    if (!quantities) return;
    for (const [name, field] of Object.entries(this.fields))
      if (document.activeElement !== field) field.value = String(rounded(/** @type {any} */ (quantities)[name], 8));
  }
}
