// What slipd's names mean, in words (docs/socket.md).

const kStates = {
  ok: "ok: the margin is measured",
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

export const stateWords = (state) => kStates[state] ?? `${state}: a state that this page does not have`;
export const healthWords = (health) => kHealth[health] ?? String(health ?? "–");

export function slidingWords(estimate) {
  if (!estimate.sliding) return "–";
  const words = kSliding[estimate.sliding] ?? estimate.sliding;
  const time = estimate.sliding_for_ms;
  return typeof time === "number" ? `${words}, for ${(time / 1000).toFixed(1)} s` : words;
}

// An alert that this page does not have counts as the worst one.
export function alertWords(estimate) {
  if (!estimate.alert) return "no alert known";
  if (estimate.alert === "none") return "no alert";
  const cause = estimate.alert_cause ? `: ${estimate.alert_cause}` : "";
  return `${estimate.alert === "warn" ? "⚠ warn" : "✕ slip"}${cause}`;
}

export function alertLevel(estimate) {
  if (!estimate.alert) return "unknown";
  return estimate.alert === "none" || estimate.alert === "warn" ? estimate.alert : "slip";
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
