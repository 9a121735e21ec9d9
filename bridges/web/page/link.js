// The WebSocket to slipd-web: connects again by itself, and says within a second that nothing comes any more.
//
// slipd-web sends a message at least every 250 ms. Each is answered with "ready", and each picture with "drawn", when this page has
// taken it; slipd-web sends the next one only then, so that a slow page gets fewer and never old ones.

const kSilentMs = 800;  // without a message, the connection counts as lost
const kConnectMs = 5000;  // for the first one
const kLookMs = 100;    // between two looks at the clock
const kFirstPauseMs = 250, kLastPauseMs = 2000;
const kDrift = 1e-3;    // what two clocks may differ by, of the time

export class Link extends EventTarget {
  #socket = null;
  #heard = 0;
  #pause = kFirstPauseMs;
  #look = "";
  #lost = true;
  #quickest = Infinity;
  #timed = 0;

  constructor() {
    super();
    this.#connect();
    setInterval(() => this.#check(), kLookMs);
  }

  // Whether messages come.
  get lost() { return this.#lost; }

  // How much longer than the quickest message one was on its way, ms, that slipd-web made at `made_ms` of its own clock: what
  // waited in slipd-web, in the network or in a browser that slept is older than it says.
  late(made_ms) {
    const now = performance.now(), way = now - made_ms;
    this.#quickest = Math.min(way, this.#quickest + kDrift * (now - this.#timed));
    this.#timed = now;
    return way - this.#quickest;
  }

  // The sensor of which pictures are wanted; "": none.
  look(sensor) {
    this.#look = sensor;
    this.#send(sensor ? `look ${sensor}` : "look");
  }

  #connect() {
    const address = new URL("live", document.baseURI);
    address.protocol = address.protocol.replace("http", "ws");
    address.hash = "";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#heard = performance.now();
    this.#quickest = Infinity;  // a clock may have stood still while a machine slept
    socket.onopen = () => this.look(this.#look);
    socket.onmessage = (event) => { if (socket === this.#socket) this.#take(event.data); };
    socket.onclose = () => { if (socket === this.#socket) this.#again(); };
  }

  #send(text) {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(text);
  }

  #take(data) {
    this.#heard = performance.now();
    this.#pause = kFirstPauseMs;
    if (this.#lost) {
      this.#lost = false;
      this.#tell("found", null);
    }
    if (typeof data !== "string") {
      this.#tell("picture", data);
      this.#send("drawn");
      return;
    }
    const message = JSON.parse(data);
    this.#tell(message.type, message);
    if (message.type === "live") this.#send("ready");
  }

  #check() {
    const patience = this.#lost ? kConnectMs : kSilentMs;
    if (this.#socket && performance.now() - this.#heard > patience) this.#again();
  }

  #again() {
    const old = this.#socket;
    this.#socket = null;
    old?.close();
    if (!this.#lost) {
      this.#lost = true;
      this.#tell("lost", null);
    }
    setTimeout(() => this.#connect(), this.#pause);
    this.#pause = Math.min(2 * this.#pause, kLastPauseMs);
  }

  #tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}
