// The page "Method": for each sensor the error of each method against its time, which one runs and why, and what its scene leaves out.
import { colour, fixed, isNumber, make, sized } from "./dom.js";

// Why slipd uses a method, by method_reason of docs/socket.md.
const kReasons = {
  configured: "The configuration names it (estimator.method).",
  few_taxels: "No single frame of a sensor of so few taxels tells its margin; fit weighs them over time, whatever estimator.method says.",
  skin: "The taxels lie under rubber (skin.depth_mm), for which no other method corrects.",
  forces: "The sensor gives a force only, or its skin is flat: nothing else tells its margin.",
  no_shear: "The sensor measures no shear, so it has no margin.",
  no_force: "The sensor measures how far a surface moves, and no force, so it has no margin.",
};

const kMethods = {
  "svd-knn": "compares the frame with trained ones in the positions of its training data",
  registered: "compares the frame with trained ones, on rings about the contact's centre",
  moments: "the ratio of the second moments of shear and pressure; no training, the cheapest",
  fit: "fits the contact model to all taxels; its sigma follows from the fit; the most accurate",
  "block-fit": "fits the contact model to taxels summed in square blocks; nearly as accurate, in a fifth of the time",
  closing: "compares the shear with pressures recorded while the gripper closed; any shape",
  friction: "margin from friction and forces: 1 − (Q/P)/μ",
};

export class MethodPage {
  element = make("div", { class: "stack" });

  hide() {}

  async show() {
    this.element.replaceChildren(make("p", { class: "empty" }, "Asking slipd …"));
    const answer = await fetch("api/method").then((response) => response.json()).catch((error) => ({ trouble: String(error) }));
    if (!answer.sensors) {
      this.element.replaceChildren(make("p", { class: "empty" }, answer.trouble ?? "slipd is not reached"));
      return;
    }
    this.element.replaceChildren(make("h2", {}, "Method and trust"),
      make("p", { class: "note" }, "The error is that of single frames of unseen contacts of the sensor's scene, by each method alone. In a grasp, " +
        "sigma beside each margin says what to expect."),
      ...answer.sensors.map((sensor) => this.#sensor(sensor)));
    this.#draw = () => answer.sensors.forEach((sensor) => drawTradeoff(this.element.querySelector(`[data-plot="${CSS.escape(sensor.name)}"]`), sensor));
    this.#draw();
    window.onresize = () => this.#draw();
  }

  #draw = () => {};

  #sensor(sensor) {
    const rows = sensor.tradeoff?.rows ?? [], used = sensor.method;
    const percent = (value) => (isNumber(value) ? `${(100 * value).toFixed(0)} %` : "–");
    const titles = ["Method", "Rank, rings", "Mean error", "95 % below", "Right class", "Answered", "In σ, 2 σ", "p50", "p99"];
    const table = make("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": `Methods of ${sensor.name}` }, make("table", {},
      make("thead", {}, make("tr", {}, ...titles.map((text) => make("th", { scope: "col" }, text)))),
      make("tbody", {}, ...rows.map((row) => make("tr", { class: row.method === used ? "used" : "" },
        make("td", {}, row.method), make("td", {}, [row.rank, row.rings].filter(Boolean).join(", ") || "–"),
        make("td", {}, fixed(row.mean_error, 3)), make("td", {}, fixed(row.p95_error, 3)), make("td", {}, percent(row.class_right)),
        make("td", {}, percent(row.answered)), make("td", {}, `${percent(row.within_sigma)}, ${percent(row.within_two_sigma)}`),
        make("td", {}, fixed(row.p50_us, 1, "µs")), make("td", {}, fixed(row.p99_us, 1, "µs")))))));
    const name = `method-${sensor.name}`;
    return make("section", { class: "card", "aria-labelledby": name },
      make("div", { class: "head" }, make("h2", { id: name }, sensor.name), sensor.simulated ? make("span", { class: "simulated" }, "simulated") : null,
        make("span", { class: "kind" }, `${sensor.taxels ?? "–"} taxels, ${sensor.class ?? "class not known"}`)),
      make("p", {}, ...why(sensor, rows)),
      rows.length < 2 ? null : make("canvas", { class: "plot small", role: "img", "data-plot": sensor.name,
                                                  "aria-label": "Mean error against time of each method; the table has the numbers" }),
      rows.length === 0 ? make("p", { class: "empty" }, sensor.trouble ?? "Nothing has been measured for this sensor yet.") : table,
      make("p", { class: "note" }, leftOut(sensor, rows)));
  }
}

function why(sensor, rows) {
  if (!sensor.method) return ["No method runs yet."];
  const meaning = kMethods[sensor.method] ? `: ${kMethods[sensor.method]}` : "";
  const said = [make("strong", {}, sensor.method), `${meaning}. `];
  const own = rows.find((row) => row.method === sensor.method);
  if (sensor.method_reason === "auto") said.push(chosen(sensor, rows, own));
  else if (kReasons[sensor.method_reason]) said.push(kReasons[sensor.method_reason]);
  said.push(own ? ` Its mean error is ${fixed(own.mean_error, 3)} at ${fixed(own.p50_us, 1, "µs")} a frame.`
                : " Its error on single frames was not measured for this sensor.");
  return said;
}

// Why `auto` took it.
function chosen(sensor, rows, own) {
  const budget = sensor.tradeoff?.budget_us, limit = `${fixed(budget, 0, "µs")} a frame (estimator.budget_us)`;
  const others = rows.map((row) => row.method).filter((method) => method !== sensor.method).join(", ");
  if (!own || !isNumber(budget) || !others) return "Method auto chose it.";
  return own.p50_us <= budget ? `Method auto chose it: of the methods within ${limit} it errs least and answers most.`
                              : `Method auto chose it: it is faster than ${others}, and none takes at most ${limit}.`;
}

function leftOut(sensor, rows) {
  const measured = new Set(rows.map((row) => row.method));
  const others = Object.keys(kMethods).filter((method) => method !== "friction" && !measured.has(method));
  const processor = sensor.tradeoff?.processor ? `Measured on ${sensor.tradeoff.processor}. ` : "";
  return processor + (others.length > 0 && rows.length > 0 ? `Not measured for this sensor's scene: ${others.join(", ")}.` : "");
}

// Both axes by powers of ten.
function drawTradeoff(canvas, sensor) {
  if (!canvas) return;
  const { context, width, height } = sized(canvas);
  const rows = sensor.tradeoff.rows.filter((row) => row.mean_error > 0 && row.p50_us > 0);
  context.clearRect(0, 0, width, height);
  if (rows.length === 0) return;
  const span = (values) => [Math.floor(Math.log10(Math.min(...values))), Math.max(Math.ceil(Math.log10(Math.max(...values))), Math.floor(Math.log10(Math.min(...values))) + 1)];
  const [left, right] = span(rows.map((row) => row.p50_us)), [bottom, top] = span(rows.map((row) => row.mean_error));
  const x = (value) => 60 + (Math.log10(value) - left) / (right - left) * (width - 130);
  const y = (value) => height - 26 - (Math.log10(value) - bottom) / (top - bottom) * (height - 42);
  context.font = `${0.78 * parseFloat(getComputedStyle(document.documentElement).fontSize)}px system-ui, sans-serif`;
  context.strokeStyle = colour("line");
  context.fillStyle = colour("faint");
  for (let power = left; power <= right; ++power) {
    line(context, x(10 ** power), 16, x(10 ** power), height - 26);
    context.textAlign = "center";
    context.fillText(`${10 ** power} µs`, x(10 ** power), height - 8);
  }
  for (let power = bottom; power <= top; ++power) {
    line(context, 60, y(10 ** power), width - 70, y(10 ** power));
    context.textAlign = "right";
    context.fillText(String(10 ** power), 54, y(10 ** power) + 4);
  }
  for (const row of rows) {
    const used = row.method === sensor.method;
    context.fillStyle = colour(used ? "good-fill" : "faint");
    context.beginPath();
    context.arc(x(row.p50_us), y(row.mean_error), used ? 6 : 4, 0, 2 * Math.PI);
    context.fill();
    context.fillStyle = colour("ink");
    context.textAlign = "left";
    context.fillText(row.method, x(row.p50_us) + 9, y(row.mean_error) + 4);
  }
}

function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
