// @ts-check
// The diagram: S against Ca Ã z̃, the paper's lines, every collision tried, and the user's own.
import { colour, label, line, logTicks, surface, ticks } from "./canvas.js";

/**
 * @typedef {{strength: number, symmetry: number, outcome: string, own?: number, tried?: number,
 *   small?: boolean}} Point own: row of the user's table; tried: number of a collision tried here
 * @typedef {{name: string, label: string, alpha: number, beta: number}} Line
 */

/** Dashes of the lines in their order, in the diagram and in its legend. */
export const DASHES = [[7, 4], [2, 4], [9, 3, 2, 3]];

export class Diagram {
  /** @param {HTMLCanvasElement} canvas @param {Line[]} lines */
  constructor(canvas, lines) {
    this.canvas = canvas;
    this.lines = lines;
    /** @type {Set<string>} lines that are not shown */
    this.without = new Set(["paper-rounded"]);
    this.logarithmic = false;
    /** @type {Point[]} */
    this.points = [];
    /** @type {Point | null} the collision at hand */
    this.here = null;
    /** @type {Point | null} */
    this.chosen = null;
    this.frame = { left: 50, top: 10, right: 10, bottom: 40 };
    this.range = { x: [0.01, 1], y: [0, 1] };
    this.layer = document.createElement("canvas");
    this.drawn = "";
  }

  #measure() {
    const seen = [...this.points, ...(this.here ? [this.here] : [])].filter(drawable);
    let [low, high] = [0.02, 0.5];
    let least = 0.08;
    for (const { strength, symmetry } of seen) {
      low = Math.min(low, strength / 1.15);
      high = Math.max(high, strength * 1.15);
      if (symmetry > 0) least = Math.min(least, symmetry / 1.2);
    }
    this.range = { x: [low, high], y: this.logarithmic ? [Math.max(least, 0.005), 1.15] : [0, 1.04] };
  }

  /** @param {number} strength */
  X(strength) {
    const [low, high] = this.range.x;
    const { left, right } = this.frame;
    return left + (Math.log(strength / low) / Math.log(high / low)) * (this.canvas.clientWidth - left - right);
  }

  /** @param {number} symmetry */
  Y(symmetry) {
    const [low, high] = this.range.y;
    const { top, bottom } = this.frame;
    const share = this.logarithmic ? Math.log(Math.max(symmetry, low) / low) / Math.log(high / low) : (symmetry - low) / (high - low);
    return this.canvas.clientHeight - bottom - share * (this.canvas.clientHeight - top - bottom);
  }

  /** @param {number} px @param {number} py @returns {{strength: number, symmetry: number}} */
  toPlane(px, py) {
    const { left, right, top, bottom } = this.frame;
    const [xLow, xHigh] = this.range.x;
    const [yLow, yHigh] = this.range.y;
    const x = (px - left) / (this.canvas.clientWidth - left - right);
    const y = (this.canvas.clientHeight - bottom - py) / (this.canvas.clientHeight - top - bottom);
    const symmetry = this.logarithmic ? yLow * (yHigh / yLow) ** y : yLow + y * (yHigh - yLow);
    return { strength: xLow * (xHigh / xLow) ** x, symmetry: Math.min(1, Math.max(0, symmetry)) };
  }

  /** The nearest point within reach, px. @param {number} px @param {number} py @param {number} reach */
  near(px, py, reach) {
    let best = null;
    let least = reach;
    for (const point of this.points) {
      if (!drawable(point)) continue;
      const distance = Math.hypot(this.X(point.strength) - px, this.Y(point.symmetry) - py);
      // The newest of those in one place, and never a small one before a large one.
      if (distance < least || (distance === least && best)) [best, least] = [point, distance];
    }
    return best;
  }

  /**
   * Axes, lines and points are drawn once and kept: with thousands of points that takes longer than
   * a frame of the film beside them.
   * @param {string} version changes with whatever they show
   */
  draw(version) {
    const { context, width, height, font } = surface(this.canvas);
    const here = this.here && drawable(this.here) ? this.here : null;
    const key = [version, width, height, font, here?.strength, here?.symmetry, this.logarithmic, [...this.without]].join(" ");
    if (key !== this.drawn) {
      this.drawn = key;
      this.frame = { left: (this.logarithmic ? 4.6 : 3.6) * font, top: 0.6 * font, right: 0.9 * font, bottom: 3.1 * font };
      this.#measure();
      this.#drawAxes(context, width, height, font);
      const order = (/** @type {Point} */ p) => (p.own !== undefined ? 0 : p.small ? 1 : 2);
      for (const point of [...this.points].sort((a, b) => order(a) - order(b))) if (drawable(point)) this.#drawPoint(context, point);
      context.save();
      context.beginPath();
      context.rect(this.frame.left, this.frame.top, width - this.frame.left - this.frame.right, height - this.frame.top - this.frame.bottom);
      context.clip();
      this.lines.forEach((line, k) => this.#drawLine(context, line, DASHES[k % DASHES.length]));
      context.restore();
      [this.layer.width, this.layer.height] = [this.canvas.width, this.canvas.height];
      this.layer.getContext("2d")?.drawImage(this.canvas, 0, 0);
    } else context.drawImage(this.layer, 0, 0, width, height);
    if (this.chosen && drawable(this.chosen)) this.#drawRing(context, this.chosen, "captured", 9);
    if (here) this.#drawHere(context, here, font);
  }

  /** @param {CanvasRenderingContext2D} context @param {number} width @param {number} height @param {number} font */
  #drawAxes(context, width, height, font) {
    const { left, top, right, bottom } = this.frame;
    const [xs, ys] = [logTicks(.../** @type {[number, number]} */ (this.range.x)), this.logarithmic ? logTicks(this.range.y[0], this.range.y[1]) : ticks(0, 1, 5)];
    context.lineWidth = 1;
    context.fillStyle = colour("faint");
    context.strokeStyle = colour("line");
    context.textAlign = "center";
    let lastEnd = -Infinity;
    for (const x of xs) {
      const px = Math.round(this.X(x)) + 0.5;
      line(context, px, top, px, height - bottom);
      const text = String(x);
      if (px - 0.3 * font * text.length > lastEnd + 6) {
        context.fillText(text, px, height - bottom + 1.25 * font);
        lastEnd = px + 0.3 * font * text.length;
      }
    }
    context.textAlign = "right";
    for (const y of ys) {
      const py = Math.round(this.Y(y)) + 0.5;
      line(context, left, py, width - right, py);
      context.fillText(String(y), left - 6, py + 0.35 * font);
    }
    context.fillStyle = colour("ink");
    context.textAlign = "center";
    context.fillText("Ca Ã z̃", (left + width - right) / 2, height - 0.5 * font);
    context.save();
    context.translate(font, (top + height - bottom) / 2);
    context.rotate(-Math.PI / 2);
    context.fillText("symmetry S", 0, 0);
    context.restore();
  }

  /** @param {CanvasRenderingContext2D} context @param {Line} law @param {number[]} dashes */
  #drawLine(context, law, dashes) {
    if (this.without.has(law.name)) return;
    const [low, high] = this.range.x;
    context.strokeStyle = colour(law.name);
    context.lineWidth = 2;
    context.setLineDash(dashes);
    context.beginPath();
    for (let k = 0; k <= 100; ++k) {
      const x = low * (high / low) ** (k / 100);
      context.lineTo(this.X(x), this.Y(Math.min(law.alpha * x ** law.beta, 3)));
    }
    context.stroke();
    context.setLineDash([]);
  }

  /** @param {CanvasRenderingContext2D} context @param {Point} point */
  #drawPoint(context, point) {
    const [x, y] = [this.X(point.strength), this.Y(point.symmetry)];
    const size = point.small ? (this.points.length > 3000 ? 1.8 : 3) : 4.6;
    const broke = point.outcome === "broke";
    context.globalAlpha = point.small ? 0.75 : 1;
    context.strokeStyle = context.fillStyle = colour(point.outcome === "slipped" ? "unbroken" : point.outcome);
    context.lineWidth = size < 2 ? 1 : 1.6;
    context.beginPath();
    if (point.outcome === "failed") {
      for (const side of [-1, 1]) {
        context.moveTo(x - size, y - side * size);
        context.lineTo(x + size, y + side * size);
      }
    } else if (point.own !== undefined) {
      for (const [dx, dy] of [[0, -1.35], [1.35, 0], [0, 1.35], [-1.35, 0]]) context.lineTo(x + size * dx, y + size * dy);
      context.closePath();
    } else if (point.outcome === "captured") context.rect(x - size, y - size, 2 * size, 2 * size);
    else context.arc(x, y, size, 0, 2 * Math.PI);
    if (broke) context.fill();
    else {
      context.fillStyle = colour("card");
      context.fill();
      context.stroke();
    }
    context.globalAlpha = 1;
  }

  /** @param {CanvasRenderingContext2D} context @param {Point} point @param {string} ink @param {number} radius */
  #drawRing(context, point, ink, radius) {
    context.strokeStyle = colour(ink);
    context.lineWidth = 2.6;
    context.beginPath();
    context.arc(this.X(point.strength), this.Y(point.symmetry), radius, 0, 2 * Math.PI);
    context.stroke();
  }

  /** @param {CanvasRenderingContext2D} context @param {Point} here @param {number} font */
  #drawHere(context, here, font) {
    this.#drawPoint(context, here);
    this.#drawRing(context, here, "ink", 10);
    const [x, y] = [this.X(here.strength), this.Y(here.symmetry)];
    const right = x < this.canvas.clientWidth - 6 * font;
    context.textAlign = right ? "left" : "right";
    label(context, "now", x + (right ? 15 : -15), y + 0.35 * font, "ink", "card");
  }
}

/** @param {Point} point */
function drawable(point) {
  return point.strength > 0 && Number.isFinite(point.strength) && Number.isFinite(point.symmetry);
}
