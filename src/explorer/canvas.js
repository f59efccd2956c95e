// @ts-check
// A canvas as sharp as the screen, colours from the style sheet, axes.

/** @typedef {{context: CanvasRenderingContext2D, width: number, height: number, font: number}} Surface */

/**
 * A canvas at the resolution of the screen, cleared; sizes in CSS pixels.
 * @param {HTMLCanvasElement} canvas @returns {Surface}
 */
export function surface(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const font = 0.82 * parseFloat(getComputedStyle(document.documentElement).fontSize);
  context.font = `${font}px system-ui, sans-serif`;
  context.lineJoin = "round";
  context.lineCap = "round";
  return { context, width, height, font };
}

/** @type {Map<string, string>} */
const colours = new Map();

/** Forget the colours: the theme has changed. */
export function forgetColours() {
  colours.clear();
}

/** @param {string} name of a colour in the style sheet */
export function colour(name) {
  let value = colours.get(name);
  if (value === undefined) {
    value = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
    colours.set(name, value);
  }
  return value;
}

/** Round numbers that divide a range. @param {number} low @param {number} high @param {number} about how many */
export function ticks(low, high, about) {
  const raw = (high - low) / about;
  const power = 10 ** Math.floor(Math.log10(raw));
  const steps = [0.5, 1, 2, 5, 10].map((k) => k * power);
  const place = steps.findIndex((s) => s >= raw * 0.999);
  const step = steps[place] > high - low ? steps[place - 1] : steps[place]; // never one tick alone
  const all = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) all.push(Number((k * step).toPrecision(12)));
  return all;
}

/** 1, 2, 5 of every decade in a range. @param {number} low @param {number} high */
export function logTicks(low, high) {
  const all = [];
  for (let decade = Math.floor(Math.log10(low)); decade <= Math.log10(high); ++decade)
    for (const k of [1, 2, 5]) {
      const tick = Number(`${k}e${decade}`);
      if (tick >= low * 0.999 && tick <= high * 1.001) all.push(tick);
    }
  return all;
}

/** @param {CanvasRenderingContext2D} context @param {number} x1 @param {number} y1 @param {number} x2 @param {number} y2 */
export function line(context, x1, y1, x2, y2) {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
}

/** Text with a halo, legible on anything. @param {CanvasRenderingContext2D} context @param {string} text
 * @param {number} x @param {number} y @param {string} ink @param {string} [halo] */
export function label(context, text, x, y, ink, halo = "fluid") {
  context.lineWidth = 4;
  context.strokeStyle = colour(halo);
  context.strokeText(text, x, y);
  context.fillStyle = colour(ink);
  context.fillText(text, x, y);
}
