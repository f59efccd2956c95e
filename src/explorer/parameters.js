// @ts-check
// What decides a collision: parameters with their limits, the engine's row, and the same run elsewhere.

/**
 * @typedef {{name: string, default: number | string | boolean | null, follows: string, scope: string, low: number | null,
 *   high: number | null, whole: boolean, choices: string[] | null, rule: string, meaning: string,
 *   advice: string, place: string, column: string}} Parameter
 *
 * @typedef {Record<string, any>} Values parameters by name; null where one follows another
 *
 * @typedef {{diameter: number, obstacle_radius: number, speed: number, viscosity: number,
 *   surface_tension: number, thickness: number, offset: number}} Quantities µm, mm/s, mPa s, mN/m
 */

export const QUANTITIES = /** @type {const} */ ([
  ["diameter", "D0, droplet", "µm", "um"],
  ["obstacle_radius", "R, pillar", "µm", "um"],
  ["thickness", "z, chamber", "µm", "um"],
  ["speed", "v, fluid", "mm/s", "mm/s"],
  ["viscosity", "μ, fluid", "mPa s", "mPa s"],
  ["surface_tension", "γ, interface", "mN/m", "mN/m"],
  ["offset", "start y", "µm", "um"],
]);
/** What decides a collision beside the constants. */
export const GROUPS = ["size_ratio", "simulation_capillary_number", "offset"];

export class Model {
  /** @param {any} facts what Python says of the model */
  constructor(facts) {
    this.facts = facts;
    /** @type {Parameter[]} */
    this.parameters = facts.parameters;
    this.byName = Object.fromEntries(this.parameters.map((p) => [p.name, p]));
  }

  /** @returns {Values} */
  defaults() {
    return Object.fromEntries(this.parameters.map((p) => [p.name, p.default]));
  }

  /**
   * Whether a parameter means something in the model that is chosen.
   * @param {Values} values @param {string} name
   */
  means(values, name) {
    const { scope } = this.byName[name];
    return !scope || scope === values.model;
  }

  /**
   * The value of a parameter, also where it follows another one; null where it has no meaning.
   * @param {Values} values @param {string} name @returns {any}
   */
  value(values, name) {
    if (!this.means(values, name)) return null;
    if (values[name] !== null) return values[name];
    const ratio = this.facts.ratios[name];
    return ratio ? ratio * this.value(values, this.byName[name].follows) : this.facts.defaults[values.model][name];
  }

  /**
   * The engine's row; the automatic time step is not a number there.
   * @param {Values} values @returns {Float64Array}
   */
  row(values) {
    // Without springs line tension is the only force, and the unit.
    const tension = this.value(values, "line_tension") ?? 1;
    const edges = this.value(values, "edge_stiffness") ?? 0;
    /** @type {Record<string, number>} what is not the parameter itself */
    const own = {
      ...this.facts.constants,
      obstacle_radius: 1 / values.size_ratio,
      drag: values.simulation_capillary_number * tension,
      line_tension: tension,
      edge_stiffness: edges * tension,
      adhesion: tension * (1 + Math.cos((Math.PI / 180) * values.contact_angle)),
      front_tracking: Number(values.model === "front-tracking"),
      time_step: values.time_step === "auto" ? NaN : values.time_step,
      neck_separation_in_diameters: Number(values.neck_separation_unit === "diameter"),
      neck_thickness: this.neckThreshold(values),
      neck_thickness_is_fixed: Number(values.neck_thickness_unit === "thickness"),
      stop_at_breakup: Number(!values.follow_daughters),
    };
    return Float64Array.from(this.facts.fields, (/** @type {string} */ name) => own[name] ?? Number(this.value(values, name) ?? 0));
  }

  /**
   * The thickness below which a neck breaks, D0; z of the chamber is R.
   * @param {Values} values
   */
  neckThreshold(values) {
    return values.neck_thickness_unit === "thickness" ? values.neck_thickness / values.size_ratio : values.neck_thickness;
  }

  /**
   * Why a value is refused, or nothing.
   * @param {string} name @param {any} value @param {Values} [values] the others, which say what means something
   */
  refusal(name, value, values) {
    const p = this.byName[name];
    if ((value === null && p.follows) || (values && !this.means(values, name))) return "";
    if (p.choices ? p.choices.includes(value) : typeof p.default === "boolean") return "";
    if (value === "auto" && p.default === "auto") return "";
    const good = typeof value === "number" && Number.isFinite(value) && (!p.whole || Number.isInteger(value)) &&
      value >= /** @type {number} */ (p.low) && value <= /** @type {number} */ (p.high);
    return good ? "" : `${name} must be ${p.rule}; got ${value}; ${p.advice}`;
  }

  /** Why values are refused, or nothing. @param {Values} values */
  firstRefusal(values) {
    return this.parameters.map(({ name }) => this.refusal(name, values[name], values)).find(Boolean) ?? "";
  }

  /**
   * Read one parameter as somebody typed it; not a number where it is none.
   * @param {string} name @param {string} text
   */
  read(name, text) {
    const p = this.byName[name];
    const word = text.trim();
    if (word === "" && p.follows) return null;
    if (word === "auto" && p.default === "auto") return word;
    if (p.choices) return word;
    if (typeof p.default === "boolean") return word === "true";
    return word === "" ? NaN : Number(word);
  }

  /** @param {Values} values */
  groups(values) {
    const area = (Math.PI / 4) * values.size_ratio ** 2;
    const capillary = this.facts.ca_per_ca_sim * values.simulation_capillary_number;
    return { capillary, area, thickness: 1, strength: capillary * area };
  }

  /**
   * Bk of a collision, from the line of the paper's simulations [paper, eq. bkeqn].
   * @param {number} strength Ca Ã z̃ @param {number} symmetry
   */
  breakupNumber(strength, symmetry) {
    const { alpha, beta } = this.facts.lines[0];
    return strength * (symmetry / alpha) ** (-1 / beta);
  }

  /**
   * The dimensionless groups of an experiment; the order of operations is Python's.
   * @param {Quantities} q
   */
  ofQuantities(q) {
    const capillary = ((q.viscosity * q.speed) / q.surface_tension) * 1e-3;
    return {
      size_ratio: q.diameter / q.obstacle_radius,
      simulation_capillary_number: capillary / this.facts.ca_per_ca_sim,
      offset: q.offset / q.diameter,
    };
  }

  /**
   * An experiment with these groups: the pillar and the liquids of another one, size and speed rounded.
   * @param {Values} values @param {Quantities} like @returns {Quantities}
   */
  quantitiesOf(values, like) {
    const diameter = rounded(values.size_ratio * like.obstacle_radius, 4);
    const capillary = this.facts.ca_per_ca_sim * values.simulation_capillary_number;
    const speed = rounded(((capillary * like.surface_tension) / like.viscosity) * 1e3, 4);
    return { ...like, diameter, speed, offset: rounded(values.offset * diameter, 4) };
  }

  /** What differs from the defaults. @param {Values} values */
  differing(values) {
    return this.parameters.filter((p) => this.means(values, p.name) && values[p.name] !== p.default).map((p) => p.name);
  }

  /** The words of the command, an option with its value in one.
   * @param {Values} values @param {Quantities | null} quantities */
  command(values, quantities) {
    const words = ["pinchoff run"];
    if (quantities) {
      for (const [name, , , unit] of QUANTITIES) words.push(`--${name.replace("_", "-")} '${quantities[name]} ${unit}'`);
    } else {
      words.push(`--size-ratio ${values.size_ratio}`, `--capillary ${values.simulation_capillary_number}`);
      words.push(`--offset ${values.offset}`);
    }
    for (const name of this.differing(values)) {
      if (name === "model") words.splice(1, 0, `--model ${values.model}`);
      else if (!GROUPS.includes(name)) words.push(`--set ${name}=${values[name]}`);
    }
    return words;
  }

  /** @param {Values} values @param {Quantities | null} quantities */
  python(values, quantities) {
    const constants = this.differing(values).filter((name) => !GROUPS.includes(name));
    const given = constants.map((name) => `${name}=${pythonic(values[name])}`);
    const of = quantities
      ? QUANTITIES.map(([name, , , unit]) => `${name}="${quantities[name]} ${unit}"`)
      : GROUPS.map((name) => `${name}=${values[name]}`);
    const call = quantities ? "po.Parameters.from_physical" : "po.Parameters";
    return [
      "import pinchoff as po",
      "",
      `p = ${call}(`,
      ...[...of, ...given].map((argument) => `    ${argument},`),
      ")",
      "c = po.simulate(p, outlines=True)",
    ].join("\n");
  }
}

/** @param {any} value */
function pythonic(value) {
  if (typeof value === "boolean") return value ? "True" : "False";
  return typeof value === "string" ? `"${value}"` : String(value);
}

/** A time in seconds. @param {number} time t0 @param {Quantities} quantities */
export function secondsOf(time, quantities) {
  return (time * quantities.diameter * 1e-3) / quantities.speed;
}

/** @param {number} value @param {number} digits significant */
export function rounded(value, digits) {
  return Number(value.toPrecision(digits));
}

/**
 * A number as people read it: significant digits, a true minus sign, a dash where there is none.
 * @param {number} value @param {number} digits
 */
export function shown(value, digits = 3) {
  if (value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size < 1e-3 || size >= 1e6 ? value.toExponential(digits - 1) : String(rounded(value, Math.max(digits, Math.floor(Math.log10(size)) + 1)));
  return text.replace("-", "−");
}
