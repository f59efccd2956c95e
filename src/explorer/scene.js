// @ts-check
// The scene: the flow, the pillar, the droplets at one time, and what is measured on them.
import { colour, label, surface } from "./canvas.js";
import { AREA, ID, INFO, NECK } from "./engine.js";
import { shown } from "./parameters.js";
import { centre, extent, outlineIn, outlinesAt } from "./recording.js";
import { drawFluid, drawHalves, drawNeck, drawOutline, drawPillar, drawScaleBar, Plane } from "./shapes.js";

/** @typedef {import("./engine.js").Run} Run @typedef {import("./engine.js").Recording} Recording */

/** Time around first contact in which the halves of the droplet are shown, t0. */
const CONTACT_SHOWN = 0.3;
const STREAKS = 130;

/** What part of the plane is seen. @param {number} radius @param {number} offset @param {number} width @param {number} height px */
function viewOf(radius, offset, width, height) {
  const left = -radius - (width < 500 ? 1.5 : 1.9);
  const right = radius <= 1.5 ? radius + (width < 500 ? 1.6 : 2.3) : -radius + 3.2;
  const tall = 2 * (Math.abs(offset) + 0.62); // the droplet's start is in view
  const wide = (tall * width) / height;
  const extra = Math.max(0, wide - (right - left)) / 2;
  return new Plane(left - extra, width / (right - left + 2 * extra), width, height);
}

export class Scene {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {Run | null} */
    this.run = null;
    this.radius = 0.2;
    this.offset = 0;
    this.time = 0;
    this.hover = false;
    /** @type {number[][]} */
    this.streaks = [];
    this.streaksFor = "";
    /** @type {((x: number, y: number) => Float64Array) | null} fluid velocity */
    this.velocity = null;
    this.unitWord = "D0";
  }

  get view() {
    return viewOf(this.radius, this.offset, this.canvas.clientWidth || 600, this.canvas.clientHeight || 300);
  }

  /** Where the offset's handle is, D0. */
  get handle() {
    const { left, right } = this.view;
    return left + 0.13 * (right - left);
  }

  /** @param {number} px @param {number} py @returns {[number, number]} */
  toPlane(px, py) {
    const v = this.view;
    return [v.left + px / v.scale, (v.height / 2 - py) / v.scale];
  }

  /** Whether a point takes hold of the droplet: on it, or at its handle. @param {number} x @param {number} y */
  holds(x, y) {
    const grip = 14 / this.view.scale;
    if (Math.hypot(x - this.handle, y - this.offset) < 0.5 + grip) return true;
    if (!this.run?.recording) return false;
    return outlinesAt(this.run.recording, this.time).some(({ points }) => {
      const [left, right, low, high] = extent(points);
      return x > left - grip && x < right + grip && y > low - grip && y < high + grip;
    });
  }

  /** First time at which the droplet is in view. */
  get entry() {
    const recording = this.run?.recording;
    if (!recording) return 0;
    const { left } = this.view;
    for (let f = 0; f + 1 < recording.frames.length; ++f) {
      const [, right] = extent(outlineIn(recording, recording.frames[f]));
      if (right > left) return recording.times[f];
    }
    return 0;
  }

  /** Carry the streaks with the fluid. @param {number} step t0 */
  drift(step) {
    if (!this.velocity) return;
    const { left, right } = this.view;
    for (const streak of this.streaks) {
      const [u, v] = this.velocity(streak[0], streak[1]);
      streak[0] += u * step;
      streak[1] += v * step;
      if (streak[0] > right + 0.2) streak[0] -= right - left + 0.4;
    }
  }

  draw() {
    const { context, font } = surface(this.canvas);
    const v = this.view;
    drawFluid(context, v);
    this.#drawStreaks(context, v);
    drawPillar(context, v, this.radius);
    if (this.run?.recording) this.#drawPath(context, v, this.run.recording);
    this.#drawHandle(context, v);
    if (this.run?.recording) this.#drawDroplets(context, v, this.run, this.run.recording, font);
    drawScaleBar(context, v, font, this.unitWord);
  }

  /** @param {CanvasRenderingContext2D} context @param {Plane} v */
  #drawStreaks(context, v) {
    if (!this.velocity) return;
    const tall = v.height / v.scale;
    const key = `${this.radius} ${v.left} ${v.right} ${tall}`;
    if (key !== this.streaksFor) {
      // An additive sequence covers the view evenly, and is the same at every visit.
      this.streaks = Array.from({ length: STREAKS }, (_, k) => [
        v.left + ((0.5 + k * 0.7548776662466927) % 1) * (v.right - v.left),
        ((0.5 + k * 0.5698402909980532) % 1 - 0.5) * tall,
      ]);
      this.streaksFor = key;
    }
    context.strokeStyle = colour("stream");
    context.lineWidth = 1.2;
    context.beginPath();
    for (const [x, y] of this.streaks) {
      if (Math.hypot(x, y) < this.radius) continue;
      const [u, w] = this.velocity(x, y);
      const long = 0.13 / Math.max(1, Math.hypot(u, w));
      context.moveTo(v.X(x), v.Y(y));
      context.lineTo(v.X(x + long * u), v.Y(y + long * w));
    }
    context.stroke();
  }

  /** The way of the droplet's centre until it breaks.
   * @param {CanvasRenderingContext2D} context @param {Plane} v @param {Recording} recording */
  #drawPath(context, v, recording) {
    context.setLineDash([2, 5]);
    context.strokeStyle = colour("faint");
    context.lineWidth = 1;
    context.beginPath();
    for (let f = 0; f + 1 < recording.frames.length; f += 3) {
      const k = recording.frames[f];
      if (recording.info[k * INFO + ID] !== 0) break;
      const [x, y] = centre(outlineIn(recording, k));
      context.lineTo(v.X(x), v.Y(y));
    }
    context.stroke();
    context.setLineDash([]);
  }

  /** @param {CanvasRenderingContext2D} context @param {Plane} v */
  #drawHandle(context, v) {
    const [x, y] = [v.X(this.handle), v.Y(this.offset)];
    context.strokeStyle = context.fillStyle = colour(this.hover ? "accent" : "faint");
    context.lineWidth = this.hover ? 2 : 1.2;
    context.setLineDash([5, 5]);
    context.beginPath();
    context.arc(x, y, 0.5 * v.scale, 0, 2 * Math.PI);
    context.stroke();
    context.setLineDash([]);
    for (const side of [-1, 1]) {
      context.beginPath();
      context.moveTo(x - 6, y + side * 7);
      context.lineTo(x + 6, y + side * 7);
      context.lineTo(x, y + side * 14);
      context.fill();
    }
  }

  /** @param {CanvasRenderingContext2D} context @param {Plane} v @param {Run} run @param {Recording} recording
   * @param {number} font */
  #drawDroplets(context, v, run, recording, font) {
    const now = outlinesAt(recording, this.time);
    const contact = run.contacts[0];
    const halves = contact && Math.abs(this.time - contact.time) < CONTACT_SHOWN;
    for (const { points } of now) drawOutline(context, v, points);
    if (halves) drawHalves(context, v, contact, now.find((d) => d.info[ID] === contact.droplet));
    for (const { info } of now) {
      const touched = contact && this.time >= contact.time;
      if (touched && Number.isFinite(info[NECK]) && info[NECK] < 0.75 * Math.sqrt((4 * info[AREA]) / Math.PI)) drawNeck(context, v, info);
    }
    const right = Math.max(...now.map(({ points }) => extent(points)[1]));
    if (right < v.left) {
      context.textAlign = "left";
      label(context, `◂ the droplet is ${shown(v.left - right, 2)} D0 upstream`, 12, v.height - 14 - font, "faint");
    }
    if (halves) {
      context.textAlign = "left";
      label(context, `S = ${shown(contact.symmetry)}`, v.X(this.radius) + 12, v.Y(0) - 10, "centre");
    }
  }
}
