// What slipd's names mean, in words (docs/socket.md).

const kOk = {
  calm: "ok: the margin is measured",
  warn: "warn: the margin is measured, and small",
  slip: "slip: the margin is measured, and too small",
  gone: "slip: the margin is measured, and may be 0",
};
const kStates = {
  no_contact: "no contact: nothing touches the sensor",
  learning: "learning: let it slip once or give a friction",
  out_of_model: "out of model: the contact is not one that slipd can judge; let go and grip again",
  no_shear: "no shear: this sensor measures no tangential force",
  unzeroed: "unzeroed: let go of the object, or zero the sensor (slipctl rebias)",
  stale: "stale: no fresh frame comes from the sensor",
  fault: "fault: the sensor is not believed",
  disconnected: "disconnected: slipd is not reached",
};

const kHealth = {
  unknown: "unknown",
  good: "good",
  not_finite: "values that are not numbers",
  full_scale: "too many taxels beyond full scale",
  spike: "a taxel that no neighbour supports",
  uniform: "all taxels read the same",
  wrong_scale: "the force does not fit the contact's size",
  saturated: "taxels stand at full scale",
  repeated: "a frame came twice",
  frozen: "the same frame again and again",
  dead_normal: "the pressure channel stands still",
  dead_shear_x: "the shear channel x stands still",
  dead_shear_y: "the shear channel y stands still",
  dead_row: "a row or column of taxels stands still",
  time: "the frame's time is not after the last one's",
  jump: "another contact than a frame ago",
  noisy: "a channel has become much noisier",
  unexplained: "the frames say nothing of friction",
};

const kSliding = {
  none: "does not slide",
  disturbed: "disturbed: the load changed",
  translation: "slides along",
  rotation: "turns",
};

const kTouching = ["ok", "learning", "out_of_model"];
const kWithoutFrames = ["stale", "fault", "disconnected"];

// A margin of which nothing is left within its standard deviation, or by what the page shows of it.
const isGone = ({ gamma, sigma }) => typeof gamma === "number" && gamma - 2 * (sigma ?? 0) < 0.005;

// How bad a margin that is known is: "calm", "warn", "slip", "gone"; "": there is none.
export function marginLevel(estimate) {
  if (estimate.state !== "ok") return "";
  if (isGone(estimate)) return "gone";
  const level = alertLevel(estimate);
  return level === "warn" || level === "slip" ? level : "calm";
}

export const stateWords = (estimate) =>
  kOk[marginLevel(estimate)] ?? kStates[estimate.state] ?? `${estimate.state}: a state that this page does not have`;
export const healthWords = (health) => kHealth[health] ?? String(health ?? "–");

// A pattern that stands still is no evidence where all of a contact may slide.
export function slidingWords(estimate) {
  if (!estimate.sliding || (estimate.sliding === "none" && isGone(estimate)))
    return kTouching.includes(estimate.state) ? "not known: the pattern cannot show it" : "–";
  const words = kSliding[estimate.sliding] ?? estimate.sliding;
  const time = estimate.sliding_for_ms;
  return typeof time === "number" ? `${words}, for ${(time / 1000).toFixed(1)} s` : words;
}

// What is known of an estimate without its frames: an alert that was raised stands, and that there is none is not known any more.
export function withoutFrames(estimate, state) {
  const { sensor, grasp, simulated, alert, alert_cause } = estimate;
  return { sensor, grasp, simulated, state, gamma: null, alert: alert === "none" ? "unknown" : alert, alert_cause };
}

export function alertWords(estimate) {
  const level = alertLevel(estimate);
  if (level === "none") return "no alert";
  if (level === "unknown") return "? alert unknown";
  const stands = kWithoutFrames.includes(estimate.state) ? " (stands)" : "";
  const cause = estimate.alert_cause ? `: ${estimate.alert_cause}` : "";
  return `${level === "warn" ? "⚠ warn" : "✕ slip"}${stands}${cause}`;
}

// An alert that this page does not have counts as the worst one.
export function alertLevel({ alert }) {
  if (!alert) return "unknown";
  return ["none", "unknown", "warn"].includes(alert) ? alert : "slip";
}

// gamma_low. Where it is all that is known it must not read like a margin: with little tangential load it is near 1, whatever the
// contact is.
export function lowerBoundWords({ state, gamma_low: low }) {
  if (typeof low !== "number") return "no lower bound";
  const bound = `lower bound ${low.toFixed(2)} (95\u00a0%)`;
  if (state === "ok") return bound;
  return `no margin; ${bound} ${state === "learning" ? "for the lowest friction set" : "of the forces alone"}`;
}

// What a gripper may do now.
export function adviceWords(estimate) {
  const force = estimate.grip_increase_n;
  if (typeof force !== "number") return "–";
  const size = `${Math.abs(force).toFixed(2)} N`;
  if (force > 0.005) return `grip ${size} harder`;
  if (force < -0.005) return `${size} less would do`;
  return "the grip is as asked";
}
