// @ts-check
// Neck, shape parameter and area of every droplet against time, on one axis of time.
import { colour, line, surface, ticks } from "./canvas.js";
import { AREA, ID, INFO, NECK, SHAPE } from "./engine.js";

/** @typedef {import("./engine.js").Run} Run */

const REFERENCE_AREA = Math.PI / 4; // of the undeformed droplet, D0²
const SHADES = ["rim", "centre", "neck", "broke", "unbroken", "captured"];

export class Traces {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {Run | null} */
    this.run = null;
    this.time = 0;
    this.from = 0;
    this.threshold = 0;
    this.left = 46;
    this.units = { time: 1, timeWord: "t / t0", length: 1, neckWord: "neck / D0" };
  }

  /** @param {number} px @returns {number} */
  toTime(px) {
    const times = this.run?.recording?.times;
    const end = times?.at(-1) ?? 1;
    return this.from + ((px - this.left) / (this.canvas.clientWidth - this.left - 10)) * (end - this.from);
  }

  draw() {
    const { context, width, height, font } = surface(this.canvas);
    const recording = this.run?.recording;
    if (!recording) return;
    this.left = 3.6 * font;
    const end = /** @type {number} */ (recording.times.at(-1));
    const X = (/** @type {number} */ t) => this.left + ((t - this.from) / (end - this.from)) * (width - this.left - 10);
    const bottom = 1.5 * font;
    const each = (height - bottom) / 3;
    const panels = [
      { name: this.units.neckWord, of: NECK, unit: 1 / this.units.length, floor: 0, least: this.units.length },
      { name: "𝒜", of: SHAPE, unit: 1, floor: 1, least: 1.5 },
      { name: "area / A0", of: AREA, unit: REFERENCE_AREA, floor: 0, least: 1.1 },
    ];
    panels.forEach(({ name, of, unit, floor, least }, row) => {
      const curves = curvesOf(recording, of, unit);
      let most = least;
      for (const curve of curves.values()) for (const [t, value] of curve) if (t >= this.from && Number.isFinite(value)) most = Math.max(most, value);
      const [top, low] = [row * each + 1.5 * font, (row + 1) * each - 0.4 * font];
      const Y = (/** @type {number} */ y) => low - ((y - floor) / (most - floor)) * (low - top);
      context.strokeStyle = colour("line");
      context.lineWidth = 1;
      context.fillStyle = colour("faint");
      context.textAlign = "right";
      for (const tick of ticks(floor, most, Math.max(1, Math.floor((low - top) / (1.5 * font))))) {
        line(context, this.left, Y(tick), width - 10, Y(tick));
        context.fillText(String(tick), this.left - 6, Y(tick) + 0.35 * font);
      }
      if (of === NECK && this.threshold) {
        context.setLineDash([5, 4]);
        context.strokeStyle = colour("neck");
        const y = Y(this.threshold * this.units.length);
        line(context, this.left, y, width - 10, y);
        context.setLineDash([]);
      }
      for (const [id, curve] of curves) drawCurve(context, curve, X, Y, colour(SHADES[id % SHADES.length]), this.from);
      context.textAlign = "left";
      context.fillStyle = colour("ink");
      context.fillText(name, this.left, top - 0.4 * font);
    });
    this.#drawTime(context, X, width, height, font, end);
  }

  /** @param {CanvasRenderingContext2D} context @param {(t: number) => number} X @param {number} width
   * @param {number} height @param {number} font @param {number} end */
  #drawTime(context, X, width, height, font, end) {
    context.textAlign = "center";
    context.fillStyle = colour("faint");
    const { time: factor, timeWord } = this.units;
    for (const tick of ticks(this.from * factor, end * factor, Math.max(2, width / 110)))
      if (X(tick / factor) < width - 4.2 * font) context.fillText(String(tick), X(tick / factor), height - 0.3 * font);
    context.textAlign = "right";
    context.fillText(timeWord, width - 4, height - 0.3 * font);
    context.strokeStyle = colour("faint");
    context.lineWidth = 1;
    const vertical = (/** @type {number} */ time) => line(context, X(time), 0, X(time), height - 1.5 * font);
    context.setLineDash([2, 3]);
    for (const time of [this.run?.contacts[0]?.time, this.run?.breakups[0]?.time]) if (time !== undefined) vertical(time);
    context.setLineDash([]);
    context.strokeStyle = colour("accent");
    context.lineWidth = 2;
    vertical(Math.max(this.from, this.time));
  }
}

/** @param {import("./engine.js").Recording} recording @param {number} of @param {number} unit
 * @returns {Map<number, [number, number][]>} by droplet: time and value */
function curvesOf(recording, of, unit) {
  const curves = new Map();
  for (let f = 0; f + 1 < recording.frames.length; ++f)
    for (let k = recording.frames[f]; k < recording.frames[f + 1]; ++k) {
      const id = recording.info[k * INFO + ID];
      if (!curves.has(id)) curves.set(id, []);
      curves.get(id).push([recording.times[f], recording.info[k * INFO + of] / unit]);
    }
  return curves;
}

/** @param {CanvasRenderingContext2D} context @param {[number, number][]} curve @param {(t: number) => number} X
 * @param {(y: number) => number} Y @param {string} ink @param {number} from */
function drawCurve(context, curve, X, Y, ink, from) {
  context.strokeStyle = ink;
  context.lineWidth = 1.8;
  context.beginPath();
  let drawing = false;
  for (const [time, value] of curve) {
    const seen = time >= from && Number.isFinite(value);
    if (seen && drawing) context.lineTo(X(time), Y(value));
    else if (seen) context.moveTo(X(time), Y(value));
    drawing = seen;
  }
  context.stroke();
}
