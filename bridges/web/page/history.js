// The last minute of a sensor or grasp, as points for plots.
import { isNumber } from "./dom.js";

const kKeptS = 62;

export class History {
  points = [];
  #gap = false;

  add(estimate, now_ms) {
    const t = now_ms / 1000, known = (value, factor = 1) => (isNumber(value) ? factor * value : null);
    this.points.push({
      t, gap: this.#gap, alert: estimate.alert,
      gamma: known(estimate.gamma), sigma: known(estimate.sigma), low: isNumber(estimate.gamma) ? known(estimate.gamma_low) : null, truth: known(estimate.truth?.gamma),
      normal: known(estimate.normal_n), shear: known(estimate.shear_n), torque: known(estimate.torque_nmm),
      friction: known(estimate.friction, 10), frictionSigma: known(estimate.friction_sigma, 10),
    });
    this.#gap = false;
    let old = 0;
    while (old < this.points.length && this.points[old].t < t - kKeptS) ++old;
    if (old > 200) this.points.splice(0, old);
  }

  // What comes next is not joined with what was before.
  gap() { this.#gap = true; }
}
