// server.mjs PORT: a WebSocket server of npm's `ws`. What stands on a line of its input, as JSON text, goes to every client. Prints how many
// clients it has whenever that changes. Ends with its input, once everything is sent.
import { createRequire } from "node:module";
import { createInterface } from "node:readline";

const { WebSocketServer } = createRequire(process.cwd() + "/")("ws");
const server = new WebSocketServer({ host: "127.0.0.1", port: Number(process.argv[2]), perMessageDeflate: true });
const tell = () => console.log(server.clients.size);
server.on("listening", tell);
server.on("connection", (client) => {
  client.on("error", (error) => console.error(String(error)));
  client.on("close", tell);
  client.send('{"message": "Welcome"}', tell);
});
for await (const line of createInterface({ input: process.stdin })) {
  const text = JSON.parse(line);
  const half = text.length >> 1;
  for (const client of server.clients) {
    client.send(text.slice(0, half), { fin: false });  // a message in two fragments
    client.send(text.slice(half), { fin: true });
  }
}
for (const client of server.clients) client.close();
server.close();
