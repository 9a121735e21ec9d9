// The margin as a dial: an arc from 0 (slips) to 1 (no tangential load), its standard deviation as a band, gamma_low as a
// mark. Without a margin it has the truth of a simulated sensor at most.
import { isNumber, makeSvg, setData } from "./dom.js";

const kRadius = 42, kCentre = 50;

function point(value, radius) {
  const angle = Math.PI * (1 - value);
  return `${(kCentre + radius * Math.cos(angle)).toFixed(2)} ${(kCentre - radius * Math.sin(angle)).toFixed(2)}`;
}

function arc(from, to, radius = kRadius) {
  return `M ${point(from, radius)} A ${radius} ${radius} 0 0 1 ${point(to, radius)}`;
}

const limited = (value) => Math.min(1, Math.max(0, value));

export class Dial {
  #parts = {};

  constructor() {
    const stroke = (name, width, path = "") =>
      (this.#parts[name] = makeSvg("path", { class: name, fill: "none", "stroke-width": width, d: path }));
    this.element = makeSvg("svg", { class: "dial", viewBox: "0 0 100 64", role: "meter", "aria-valuemin": 0, "aria-valuemax": 1,
                                    "aria-label": "safety margin" },
      stroke("track", 9, arc(0, 1)), stroke("value", 9), stroke("band", 15), stroke("needle", 2.5),
      (this.#parts.low = makeSvg("path", { class: "low" })), (this.#parts.truth = makeSvg("path", { class: "truth" })),
      makeSvg("text", { x: 8, y: 62, "text-anchor": "middle" }, "0"), makeSvg("text", { x: 92, y: 62, "text-anchor": "middle" }, "1"));
  }

  show({ gamma = null, sigma = null, gamma_low = null, truth = null }) {
    const known = isNumber(gamma);
    const at = known ? limited(gamma) : 0;
    this.#set("value", known ? arc(0, Math.max(at, 0.002)) : "");
    this.#set("needle", known ? `M ${point(at, 28)} L ${point(at, 49)}` : "");
    this.#set("band", known && isNumber(sigma) ? arc(limited(at - sigma), Math.max(limited(at + sigma), limited(at - sigma) + 0.002)) : "");
    this.#set("low", known && isNumber(gamma_low) ? this.#mark(limited(gamma_low), 36, 30) : "");
    this.#set("truth", isNumber(truth?.gamma) ? this.#mark(limited(truth.gamma), 36, 30) : "");
    setData(this.element, "level", !known ? "none" : at < 0.2 ? "bad" : at < 0.4 ? "mid" : "good");
    const words = known ? `margin ${at.toFixed(2)}` : "no margin";
    if (this.element.getAttribute("aria-valuetext") === words) return;
    this.element.setAttribute("aria-valuetext", words);
    if (known) this.element.setAttribute("aria-valuenow", at.toFixed(2));
    else this.element.removeAttribute("aria-valuenow");
  }

  #mark(value, tip, foot) {
    const half = 0.022;
    return `M ${point(value, tip)} L ${point(value - half, foot)} L ${point(value + half, foot)} Z`;
  }

  #set(name, path) {
    if (this.#parts[name].getAttribute("d") !== path) this.#parts[name].setAttribute("d", path);
  }
}
