// Pressure and shear of a frame on a canvas: pressure as brightness, shear as arrows, light where the contact sticks and orange
// where it slips. A grid is drawn as one small picture that the browser enlarges; other layouts as discs.
import { sized } from "./dom.js";

const kMostArrows = 20;        // along a side
const kSmallestArrow = 0.04;   // share of the largest shear below which there is no arrow
const kNoiseSigmas = 5;        // standard deviations of noise below which there is none either
const kUsualNoise = 0.01;      // standard deviation of a taxel's shear where it was not measured, share of the greatest pressure
// From no pressure to the peak: dark to bright without a change of hue that the colour-blind lose (after viridis' blue half).
const kRamp = [[16, 19, 26], [28, 52, 96], [38, 98, 140], [72, 152, 158], [150, 205, 160], [240, 246, 190]];

function ramp(share) {
  const at = Math.min(0.9999, Math.max(0, share)) * (kRamp.length - 1), low = Math.floor(at), part = at - low;
  return kRamp[low].map((value, i) => Math.round(value + part * (kRamp[low + 1][i] - value)));
}
const kColours = Array.from({ length: 256 }, (_, i) => ramp(i / 255));

// Standard deviation of one taxel's shear as a share of the largest shear. `known`: as slipd measured it, in the unit of the peaks.
export const shearNoise = (peak, peakShear, known = null) => (known ?? kUsualNoise * peak) / peakShear;

// Where taxels are: x and y, mm, of each. A grid has `columns`.
export class Layout {
  constructor(x, y) {
    this.x = x;
    this.y = y;
    this.left = Math.min(...this.#ends(x));
    this.right = Math.max(...this.#ends(x));
    this.bottom = Math.min(...this.#ends(y));
    this.top = Math.max(...this.#ends(y));
    this.columns = this.#columns();
    this.pitch = this.#pitch();
  }

  get size() { return this.x.length; }

  #ends(values) {
    let least = Infinity, most = -Infinity;
    for (const value of values) {
      if (value < least) least = value;
      if (value > most) most = value;
    }
    return [least, most];
  }

  // Rows of equal length, x fastest; 0: it is no grid.
  #columns() {
    const { x, y } = this, near = 1e-4 * Math.max(1e-6, this.right - this.left, this.top - this.bottom);
    let columns = 1;
    while (columns < x.length && Math.abs(y[columns] - y[0]) < near) ++columns;
    if (x.length % columns !== 0) return 0;
    for (let i = 0; i < x.length; ++i) {
      if (Math.abs(x[i] - x[i % columns]) > near || Math.abs(y[i] - y[i - i % columns]) > near) return 0;
      if (i >= columns && y[i] <= y[i - columns] || i % columns > 0 && x[i] <= x[i - 1]) return 0;
    }
    return columns;
  }

  #pitch() {
    if (this.columns > 1) return (this.right - this.left) / (this.columns - 1);
    let least = Infinity;
    for (let i = 1; i < this.x.length; ++i) least = Math.min(least, Math.hypot(this.x[i] - this.x[0], this.y[i] - this.y[0]));
    return Number.isFinite(least) ? least : 1;
  }
}

export class TaxelMap {
  #small = document.createElement("canvas");
  #arrows = [];

  constructor(canvas) {
    this.canvas = canvas;
  }

  // There is no picture: it must not look like one of a sensor that nothing touches.
  clear() {
    const { context, width, height } = sized(this.canvas);
    context.clearRect(0, 0, width, height);
    this.canvas.dataset.picture = "none";
    this.canvas.dataset.sequence = this.canvas.dataset.stick = "";
  }

  // `normal`, `x`, `y`: values of each taxel; `scale`: what to multiply them with to get shares of the peaks; `noise`: shearNoise().
  // `contact`: center_mm, radius_mm, gamma and state of an estimate; absent: no zones.
  draw(layout, { normal, x, y, normalScale, shearScale, noise }, contact) {
    this.canvas.dataset.picture = "shown";
    const { context, width, height } = sized(this.canvas);
    context.fillStyle = "#10131a";
    context.fillRect(0, 0, width, height);
    if (!layout || layout.size !== normal.length) return;
    const margin = layout.pitch / 2;
    const across = Math.max(layout.right - layout.left, layout.top - layout.bottom) + 2 * margin;
    const per = Math.min(width, height) / across;
    const middle = { x: (layout.left + layout.right) / 2, y: (layout.bottom + layout.top) / 2 };
    const place = (mx, my) => [width / 2 + (mx - middle.x) * per, height / 2 - (my - middle.y) * per];
    if (layout.columns > 1) this.#grid(context, layout, normal, normalScale, place, per);
    else this.#discs(context, layout, normal, normalScale, place, per);
    const zones = this.#zones(contact);
    this.canvas.dataset.stick = zones !== null && zones.stick !== null ? String(zones.stick / zones.radius) : "";
    this.#drawArrows(context, layout, x, y, { scale: shearScale, noise }, zones, place, per);
    this.#drawZones(context, zones, place, per);
  }

  #grid(context, layout, normal, scale, place, per) {
    const { columns } = layout, rows = layout.size / columns, small = this.#small;
    if (small.width !== columns || small.height !== rows) {
      small.width = columns;
      small.height = rows;
    }
    const inner = small.getContext("2d"), image = inner.createImageData(columns, rows), pixels = image.data;
    for (let row = 0, i = 0; row < rows; ++row) {
      let at = 4 * columns * (rows - 1 - row);  // y points up
      for (let column = 0; column < columns; ++column, ++i, at += 4) {
        const rgb = kColours[Math.min(255, Math.max(0, Math.round(255 * normal[i] * scale)))] ?? kColours[0];
        pixels[at] = rgb[0];
        pixels[at + 1] = rgb[1];
        pixels[at + 2] = rgb[2];
        pixels[at + 3] = 255;
      }
    }
    inner.putImageData(image, 0, 0);
    const half = layout.pitch / 2, [left, top] = place(layout.left - half, layout.top + half);
    context.imageSmoothingEnabled = columns > 40;
    context.drawImage(small, left, top, (layout.right - layout.left + layout.pitch) * per, (layout.top - layout.bottom + layout.pitch) * per);
  }

  #discs(context, layout, normal, scale, place, per) {
    const radius = Math.max(2, 0.46 * layout.pitch * per);
    for (let i = 0; i < layout.size; ++i) {
      const [r, g, b] = kColours[Math.min(255, Math.max(0, Math.round(255 * normal[i] * scale)))] ?? kColours[0];
      context.fillStyle = `rgb(${r},${g},${b})`;
      context.strokeStyle = "#56657c";
      context.beginPath();
      context.arc(...place(layout.x[i], layout.y[i]), radius, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
  }

  #zones(contact) {
    const { center_mm: centre, radius_mm: radius, gamma, state } = contact ?? {};
    if (!Array.isArray(centre) || !(radius > 0)) return null;
    // docs/theory.md (3.1): the stick zone's radius is that of the contact times the cube root of the margin.
    const stick = state === "ok" && typeof gamma === "number" ? Math.cbrt(Math.max(0, gamma)) * radius : null;
    return { x: centre[0], y: centre[1], radius, stick };
  }

  #drawZones(context, zones, place, per) {
    if (!zones) return;
    const ring = (radius, dash) => {
      context.setLineDash(dash);
      context.beginPath();
      context.arc(...place(zones.x, zones.y), radius * per, 0, 2 * Math.PI);
      context.stroke();
      context.setLineDash([]);
    };
    context.lineWidth = 1.5;
    context.strokeStyle = "#ffffffb0";
    ring(zones.radius, []);
    if (zones.stick !== null) ring(zones.stick, [5, 4]);
  }

  // Means over squares of taxels, so that a fine grid has arrows that can be seen. None is of noise alone.
  #drawArrows(context, layout, x, y, { scale, noise }, zones, place, per) {
    const fine = layout.columns > kMostArrows || layout.size > kMostArrows * kMostArrows;
    const side = fine ? Math.max(layout.right - layout.left, layout.top - layout.bottom, 1e-9) / kMostArrows : 0;
    const bins = this.#arrows;
    bins.length = 0;
    if (!fine) {
      for (let i = 0; i < layout.size; ++i) bins.push([layout.x[i], layout.y[i], x[i], y[i], 1]);
    } else {
      const found = new Map();
      for (let i = 0; i < layout.size; ++i) {
        if (x[i] === 0 && y[i] === 0) continue;
        const column = Math.min(kMostArrows - 1, Math.floor((layout.x[i] - layout.left) / side));
        const row = Math.min(kMostArrows - 1, Math.floor((layout.y[i] - layout.bottom) / side));
        const key = row * kMostArrows + column;
        const bin = found.get(key);
        if (bin) {
          bin[2] += x[i];
          bin[3] += y[i];
          ++bin[4];
        } else {
          found.set(key, [layout.left + (column + 0.5) * side, layout.bottom + (row + 0.5) * side, x[i], y[i], 1]);
        }
      }
      bins.push(...found.values());
    }
    const length = (fine ? side : layout.pitch) * per * 1.15;
    context.lineWidth = Math.max(1.2, length / 11);
    context.lineCap = "round";
    let arrows = 0;
    for (const [mx, my, sx, sy, count] of bins) {
      const ax = sx * scale / count, ay = sy * scale / count, size = Math.hypot(ax, ay);
      if (!(size > Math.max(kSmallestArrow, kNoiseSigmas * noise / Math.sqrt(count)))) continue;
      ++arrows;
      const slips = zones && zones.stick !== null && Math.hypot(mx - zones.x, my - zones.y) > zones.stick;
      this.#arrow(context, place(mx, my), ax * length, -ay * length, slips ? "#ff9d2e" : "#f4f8ff");
    }
    this.canvas.dataset.arrows = String(arrows);
  }

  #arrow(context, [px, py], dx, dy, colour) {
    const angle = Math.atan2(dy, dx), size = Math.hypot(dx, dy), head = Math.min(6, 0.4 * size);
    context.strokeStyle = colour;
    context.beginPath();
    context.moveTo(px - dx / 2, py - dy / 2);
    context.lineTo(px + dx / 2, py + dy / 2);
    for (const turn of [2.6, -2.6]) {
      context.moveTo(px + dx / 2, py + dy / 2);
      context.lineTo(px + dx / 2 + head * Math.cos(angle + turn), py + dy / 2 + head * Math.sin(angle + turn));
    }
    context.stroke();
  }
}
