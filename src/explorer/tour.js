// @ts-check
// The guided tour: one collision after the other, with what to see in it.

/** @typedef {{title: string, text: string, values: Record<string, any>, at: string}} Stop */

export class Tour {
  /**
   * @param {Stop[]} stops @param {(id: string) => HTMLElement} byId
   * @param {(stop: Stop) => void} show
   */
  constructor(stops, byId, show) {
    this.stops = stops;
    this.byId = byId;
    this.show = show;
    this.at = -1;
    byId("tour-open").onclick = () => this.go(0);
    byId("tour-next").onclick = () => (this.at + 1 < stops.length ? this.go(this.at + 1) : this.end());
    byId("tour-back").onclick = () => this.go(Math.max(0, this.at - 1));
    byId("tour-close").onclick = () => this.end();
    byId("tour-dots").replaceChildren(...stops.map(() => document.createElement("i")));
  }

  /** @param {number} place */
  go(place) {
    this.at = place;
    const stop = this.stops[place];
    this.byId("tour").hidden = false;
    this.byId("tour-title").textContent = stop.title;
    this.byId("tour-place").textContent = `${place + 1} of ${this.stops.length}`;
    this.byId("tour-text").textContent = stop.text;
    /** @type {HTMLButtonElement} */ (this.byId("tour-back")).disabled = place === 0;
    this.byId("tour-next").textContent = place + 1 < this.stops.length ? "Next" : "Done";
    [...this.byId("tour-dots").children].forEach((dot, k) => dot.classList.toggle("now", k === place));
    this.show(stop);
    this.byId("tour-title").focus({ preventScroll: true });
    this.byId("tour").scrollIntoView({ block: "nearest" });
  }

  end() {
    this.byId("tour").hidden = true;
    this.byId("tour-open").focus();
  }
}
