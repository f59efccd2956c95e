// @ts-check
// Files and text out of the page, without anything leaving it otherwise.
import { colour } from "./canvas.js";

/** @param {Blob} blob @param {string} name */
export function saveBlob(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/**
 * Save a canvas on an opaque ground with a line of text below it.
 * @param {HTMLCanvasElement} canvas @param {string} name @param {string} caption
 * @returns {Promise<string>} what to say of it
 */
export function savePng(canvas, name, caption) {
  const size = Math.round(canvas.width / 55);
  const picture = document.createElement("canvas");
  [picture.width, picture.height] = [canvas.width, canvas.height + 2 * size];
  const context = /** @type {CanvasRenderingContext2D} */ (picture.getContext("2d"));
  context.fillStyle = colour("card");
  context.fillRect(0, 0, picture.width, picture.height);
  context.drawImage(canvas, 0, 0);
  context.fillStyle = colour("ink");
  context.font = `${size}px system-ui, sans-serif`;
  context.fillText(caption, size, canvas.height + 1.35 * size, picture.width - 2 * size);
  return new Promise((resolve) =>
    picture.toBlob((blob) => {
      if (blob) saveBlob(blob, name);
      resolve(blob ? `${name}: ${picture.width} × ${picture.height} pixels.` : "The browser could not make the picture.");
    }),
  );
}

/** @param {string} text @returns {Promise<boolean>} whether it could be copied */
export async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}
