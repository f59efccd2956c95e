// @ts-check
// A run in words and numbers.
import { outcomeOf } from "./engine.js";
import { secondsOf, shown } from "./parameters.js";

/** @typedef {import("./points.js").Tried} Tried @typedef {import("./engine.js").Run} Run */

/** @type {Record<string, string>} */
export const WORDS = { broke: "breaks", slipped: "slips past", captured: "is caught", failed: "is stopped by a guard" };

/** A sentence or two about a run. @param {Tried} tried @param {Run} run */
export function summaryOf(tried, run) {
  const { symmetry, breakup_time: time } = run.result;
  const met = Number.isFinite(symmetry) ? `S = ${shown(symmetry)}, Bk = ${shown(tried.breakupNumber)}` : "no contact";
  const end = Number.isFinite(time) ? ` It breaks at ${shown(time)} t0.` : "";
  return `The droplet ${WORDS[outcomeOf(run)]}. ${met}.${end}`;
}

/** Lines about a point of the diagram. @param {Tried} tried */
export function linesOf({ outcome, breakupNumber, symmetry, groups, values, run: { result } }) {
  const ratio = result.small_daughter_area / result.large_daughter_area;
  return [
    `${WORDS[outcome]}   Bk = ${shown(breakupNumber)}`,
    `S = ${shown(symmetry)}   Ca = ${shown(groups.capillary)}`,
    `D0/R = ${shown(values.size_ratio)}   y = ${shown(values.offset)} D0`,
    ...(Number.isFinite(ratio) ? [`A1/A2 = ${shown(ratio)}`] : []),
  ].join("\n");
}

/**
 * Fill a list with the numbers of a run.
 * @param {HTMLElement} list @param {Tried} tried @param {Run} run
 */
export function showNumbers(list, tried, run) {
  const { result } = run;
  const { groups, breakupNumber, values, quantities: q } = tried;
  const time = (/** @type {number} */ t) => (q ? [shown(secondsOf(t, q)), "s"] : [shown(t), "t0"]);
  const length = (/** @type {number} */ x) => (q ? [shown(x * q.diameter), "µm"] : [shown(x), "D0"]);
  const neck = Number.isFinite(result.minimum_neck) ? result.minimum_neck : NaN;
  const side = breakupNumber > 1 ? "above the line" : breakupNumber <= 1 ? "below the line" : "";
  const daughters = result.droplet_count > 2 ? `${result.droplet_count} droplets` : "";
  const rows = [
    ["S", shown(result.symmetry)],
    ["Bk", shown(breakupNumber), side],
    ["Ca", shown(groups.capillary)],
    ["Ca Ã z̃", shown(groups.strength), `Ã = ${shown(groups.area)}`],
    ["impact b", ...length(result.impact_parameter)],
    ["contact", ...time(result.contact_time)],
    ["break-up", ...time(result.breakup_time)],
    ["A1/A2", shown(result.small_daughter_area / result.large_daughter_area), daughters],
    ["thinnest neck", ...length(neck)],
    ["largest 𝒜", shown(result.maximum_shape_parameter)],
    ["Ca_sim", shown(values.simulation_capillary_number)],
    ["D0/R", shown(values.size_ratio)],
  ];
  list.replaceChildren(...rows.map(([name, value, unit = ""]) => numberBox(name, value, unit)));
}

/** @param {string} name @param {string} value @param {string} unit */
function numberBox(name, value, unit) {
  const [box, dt, dd, small] = ["div", "dt", "dd", "small"].map((tag) => document.createElement(tag));
  dt.textContent = name;
  dd.textContent = `${value} `;
  small.textContent = value === "–" ? "" : unit;
  dd.append(small);
  box.append(dt, dd);
  return box;
}

/**
 * Buttons for the moments of a run, below the slider of time.
 * @param {HTMLElement} box @param {Run} run @param {number} end @param {(name: string) => void} goTo
 */
export function showMarks(box, run, end, goTo) {
  const moments = [["contact", run.contacts[0]?.time], ["break-up", run.breakups[0]?.time]];
  box.replaceChildren();
  let last = -1;
  for (const [name, time] of moments) {
    if (typeof time !== "number") continue;
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
    // Two moments close to each other: the words must not lie on each other.
    last = Math.min(0.95, Math.max(time / end, last + 0.19));
    button.style.left = `${100 * last}%`;
    button.onclick = () => goTo(String(name));
    box.append(button);
  }
}
