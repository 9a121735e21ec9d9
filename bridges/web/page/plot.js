// Lines over time on a canvas: a band about one of them, marks for alerts, gaps where nothing is known.
import { colour, fixed, isNumber, sized } from "./dom.js";

const kRight = 10, kTop = 8;
let edge = 44, foot = 20, letters = 12;  // px, by the size of the page's text

function measure() {
  letters = Math.round(0.78 * parseFloat(getComputedStyle(document.documentElement).fontSize));
  edge = Math.round(3.5 * letters);
  foot = Math.round(1.7 * letters);
}

// A step of an axis that people read easily: 1, 2 or 5 times a power of ten.
function step(range, most) {
  const rough = range / most, power = 10 ** Math.floor(Math.log10(rough));
  for (const factor of [1, 2, 5]) if (factor * power >= rough) return factor * power;
  return 10 * power;
}

// `lines`: [{ key, colour, band?, dash? }] of points { t, … }, in s; `low`, `high`: ends of the axis, absent: what the points need.
// `range`: [first, last] s; `relative`: times are said as before the last; `cursor`: a time to mark.
export function drawPlot(canvas, points, { lines, range, low, high, unit = "", relative = false, cursor = null, alerts = true }) {
  const { context, width, height } = sized(canvas);
  measure();
  const [first, last] = range;
  const begin = firstAt(points, first), end = firstAt(points, last) + 1;
  const shown = points.slice(Math.max(0, begin - 1), end + 1);
  const [bottom, top] = ends(shown, lines, low, high);
  const x = (t) => edge + (t - first) / (last - first) * (width - edge - kRight);
  const y = (value) => height - foot - (value - bottom) / (top - bottom) * (height - kTop - foot);
  context.clearRect(0, 0, width, height);
  context.font = `${letters}px system-ui, sans-serif`;
  axes(context, { width, height, first, last, bottom, top, x, y, unit, relative });
  context.save();
  context.beginPath();
  context.rect(edge, kTop - 2, width - edge - kRight, height - kTop - foot + 4);
  context.clip();
  if (alerts) marks(context, shown, x, height);
  for (const line of lines) {
    if (line.band) band(context, shown, line, x, y);
    stroke(context, shown, line, x, y);
  }
  if (cursor !== null) upright(context, x(cursor), height, colour("ink"), 2);
  context.restore();
  return (pixel) => first + (pixel - edge) / (width - edge - kRight) * (last - first);
}

// The first point at or after `t`; points are in order.
export function firstAt(points, t) {
  let low = 0, high = points.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (points[middle].t < t) low = middle + 1;
    else high = middle;
  }
  return low;
}

function ends(points, lines, low, high) {
  if (low !== undefined && high !== undefined) return [low, high];
  let least = low ?? 0, most = high ?? -Infinity;
  for (const point of points) {
    for (const { key } of lines) {
      const value = point[key];
      if (!isNumber(value)) continue;
      if (low === undefined && value < least) least = value;
      if (high === undefined && value > most) most = value;
    }
  }
  if (!(most > least)) most = least + 1;
  const grown = step(most - least, 4);
  return [least < 0 ? Math.floor(least / grown) * grown : least, high ?? Math.ceil(most / grown) * grown];
}

function axes(context, { width, height, first, last, bottom, top, x, y, unit, relative }) {
  context.strokeStyle = colour("line");
  context.fillStyle = colour("faint");
  context.lineWidth = 1;
  context.textAlign = "right";
  context.textBaseline = "middle";
  const up = step(top - bottom, 5);
  for (let value = Math.ceil(bottom / up - 1e-9) * up; value <= top + 1e-9; value += up) {
    const at = Math.round(y(value)) + 0.5;
    context.beginPath();
    context.moveTo(edge, at);
    context.lineTo(width - kRight, at);
    context.stroke();
    context.fillText(fixed(value, Math.max(0, -Math.floor(Math.log10(up) + 1e-9))), edge - 6, at);
  }
  context.textBaseline = "alphabetic";
  const across = step(last - first, Math.max(2, width / (9 * letters))), origin = relative ? last : 0;
  for (let t = Math.ceil((first - origin) / across - 1e-9) * across; t <= last - origin + 1e-9; t += across) {
    const text = fixed(t, Math.max(0, -Math.floor(Math.log10(across) + 1e-9)));
    const at = x(t + origin);
    context.textAlign = at > width - 3 * letters ? "right" : "center";
    context.fillText(`${text} s`, Math.min(at, width - 4), height - 5);
  }
  if (unit) {
    context.textAlign = "left";
    context.fillText(unit, edge + 5, kTop + letters);
  }
}

function upright(context, at, height, stroke, width) {
  context.strokeStyle = stroke;
  context.lineWidth = width;
  context.beginPath();
  context.moveTo(at, kTop - 2);
  context.lineTo(at, height - foot);
  context.stroke();
}

// Where an alert begins, and how long it lasts as a bar at the top.
function marks(context, points, x, height) {
  for (let i = 0; i < points.length; ++i) {
    const level = points[i].alert;
    if (!level || level === "none" || level === "unknown") continue;
    const fill = colour(level === "warn" ? "mid-fill" : "bad-fill");
    if (i > 0 && points[i - 1].alert !== level) upright(context, x(points[i].t), height, fill, level === "warn" ? 1 : 1.5);
    let end = i;
    while (end + 1 < points.length && joined(points, end + 1) && points[end + 1].alert === level) ++end;
    context.fillStyle = fill;
    context.fillRect(x(points[i].t), kTop - 2, Math.max(2, x(points[end].t) - x(points[i].t)), level === "warn" ? 3 : 6);
    i = end;
  }
}

const joined = (points, i) => points[i].gap !== true;

function stroke(context, points, { key, colour: name, dash = [], width = 2 }, x, y) {
  context.strokeStyle = colour(name);
  context.lineWidth = width;
  context.lineJoin = "round";
  context.setLineDash(dash);
  context.beginPath();
  let open = false;
  for (let i = 0; i < points.length; ++i) {
    const value = points[i][key];
    if (!isNumber(value)) {
      open = false;
      continue;
    }
    if (open && joined(points, i)) context.lineTo(x(points[i].t), y(value));
    else context.moveTo(x(points[i].t), y(value));
    open = true;
  }
  context.stroke();
  context.setLineDash([]);
}

function band(context, points, { key, band: spread, fill = "band" }, x, y) {
  context.fillStyle = colour(fill);
  for (let i = 0; i < points.length; ++i) {
    if (!isNumber(points[i][key]) || !isNumber(points[i][spread])) continue;
    let end = i;
    while (end + 1 < points.length && joined(points, end + 1) && isNumber(points[end + 1][key]) && isNumber(points[end + 1][spread])) ++end;
    context.beginPath();
    for (let j = i; j <= end; ++j) context.lineTo(x(points[j].t), y(points[j][key] + points[j][spread]));
    for (let j = end; j >= i; --j) context.lineTo(x(points[j].t), y(points[j][key] - points[j][spread]));
    context.fill();
    i = end;
  }
}

// What the lines of a plot are.
export function keys(make, entries) {
  return make("ul", { class: "keys" }, ...entries.map(([name, text]) => {
    const swatch = make("i");
    swatch.style.background = `var(--${name})`;
    return make("li", {}, swatch, text);
  }));
}
