// messages.mjs FILE.mcap: prints each message of an MCAP file as one line of JSON, read by @mcap/core's indexed reader and decoded from
// the .msg text of its schema by @foxglove/rosmsg2-serialization. First a line with the header, the channels and the statistics.
// Numbers that JSON lacks are texts: "NaN", 64 bit integers. Bytes are hexadecimal text.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
const require = createRequire(process.cwd() + "/");
const { McapIndexedReader } = require("@mcap/core");
const { loadDecompressHandlers } = require("@mcap/support");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

const plain = (_, value) => {
  if (typeof value === "bigint") return value.toString();
  if (typeof value === "number" && !Number.isFinite(value)) return String(value);
  if (value instanceof Uint8Array) return Buffer.from(value).toString("hex");
  return value;
};
const print = (value) => console.log(JSON.stringify(value, plain));

const bytes = await readFile(process.argv[2]);
const readable = {
  size: async () => BigInt(bytes.length),
  read: async (offset, length) => new Uint8Array(bytes.buffer, bytes.byteOffset + Number(offset), Number(length)),
};
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
const readers = new Map();
for (const [id, schema] of reader.schemasById) {
  if (schema.encoding !== "ros2msg") throw new Error(`schema ${schema.name} is ${schema.encoding}`);
  readers.set(id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
}
print({
  profile: reader.header.profile,
  library: reader.header.library,
  crc: reader.dataEndCrc,
  topics: Object.fromEntries([...reader.channelsById.values()].map((c) => [c.topic, reader.schemasById.get(c.schemaId).name])),
  hashes: Object.fromEntries([...reader.channelsById.values()].map((c) => [c.topic, c.metadata.get("topic_type_hash")])),
  messages: reader.statistics.messageCount,
  chunks: reader.statistics.chunkCount,
});
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  print({ topic: channel.topic, time: message.logTime, message: readers.get(channel.schemaId).readMessage(message.data) });
}
