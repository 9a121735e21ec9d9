// Pictures of frames as slipd-web sends them (docs/web.md): the head's length in 4 bytes, little-endian, the head in JSON, the values.
//   kind "layout": x and y of each taxel, mm, float32
//   kind "frame":  pressure of each taxel as a share of peak_pa in 255ths, shear x and y as shares of peak_shear_pa in 127ths

const kText = new TextDecoder();

export function readPicture(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(kText.decode(new Uint8Array(buffer, 4, length)));
  const begin = 4 + length, count = head.taxels;
  if (head.kind === "layout") {
    const values = new Float32Array(buffer.slice(begin));
    return { ...head, x: values.subarray(0, count), y: values.subarray(count, 2 * count) };
  }
  return {
    ...head,
    normal: new Uint8Array(buffer, begin, count),
    x: new Int8Array(buffer, begin + count, count),
    y: new Int8Array(buffer, begin + 2 * count, count),
  };
}
