// @ts-check
// The time that is shown: moments of the run by their names, and playing.

export class Clock {
  /** @param {import("./session.js").Session} session @param {import("./scene.js").Scene} scene
   * @param {(id: string) => any} byId @param {() => void} redraw */
  constructor(session, scene, byId, redraw) {
    this.session = session;
    this.scene = scene;
    this.byId = byId;
    this.redraw = redraw;
    /** @type {string | null} where the time is to be once the run is there */
    this.wanted = null;
    this.lastFrame = 0;
  }

  get end() {
    return this.session.run?.recording?.times.at(-1) ?? 1;
  }

  /** The time of a moment by its name. @param {string} name @returns {number} */
  moment(name) {
    const { run } = this.session;
    if (name === "contact") return run?.contacts[0]?.time ?? this.scene.entry;
    if (name === "break-up") return run?.breakups[0] ? run.breakups[0].time + 1e-6 : this.moment("contact");
    if (name === "end") return this.end;
    if (name === "start") return 0;
    return this.scene.entry;
  }

  /** @param {number} time */
  goTo(time) {
    this.session.state.time = Math.min(this.end, Math.max(0, time));
    this.redraw();
  }

  /** @param {number} duration t0 */
  goOn(duration) {
    this.goTo(this.session.state.time + duration);
  }

  /** Where the time is in a run that has just come. @param {boolean} first whether it is the first run */
  settle(first) {
    const { state } = this.session;
    if (this.wanted !== null) state.time = this.moment(this.wanted);
    else if (first && !state.time) state.time = this.scene.entry;
    this.wanted = null;
    state.time = Math.min(state.time, this.end);
  }

  /** @param {boolean} playing */
  play(playing) {
    const { state } = this.session;
    if (playing && state.time >= this.end - 1e-9) this.goTo(this.scene.entry);
    state.playing = playing;
    this.byId("play").textContent = playing ? "❚❚" : "▶";
    this.byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  }

  toggle() {
    this.play(!this.session.state.playing);
  }

  /** Let the time pass until a frame of the screen. @param {number} now ms */
  tick(now) {
    const { state, run } = this.session;
    const step = Math.min(0.1, (now - this.lastFrame) / 1000) * Number(this.byId("speed").value);
    this.lastFrame = now;
    if (!state.playing || !run) return;
    this.goOn(step);
    this.scene.drift(step);
    if (state.time >= this.end) this.play(false);
  }
}
