// The page "Live": a card for each grasp and sensor; of the one that is chosen its map, its last minute, and its health.
import { Card, disconnected } from "./card.js";
import { fixed, isNumber, make, setText } from "./dom.js";
import { History } from "./history.js";
import { Layout, TaxelMap } from "./map.js";
import { drawPlot, keys } from "./plot.js";
import { readPicture } from "./picture.js";
import { alertWords, healthWords, stateWords } from "./words.js";

const kSpans = [60, 20, 5];  // s, of the history
const kHealthRows = [
  ["health", "Frames"], ["rate", "Rate"], ["lost", "Gaps, lost, skipped"], ["latency", "Latency, last minute"],
  ["zero", "Zero"], ["realtime", "Real time"], ["device", "Device"], ["trouble", "Trouble"],
];

export class LivePage {
  #cards = new Map();
  #latest = new Map();
  #histories = new Map();
  #chosen = "";
  #layouts = new Map();
  #picture = null;
  #status = null;
  #expiry = new Map();
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
    this.#makeDetail();
    link.addEventListener("hello", ({ detail }) => { this.#maxAge = detail.max_age_ms; });
    link.addEventListener("live", ({ detail }) => this.#take(detail));
    link.addEventListener("status", ({ detail }) => { this.#status = detail; this.#showHealth(); });
    link.addEventListener("picture", ({ detail }) => this.#takePicture(detail));
    link.addEventListener("lost", () => this.#stop("slipd-web is not reached: what was here is gone; trying again"));
    setInterval(() => this.#expire(), 100);
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
    if (message.slipd !== "ok") {
      this.#stop(`slipd is not reached: ${message.why}`);
      return;
    }
    this.#stopped = "";
    this.lost.hidden = true;
    const now = performance.now();
    const all = [...message.grasps, ...message.sensors];
    const names = new Set(all.map((each) => each.grasp ?? each.sensor));
    for (const name of this.#cards.keys()) if (!names.has(name)) this.#remove(name);
    for (const estimate of all) {
      const name = estimate.grasp ?? estimate.sensor;
      if (!this.#cards.has(name)) this.#add(name, estimate);
      const before = this.#latest.get(name);
      this.#latest.set(name, estimate);
      this.#expiry.set(name, now + this.#maxAge - (estimate.age_ms ?? 0));
      this.#histories.get(name).add(estimate, now);
      this.#tell(name, before, estimate);
    }
    this.empty.hidden = all.length > 0;
    if (all.length === 0) setText(this.empty, "slipd has no sensors; its configuration names them.");
    if (!this.#chosen && all.length > 0) this.#choose(message.sensors[0]?.sensor ?? all[0].grasp);
    this.#redraw();
  }

  // No margin outlives its frame, even if nothing else comes.
  #expire() {
    if (this.#stopped) return;
    const now = performance.now();
    for (const [name, until] of this.#expiry) {
      const estimate = this.#latest.get(name);
      if (now <= until || estimate.state === "stale" || estimate.state === "fault") continue;
      this.#latest.set(name, { ...disconnected(estimate), state: "stale", alert: estimate.alert, alert_cause: estimate.alert_cause });
      this.#redraw();
    }
  }

  #stop(why) {
    this.#stopped = why;
    setText(this.lost, why);
    this.lost.hidden = false;
    for (const [name, estimate] of this.#latest) {
      this.#latest.set(name, disconnected(estimate));
      this.#histories.get(name).gap();
    }
    this.#picture = null;
    this.#redraw();
  }

  // Alerts for those who cannot see the page, and changes of state of the chosen one.
  #tell(name, before, now) {
    const alerted = before && before.alert !== now.alert && now.alert !== "none";
    const changed = before && before.state !== now.state && name === this.#chosen && now.state !== "ok";
    if (alerted) setText(this.said, `${name}: ${alertWords(now)}`);
    else if (changed) setText(this.said, `${name}: ${stateWords(now.state)}`);
  }

  #add(name, estimate) {
    const card = new Card(name, estimate.grasp !== undefined ? "grasp" : "sensor", () => this.#choose(name));
    this.#cards.set(name, card);
    this.#histories.set(name, new History());
    this.cards.append(card.element);
  }

  #remove(name) {
    this.#cards.get(name).element.remove();
    for (const map of [this.#cards, this.#latest, this.#histories, this.#expiry, this.#layouts]) map.delete(name);
    if (this.#chosen === name) this.#chosen = "";
  }

  #choose(name) {
    this.#chosen = name;
    this.#picture = null;
    for (const [each, card] of this.#cards) card.choose(each === name);
    this.detail.hidden = !this.#latest.has(name);
    const sensor = this.#sensor(name);
    this.figure.hidden = !sensor;
    this.healthCard.hidden = !sensor;
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
    this.figure = make("figure", { class: "card" }, make("h3", {}, "Pressure and shear"), this.canvas, this.caption);
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
    this.health = Object.fromEntries(kHealthRows.map(([key]) => [key, make("dd")]));
    this.healthCard = make("section", { class: "card" }, make("h3", {}, "Health"),
      make("dl", { class: "facts" }, ...kHealthRows.flatMap(([key, label]) => [make("dt", {}, label), this.health[key]])));
    this.history = new HistoryView(this.margins, this.forces, this.others);
    const time = make("section", { class: "card" },
      make("div", { class: "head" }, make("h3", {}, "The last minute"), make("span", { class: "bar", role: "group", "aria-label": "Time shown" }, ...this.spans)),
      ...this.history.parts());
    this.detail.append(make("div", { class: "wide" }, this.title), make("div", { class: "column" }, this.figure, this.healthCard), time);
  }

  #zoom(span) {
    this.#span = span;
    this.spans.forEach((button, i) => button.setAttribute("aria-pressed", String(kSpans[i] === span)));
    this.#redraw();
  }

  #takePicture(data) {
    const picture = readPicture(data);
    if (picture.kind === "layout") this.#layouts.set(picture.sensor, new Layout(picture.x, picture.y));
    else if (picture.sensor === this.#chosen) this.#picture = picture;
    this.#redraw();
  }

  #showHealth() {
    const sensor = this.#status?.status.sensors.find((each) => each.name === this.#chosen);
    const facts = this.#status?.sensors.find((each) => each.name === this.#chosen);
    if (!sensor) return;
    const latency = sensor.latency_last_minute_us, zero = sensor.zero, realtime = this.#status.status.realtime;
    const rows = {
      health: healthWords(sensor.health) + (sensor.receiving ? "" : "; no fresh frames"),
      rate: `${fixed(sensor.rate_hz, 0, "Hz")} (device ${fixed(facts?.rate_hz, 0, "Hz")})`,
      lost: `${sensor.gaps}, ${sensor.lost}, ${sensor.skipped} of ${sensor.received}`,
      latency: `p50 ${fixed(latency?.p50, 0, "µs")}, p99 ${fixed(latency?.p99, 0, "µs")}`,
      zero: !zero ? "needs none" : zero.trouble ?? (isNumber(zero.taken_s_ago) ? `${zero.origin}, ${fixed(zero.taken_s_ago, 0, "s")} old` : "not known yet"),
      realtime: realtime.mode === "off" ? "off" : !realtime.got?.priority ? `asked, not got${realtime.refused ? `: ${realtime.refused}` : ""}` : `priority ${realtime.got.priority}`,
      device: `${facts?.device || sensor.driver}, ${facts?.taxels ?? "–"} taxels, method ${sensor.method ?? "–"}`,
      trouble: sensor.trouble ?? "none",
    };
    for (const [key, text] of Object.entries(rows)) setText(this.health[key], text);
  }

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
    const picture = this.#picture;
    if (!picture) {
      this.map.draw(null, { normal: [] });
      setText(this.caption, this.#stopped || "no picture yet");
      return;
    }
    const loaded = picture.peak_pa > 0 && estimate.state !== "no_contact";
    this.map.draw(this.#layouts.get(picture.sensor),
      { ...picture, normalScale: loaded ? 1 / 255 : 0, shearScale: loaded ? 1 / 127 : 0 }, estimate);
    setText(this.caption, `peak ${fixed(picture.peak_pa / 1000, 1, "kPa")}, shear up to ${fixed(picture.peak_shear_pa / 1000, 1, "kPa")}. ` +
      "Ring: the contact; dashed: what sticks; orange arrows: what slips.");
    this.canvas.dataset.sequence = String(picture.seq);
  }
}

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
