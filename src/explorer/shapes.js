// @ts-check
// What a scene is drawn of: pillar, outlines, the halves of a contact, a neck, the scale bar.
import { colour, label, line } from "./canvas.js";
import { ENDS } from "./engine.js";

/** A part of the plane on a canvas: the flow's axis in the middle of its height, lengths in D0. */
export class Plane {
  /** @param {number} left its end @param {number} scale pixels a D0 @param {number} width @param {number} height px */
  constructor(left, scale, width, height) {
    this.left = left;
    this.scale = scale;
    this.width = width;
    this.height = height;
  }

  get right() {
    return this.left + this.width / this.scale;
  }

  /** @param {number} x */
  X(x) {
    return (x - this.left) * this.scale;
  }

  /** @param {number} y */
  Y(y) {
    return this.height / 2 - y * this.scale;
  }
}

/** @param {CanvasRenderingContext2D} context @param {Plane} plane */
export function drawFluid(context, plane) {
  context.fillStyle = colour("fluid");
  context.fillRect(0, 0, plane.width, plane.height);
}

/** @param {CanvasRenderingContext2D} context @param {Plane} plane @param {number} radius */
export function drawPillar(context, plane, radius) {
  context.fillStyle = colour("pillar");
  context.beginPath();
  context.arc(plane.X(0), plane.Y(0), radius * plane.scale, 0, 2 * Math.PI);
  context.fill();
}

/** @param {CanvasRenderingContext2D} context @param {Plane} plane @param {number} font @param {string} word */
export function drawScaleBar(context, plane, font, word) {
  const long = plane.scale > 30 ? 1 : 2;
  const [x, y] = [plane.width - 14, plane.height - 14];
  context.strokeStyle = colour("ink");
  context.lineWidth = 2;
  line(context, x - long * plane.scale, y, x, y);
  context.textAlign = "right";
  context.font = `${font}px system-ui, sans-serif`;
  label(context, long === 1 ? word : `${long} × ${word}`, x, y - 6, "ink");
}

/** @param {CanvasRenderingContext2D} context @param {Plane} plane @param {ArrayLike<number>} points x, y, … */
export function drawOutline(context, plane, points) {
  trace(context, plane, points);
  context.fillStyle = colour("droplet");
  context.globalAlpha = 0.92;
  context.fill();
  context.globalAlpha = 1;
  context.strokeStyle = colour("rim");
  context.lineWidth = 2.2;
  context.stroke();
}

/** @param {CanvasRenderingContext2D} context @param {Plane} plane @param {ArrayLike<number>} points */
function trace(context, plane, points) {
  context.beginPath();
  for (let k = 0; k < points.length; k += 2) context.lineTo(plane.X(points[k]), plane.Y(points[k + 1]));
  context.closePath();
}

/**
 * The centre line of a contact, through the pillar's centre along the velocity, and the smaller half.
 * @param {CanvasRenderingContext2D} context @param {Plane} plane @param {import("./engine.js").Contact} contact
 * @param {{points: ArrayLike<number>} | undefined} droplet
 */
export function drawHalves(context, plane, contact, droplet) {
  const speed = Math.hypot(contact.vx, contact.vy);
  const [ux, uy] = [contact.vx / speed, contact.vy / speed];
  const far = 4 * (plane.right - plane.left);
  if (droplet) {
    // The half on the side of the line away from the droplet's centre is the smaller one.
    const side = Math.sign(ux * contact.y - uy * contact.x) || 1;
    context.save();
    trace(context, plane, droplet.points);
    context.clip();
    context.beginPath();
    for (const [a, b] of [[-far, 0], [far, 0], [far, -far], [-far, -far]])
      context.lineTo(plane.X(a * ux - side * b * uy), plane.Y(a * uy + side * b * ux));
    context.closePath();
    context.fillStyle = colour("half");
    context.globalAlpha = 0.5;
    context.fill();
    context.restore();
  }
  context.strokeStyle = colour("centre");
  context.lineWidth = 1.6;
  context.setLineDash([9, 5]);
  line(context, plane.X(-far * ux), plane.Y(-far * uy), plane.X(far * ux), plane.Y(far * uy));
  context.setLineDash([]);
}

/** @param {CanvasRenderingContext2D} context @param {Plane} plane @param {ArrayLike<number>} info */
export function drawNeck(context, plane, info) {
  context.strokeStyle = colour("neck");
  context.lineWidth = 3;
  line(context, plane.X(info[ENDS]), plane.Y(info[ENDS + 1]), plane.X(info[ENDS + 2]), plane.Y(info[ENDS + 3]));
}
