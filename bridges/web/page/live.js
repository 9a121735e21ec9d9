// The page "Live": a card for each grasp and sensor; of the one that is chosen its map, its last minute, and its health.
import { Card } from "./card.js";
import { fixed, isNumber, make, setText } from "./dom.js";
import { Health } from "./health.js";
import { History } from "./history.js";
import { Layout, TaxelMap, shearNoise } from "./map.js";
import { drawPlot, keys } from "./plot.js";
import { readPicture } from "./picture.js";
import { alertWords, stateWords, withoutFrames } from "./words.js";

const kSpans = [60, 20, 5];  // s, of the history
const kStatusMs = 3000;        // how long a status holds; there is one each second
const kLongArrowMm = 0.1;      // the least displacement of a gel that is drawn as an arrow of full length

export class LivePage {
  #cards = new Map();
  #latest = new Map();
  #histories = new Map();
  #chosen = "";
  #layouts = new Map();
  #picture = null;
  #status = null;
  #statusAt = 0;
  #sampled = new Map();  // when the frame of an estimate was taken, ms of performance.now()
  #timer = 0;
  #maxAge = 500;
  #stopped = "connecting to slipd-web";
  #drawn = false;
  #span = kSpans[0];

  constructor(link) {
    this.link = link;
    this.element = make("div");
    this.lost = make("p", { class: "lost", role: "alert", hidden: true });
    this.said = make("p", { class: "said", "aria-live": "assertive" });
    this.cards = make("section", { class: "cards", "aria-label": "Margins" });
    this.detail = make("section", { class: "detail", "aria-label": "Details", hidden: true });
    this.empty = make("p", { class: "empty" }, "Waiting for slipd.");
    this.element.append(this.lost, this.said, this.empty, this.cards, this.detail);
    this.health = new Health();
    this.#makeDetail();
    link.addEventListener("hello", ({ detail }) => { this.#maxAge = detail.max_age_ms; });
    link.addEventListener("live", ({ detail }) => this.#take(detail));
    link.addEventListener("status", ({ detail }) => this.#takeStatus(detail));
    link.addEventListener("picture", ({ detail }) => this.#takePicture(detail));
    link.addEventListener("lost", () => this.#stop("slipd-web is not reached: what was here is gone; trying again"));
    window.addEventListener("resize", () => this.#redraw());
  }

  show(name) {
    this.shown = true;
    if (name) this.#choose(name);
    else this.link.look(this.#sensor(this.#chosen) ? this.#chosen : "");
    this.#redraw();
  }

  hide() {
    this.shown = false;
    this.link.look("");
  }

  #sensor(name) { return this.#latest.get(name)?.sensor !== undefined; }

  #take(message) {
    const all = [...message.grasps, ...message.sensors];
    if (message.slipd !== "ok") {
      this.#stop(`slipd is not reached: ${message.why}`, all);
      return;
    }
    this.#stopped = "";
    this.lost.hidden = true;
    const now = performance.now(), late = this.link.late(message.made_ms);
    const names = new Set(all.map(nameOf));
    for (const name of this.#cards.keys()) if (!names.has(name)) this.#remove(name);
    for (const estimate of all) {
      const name = nameOf(estimate), before = this.#latest.get(name);
      this.#add(estimate);
      if (isNumber(estimate.age_ms)) this.#sampled.set(name, now - estimate.age_ms - late);
      this.#expire(name, now);
      this.#histories.get(name).add(this.#latest.get(name), now);
      this.#tell(name, before, this.#latest.get(name));
    }
    this.empty.hidden = all.length > 0;
    if (all.length === 0) setText(this.empty, "slipd has no sensors; its configuration names them.");
    this.#chooseFirst();
    this.#watch();
    this.#redraw();
  }

  // No margin outlives its frame, even if nothing else comes.
  #expire(name, now) {
    const estimate = this.#latest.get(name);
    if (now - this.#sampled.get(name) <= this.#maxAge) return;
    this.#latest.set(name, withoutFrames(estimate, estimate.state === "fault" ? "fault" : "stale"));
  }

  #expireAll() {
    const now = performance.now();
    if (!this.#stopped) for (const name of this.#latest.keys()) this.#expire(name, now);
    if (now - this.#statusAt > kStatusMs) this.#status = null;
    this.#watch();
    this.#showHealth();
    this.#redraw();
  }

  // Sets the clock for what gets too old next.
  #watch() {
    const now = performance.now();
    const ends = [...this.#sampled.values(), this.#picture?.sampled].map((sampled) => sampled + this.#maxAge);
    if (this.#status) ends.push(this.#statusAt + kStatusMs);
    const next = Math.min(...ends.filter((end) => end >= now));
    clearTimeout(this.#timer);
    if (next < Infinity) this.#timer = setTimeout(() => this.#expireAll(), next - now + 1);
  }

  // `known`: what slipd-web still knows, for a page that was loaded meanwhile.
  #stop(why, known = []) {
    this.#stopped = why;
    setText(this.lost, why);
    this.lost.hidden = false;
    for (const estimate of known) if (!this.#latest.has(nameOf(estimate))) this.#add(estimate);
    for (const [name, estimate] of this.#latest) {
      this.#latest.set(name, withoutFrames(estimate, "disconnected"));
      this.#histories.get(name).gap();
    }
    this.empty.hidden = this.#latest.size > 0;
    this.#picture = this.#status = null;
    this.#chooseFirst();
    this.#showHealth();
    this.#redraw();
  }

  // Alerts for those who cannot see the page, and changes of state of the chosen one.
  #tell(name, before, now) {
    const alerted = before && before.alert !== now.alert && now.alert !== "none" && now.alert !== "unknown";
    const changed = before && before.state !== now.state && name === this.#chosen && now.state !== "ok";
    if (alerted) setText(this.said, `${name}: ${alertWords(now)}`);
    else if (changed) setText(this.said, `${name}: ${stateWords(now)}`);
  }

  #add(estimate) {
    const name = nameOf(estimate);
    this.#latest.set(name, estimate);
    if (this.#cards.has(name)) return;
    const card = new Card(name, estimate.grasp !== undefined ? "grasp" : "sensor", seesDisplacement(estimate), () => this.#choose(name));
    this.#cards.set(name, card);
    this.#histories.set(name, new History());
    this.cards.append(card.element);
    if (name === this.#chosen) this.#choose(name);  // an address had named it before it was known
  }

  #chooseFirst() {
    const names = [...this.#latest.keys()];
    if (!this.#chosen && names.length > 0) this.#choose(names.find((name) => this.#sensor(name)) ?? names[0]);
  }

  #remove(name) {
    this.#cards.get(name).element.remove();
    for (const map of [this.#cards, this.#latest, this.#histories, this.#sampled, this.#layouts]) map.delete(name);
    if (this.#chosen === name) this.#chosen = "";
  }

  #choose(name) {
    this.#chosen = name;
    this.#picture = null;
    for (const [each, card] of this.#cards) card.choose(each === name);
    this.detail.hidden = !this.#latest.has(name);
    const sensor = this.#sensor(name);
    this.figure.hidden = !sensor;
    this.health.element.hidden = !sensor;
    setText(this.title, name);
    if (this.shown !== false) this.link.look(sensor ? name : "");
    this.#showHealth();
    this.#redraw();
  }

  #makeDetail() {
    this.title = make("h2");
    this.canvas = make("canvas", { class: "map", role: "img", "aria-label": "Pressure and shear of the taxels" });
    this.map = new TaxelMap(this.canvas);
    this.caption = make("figcaption");
    this.figureTitle = make("h3");
    this.figure = make("figure", { class: "card" }, this.figureTitle, this.canvas, this.caption);
    this.margins = make("canvas", { class: "plot", role: "img", tabindex: 0, "aria-label": "Margin over time" });
    this.forces = make("canvas", { class: "plot small", role: "img", "aria-label": "Forces over time" });
    this.others = make("canvas", { class: "plot small", role: "img", "aria-label": "Torque and friction over time" });
    this.spans = kSpans.map((span) =>
      make("button", { type: "button", "aria-pressed": String(span === this.#span), onclick: () => this.#zoom(span) }, `${span} s`));
    this.margins.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.#zoom(Math.min(60, Math.max(2, this.#span * (event.deltaY > 0 ? 1.25 : 0.8))));
    }, { passive: false });
    this.margins.addEventListener("keydown", (event) => {
      const factor = { "+": 0.8, "-": 1.25 }[event.key];
      if (factor) this.#zoom(Math.min(60, Math.max(2, this.#span * factor)));
    });
    this.history = new HistoryView(this.margins, this.forces, this.others);
    const time = make("section", { class: "card" },
      make("div", { class: "head" }, make("h3", {}, "The last minute"), make("span", { class: "bar", role: "group", "aria-label": "Time shown" }, ...this.spans)),
      ...this.history.parts());
    this.detail.append(make("div", { class: "wide" }, this.title), make("div", { class: "column" }, this.figure, this.health.element), time);
  }

  #zoom(span) {
    this.#span = span;
    this.spans.forEach((button, i) => button.setAttribute("aria-pressed", String(kSpans[i] === span)));
    this.#redraw();
  }

  #takePicture(data) {
    const picture = readPicture(data);
    if (picture.kind === "layout") this.#layouts.set(picture.sensor, new Layout(picture.x, picture.y));
    else if (picture.sensor === this.#chosen)
      this.#picture = { ...picture, sampled: performance.now() - picture.age_ms - this.link.late(picture.made_ms) };
    this.#watch();
    this.#redraw();
  }

  #takeStatus(status) {
    this.#status = status;
    this.#statusAt = performance.now();
    this.#watch();
    this.#showHealth();
  }

  #showHealth() { this.health.show(this.#chosen, this.#status, this.#latest.get(this.#chosen)?.state); }

  // At most once a picture of the screen, whatever comes.
  #redraw() {
    if (this.#drawn) return;
    this.#drawn = true;
    requestAnimationFrame(() => {
      this.#drawn = false;
      this.#draw();
    });
  }

  #draw() {
    if (this.shown === false) return;
    for (const [name, card] of this.#cards) card.show(this.#latest.get(name));
    const estimate = this.#latest.get(this.#chosen);
    if (!estimate) return;
    this.detail.hidden = false;
    this.history.draw(this.#histories.get(this.#chosen), performance.now(), this.#span);
    if (!this.figure.hidden) this.#drawMap(estimate);
  }

  #drawMap(estimate) {
    const picture = this.#picture, now = performance.now();
    setText(this.figureTitle, seesDisplacement(estimate) ? "Displacement of the surface" : "Pressure and shear");
    this.canvas.setAttribute("aria-label", seesDisplacement(estimate) ? "Displacement of the surface" : "Pressure and shear of the taxels");
    if (!picture || !(now - picture.sampled <= this.#maxAge)) {
      this.map.clear();
      setText(this.caption, this.#noPicture(estimate, now));
      return;
    }
    if (seesDisplacement(estimate)) this.#drawDisplacement(picture);
    else this.#drawPressure(estimate, picture);
    this.canvas.dataset.sequence = String(picture.seq);
  }

  // The frame's values are no pressures (docs/displacement.md): x and y in mm, and how much the picture has changed, of 1.
  #drawDisplacement(picture) {
    const peakMm = picture.peak_shear_pa, longest = Math.max(peakMm, kLongArrowMm);
    this.map.draw(this.#layouts.get(picture.sensor),
      { ...picture, normalScale: picture.peak_pa / 255, shearScale: peakMm / longest / 127, noise: 0 });
    setText(this.caption, `arrows: how far the surface has moved since rest, up to ${fixed(peakMm, 2, "mm")}; bright: where the picture has changed.`);
  }

  #drawPressure(estimate, picture) {
    const loaded = picture.peak_pa > 0 && estimate.state !== "no_contact";
    const zero = this.#status?.status.sensors.find((each) => each.name === this.#chosen)?.zero;
    const noise = shearNoise(picture.peak_pa, picture.peak_shear_pa, zero?.noise_shear_pa);
    this.map.draw(this.#layouts.get(picture.sensor),
      { ...picture, normalScale: loaded ? 1 / 255 : 0, shearScale: loaded ? 1 / 127 : 0, noise }, estimate);
    setText(this.caption, `peak ${fixed(picture.peak_pa / 1000, 1, "kPa")}, shear up to ${fixed(picture.peak_shear_pa / 1000, 1, "kPa")}. ` +
      "Ring: the contact; dashed: what sticks; orange arrows: what slips.");
  }

  #noPicture(estimate, now) {
    if (this.#stopped) return `no picture: ${this.#stopped}`;
    const sampled = this.#sampled.get(this.#chosen);
    if (sampled === undefined) return "no picture yet";
    const age = fixed((now - sampled) / 1000, 0, "s");
    return now - sampled > this.#maxAge ? `no picture: ${estimate.state} for ${age}` : "no picture: it is under way";
  }
}

// A camera that looks at a gel, or a grasp of such fingers.
const seesDisplacement = (estimate) => estimate.displacement_mm !== undefined;

const nameOf = (estimate) => estimate.grasp ?? estimate.sensor;

// The canvases of the last minute.
class HistoryView {
  constructor(margins, forces, others) {
    Object.assign(this, { margins, forces, others });
  }

  parts() {
    const list = (entries) => keys(make, entries);
    return [
      this.margins, list([["good-fill", "margin ± σ"], ["faint", "lower bound (95 %)"], ["sim", "truth (simulated)"], ["mid-fill", "warn"], ["bad-fill", "slip"]]),
      this.forces, list([["good-fill", "normal force, N"], ["mid-fill", "shear force, N"]]),
      this.others, list([["good-fill", "torque, N mm"], ["sim", "friction ± σ, × 10"]]),
    ];
  }

  draw(history, now, span) {
    const range = [now / 1000 - span, now / 1000], points = history.points;
    drawPlot(this.margins, points, { range, relative: true, low: 0, high: 1, unit: "Γ", lines: [
      { key: "truth", colour: "sim", dash: [4, 3], width: 1.5 }, { key: "low", colour: "faint", dash: [2, 3], width: 1.5 },
      { key: "gamma", colour: "good-fill", band: "sigma" }] });
    drawPlot(this.forces, points, { range, relative: true, unit: "N", lines: [
      { key: "shear", colour: "mid-fill" }, { key: "normal", colour: "good-fill" }] });
    drawPlot(this.others, points, { range, relative: true, lines: [
      { key: "torque", colour: "good-fill" }, { key: "friction", colour: "sim", band: "frictionSigma" }] });
  }
}
