// @ts-check
// Hand and keys on the scene and on the diagram.

/**
 * Take the droplet and move it up and down.
 * @param {import("./scene.js").Scene} scene
 * @param {{offset: () => number, moveTo: (offset: number) => void, take: () => void, redraw: () => void}} page
 */
export function holdDroplet(scene, page) {
  /** @type {{y: number, offset: number} | null} where it was taken */
  let held = null;
  const { canvas } = scene;
  canvas.onpointerdown = (event) => {
    const [x, y] = scene.toPlane(event.offsetX, event.offsetY);
    if (!scene.holds(x, y)) return;
    held = { y, offset: page.offset() };
    canvas.setPointerCapture(event.pointerId);
    page.take();
  };
  canvas.onpointermove = (event) => {
    const [x, y] = scene.toPlane(event.offsetX, event.offsetY);
    const over = held !== null || scene.holds(x, y);
    canvas.style.cursor = over ? "ns-resize" : "default";
    if (over !== scene.hover) {
      scene.hover = over;
      page.redraw();
    }
    if (held) page.moveTo(held.offset + y - held.y);
  };
  canvas.onpointerup = canvas.onpointercancel = () => (held = null);
  canvas.onpointerleave = () => {
    scene.hover = held !== null;
    page.redraw();
  };
  canvas.onkeydown = (event) => {
    const step = event.shiftKey ? 0.001 : 0.01;
    if (event.key === "ArrowUp") page.moveTo(page.offset() + step);
    else if (event.key === "ArrowDown") page.moveTo(page.offset() - step);
    else return;
    event.preventDefault();
  };
}

/**
 * Drag in the diagram, click its points, walk through them with the keys.
 * @param {import("./diagram.js").Diagram} diagram
 * @param {{aim: (px: number, py: number) => void, pick: (point: import("./diagram.js").Point) => void,
 *   tell: (point: any, px: number, py: number) => void, hush: () => void,
 *   now: () => import("./diagram.js").Point | null}} page
 */
export function exploreDiagram(diagram, page) {
  /** @type {{x: number, y: number, moved: boolean} | null} */
  let grip = null;
  const { canvas } = diagram;
  canvas.onpointerdown = (event) => {
    grip = { x: event.offsetX, y: event.offsetY, moved: false };
    canvas.setPointerCapture(event.pointerId);
  };
  canvas.onpointermove = (event) => {
    if (!grip) {
      const point = diagram.near(event.offsetX, event.offsetY, 12);
      canvas.style.cursor = point ? "pointer" : "crosshair";
      return point ? page.tell(point, event.offsetX, event.offsetY) : page.hush();
    }
    if (!grip.moved && Math.hypot(event.offsetX - grip.x, event.offsetY - grip.y) < 5) return;
    grip.moved = true;
    page.hush();
    page.aim(event.offsetX, event.offsetY);
  };
  canvas.onpointerup = (event) => {
    const clicked = grip && !grip.moved;
    grip = null;
    if (!clicked) return;
    const point = diagram.near(event.offsetX, event.offsetY, 14);
    if (point) page.pick(point);
    else page.aim(event.offsetX, event.offsetY);
  };
  canvas.onpointercancel = () => (grip = null);
  canvas.onpointerleave = page.hush;
  canvas.onkeydown = (event) => {
    const { here } = diagram;
    const step = event.shiftKey ? 2 : 10;
    /** @type {Record<string, [number, number]>} */
    const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
    const move = moves[event.key];
    if (move && here) page.aim(diagram.X(here.strength) + move[0], diagram.Y(here.symmetry) + move[1]);
    else if (event.key === "n" || event.key === "p") walk(diagram, page, event.key === "n" ? 1 : -1);
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
}

/** Bring the next point back, in the order of Ca Ã z̃ and S.
 * @param {import("./diagram.js").Diagram} diagram
 * @param {{pick: (point: import("./diagram.js").Point) => void, now: () => import("./diagram.js").Point | null}} page
 * @param {number} way */
function walk(diagram, page, way) {
  const all = diagram.points.filter((point) => point.symmetry >= 0).sort((a, b) => a.strength - b.strength || a.symmetry - b.symmetry);
  const now = page.now();
  const place = all.findIndex((point) => point === now);
  if (all.length) page.pick(all[(place + way + all.length) % all.length]);
}

/** @param {Record<string, (coarse: boolean) => void>} keys what each key does, but in fields */
export function listenToKeys(keys) {
  document.onkeydown = (event) => {
    const { tagName } = /** @type {HTMLElement} */ (event.target);
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(tagName)) return;
    if (event.key === " " && /^(BUTTON|SUMMARY|A)$/.test(tagName)) return;
    const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    act(!event.shiftKey);
  };
}
