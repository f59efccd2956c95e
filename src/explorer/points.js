// @ts-check
// Every collision that was tried: for the diagram, and as a table that other programs read.
import { outcomeOf } from "./engine.js";
import { GROUPS, secondsOf } from "./parameters.js";

/**
 * @typedef {import("./engine.js").Run} Run
 * @typedef {import("./parameters.js").Values} Values
 * @typedef {import("./parameters.js").Quantities} Quantities
 * @typedef {{values: Values, quantities: Quantities | null, run: Run, strength: number, symmetry: number, outcome: string, small: boolean,
 *   breakupNumber: number, groups: ReturnType<import("./parameters.js").Model["groups"]>}} Tried
 */

/** More points than this slow the drawing; the oldest are then forgotten, which the page says. */
export const MOST_POINTS = 20000;

export class Points {
  /** @param {import("./parameters.js").Model} model */
  constructor(model) {
    this.model = model;
    /** @type {Map<string, Tried>} */
    this.byKey = new Map();
    this.forgotten = 0;
    this.version = 0; // changes with the points
  }

  /** @param {Values} values */
  key(values) {
    return this.model.parameters.map((p) => values[p.name]).join(" ");
  }

  /** @param {Values} values @param {Quantities | null} quantities @param {Run} run
   * @param {boolean} small from a map rather than by hand @returns {Tried} */
  add(values, quantities, run, small) {
    const key = this.key(values);
    const before = this.byKey.get(key);
    const groups = this.model.groups(values);
    const symmetry = run.result.symmetry;
    const breakupNumber = this.model.breakupNumber(groups.strength, symmetry);
    // The outlines of thousands of collisions would fill the memory; a click computes them again.
    const light = { ...run, recording: null };
    const tried = { values: { ...values }, quantities, run: light, strength: groups.strength, symmetry, outcome: outcomeOf(run), small: small && (before?.small ?? true), breakupNumber, groups };
    ++this.version;
    this.byKey.delete(key);
    this.byKey.set(key, tried);
    if (this.byKey.size > MOST_POINTS) {
      this.byKey.delete(/** @type {string} */ (this.byKey.keys().next().value));
      ++this.forgotten;
    }
    return tried;
  }

  clear() {
    this.byKey.clear();
    ++this.version;
    this.forgotten = 0;
  }

  get all() {
    return [...this.byKey.values()];
  }

  /** The points as CSV, in the columns of pinchoff's collisions table; not measured is empty. */
  csv() {
    const own = this.model.parameters.map((p) => p.name).filter((name) => !GROUPS.includes(name));
    const columns = [...COLUMNS.map(([name]) => name), ...own.map((name) => this.model.byName[name].column)];
    const rows = this.all.map((tried, k) => [
      ...COLUMNS.map(([, of]) => of(tried, k)),
      ...own.map((name) => this.model.value(tried.values, name)),
    ]);
    return [columns, ...rows].map((row) => row.map(cell).join(",")).join("\r\n") + "\r\n";
  }
}

/** @type {[string, (tried: Tried, k: number) => any][]} */
const COLUMNS = [
  ["source", () => "simulation"],
  ["collision_id", (_, k) => k],
  ...GROUPS.map((name) => /** @type {[string, (tried: Tried) => any]} */ ([name, (t) => t.values[name]])),
  ["capillary_number", (t) => t.groups.capillary],
  ["normalized_area", (t) => t.groups.area],
  ["normalized_thickness", (t) => t.groups.thickness],
  ["symmetry", (t) => t.symmetry],
  ["breakup_number", (t) => t.breakupNumber],
  ["outcome", (t) => t.outcome],
  ["broke", (t) => (t.outcome === "failed" && !(t.run.result.breakup_count > 0) ? NaN : t.run.result.breakup_count > 0)],
  ["accepted", (t) => t.outcome !== "failed" && Number.isFinite(t.symmetry)],
  ["impact_parameter", (t) => t.run.result.impact_parameter],
  ["speed", (t) => t.run.result.contact_speed],
  ["contact_time", (t) => t.run.result.contact_time],
  ["neck_thickness", (t) => t.run.result.minimum_neck],
  ["maximum_shape_parameter", (t) => t.run.result.maximum_shape_parameter],
  ["daughter_area_ratio", (t) => t.run.result.small_daughter_area / t.run.result.large_daughter_area],
  ["breakup_time", (t) => t.run.result.breakup_time],
  ["breakup_neck", (t) => t.run.result.breakup_neck],
  ["breakup_count", (t) => t.run.result.breakup_count],
  ["droplet_count", (t) => t.run.result.droplet_count],
  ["end_time", (t) => t.run.result.end_time],
  // In the laboratory's units, where they were chosen; empty where not.
  ["contact_time_s", (t) => physical(t, (q) => secondsOf(t.run.result.contact_time, q))],
  ["area_um2", (t) => physical(t, (q) => t.run.result.contact_area * q.diameter ** 2)],
  ["speed_mm_s", (t) => physical(t, (q) => t.run.result.contact_speed * q.speed)],
  ["neck_um", (t) => physical(t, (q) => t.run.result.minimum_neck * q.diameter)],
  ["obstacle_radius_um", (t) => physical(t, (q) => q.obstacle_radius)],
  ["thickness_um", (t) => physical(t, (q) => q.thickness)],
  ["viscosity_mPa_s", (t) => physical(t, (q) => q.viscosity)],
  ["surface_tension_mN_m", (t) => physical(t, (q) => q.surface_tension)],
];

/** @param {Tried} tried @param {(quantities: Quantities) => number} of */
function physical(tried, of) {
  return tried.quantities ? of(tried.quantities) : NaN;
}

/** @param {any} value */
function cell(value) {
  if (value === null) return "";
  if (typeof value === "number") return Number.isFinite(value) ? String(value) : "";
  const text = String(value);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
