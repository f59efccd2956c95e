// @ts-check
// The outlines of a run at any time, from those that were recorded.
import { COUNT, ENDS, ID, INFO } from "./engine.js";

/** @typedef {import("./engine.js").Recording} Recording */

/** Vertices of droplet k. @param {Recording} recording @param {number} k */
export function outlineIn(recording, k) {
  return recording.vertices.subarray(2 * recording.first[k], 2 * recording.first[k + 1]);
}

/** The frame at or before a time. @param {Recording} recording @param {number} time */
function frameAt(recording, time) {
  let low = 0;
  let high = recording.times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (recording.times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

/**
 * The droplets at a time, between two records by the straight line, while they are the same droplets.
 * @param {Recording} recording @param {number} time
 * @returns {{info: Float64Array, points: ArrayLike<number>}[]}
 */
export function outlinesAt(recording, time) {
  const f = frameAt(recording, time);
  const [a, b] = [recording.frames[f], recording.frames[f + 1]];
  const same = f + 2 < recording.frames.length && recording.frames[f + 2] - b === b - a && sameDroplets(recording, a, b);
  const share = same ? Math.min(1, Math.max(0, (time - recording.times[f]) / (recording.times[f + 1] - recording.times[f]))) : 0;
  return Array.from({ length: b - a }, (_, k) => {
    const info = recording.info.slice((a + k) * INFO, (a + k + 1) * INFO);
    const here = outlineIn(recording, a + k);
    if (!share) return { info, points: here };
    const next = outlineIn(recording, b + k);
    const after = recording.info.subarray((b + k) * INFO, (b + k + 1) * INFO);
    // The neck may pass to other vertices from one record to the next: then it stays.
    const near = [0, 1, 2, 3].every((e) => Math.abs(info[ENDS + e] - after[ENDS + e]) < 0.15);
    if (near) for (let e = 0; e < 4; ++e) info[ENDS + e] += share * (after[ENDS + e] - info[ENDS + e]);
    return { info, points: here.map((value, e) => value + share * (next[e] - value)) };
  });
}

/** @param {Recording} recording @param {number} a @param {number} b */
function sameDroplets(recording, a, b) {
  for (let k = 0; k < b - a; ++k) {
    const [p, q] = [(a + k) * INFO, (b + k) * INFO];
    if (recording.info[p + ID] !== recording.info[q + ID] || recording.info[p + COUNT] !== recording.info[q + COUNT]) return false;
  }
  return true;
}

/** @param {ArrayLike<number>} points @returns {[number, number, number, number]} left, right, low, high */
export function extent(points) {
  let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
  for (let k = 0; k < points.length; k += 2) {
    left = Math.min(left, points[k]);
    right = Math.max(right, points[k]);
    low = Math.min(low, points[k + 1]);
    high = Math.max(high, points[k + 1]);
  }
  return [left, right, low, high];
}

/** @param {ArrayLike<number>} points */
export function centre(points) {
  let [x, y] = [0, 0];
  for (let k = 0; k < points.length; k += 2) [x, y] = [x + points[k], y + points[k + 1]];
  return [(2 * x) / points.length, (2 * y) / points.length];
}
