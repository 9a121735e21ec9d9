// Reads a recording of slipd (core/recording/recording.hpp) in the browser: a CBOR sequence of a header and blocks of frames. Taxels
// stay where they are in the file's bytes. A block whose form is wrong is left out, and counted.

const kText = new TextDecoder();
const kFloats = 85;  // tag of RFC 8746: float32, little-endian
const kStates = ["ok", "no_contact", "learning", "out_of_model", "no_shear", "unzeroed", "stale", "fault"];
const kAlerts = ["none", "warn", "slip", "unknown"];
const kSlidings = ["none", "disturbed", "translation", "rotation"];
const kCauses = [null, "margin", "sliding"];
// How a block begins: a map of eight, its first key "block", a number of 8 bytes.
const kBlock = [0xa8, 0x65, 0x62, 0x6c, 0x6f, 0x63, 0x6b, 0x1b];

const kScaled = 100;  // frames that the scale is taken from

class Cut extends Error {}

// Items of CBOR (RFC 8949) with given lengths, as slipd writes them.
class Items {
  constructor(bytes, at = 0, end = bytes.length) {
    Object.assign(this, { bytes, at, end, view: new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength) });
  }

  next(depth = 0) {
    if (depth > 8) throw new Cut("nested too deeply");
    const first = this.#take(1), kind = this.bytes[first] >> 5, short = this.bytes[first] & 31;
    if (kind === 7) return this.#simple(short);
    const length = this.#argument(short);
    switch (kind) {
      case 0: return length;
      case 1: return -1 - length;
      case 2: return this.#bytes(length);
      case 3: return kText.decode(this.#bytes(length));
      case 4: return Array.from({ length: this.#count(length) }, () => this.next(depth + 1));
      case 5: {
        const entries = {};
        for (let i = this.#count(length); i > 0; --i) entries[this.next(depth + 1)] = this.next(depth + 1);
        return entries;
      }
      default: {
        const value = this.next(depth + 1);
        return length === kFloats && value instanceof Uint8Array ? floats(value) : value;
      }
    }
  }

  #take(count) {
    const at = this.at;
    if (!(at + count <= this.end)) throw new Cut("cut");
    this.at += count;
    return at;
  }

  // An item has a byte at least, so a larger count is none.
  #count(count) {
    if (count > this.end - this.at) throw new Cut("cut");
    return count;
  }

  #bytes(count) {
    const at = this.#take(count);
    return this.bytes.subarray(at, at + count);
  }

  #argument(short) {
    if (short < 24) return short;
    if (short === 24) return this.bytes[this.#take(1)];
    if (short === 25) return this.view.getUint16(this.#take(2));
    if (short === 26) return this.view.getUint32(this.#take(4));
    if (short === 27) return Number(this.view.getBigUint64(this.#take(8)));
    throw new Cut("lengths must be given");
  }

  #simple(short) {
    if (short === 26) return this.view.getFloat32(this.#take(4));
    if (short === 27) return this.view.getFloat64(this.#take(8));
    return { 20: false, 21: true }[short] ?? null;
  }
}

function floats(bytes) {
  if (bytes.byteOffset % 4 === 0) return new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length >> 2);
  return { unaligned: bytes };  // copied when it is looked at
}

// Taxels of a frame, as numbers.
export function taxels(values) {
  return values.unaligned ? new Float32Array(values.unaligned.slice().buffer) : values;
}

function layoutOf(about) {
  const { grid, pitch_m: pitch, x_m: x, y_m: y, side_m: side } = about.layout;
  if (grid) {
    const [columns, rows] = grid, count = columns * rows;
    const place = (index, size) => 1e3 * pitch * (index - (size - 1) / 2);
    return {
      x: Float32Array.from({ length: count }, (_, i) => place(i % columns, columns)),
      y: Float32Array.from({ length: count }, (_, i) => place(Math.floor(i / columns), rows)),
      area_m2: pitch * pitch,
    };
  }
  if (x && y) return { x: Float32Array.from(x, (v) => 1e3 * v), y: Float32Array.from(y, (v) => 1e3 * v), area_m2: null };
  return { x: Float32Array.of(0), y: Float32Array.of(0), area_m2: side ? side * side : null };
}

function pointOf(frame, start_ns) {
  const estimate = frame.estimate ?? {};
  const known = (value, factor = 1) => (typeof value === "number" && Number.isFinite(value) ? factor * value : null);
  const state = frame.estimate ? kStates[estimate.state] ?? "fault" : null;
  return {
    t: 1e-9 * (frame.time_ns - start_ns), seq: frame.seq, state,
    alert: frame.estimate ? kAlerts[estimate.alert] ?? "slip" : null, alert_cause: kCauses[estimate.alert_cause] ?? null,
    sliding: kSlidings[estimate.sliding] ?? null,
    gamma: state === "ok" ? known(estimate.gamma) : null, sigma: known(estimate.sigma), truth: known(frame.truth_gamma),
    normal: known(estimate.normal_n), shear: known(estimate.shear_n), torque: known(estimate.torque_nm, 1e3),
    friction: known(estimate.friction), taxels: [frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa],
  };
}

// Forces of frames that were recorded without estimates: sums over taxels.
function addForces(point, area_m2) {
  if (area_m2 === null || point.normal !== null) return;
  const [normal, x, y] = point.taxels.map(taxels);
  const sum = (values) => values.reduce((total, value) => total + value, 0) * area_m2;
  point.normal = sum(normal);
  point.shear = Math.hypot(sum(x), sum(y));
}

// The same scale in all frames, so that they compare: the peaks of some of them.
function peaksOf(points) {
  let peak = 0, shear = 0;
  for (let i = 0; i < points.length; i += Math.ceil(points.length / kScaled)) {
    const [normal, x, y] = points[i].taxels.map(taxels);
    for (let j = 0; j < normal.length; ++j) {
      if (normal[j] > peak) peak = normal[j];
      const square = x[j] * x[j] + y[j] * y[j];
      if (square > shear) shear = square;
    }
  }
  return { peak, peakShear: Math.sqrt(shear) };
}

function findBlock(bytes, from) {
  for (let at = bytes.indexOf(kBlock[0], from); at >= 0; at = bytes.indexOf(kBlock[0], at + 1)) {
    if (kBlock.every((value, i) => bytes[at + i] === value)) return at;
  }
  return -1;
}

function readFrames(items, start_ns, points) {
  while (items.at < items.end) points.push(pointOf(items.next(), start_ns));
}

// { sensor, simulated, layout, points, damaged, … }. Throws Error for what is no recording.
export function readRecording(buffer) {
  const bytes = new Uint8Array(buffer), items = new Items(bytes);
  let head;
  try { head = items.next(); } catch { head = null; }
  if (head?.format !== "slipd-recording") throw new Error("this file is no recording of slipd");
  if (head.version !== 1 && head.version !== 2) throw new Error(`this recording is of version ${head.version}, which this page cannot read`);
  const about = head.version === 2 ? new Items(head.body).next() : head;
  const points = [];
  let damaged = 0;
  if (head.version === 1) {
    try { readFrames(items, about.start_monotonic_ns, points); } catch { ++damaged; }
  } else {
    for (let at = findBlock(bytes, items.at), number = 0; at >= 0;) {
      let next = at + 1;
      try {
        const inside = new Items(bytes, at), block = inside.next(), first = points.length;
        try { readFrames(new Items(block.body), about.start_monotonic_ns, points); } catch { points.length = first; ++damaged; }
        damaged += Math.max(0, block.block - number);
        number = block.block + 1;
        next = inside.at;
      } catch { /* cut, or not a block */ }
      at = findBlock(bytes, next);
    }
  }
  const layout = layoutOf(about);
  const usual = points.filter((point) => point.taxels.every(Boolean));
  for (const point of usual) if (point.state === null) addForces(point, layout.area_m2);
  return { ...about, layout, points: usual, damaged, ...peaksOf(usual) };
}
