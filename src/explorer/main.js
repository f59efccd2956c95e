// @ts-check
// The page: its parts are made here and joined.
import { ParameterForm, QuantityForm, SliderRow } from "./controls.js";
import { Clock } from "./clock.js";
import { Diagram } from "./diagram.js";
import { Engine } from "./engine.js";
import { exploreDiagram, holdDroplet, listenToKeys } from "./gestures.js";
import { Newest, prepareWorkers } from "./jobs.js";
import { showLegend } from "./legend.js";
import { OF_POINTS } from "./link.js";
import { SliceMap } from "./map.js";
import { OwnData } from "./own.js";
import { Model, rounded } from "./parameters.js";
import { Points } from "./points.js";
import { Scene } from "./scene.js";
import { Session } from "./session.js";
import { Sharing } from "./sharing.js";
import { Tour } from "./tour.js";
import { Traces } from "./traces.js";
import { View } from "./view.js";

/** @typedef {import("./parameters.js").Values} Values */

/** @param {string} id @returns {any} */
const byId = (id) => document.getElementById(id);
const facts = JSON.parse(byId("facts").textContent);
const ownPayload = JSON.parse(byId("own-data").textContent);
const lines = [...facts.lines, ...(ownPayload?.lines ?? [])];
const model = new Model(facts);
const points = new Points(model);
const scene = new Scene(byId("scene"));
const traces = new Traces(byId("traces"));
const diagram = new Diagram(byId("diagram"), lines);
/** @type {Engine | null} for the fluid's velocity */
let engine = null;

const session = new Session(model, points, {
  set: () => {
    showControls();
    view.showRefusal();
  },
  refused: () => view.showRefusal(),
  arrived: showArrived,
});
const { state } = session;
const redraw = () => view.redraw();
const clock = new Clock(session, scene, byId, redraw);
const view = new View(facts, session, clock, { scene, traces, diagram }, byId);
const own = new OwnData(ownPayload, model, byId, {
  redraw,
  simulate: (changes, symmetry) => {
    clock.wanted = "contact";
    state.quantities = null;
    session.seek(changes, symmetry);
  },
});
view.own = own;
const sharing = new Sharing(session, diagram, byId);
const remember = () => sharing.remember();
const sliceMap = new SliceMap(session, facts, byId, { redraw, remember, trouble });
sharing.offerFiles(scene, facts);

/** @param {string} message */
function trouble(message) {
  byId("trouble").textContent = `The engine could not run here: ${message}. The command and the Python below give the same run.`;
  byId("trouble").hidden = false;
}

/** @param {Values} values @param {boolean} first whether their run is the first */
function showArrived(values, first) {
  const run = /** @type {import("./engine.js").Run} */ (session.run);
  scene.run = traces.run = run;
  scene.radius = 1 / values.size_ratio;
  scene.offset = values.offset;
  traces.threshold = model.neckThreshold(values);
  engine?.prepare(run.row);
  traces.from = Math.max(0, scene.entry);
  clock.settle(first);
  view.showRun();
  remember();
}

// --- controls

const modelChoices = model.byName.model?.choices ?? [];
if (modelChoices.length) {
  byId("model-pick").hidden = false;
  fill(byId("model"), modelChoices.map((name) => [name, name]));
  byId("model").onchange = () => session.set({ model: byId("model").value });
}

const set = (/** @type {Values} */ changes) => session.set(changes);
const setQuantities = (/** @type {Record<string, number>} */ changes) => session.setQuantities(changes);
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
  if (!state.quantities) byId("physical-card").open = true;
  session.changeUnits(facts.laboratory);
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
  session.replace({ ...model.defaults(), size_ratio, simulation_capillary_number, offset, ...preset.constants });
};

/** Show a collision from where something is to be seen. @param {Values} values @param {string} at */
function present(values, at) {
  clock.wanted = at;
  session.replace({ ...model.defaults(), ...values }, null);
  clock.play(at === "entry");
}

const tour = new Tour(facts.tour, byId, (stop) => present(stop.values, stop.at));

byId("play").onclick = () => clock.toggle();
byId("scrub").oninput = () => stopAt(Number(byId("scrub").value));

/** @param {number} time */
function stopAt(time) {
  clock.play(false);
  clock.goTo(time);
}

// --- hand

traces.canvas.onpointerdown = (/** @type {PointerEvent} */ event) => {
  traces.canvas.setPointerCapture(event.pointerId);
  stopAt(traces.toTime(event.offsetX));
};
traces.canvas.onpointermove = (/** @type {PointerEvent} */ event) => {
  if (event.buttons) clock.goTo(traces.toTime(event.offsetX));
};

holdDroplet(scene, { offset: () => state.values.offset, moveTo, take: () => clock.play(false), redraw });

/** @param {number} offset */
function moveTo(offset) {
  const { low, high } = /** @type {any} */ (model.byName.offset);
  session.set({ offset: Math.min(high, Math.max(low, Number(offset.toFixed(4)))) });
}

exploreDiagram(diagram, {
  aim,
  pick: bringBack,
  tell: (point, px, py) => view.showTip(point, px, py),
  hush: () => (byId("tip").hidden = true),
  now: () => own.chosenPoint ?? session.here,
});

/** Ca and S of a place in the diagram. @param {number} px @param {number} py */
function aim(px, py) {
  const { strength, symmetry } = diagram.toPlane(px, py);
  const area = model.groups(state.values).area;
  const wanted = strength / area / facts.ca_per_ca_sim;
  const { low, high } = /** @type {any} */ (model.byName.simulation_capillary_number);
  session.seek({ simulation_capillary_number: rounded(Math.min(high, Math.max(low, wanted)), 4) }, symmetry);
}

/** @param {any} point of the diagram */
function bringBack(point) {
  if (point.own !== undefined) return own.choose(point.own);
  const quantities = state.quantities && model.quantitiesOf(point.values, state.quantities);
  const { follow_daughters } = state.values;
  const values = { ...point.values, follow_daughters: point.small ? follow_daughters : point.values.follow_daughters };
  if (quantities) quantities.offset = values.offset * quantities.diameter;
  session.replace(values, quantities);
}

byId("log-symmetry").onchange = () => {
  diagram.logarithmic = byId("log-symmetry").checked;
  redraw();
  remember();
};
byId("clear").onclick = () => {
  sliceMap.clear();
  points.clear();
  const { here, run } = session;
  if (here && run) session.here = points.add(here.values, here.quantities, run, false);
  redraw();
  remember();
};

// --- keys, theme, start

listenToKeys({
  " ": () => clock.toggle(),
  ArrowLeft: (coarse) => clock.goOn(coarse ? -0.1 : -0.02),
  ArrowRight: (coarse) => clock.goOn(coarse ? 0.1 : 0.02),
  Home: () => clock.goTo(clock.moment("start")),
  c: () => clock.goTo(clock.moment("contact")),
  b: () => clock.goTo(clock.moment("break-up")),
  End: () => clock.goTo(clock.moment("end")),
  m: () => byId("map").click(),
  "?": () => byId("help").showModal(),
});

byId("help-open").onclick = () => byId("help").showModal();
byId("help-source").textContent = `pinchoff ${facts.version}: the model of Droplet Breakup Against an Isolated Obstacle, Soft Matter 2026, doi 10.1039/D5SM01266J.`;
byId("theme").onclick = () => view.changeTheme();
new ResizeObserver(() => {
  traces.from = Math.max(0, scene.entry);
  redraw();
}).observe(document.body);

/** @param {number} now ms */
function frame(now) {
  clock.tick(now);
  view.update();
  requestAnimationFrame(frame);
}

async function begin() {
  const packed = Uint8Array.from(atob(byId("engine").textContent), (letter) => letter.charCodeAt(0));
  const unpacking = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const code = new Uint8Array(await new Response(unpacking).arrayBuffer());
  prepareWorkers(code, byId("worker").textContent);
  session.newest = new Newest(trouble);
  const linked = location.hash.length > 1 ? sharing.restore(location.hash) : null;
  if (linked?.wrong.length) trouble(`the link asks for what cannot be: ${linked.wrong.join("; ")}`);
  showLegend(byId("legend"), lines, diagram.without, ownPayload !== null, () => {
    redraw();
    remember();
  });
  session.compute();
  requestAnimationFrame(frame);
  engine = await Engine.make(code);
  scene.velocity = (x, y) => /** @type {Engine} */ (engine).velocity(x, y);
  engine.prepare(model.row(state.values));
  redraw();
  if (!linked) return clock.play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
  const { tried, map } = linked.found;
  const wanted = tried.map((point) => ({ ...state.values, ...Object.fromEntries(OF_POINTS.map((name, k) => [name, point[k]])) }));
  if (wanted.length > 1) await sliceMap.run(wanted, false, "from the link");
  if (Number(map) > 1 && Number(map) <= 40) await sliceMap.map(Number(map));
}

begin().catch((error) => trouble(String(error)));

/** For tests and for the console. */
const current = () => ({ run: session.run, here: session.here, refused: session.refused });
Object.assign(window, { explorer: { engine: () => engine, state, model, points, diagram, scene, own, set, goTo: (/** @type {number} */ time) => clock.goTo(time), tour, facts, current } });
