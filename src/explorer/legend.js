// @ts-check
// What the marks and lines of the diagram mean; a line is shown or not by its box.
import { DASHES } from "./diagram.js";

const MARKS = [
  ["broke", '<circle cx="13" cy="6" r="4.5" fill="var(--broke)"/>'],
  ["did not", '<circle cx="13" cy="6" r="4.3" fill="none" stroke="var(--unbroken)" stroke-width="1.7"/>'],
  ["stopped", '<path d="M9 2L17 10M9 10L17 2" stroke="var(--failed)" stroke-width="1.7"/>'],
];
const YOURS = ["yours", '<path d="M13 0.5L18.5 6L13 11.5L7.5 6Z" fill="var(--broke)"/>'];

/**
 * @param {HTMLElement} box @param {import("./diagram.js").Line[]} lines @param {Set<string>} without lines that
 * are not shown @param {boolean} own whether there are points of the user's @param {() => void} onChange
 */
export function showLegend(box, lines, without, own, onChange) {
  const marks = (own ? [...MARKS, YOURS] : MARKS).map(([text, drawing]) => {
    const mark = Object.assign(document.createElement("span"), { className: "mark" });
    mark.append(symbol(drawing), text);
    return mark;
  });
  const toggles = lines.map((line, k) => {
    const label = document.createElement("label");
    const tick = Object.assign(document.createElement("input"), { type: "checkbox", checked: !without.has(line.name) });
    tick.onchange = () => {
      if (tick.checked) without.delete(line.name);
      else without.add(line.name);
      onChange();
    };
    const dashes = DASHES[k % DASHES.length].map((long) => 0.75 * long).join(" ");
    const drawing = `<path d="M1 6H25" stroke="var(--${CSS.escape(line.name)})" stroke-width="2.2" stroke-dasharray="${dashes}"/>`;
    label.append(tick, symbol(drawing), line.label);
    return label;
  });
  box.replaceChildren(...marks, ...toggles);
}

/** A drawing of our own; never of text from a file. @param {string} drawing */
function symbol(drawing) {
  const text = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 26 12" aria-hidden="true">${drawing}</svg>`;
  return document.importNode(new DOMParser().parseFromString(text, "image/svg+xml").documentElement, true);
}
