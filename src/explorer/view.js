// @ts-check
// What the page shows of the state and of the run, in pictures and in words.
import { forgetColours } from "./canvas.js";
import { outcomeOf } from "./engine.js";
import { secondsOf, shown } from "./parameters.js";
import { linesOf, showMarks, showNumbers, summaryOf, WORDS } from "./readout.js";

const darkScreen = matchMedia("(prefers-color-scheme: dark)");

export class View {
  /**
   * @param {any} facts @param {import("./session.js").Session} session @param {import("./clock.js").Clock} clock
   * @param {{scene: import("./scene.js").Scene, traces: import("./traces.js").Traces,
   *   diagram: import("./diagram.js").Diagram}} pictures
   * @param {(id: string) => any} byId
   */
  constructor(facts, session, clock, pictures, byId) {
    this.facts = facts;
    this.session = session;
    this.clock = clock;
    this.pictures = pictures;
    /** @type {import("./own.js").OwnData | null} once it is there */
    this.own = null;
    this.byId = byId;
    this.changed = true;
    darkScreen.addEventListener("change", () => this.changeColours());
  }

  redraw() {
    this.changed = true;
  }

  /** Draw, if anything has changed. */
  update() {
    if (!this.changed) return;
    this.changed = false;
    this.#draw();
  }

  changeTheme() {
    const now = document.documentElement.dataset.theme ?? (darkScreen.matches ? "dark" : "light");
    document.documentElement.dataset.theme = now === "dark" ? "light" : "dark";
    this.changeColours();
  }

  changeColours() {
    forgetColours();
    this.redraw();
  }

  #draw() {
    const { scene, traces, diagram } = this.pictures;
    const own = /** @type {import("./own.js").OwnData} */ (this.own);
    const { state, run, here, points } = this.session;
    const { quantities } = state;
    scene.time = traces.time = state.time;
    scene.unitWord = quantities ? `D0 = ${shown(quantities.diameter)} µm` : "D0";
    traces.units = quantities
      ? { time: secondsOf(1, quantities), timeWord: "t / s", length: quantities.diameter, neckWord: "neck / µm" }
      : { time: 1, timeWord: "t / t0", length: 1, neckWord: "neck / D0" };
    scene.draw();
    own.draw(scene.view, state.time - (run?.contacts[0]?.time ?? 0));
    traces.draw();
    diagram.points = [...own.points, ...points.all];
    diagram.here = here;
    diagram.chosen = own.chosenPoint;
    diagram.draw(`${points.version} ${own.version} ${document.documentElement.dataset.theme} ${darkScreen.matches}`);
    this.#showTime();
  }

  #showTime() {
    const { time, quantities } = this.session.state;
    const scrub = this.byId("scrub");
    scrub.max = String(this.clock.end);
    scrub.value = String(time);
    scrub.setAttribute("aria-valuetext", `${shown(time)} t0`);
    const clock = quantities ? `${secondsOf(time, quantities).toFixed(2)} s` : `${time.toFixed(2)} t0`;
    this.byId("clock").textContent = `t = ${clock}`;
  }

  showRefusal() {
    const { refused } = this.session;
    const box = this.byId("refusal");
    box.hidden = !refused;
    box.textContent = refused ? `${refused}. The picture is that of the last collision that could be run.` : "";
  }

  /** Show the run that has come in words. */
  showRun() {
    const { facts, byId, clock } = this;
    const { run, here, points } = this.session;
    if (!run || !here) return;
    const outcome = outcomeOf(run);
    const summary = summaryOf(here, run);
    byId("outcome").dataset.outcome = outcome;
    byId("outcome").textContent = WORDS[outcome];
    byId("note").textContent = outcome === "failed" ? facts.guards[run.guard] : run.contacts.length ? "" : "no contact";
    showMarks(byId("marks"), run, clock.end, (name) => clock.goTo(clock.moment(name)));
    showNumbers(byId("numbers"), here, run);
    this.#showTakeaway();
    byId("summary").textContent = summary;
    byId("traces").setAttribute("aria-label", `Neck, shape parameter and area of the droplets against time. ${summary}`);
    byId("diagram").setAttribute("aria-label", `Symmetry against Ca Ã z̃, ${points.all.length} collisions tried. ${summary}`);
    byId("footer").textContent = `pinchoff ${facts.version} · this collision: ${run.result.steps} steps, computed in ${run.milliseconds.toFixed(0)} ms here`;
    this.redraw();
  }

  #showTakeaway() {
    const { model, state } = this.session;
    // An option is not torn apart at the end of a line.
    const words = model.command(state.values, state.quantities).map((text) => Object.assign(document.createElement("span"), { textContent: text }));
    this.byId("command").replaceChildren(...words.flatMap((word, k) => (k ? [" ", word] : [word])));
    this.byId("python").textContent = model.python(state.values, state.quantities);
  }

  /** @param {any} point of the diagram @param {number} px @param {number} py */
  showTip(point, px, py) {
    const { diagram } = this.pictures;
    const tip = this.byId("tip");
    const { clientWidth: width, clientHeight: height } = diagram.canvas;
    tip.hidden = false;
    if (point.own !== undefined) this.own?.describe(point.own, tip);
    else tip.textContent = linesOf(point);
    const right = px > width / 2;
    tip.style.left = right ? "" : `${px + 16}px`;
    tip.style.right = right ? `${width - px + 16}px` : "";
    tip.style.top = `${Math.max(0, Math.min(py - 20, height - tip.offsetHeight))}px`;
  }
}
