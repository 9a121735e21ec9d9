// A sensor or a grasp in short: dial, number, state in words, alert and its cause, sliding, advice.
import { Dial } from "./dial.js";
import { fixed, isNumber, make, setData, setText } from "./dom.js";
import { adviceWords, alertLevel, alertWords, lowerBoundWords, marginLevel, slidingWords, stateWords } from "./words.js";

export class Card {
  #dial = new Dial();
  #number = make("p", { class: "number" });
  #value = make("span");
  #sigma = make("small");
  #low = make("p", { class: "low" });
  #truth = make("p", { class: "low true" });
  #state = make("span", { class: "state" });
  #alert = make("span", { class: "alert" });
  #simulated = make("span", { class: "simulated", hidden: true }, "simulated");
  #facts = {};

  // `kind`: "sensor" or "grasp"; `gel`: it sees displacements, and no forces; `choose`: called to show its details, absent: there are none.
  constructor(name, kind, gel, choose) {
    const fact = (key, label) => [make("dt", {}, label), (this.#facts[key] = make("dd"))];
    this.#number.append(this.#value, this.#sigma);
    this.button = choose ? make("button", { type: "button", "aria-pressed": "false", "aria-label": `Details of ${name}`, onclick: choose }, "Details") : null;
    const title = `card-${kind}-${name}`;
    this.element = make("article", { class: "card", "aria-labelledby": title, "data-name": name, "data-kind": kind },
      make("div", { class: "head" }, make("h2", { id: title }, name), make("span", { class: "kind" }, kind), this.#simulated),
      make("div", { class: "measure" }, this.#dial.element, make("div", {}, this.#number, this.#low, this.#truth)),
      make("div", { class: "verdict" }, this.#alert, this.#state),
      make("dl", { class: "facts" }, ...fact("slides", "Sliding"), ...fact("advice", "Advice"), ...fact("soon", "Slips in"),
        ...fact("forces", gel ? "Surface" : "Forces"), ...(kind === "grasp" ? fact("first", "First to slide") : fact("friction", "Friction"))),
      this.button ? make("div", { class: "bar" }, this.button) : null);
    this.element.tabIndex = -1;
  }

  show(estimate) {
    this.#dial.show(estimate);
    const known = isNumber(estimate.gamma);
    setText(this.#value, known ? estimate.gamma.toFixed(2) : "–");
    setText(this.#sigma, known && isNumber(estimate.sigma) ? ` ± ${estimate.sigma.toFixed(2)}` : "");
    setText(this.#low, lowerBoundWords(estimate));
    setData(this.#low, "beside", known ? "margin" : "");
    setText(this.#truth, isNumber(estimate.truth?.gamma) ? `true ${estimate.truth.gamma.toFixed(2)}` : "");
    setText(this.#state, stateWords(estimate));
    setData(this.#state, "state", estimate.state);
    setData(this.#state, "margin", marginLevel(estimate));
    setText(this.#alert, alertWords(estimate));
    setData(this.#alert, "alert", alertLevel(estimate));
    setData(this.element, "alert", alertLevel(estimate));
    setData(this.element, "state", estimate.state);
    setData(this.element, "gamma", known ? String(estimate.gamma) : "");
    this.#simulated.hidden = !estimate.simulated;
    setText(this.#facts.slides, slidingWords(estimate));
    setText(this.#facts.advice, adviceWords(estimate));
    setText(this.#facts.soon, isNumber(estimate.time_to_slip_ms) ? fixed(estimate.time_to_slip_ms / 1000, 2, "s") : "–");
    setText(this.#facts.forces, this.#forces(estimate));
    if (this.#facts.friction) setText(this.#facts.friction, this.#friction(estimate));
    if (this.#facts.first) setText(this.#facts.first, estimate.first ? `${estimate.first.sensor} (${fixed(estimate.first.gamma, 2)})` : "–");
  }

  choose(chosen) {
    this.element.classList.toggle("chosen", chosen);
    this.button?.setAttribute("aria-pressed", String(chosen));
  }

  #forces(estimate) {
    if (isNumber(estimate.displacement_mm))
      return `${fixed(estimate.displacement_mm, 2, "mm")} from rest${estimate.contact ? ", in contact" : ""}`;
    if (!isNumber(estimate.normal_n)) return "–";
    const torque = isNumber(estimate.torque_nmm) ? `, ${fixed(estimate.torque_nmm, 1, "N mm")}` : "";
    return `${fixed(estimate.normal_n, 2, "N")} normal, ${fixed(estimate.shear_n, 2, "N")} shear${torque}`;
  }

  #friction(estimate) {
    const spread = isNumber(estimate.friction_sigma) ? ` ± ${estimate.friction_sigma.toFixed(2)}` : "";
    return fixed(estimate.friction, 2) + (isNumber(estimate.friction) ? spread : "");
  }
}
