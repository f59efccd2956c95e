// @ts-check
// The page: what the user does, the collision that follows, and all that shows it.
import { forgetColours } from "./canvas.js";
import { Diagram } from "./diagram.js";
import { Engine, outcomeOf } from "./engine.js";
import { Newest, prepareWorkers, runAll } from "./jobs.js";
import { exploreDiagram, holdDroplet, listenToKeys } from "./gestures.js";
import { showLegend } from "./legend.js";
import { fragmentOf, MOST_LINKED, readFragment } from "./link.js";
import { OwnData } from "./own.js";
import { Model, QUANTITIES, rounded, shown } from "./parameters.js";
import { linesOf, showMarks, showNumbers, summaryOf, WORDS } from "./readout.js";
import { MOST_POINTS, Points } from "./points.js";
import { Scene } from "./scene.js";
import { Tour } from "./tour.js";
import { Traces } from "./traces.js";
import { ParameterForm, QuantityForm, SliderRow } from "./controls.js";
import { copyText, saveBlob, savePng } from "./export.js";

/** @typedef {import("./engine.js").Run} Run @typedef {import("./parameters.js").Values} Values */

const INTERVAL = 0.02; // between two recorded outlines, t0

/** @param {string} id @returns {any} */
const byId = (id) => document.getElementById(id);
const facts = JSON.parse(byId("facts").textContent);
const model = new Model(facts);
const darkScreen = matchMedia("(prefers-color-scheme: dark)");
const QUANTITY_NAMES = QUANTITIES.map(([name]) => name);

/** What the page shows: everything else follows from it. */
const state = {
  values: model.defaults(),
  /** @type {import("./parameters.js").Quantities | null} */
  quantities: null,
  time: 0,
  playing: false,
  map: "",
};

const scene = new Scene(byId("scene"));
const traces = new Traces(byId("traces"));
const ownPayload = JSON.parse(byId("own-data").textContent);
const lines = [...facts.lines, ...(ownPayload?.lines ?? [])];
const diagram = new Diagram(byId("diagram"), lines);
const points = new Points(model);
/** @type {Newest} */
let newest;
/** @type {Engine | null} for the fluid's velocity */
let engine = null;
/** @type {Run | null} */
let run = null;
/** @type {import("./points.js").Tried | null} */
let here = null;
let refused = "";
/** @type {(() => void) | null} */
let cancelMap = null;
/** @type {string | null} where the time is to be once the run is there */
let wantedMoment = null;
let needsDrawing = true;
const redraw = () => {
  needsDrawing = true;
};

/** @param {string} message */
function trouble(message) {
  byId("trouble").textContent = `The engine could not run here: ${message}. The command and the Python below give the same run.`;
  byId("trouble").hidden = false;
}

/** @param {string} text */
function say(text) {
  byId("said").textContent = text;
}

// --- from what was set to the collision

/** Take values, refuse or run them. @param {Values} changes */
function set(changes) {
  Object.assign(state.values, changes);
  if (state.quantities && "offset" in changes) state.quantities.offset = rounded(changes.offset * state.quantities.diameter, 6);
  if (state.quantities && ("size_ratio" in changes || "simulation_capillary_number" in changes)) {
    state.quantities = model.quantitiesOf(state.values, state.quantities);
    Object.assign(state.values, model.ofQuantities(state.quantities));
  }
  compute();
}

/** Take physical quantities, from which the groups follow. @param {Record<string, number>} changes */
function setQuantities(changes) {
  state.quantities = { .../** @type {any} */ (state.quantities), ...changes };
  Object.assign(state.values, model.ofQuantities(/** @type {any} */ (state.quantities)));
  compute();
}

function refusal() {
  for (const { name } of model.parameters) {
    const text = model.refusal(name, state.values[name], state.values);
    if (text) return text;
  }
  return "";
}

function compute() {
  refused = refusal();
  showControls();
  showRefusal();
  if (refused) return;
  const values = { ...state.values };
  const quantities = state.quantities;
  newest.ask({ job: "run", rows: [model.row(values)], interval: INTERVAL }, ({ runs }) => {
    if (!runs[0].fault) return arrived(values, quantities, runs[0]);
    refused = faultText(runs[0].fault, values);
    showRefusal();
  });
}

/** @param {Values} values @param {import("./parameters.js").Quantities | null} quantities @param {Run} computed */
function arrived(values, quantities, computed) {
  const first = run === null;
  run = computed;
  here = points.add(values, quantities, computed, false);
  scene.run = traces.run = computed;
  scene.radius = 1 / values.size_ratio;
  scene.offset = values.offset;
  traces.threshold = model.neckThreshold(values);
  engine?.prepare(computed.row);
  traces.from = Math.max(0, scene.entry);
  if (wantedMoment !== null) state.time = moment(wantedMoment);
  else if (first && !state.time) state.time = scene.entry;
  wantedMoment = null;
  state.time = Math.min(state.time, endTime());
  showRun();
}

/** @param {string} field @param {Values} values */
function faultText(field, values) {
  const name = field in state.values ? field : "the model";
  const p = model.byName[field];
  return p
    ? `${name} must be ${p.rule}, and fit the other parameters; got ${values[field]}; ${p.advice}`
    : `${field} must be possible; got a row that the engine refuses; change what you changed last`;
}

/** Bring S to a value by moving the droplet's start. @param {Values} changes @param {number} symmetry */
function seek(changes, symmetry) {
  const values = { ...state.values, ...changes };
  if (model.parameters.some(({ name }) => model.refusal(name, values[name], values))) return;
  newest.ask({ job: "seek", row: model.row(values), symmetry }, ({ found, newer }) => {
    if (found.fault || newer) return;
    set({ ...changes, offset: rounded(found.offset, 4) });
  });
}

// --- time

const endTime = () => run?.recording?.times.at(-1) ?? 1;

/** The time of a moment by its name. @param {string} name @returns {number} */
function moment(name) {
  if (name === "contact") return run?.contacts[0]?.time ?? scene.entry;
  if (name === "break-up") return run?.breakups[0] ? run.breakups[0].time + 1e-6 : moment("contact");
  if (name === "end") return endTime();
  if (name === "start") return 0;
  return scene.entry;
}

/** @param {number} time */
function goTo(time) {
  state.time = Math.min(endTime(), Math.max(0, time));
  needsDrawing = true;
}

/** @param {boolean} playing */
function play(playing) {
  if (playing && state.time >= endTime() - 1e-9) goTo(scene.entry);
  state.playing = playing;
  byId("play").textContent = playing ? "❚❚" : "▶";
  byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
}

let lastFrame = 0;
/** @param {number} now ms */
function frame(now) {
  const step = Math.min(0.1, (now - lastFrame) / 1000) * Number(byId("speed").value);
  lastFrame = now;
  if (state.playing && run) {
    goTo(state.time + step);
    scene.drift(step);
    if (state.time >= endTime()) play(false);
  }
  if (needsDrawing) {
    needsDrawing = false;
    draw();
  }
  requestAnimationFrame(frame);
}

function draw() {
  scene.time = traces.time = state.time;
  const { quantities } = state;
  scene.unitWord = quantities ? `D0 = ${shown(quantities.diameter)} µm` : "D0";
  traces.units = quantities
    ? { time: (quantities.diameter * 1e-3) / quantities.speed, timeWord: "t / s", length: quantities.diameter, neckWord: "neck / µm" }
    : { time: 1, timeWord: "t / t0", length: 1, neckWord: "neck / D0" };
  scene.draw();
  own.draw(scene.view, state.time - (run?.contacts[0]?.time ?? 0));
  traces.draw();
  diagram.points = [...own.points, ...points.all];
  diagram.here = here;
  diagram.chosen = own.chosenPoint;
  diagram.draw(`${points.version} ${own.version} ${document.documentElement.dataset.theme} ${darkScreen.matches}`);
  const scrub = byId("scrub");
  scrub.max = String(endTime());
  scrub.value = String(state.time);
  scrub.setAttribute("aria-valuetext", `${shown(state.time)} t0`);
  byId("clock").textContent = clockText();
}

function clockText() {
  const { quantities } = state;
  if (!quantities) return `t = ${state.time.toFixed(2)} t0`;
  return `t = ${((state.time * quantities.diameter * 1e-3) / quantities.speed).toFixed(2)} s`;
}

// --- what is shown of the run

function showRefusal() {
  const box = byId("refusal");
  box.hidden = !refused;
  box.textContent = refused ? `${refused}. The picture is that of the last collision that could be run.` : "";
}

function showRun() {
  if (!run || !here) return;
  const outcome = outcomeOf(run);
  const summary = summaryOf(here, run);
  byId("outcome").dataset.outcome = outcome;
  byId("outcome").textContent = WORDS[outcome];
  byId("note").textContent = outcome === "failed" ? facts.guards[run.guard] : run.contacts.length ? "" : "no contact";
  showMarks(byId("marks"), run, endTime(), (name) => goTo(moment(name)));
  showNumbers(byId("numbers"), here, run);
  showTakeaway();
  byId("summary").textContent = summary;
  byId("traces").setAttribute("aria-label", `Neck, shape parameter and area of the droplets against time. ${summary}`);
  byId("diagram").setAttribute("aria-label", `Symmetry against Ca Ã z̃, ${points.all.length} collisions tried. ${summary}`);
  byId("footer").textContent = `pinchoff ${facts.version} · this collision: ${run.result.steps} steps, computed in ${run.milliseconds.toFixed(0)} ms here`;
  needsDrawing = true;
  rememberLink();
}

function showTakeaway() {
  // An option is not torn apart at the end of a line.
  const words = model.command(state.values, state.quantities).map((text) => Object.assign(document.createElement("span"), { textContent: text }));
  byId("command").replaceChildren(...words.flatMap((word, k) => (k ? [" ", word] : [word])));
  byId("python").textContent = model.python(state.values, state.quantities);
}

// --- controls

const modelChoices = model.byName.model?.choices ?? [];
if (modelChoices.length) {
  byId("model-pick").hidden = false;
  fill(byId("model"), modelChoices.map((name) => [name, name]));
  byId("model").onchange = () => set({ model: byId("model").value });
}

const sliders = new SliderRow(byId("sliders"), model, set, setQuantities);
const parameterForm = new ParameterForm(byId("parameters"), model, set);
const quantityForm = new QuantityForm(byId("physical"), setQuantities);

function showControls() {
  sliders.show(state.values, state.quantities);
  parameterForm.show(state.values);
  quantityForm.show(state.quantities);
  if (modelChoices.length) byId("model").value = state.values.model;
  const physical = state.quantities !== null;
  byId("units").setAttribute("aria-pressed", String(physical));
  byId("physical-card").hidden = !physical;
}

byId("units").onclick = () => {
  if (state.quantities) state.quantities = null;
  else {
    state.quantities = model.quantitiesOf(state.values, facts.laboratory);
    Object.assign(state.values, model.ofQuantities(state.quantities));
    byId("physical-card").open = true;
  }
  compute();
};

/** @param {HTMLSelectElement} select @param {string[][]} options value and text */
function fill(select, options) {
  select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
}

fill(byId("example"), [["", "choose …"], ...facts.examples.map((/** @type {any} */ e, /** @type {number} */ k) => [String(k), e.title])]);
byId("example").onchange = () => {
  const example = facts.examples[byId("example").value];
  if (example) present(example.values, example.at);
};

fill(byId("preset"), facts.presets.map((/** @type {any} */ p) => [p.name, p.name]));
byId("preset").onchange = () => {
  const preset = facts.presets.find((/** @type {any} */ p) => p.name === byId("preset").value);
  byId("preset-word").textContent = preset.description;
  const { size_ratio, simulation_capillary_number, offset } = state.values;
  state.values = { ...model.defaults(), size_ratio, simulation_capillary_number, offset, ...preset.constants };
  compute();
};

/** Show a collision from where something is to be seen. @param {Values} values @param {string} at */
function present(values, at) {
  state.quantities = null;
  state.values = { ...model.defaults(), ...values };
  wantedMoment = at;
  compute();
  play(at === "entry");
}

const tour = new Tour(facts.tour, byId, (stop) => present(stop.values, stop.at));

byId("play").onclick = () => play(!state.playing);
byId("scrub").oninput = () => {
  play(false);
  goTo(Number(byId("scrub").value));
};

// --- hand and keys

traces.canvas.onpointerdown = (/** @type {PointerEvent} */ event) => {
  traces.canvas.setPointerCapture(event.pointerId);
  play(false);
  goTo(traces.toTime(event.offsetX));
};
traces.canvas.onpointermove = (/** @type {PointerEvent} */ event) => {
  if (event.buttons) goTo(traces.toTime(event.offsetX));
};

holdDroplet(scene, { offset: () => state.values.offset, moveTo, take: () => play(false), redraw });

/** @param {number} offset */
function moveTo(offset) {
  const { low, high } = /** @type {any} */ (model.byName.offset);
  set({ offset: Math.min(high, Math.max(low, Number(offset.toFixed(4)))) });
}

exploreDiagram(diagram, { aim, pick: bringBack, tell: showTip, hush: () => (byId("tip").hidden = true), now: () => own.chosenPoint ?? here });

/** Ca and S of a place in the diagram. @param {number} px @param {number} py */
function aim(px, py) {
  const { strength, symmetry } = diagram.toPlane(px, py);
  const area = model.groups(state.values).area;
  const wanted = strength / area / facts.ca_per_ca_sim;
  const { low, high } = /** @type {any} */ (model.byName.simulation_capillary_number);
  seek({ simulation_capillary_number: rounded(Math.min(high, Math.max(low, wanted)), 4) }, symmetry);
}

/** @param {any} point of the diagram */
function bringBack(point) {
  if (point.own !== undefined) return own.choose(point.own);
  if (state.quantities) state.quantities = model.quantitiesOf(point.values, state.quantities);
  const { follow_daughters } = state.values;
  state.values = { ...point.values, follow_daughters: point.small ? follow_daughters : point.values.follow_daughters };
  if (state.quantities) state.quantities.offset = state.values.offset * state.quantities.diameter;
  compute();
}

/** @param {any} point of the diagram @param {number} px @param {number} py */
function showTip(point, px, py) {
  const tip = byId("tip");
  const { clientWidth: width, clientHeight: height } = diagram.canvas;
  tip.hidden = false;
  if (point.own !== undefined) own.describe(point.own, tip);
  else tip.textContent = linesOf(point);
  const right = px > width / 2;
  tip.style.left = right ? "" : `${px + 16}px`;
  tip.style.right = right ? `${width - px + 16}px` : "";
  tip.style.top = `${Math.max(0, Math.min(py - 20, height - tip.offsetHeight))}px`;
}

byId("log-symmetry").onchange = () => {
  diagram.logarithmic = byId("log-symmetry").checked;
  needsDrawing = true;
  rememberLink();
};
byId("clear").onclick = () => {
  cancelMap?.();
  points.clear();
  state.map = "";
  byId("map-word").textContent = "";
  if (here && run) here = points.add(here.values, here.quantities, run, false);
  needsDrawing = true;
  rememberLink();
};

// --- the map

/** Rows of a slice: offset from head-on to the last that touches, Ca over the diagram's range.
 * @param {number} side */
function slice(side) {
  const { low, high } = /** @type {any} */ (model.byName.simulation_capillary_number);
  const area = model.groups(state.values).area;
  const ofStrength = (/** @type {number} */ strength) => Math.min(high, Math.max(low, strength / area / facts.ca_per_ca_sim));
  const [from, to] = [ofStrength(0.02), ofStrength(0.5)];
  const widest = 0.5 + 0.5 / state.values.size_ratio; // farther out there is hardly a contact
  const all = [];
  for (let i = 0; i < side; ++i)
    for (let j = 0; j < side; ++j)
      all.push({
        ...state.values,
        follow_daughters: false, // S and the outcome are known by the first break-up
        simulation_capillary_number: rounded(from * (to / from) ** (i / (side - 1)), 5),
        offset: rounded((widest * j) / (side - 1), 5),
      });
  return all;
}

byId("map").onclick = () => (cancelMap ? cancelMap() : map(Number(byId("map-size").value)));

/** @param {number} side */
async function map(side) {
  if (refused || cancelMap) return;
  const wanted = slice(side);
  await runThese(wanted, true, `${side} × ${side}`);
  state.map = String(side);
  rememberLink();
}

/** Run collisions on all cores and keep them as points. @param {Values[]} wanted @param {boolean} small
 * @param {string} name */
async function runThese(wanted, small, name) {
  let count = 0;
  let faults = 0;
  const begun = performance.now();
  let shownAt = begun;
  const progress = byId("map-progress");
  const job = runAll(wanted.map((values) => model.row(values)), (k, computed) => {
    ++count;
    if (computed.fault) ++faults;
    else points.add(wanted[k], null, computed, small);
    // Drawing takes time from the cores that compute.
    if (performance.now() - shownAt < 200) return;
    shownAt = performance.now();
    progress.value = count / wanted.length;
    byId("map-word").textContent = `${count} of ${wanted.length}`;
    needsDrawing = true;
  }, trouble);
  cancelMap = job.cancel;
  byId("map").textContent = "Cancel";
  progress.hidden = false;
  const whole = await job.done;
  cancelMap = null;
  needsDrawing = true;
  progress.hidden = true;
  byId("map").textContent = "Map this slice";
  const seconds = ((performance.now() - begun) / 1000).toFixed(1);
  const lost = (faults ? `, ${faults} refused` : "") + (points.forgotten ? `; the oldest beyond ${MOST_POINTS} are forgotten` : "");
  byId("map-word").textContent = (whole ? `${name}: ${wanted.length} collisions in ${seconds} s` : `cancelled after ${count}`) + lost;
}

// --- out of the page

/** @returns {import("./link.js").Linked} */
function linked() {
  const same = (/** @type {Values} */ values) => model.parameters.every(({ name }) => ["offset", "simulation_capillary_number", "size_ratio"].includes(name) || values[name] === state.values[name]);
  const byHand = points.all.filter((tried) => !tried.small && same(tried.values));
  return {
    values: state.values,
    quantities: state.quantities,
    time: state.time,
    logarithmic: diagram.logarithmic,
    without: [...diagram.without],
    map: state.map,
    tried: byHand.slice(-MOST_LINKED).map(({ values }) => [values.offset, values.simulation_capillary_number, values.size_ratio]),
  };
}

let linkTimer = 0;
function rememberLink() {
  clearTimeout(linkTimer);
  linkTimer = setTimeout(() => {
    lastLink = fragmentOf(linked(), model);
    try {
      history.replaceState(null, "", lastLink);
    } catch {
      // Some browsers refuse it for files; the link is copied from what we know.
    }
  }, 400);
}
let lastLink = "";

byId("copy-link").onclick = async () => {
  lastLink = fragmentOf(linked(), model);
  const all = points.all.filter((tried) => !tried.small).length;
  const kept = linked().tried.length;
  const left = all > kept ? ` ${all - kept} of ${all} points are not in it: only the newest ${MOST_LINKED} with these constants are.` : "";
  say(((await copyText(location.href.split("#")[0] + lastLink)) ? "The link is copied." : "Copy the address of this page.") + left);
};
byId("copy-command").onclick = async () => say((await copyText(byId("command").textContent)) ? "The command is copied." : "Mark the command and copy it.");
byId("copy-python").onclick = async () => say((await copyText(byId("python").textContent)) ? "The program is copied." : "Mark the program and copy it.");
byId("save-scene").onclick = async () => say(await savePng(scene.canvas, "collision.png", byId("summary").textContent));
byId("save-diagram").onclick = async () => say(await savePng(diagram.canvas, "diagram.png", `${points.all.length} collisions, pinchoff ${facts.version}`));
byId("save-points").onclick = () => {
  saveBlob(new Blob([points.csv()], { type: "text/csv" }), "collisions.csv");
  say(`collisions.csv has ${points.all.length} rows; pinchoff fit reads it.`);
};

// --- the user's own data

const own = new OwnData(ownPayload, model, byId, {
  redraw,
  simulate: (changes, symmetry) => {
    wantedMoment = "contact";
    state.quantities = null;
    seek(changes, symmetry);
  },
});

// --- keys, theme, start

listenToKeys({
  " ": () => play(!state.playing),
  ArrowLeft: (coarse) => goTo(state.time - (coarse ? 0.1 : 0.02)),
  ArrowRight: (coarse) => goTo(state.time + (coarse ? 0.1 : 0.02)),
  Home: () => goTo(moment("start")),
  c: () => goTo(moment("contact")),
  b: () => goTo(moment("break-up")),
  End: () => goTo(moment("end")),
  m: () => byId("map").click(),
  "?": () => byId("help").showModal(),
});

byId("help-open").onclick = () => byId("help").showModal();
byId("help-source").textContent = `pinchoff ${facts.version}: the model of Droplet Breakup Against an Isolated Obstacle, Soft Matter 2026, doi 10.1039/D5SM01266J.`;

byId("theme").onclick = () => {
  const now = document.documentElement.dataset.theme ?? (darkScreen.matches ? "dark" : "light");
  document.documentElement.dataset.theme = now === "dark" ? "light" : "dark";
  forgetColours();
  needsDrawing = true;
};
darkScreen.addEventListener("change", () => {
  forgetColours();
  needsDrawing = true;
});
new ResizeObserver(() => {
  traces.from = Math.max(0, scene.entry);
  needsDrawing = true;
}).observe(document.body);

/** Take the state of a link. @param {string} fragment */
function restore(fragment) {
  const { state: found, wrong } = readFragment(fragment, model, QUANTITY_NAMES);
  Object.assign(state, { values: found.values, quantities: found.quantities, time: found.time });
  if (found.quantities) Object.assign(state.values, model.ofQuantities(/** @type {any} */ (found.quantities)));
  diagram.logarithmic = byId("log-symmetry").checked = found.logarithmic;
  if (new URLSearchParams(fragment.slice(1)).has("without") || fragment.length > 1) diagram.without = new Set(found.without);
  if (wrong.length) trouble(`the link asks for what cannot be: ${wrong.join("; ")}`);
  return found;
}

async function begin() {
  const packed = Uint8Array.from(atob(byId("engine").textContent), (letter) => letter.charCodeAt(0));
  const unpacking = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const code = new Uint8Array(await new Response(unpacking).arrayBuffer());
  prepareWorkers(code, byId("worker").textContent);
  newest = new Newest(trouble);
  const found = location.hash.length > 1 ? restore(location.hash) : null;
  showLegend(byId("legend"), lines, diagram.without, ownPayload !== null, () => {
    redraw();
    rememberLink();
  });
  compute();
  requestAnimationFrame(frame);
  engine = await Engine.make(code);
  scene.velocity = (x, y) => /** @type {Engine} */ (engine).velocity(x, y);
  engine.prepare(model.row(state.values));
  needsDrawing = true;
  if (!found) return play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
  const tried = found.tried.map(([offset, simulation_capillary_number, size_ratio]) => ({ ...state.values, offset, simulation_capillary_number, size_ratio }));
  if (tried.length > 1) await runThese(tried, false, "from the link");
  if (Number(found.map) > 1 && Number(found.map) <= 40) await map(Number(found.map));
}

begin().catch((error) => trouble(String(error)));

/** For tests and for the console. */
Object.assign(window, { explorer: { engine: () => engine, state, model, points, diagram, scene, own, set, goTo, tour, facts, current: () => ({ run, here, refused }) } });
