// The page "Recordings": the list, and one of them played with its time line. A link #/recordings/FILE@SECONDS leads to a moment.
import { bytes, fixed, make, setText, withSigma } from "./dom.js";
import { Layout, TaxelMap, shearNoise } from "./map.js";
import { drawPlot, firstAt, keys } from "./plot.js";
import { readRecording, taxels } from "./recording.js";
import { alertWords, stateWords } from "./words.js";

const kSpeeds = [1, 0.5, 0.25, 0.1, 0.02];
const kLongestJoined = 0.1;  // s without an estimate that a line is drawn across
const kMostButtons = 12;     // of slips
const kMostBytes = 400e6;  // of a file that this page opens; larger ones are for slipctl and Python

export class RecordingsPage {
  element = make("div");
  #player = null;

  async show(rest) {
    this.hide();
    const [file, moment] = rest.split("@");
    await (file ? this.#open(file, Number(moment) || 0) : this.#list());
  }

  hide() {
    this.#player?.stop();
    this.#player = null;
  }

  async #list() {
    const answer = await fetch("api/recordings").then((response) => response.json()).catch((error) => ({ trouble: String(error) }));
    const rows = (answer.recordings ?? []).map((each) => make("tr", {},
      make("td", {}, make("a", { href: `#/recordings/${encodeURIComponent(each.file)}` }, each.file)),
      make("td", {}, make("a", { href: `recordings/${encodeURIComponent(each.file)}`, download: each.file, "aria-label": `Download ${each.file}` }, bytes(each.bytes))),
      make("td", {}, new Date(each.written_ms).toLocaleString())));
    const none = answer.trouble ?? "There are no recordings. The flight recorder writes one at each slip (recorder in slipd.json); slipctl record writes others.";
    this.element.replaceChildren(make("section", { class: "card" }, make("h2", {}, "Recordings"),
      rows.length === 0 ? make("p", { class: "empty" }, none)
        : make("div", { class: "scroll" }, make("table", { class: "files" },
          make("thead", {}, make("tr", {}, ...["File", "Download", "Written"].map((text) => make("th", { scope: "col" }, text)))),
          make("tbody", {}, ...rows)))));
  }

  async #open(file, moment) {
    const note = make("p", { class: "empty", role: "status" }, `Reading ${file} …`);
    this.element.replaceChildren(note);
    try {
      const response = await fetch(`recordings/${encodeURIComponent(file)}`);
      if (!response.ok) throw new Error(response.status === 404 ? "it is gone: slipd keeps the newest ones only" : `${response.status}`);
      const size = Number(response.headers.get("content-length"));
      if (size > kMostBytes) throw new Error(`${bytes(size)} are more than this page opens; download it and use slipctl plot or Python`);
      const recording = readRecording(await response.arrayBuffer());
      if (recording.points.length === 0) throw new Error("it has no whole frame");
      this.#player = new Player(file, recording, moment);
      this.element.replaceChildren(this.#player.element);
      this.#player.draw();
    } catch (error) {
      setText(note, `${file}: ${error.message}`);
    }
  }
}

class Player {
  #playing = false;
  #before = 0;
  #speed = kSpeeds[0];

  constructor(file, recording, moment) {
    Object.assign(this, { file, recording, points: recording.points });
    // slipd skips frames while it has no processor. One without an estimate says nothing: neither an alert nor a margin ends there.
    const estimated = this.points.filter((point) => point.state !== null);
    const late = (point, i) => i > 0 && point.t - estimated[i - 1].t > kLongestJoined;
    this.plotted = estimated.length > 0 ? estimated.map((point, i) => (late(point, i) ? { ...point, gap: true } : point)) : this.points;
    this.first = this.points[0].t;
    this.last = Math.max(this.points.at(-1).t, this.first + 1e-3);
    this.t = Math.min(this.last, Math.max(this.first, moment));
    this.layout = new Layout(recording.layout.x, recording.layout.y);
    this.#make();
    this.redraw = () => this.draw();
    window.addEventListener("resize", this.redraw);
  }

  stop() {
    this.#playing = false;
    window.removeEventListener("resize", this.redraw);
  }

  #make() {
    const { recording } = this;
    const button = (text, label, act) => make("button", { type: "button", "aria-label": label, onclick: act }, text);
    this.canvas = make("canvas", { class: "map", role: "img", "aria-label": "Pressure and shear of the taxels" });
    this.map = new TaxelMap(this.canvas);
    this.margins = make("canvas", { class: "plot", role: "img", "aria-label": "Margin over the recording; click to go there" });
    this.forces = make("canvas", { class: "plot small", role: "img", "aria-label": "Forces over the recording" });
    this.play = button("▶ Play", "Play or pause", () => this.#toggle());
    this.scrub = make("input", { type: "range", min: this.first, max: this.last, step: "any", "aria-label": "Time in the recording, s",
                                 oninput: () => this.#go(Number(this.scrub.value)) });
    this.speed = make("select", { "aria-label": "Speed", onchange: () => { this.#speed = Number(this.speed.value); } },
      ...kSpeeds.map((value) => make("option", { value }, value === 1 ? "real time" : `× ${value}`)));
    this.moment = make("a", { href: "" }, "Link to this moment");
    this.facts = make("dl", { class: "facts", "aria-live": "off" });
    this.rows = Object.fromEntries(["Time", "State", "Margin", "Alert", "Forces", "Friction"].map((label) => {
      const value = make("dd");
      this.facts.append(make("dt", {}, label), value);
      return [label, value];
    }));
    const alerts = this.plotted.filter((point, i) => point.alert === "slip" && this.plotted[i - 1]?.alert !== "slip");
    this.margins.addEventListener("click", (event) => this.#go(this.timeAt(event.offsetX)));
    const simulated = recording.simulated ? make("span", { class: "simulated" }, "simulated") : null;
    const damaged = recording.damaged ? `, ${recording.damaged} damaged blocks left out` : "";
    this.element = make("div", {},
      make("p", {}, make("a", { href: "#/recordings" }, "← Recordings")),
      make("div", { class: "head" }, make("h2", {}, this.file), simulated,
        make("span", { class: "kind" }, `${recording.sensor}, ${this.points.length} frames, ${fixed(this.last - this.first, 1, "s")}${damaged}, ` +
          `from ${new Date(recording.start_realtime_ns / 1e6).toLocaleString()}`)),
      make("div", { class: "bar" }, button("◀|", "One frame back", () => this.#step(-1)), this.play, button("|▶", "One frame on", () => this.#step(1)),
        this.scrub, this.speed, this.moment),
      make("div", { class: "bar", role: "group", "aria-label": "Slips" }, alerts.length === 0 ? "No slip alert in it." : "Slips:",
        ...alerts.slice(0, kMostButtons).map((point) => button(fixed(point.t, 2, "s"), `Go to the slip at ${fixed(point.t, 2, "s")}`, () => this.#go(point.t)))),
      make("div", { class: "detail" }, make("figure", { class: "card" }, this.canvas, this.facts),
        make("section", { class: "card" }, make("h3", {}, "Margin"), this.margins,
          keys(make, [["good-fill", "margin ± σ"], ["sim", "truth (simulated)"], ["mid-fill", "warn"], ["bad-fill", "slip"]]),
          make("h3", {}, "Forces"), this.forces, keys(make, [["good-fill", "normal force, N"], ["mid-fill", "shear force, N"]]))));
    this.element.addEventListener("keydown", (event) => this.#key(event));
  }

  #key(event) {
    if (event.target !== this.scrub && ["INPUT", "SELECT", "BUTTON", "A"].includes(event.target.tagName)) return;
    const act = { ArrowLeft: () => this.#step(-1), ArrowRight: () => this.#step(1), " ": () => this.#toggle() }[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }

  #index() { return Math.min(this.points.length - 1, Math.max(0, firstAt(this.points, this.t + 1e-9) - 1)); }

  #step(by) {
    this.#pause();
    this.#go(this.points[Math.min(this.points.length - 1, Math.max(0, this.#index() + by))].t);
  }

  #go(t) {
    this.t = Math.min(this.last, Math.max(this.first, t));
    this.draw();
  }

  #pause() {
    this.#playing = false;
    setText(this.play, "▶ Play");
  }

  #toggle() {
    if (this.#playing) {
      this.#pause();
      return;
    }
    if (this.t >= this.last) this.t = this.first;
    this.#playing = true;
    this.#before = performance.now();
    setText(this.play, "⏸ Pause");
    requestAnimationFrame(() => this.#run());
  }

  #run() {
    if (!this.#playing) return;
    const now = performance.now();
    this.#go(this.t + (now - this.#before) / 1000 * this.#speed);
    this.#before = now;
    if (this.t >= this.last) this.#pause();
    else requestAnimationFrame(() => this.#run());
  }

  draw() {
    const point = this.points[this.#index()], range = [this.first, this.last];
    this.timeAt = drawPlot(this.margins, this.plotted, { range, low: 0, high: 1, unit: "Γ", cursor: this.t, lines: [
      { key: "truth", colour: "sim", dash: [4, 3], width: 1.5 }, { key: "gamma", colour: "good-fill", band: "sigma" }] });
    drawPlot(this.forces, this.plotted, { range, unit: "N", cursor: this.t, alerts: false, lines: [
      { key: "shear", colour: "mid-fill" }, { key: "normal", colour: "good-fill" }] });
    const [normal, x, y] = point.taxels.map(taxels);
    const { peak, peakShear } = this.recording;
    this.map.draw(this.layout, { normal, x, y, normalScale: peak > 0 ? 1 / peak : 0, shearScale: peakShear > 0 ? 1 / peakShear : 0, noise: shearNoise(peak, peakShear) }, null);
    this.canvas.dataset.sequence = String(point.seq);
    this.scrub.value = String(this.t);
    this.scrub.setAttribute("aria-valuetext", fixed(this.t, 3, "s"));
    this.moment.href = `#/recordings/${encodeURIComponent(this.file)}@${this.t.toFixed(3)}`;
    setText(this.rows.Time, `${fixed(point.t, 3, "s")}, frame ${point.seq}`);
    setText(this.rows.State, point.state ? stateWords(point) : "this frame has no estimate");
    setText(this.rows.Margin, withSigma(point.gamma, point.sigma, 2) + (point.truth === null ? "" : ` (true ${fixed(point.truth, 2)})`));
    setText(this.rows.Alert, alertWords(point));
    setText(this.rows.Forces, `${fixed(point.normal, 2, "N")} normal, ${fixed(point.shear, 2, "N")} shear`);
    setText(this.rows.Friction, fixed(point.friction, 2));
  }
}
