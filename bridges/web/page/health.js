// How a sensor is, from slipd's status, which comes once a second.
import { fixed, isNumber, make, setText } from "./dom.js";
import { healthWords } from "./words.js";

const kRows = [
  ["health", "Frames"], ["rate", "Rate"], ["lost", "Gaps, lost, skipped"], ["latency", "Latency, last minute"],
  ["zero", "Zero"], ["realtime", "Real time"], ["device", "Device"], ["trouble", "Trouble"],
];

export class Health {
  #values = Object.fromEntries(kRows.map(([key]) => [key, make("dd")]));

  constructor() {
    this.element = make("section", { class: "card" }, make("h3", {}, "Health"),
      make("dl", { class: "facts" }, ...kRows.flatMap(([key, label]) => [make("dt", {}, label), this.#values[key]])));
  }

  // `status`: the message of slipd-web, null: none that is young. `state`: the sensor's. Of one that says nothing it is not known
  // how it is.
  show(name, status, state) {
    const sensor = status?.status.sensors.find((each) => each.name === name);
    const rows = sensor ? rowsOf(sensor, status.sensors.find((each) => each.name === name), status.status.realtime) : {};
    if (!sensor || state === "stale" || state === "disconnected") Object.assign(rows, { health: healthWords("unknown"), rate: "–" });
    for (const [key] of kRows) setText(this.#values[key], rows[key] ?? "–");
  }
}

function rowsOf(sensor, facts, realtime) {
  const latency = sensor.latency_last_minute_us;
  return {
    health: healthWords(sensor.health) + (sensor.receiving ? "" : "; no fresh frames"),
    rate: `${fixed(sensor.receiving ? sensor.rate_hz : null, 0, "Hz")} (device ${fixed(facts?.rate_hz, 0, "Hz")})`,
    lost: `${sensor.gaps}, ${sensor.lost}, ${sensor.skipped} of ${sensor.received}`,
    latency: `p50 ${fixed(latency?.p50, 0, "µs")}, p99 ${fixed(latency?.p99, 0, "µs")}`,
    zero: zeroWords(sensor.zero),
    realtime: realtimeWords(realtime),
    device: `${facts?.device || sensor.driver}, ${facts?.taxels ?? "–"} taxels, method ${sensor.method ?? "–"}`,
    trouble: sensor.trouble ?? "none",
  };
}

function zeroWords(zero) {
  if (!zero) return "needs none";
  return zero.trouble ?? (isNumber(zero.taken_s_ago) ? `${zero.origin}, ${fixed(zero.taken_s_ago, 0, "s")} old` : "not known yet");
}

function realtimeWords({ mode, got, refused }) {
  if (mode === "off") return "off";
  return got?.priority ? `priority ${got.priority}` : `asked, not got${refused ? `: ${refused}` : ""}`;
}
