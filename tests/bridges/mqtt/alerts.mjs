// alerts.mjs mqtt PORT... | alerts.mjs nats PORT: a durable subscriber of alerts. Prints "ready", then each payload on a line.
//
// mqtt: a persistent session of MQTT.js at one of these brokers in turn. nats: a durable consumer of the stream MQTT's messages are in.
import { createRequire } from "node:module";

const require = createRequire(process.cwd() + "/");
const [kind, ...ports] = process.argv.slice(2);

if (kind === "mqtt") {
  const servers = ports.map((port) => ({ host: "127.0.0.1", port: Number(port) }));
  const client = require("mqtt").connect({ servers, clientId: "npm-mqtt", clean: false, reconnectPeriod: 200, keepalive: 5, resubscribe: false });
  client.on("message", (_topic, payload) => console.log(payload.toString()));
  client.on("error", (error) => console.error(String(error)));
  client.on("connect", () =>
    client.subscribe("slipd/+/+/alert", { qos: 1 }, (error) => (error ? console.error(String(error)) : console.log("ready"))));
} else {
  const { connect, AckPolicy, DeliverPolicy } = require("nats");
  const connection = await connect({ servers: `127.0.0.1:${ports[0]}`, maxReconnectAttempts: -1, reconnectTimeWait: 200 });
  const stream = "$MQTT_msgs";
  const manager = await connection.jetstreamManager();
  await manager.consumers.add(stream, {
    durable_name: "npm", ack_policy: AckPolicy.Explicit, deliver_policy: DeliverPolicy.All, filter_subject: "$MQTT.msgs.slipd.*.*.alert",
  });
  const consumer = await connection.jetstream().consumers.get(stream, "npm");
  console.log("ready");
  for await (const message of await consumer.consume()) {
    console.log(message.string());
    message.ack();
  }
}
