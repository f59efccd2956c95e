// @ts-check
// What a scene is drawn of: pillar, outlines, the halves of a contact, a neck, the scale bar.
import { colour, label } from "./canvas.js";
import { ENDS } from "./engine.js";

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} radius */
export function drawPillar(context, x, y, radius) {
  context.fillStyle = colour("pillar");
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}

/** @param {CanvasRenderingContext2D} context @param {import("./scene.js").View} v @param {number} font @param {string} word */
export function drawScaleBar(context, v, font, word) {
  const long = v.scale > 30 ? 1 : 2;
  const x = v.width - 14;
  const y = v.height - 14;
  context.strokeStyle = colour("ink");
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(x - long * v.scale, y);
  context.lineTo(x, y);
  context.stroke();
  context.textAlign = "right";
  context.font = `${font}px system-ui, sans-serif`;
  label(context, long === 1 ? word : `${long} × ${word}`, x, y - 6, "ink");
}

/** @param {CanvasRenderingContext2D} context @param {ArrayLike<number>} points x, y, …
 * @param {(x: number) => number} X @param {(y: number) => number} Y */
export function drawOutline(context, points, X, Y) {
  trace(context, points, X, Y);
  context.fillStyle = colour("droplet");
  context.globalAlpha = 0.92;
  context.fill();
  context.globalAlpha = 1;
  context.strokeStyle = colour("rim");
  context.lineWidth = 2.2;
  context.stroke();
}

/** @param {CanvasRenderingContext2D} context @param {ArrayLike<number>} points
 * @param {(x: number) => number} X @param {(y: number) => number} Y */
function trace(context, points, X, Y) {
  context.beginPath();
  for (let k = 0; k < points.length; k += 2) context.lineTo(X(points[k]), Y(points[k + 1]));
  context.closePath();
}

/**
 * The centre line of a contact, through the pillar's centre along the velocity, and the smaller half.
 * @param {CanvasRenderingContext2D} context @param {import("./engine.js").Contact} contact
 * @param {{points: ArrayLike<number>} | undefined} droplet @param {import("./scene.js").View} v
 * @param {(x: number) => number} X @param {(y: number) => number} Y
 */
export function drawHalves(context, contact, droplet, v, X, Y) {
  const speed = Math.hypot(contact.vx, contact.vy);
  const [ux, uy] = [contact.vx / speed, contact.vy / speed];
  const far = 4 * (v.right - v.left);
  if (droplet) {
    // The half on the side of the line away from the droplet's centre is the smaller one.
    const side = Math.sign(ux * contact.y - uy * contact.x) || 1;
    context.save();
    trace(context, droplet.points, X, Y);
    context.clip();
    context.beginPath();
    for (const [a, b] of [[-far, 0], [far, 0], [far, -far], [-far, -far]])
      context.lineTo(X(a * ux - side * b * uy), Y(a * uy + side * b * ux));
    context.closePath();
    context.fillStyle = colour("half");
    context.globalAlpha = 0.5;
    context.fill();
    context.restore();
  }
  context.strokeStyle = colour("centre");
  context.lineWidth = 1.6;
  context.setLineDash([9, 5]);
  context.beginPath();
  context.moveTo(X(-far * ux), Y(-far * uy));
  context.lineTo(X(far * ux), Y(far * uy));
  context.stroke();
  context.setLineDash([]);
}

/** @param {CanvasRenderingContext2D} context @param {ArrayLike<number>} info
 * @param {(x: number) => number} X @param {(y: number) => number} Y */
export function drawNeck(context, info, X, Y) {
  context.strokeStyle = colour("neck");
  context.lineWidth = 3;
  context.beginPath();
  context.moveTo(X(info[ENDS]), Y(info[ENDS + 1]));
  context.lineTo(X(info[ENDS + 2]), Y(info[ENDS + 3]));
  context.stroke();
}
