// Elements in short, and numbers as text. No HTML is ever made from text.

export function make(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

export function makeSvg(tag, attributes = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

// Changes the page only where the text differs: screens at 30 pictures a second stay idle otherwise.
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function setData(element, key, value) {
  if (element.dataset[key] !== value) element.dataset[key] = value;
}

export const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

// "–" for what is not known.
export function fixed(value, digits, unit = "") {
  if (!isNumber(value)) return "–";
  const text = value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1").replace("-", "−");
  return unit ? `${text} ${unit}` : text;
}

export function withSigma(value, sigma, digits, unit = "") {
  if (!isNumber(value)) return "–";
  const spread = isNumber(sigma) ? ` ± ${sigma.toFixed(digits)}` : "";
  return fixed(value, digits) + spread + (unit ? ` ${unit}` : "");
}

export function bytes(count) {
  if (count < 1e6) return `${(count / 1e3).toFixed(1)} kB`;
  return `${(count / 1e6).toFixed(1)} MB`;
}

// A colour of the style sheet, for canvases.
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// Sizes a canvas for the screen's pixels; returns its context, with lengths in CSS pixels, and its size.
export function sized(canvas) {
  const scale = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  const columns = Math.max(1, Math.round(width * scale)), rows = Math.max(1, Math.round(height * scale));
  if (canvas.width !== columns || canvas.height !== rows) {
    canvas.width = columns;
    canvas.height = rows;
  }
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  return { context, width, height };
}
