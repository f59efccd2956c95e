// @ts-check
// All of the page in the address: what was set, what was tried, and how it is looked at.
import { GROUPS } from "./parameters.js";

/** More points than this would make an address that programs cut off. */
export const MOST_LINKED = 150;

/** What differs between the points of a link, in their order; all else is that of the state. */
export const OF_POINTS = [...GROUPS].reverse();

/**
 * @typedef {{values: Record<string, any>, quantities: Record<string, number> | null, time: number,
 *   logarithmic: boolean, without: string[], map: string, tried: number[][]}} Linked
 *   map: "count" of a side, or nothing; tried: offset, Ca_sim and D0/R of points
 */

/**
 * @param {Linked} state @param {import("./parameters.js").Model} model
 * @returns {string} the fragment, with its #
 */
export function fragmentOf(state, model) {
  const query = new URLSearchParams();
  for (const name of GROUPS) query.set(name, String(state.values[name]));
  for (const name of model.differing(state.values)) query.set(name, String(state.values[name]));
  if (state.quantities) for (const [name, value] of Object.entries(state.quantities)) query.set(`physical.${name}`, String(value));
  query.set("t", String(Number(state.time.toFixed(3))));
  if (state.logarithmic) query.set("logS", "1");
  if (state.without.length) query.set("without", state.without.join("."));
  if (state.map) query.set("map", state.map);
  if (state.tried.length) query.set("tried", state.tried.map((p) => p.join("_")).join("~"));
  return `#${query}`;
}

/**
 * Read a fragment; what is wrong is left out and named.
 * @param {string} fragment @param {import("./parameters.js").Model} model @param {string[]} quantityNames
 * @returns {{state: Linked, wrong: string[]}}
 */
export function readFragment(fragment, model, quantityNames) {
  const query = new URLSearchParams(fragment.replace(/^#/, ""));
  const values = model.defaults();
  const wrong = [];
  for (const { name } of model.parameters) {
    const text = query.get(name);
    if (text === null) continue;
    const value = model.read(name, text);
    const refusal = model.refusal(name, value);
    if (refusal) wrong.push(refusal);
    else values[name] = value;
  }
  const numbers = quantityNames.map((name) => [name, Number(query.get(`physical.${name}`) ?? NaN)]);
  const whole = numbers.every(([name, value]) => Number.isFinite(value) && (name === "offset" || Number(value) > 0));
  const tried = (query.get("tried") ?? "").split("~").filter(Boolean).map((p) => p.split("_").map(Number));
  const good = tried.filter((p) => p.length === 3 && p.every((value, k) => !model.refusal(OF_POINTS[k], value)));
  if (good.length < tried.length) wrong.push(`${tried.length - good.length} points of the link cannot be read`);
  return {
    state: {
      values,
      quantities: whole ? Object.fromEntries(numbers) : null,
      time: Math.max(0, Number(query.get("t")) || 0),
      logarithmic: query.get("logS") === "1",
      without: (query.get("without") ?? "").split(".").filter(Boolean),
      map: query.get("map") ?? "",
      tried: good.slice(0, MOST_LINKED),
    },
    wrong,
  };
}
