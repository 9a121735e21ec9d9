// record.mjs OUT.mcap COMPRESSION: writes an MCAP file with @mcap/core, as a recorder of ROS 2 does; messages are made by
// @foxglove/rosmsg2-serialization from .msg texts. COMPRESSION: none, zstd, or unchunked. Standard input, a JSON line each: first
// {"TOPIC": {"name": …, "definition": .msg text, "encoding": …}, …}, then {"topic": …, "log_ns": …, "publish_ns": …, "message": {…}}
// with the times as texts. Of a message with "bytes", hexadecimal text, these are written instead.
import { open } from "node:fs/promises";
import { createInterface } from "node:readline";
import { createRequire } from "node:module";
const require = createRequire(process.cwd() + "/");
const { McapWriter } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const zstd = require("@foxglove/wasm-zstd");
await zstd.isLoaded;

const [out, compression] = process.argv.slice(2);
const file = await open(out, "w");
let position = 0n;
const writable = {
  position: () => position,
  write: async (bytes) => {
    position += BigInt(bytes.byteLength);
    await file.write(bytes);
  },
};
const writer = new McapWriter({
  writable,
  chunkSize: 1 << 16,
  useChunks: compression !== "unchunked",
  compressChunk: compression === "zstd" ? (data) => ({ compression: "zstd", compressedData: zstd.compress(data) }) : undefined,
});
await writer.start({ profile: "ros2", library: "record.mjs" });

let channels;
for await (const line of createInterface({ input: process.stdin })) {
  const given = JSON.parse(line);
  if (!channels) {
    channels = {};
    for (const [topic, { name, definition, encoding }] of Object.entries(given)) {
      const schemaId = await writer.registerSchema({ name, encoding: "ros2msg", data: new TextEncoder().encode(definition) });
      const id = await writer.registerChannel({ schemaId, topic, messageEncoding: encoding ?? "cdr", metadata: new Map() });
      channels[topic] = { id, messages: new MessageWriter(parse(definition, { ros2: true })) };
    }
    continue;
  }
  const { id, messages } = channels[given.topic];
  if (given.message?.data && typeof given.message.data === "string") given.message.data = Buffer.from(given.message.data, "hex");
  const data = given.bytes !== undefined ? Buffer.from(given.bytes, "hex") : messages.writeMessage(given.message);
  await writer.addMessage({ channelId: id, sequence: 0, logTime: BigInt(given.log_ns), publishTime: BigInt(given.publish_ns), data });
}
await writer.end();
await file.close();
