"""consumer.py DOOR ADDRESS MAX_AGE_S NAME: what a program at a door of slipd is told of a sensor, as lines of JSON: `t` (CLOCK_MONOTONIC, s), `state`,
`alert`, `gamma`. Each door is a function that yields what its consumer believes, following the rules of the door's page."""
import asyncio
import json
import math
import os
import socket
import struct
import subprocess
import sys
import threading
import time

import slipd

POLL_S = 0.005
DISCONNECTED = ("disconnected", "unknown", None)


def _without_frames(alert):
    """What is known of an alert once its frames are too old: a raised one stands."""
    return "unknown" if alert == "none" else alert


def board(path, max_age_s, name):
    """Python, shared memory."""
    with slipd.Board(path) as memory:
        while True:
            now = memory.latest(name, max_age_s)
            yield now.state, now.alert, now.gamma


def client(path, max_age_s, name):
    """Python, a subscription."""
    with slipd.Client(path) as connection:
        for now in connection.estimates(name, max_age_s=max_age_s):
            yield now.state, now.alert, now.gamma


def _asked(connect, ask):
    """What `ask(connection)` answers, again and again, on a connection that is made anew after each failure."""
    connection = None
    while True:
        try:
            if connection is None:
                connection = connect()
            believed = ask(connection)
        except OSError:
            if connection is not None:
                connection.close()
            connection, believed = None, DISCONNECTED
        yield believed


def _received(connection, is_whole):
    """Bytes of an answer, until it is whole."""
    received = b""
    while not is_whole(received):
        more = connection.recv(1 << 16)
        if not more:
            raise ConnectionError
        received += more
    return received


def raw_socket(path, max_age_s, name):
    """A program without a library, docs/socket.md: asks, and believes an answer of state ok for as long as it is young."""
    request = json.dumps({"jsonrpc": "2.0", "id": 1, "method": "gamma", "params": {"sensor": name}}).encode() + b"\n"

    def connect():
        made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        made.settimeout(max_age_s)
        try:
            made.connect(path)
        except OSError:
            made.close()
            raise
        return made

    def ask(connection):
        connection.sendall(request)
        now = json.loads(_received(connection, lambda received: received.endswith(b"\n")))["result"]["sensors"][0]
        if now["age_ms"] is not None and now["age_ms"] <= 1e3 * max_age_s:
            return now["state"], now["alert"], now["gamma"]
        return "stale", _without_frames(now["alert"]), None

    return _asked(connect, ask)


# By registers.csv: blocks, in the order of these sensors, and what is in one.
_FIRST_BLOCK, _BLOCK_SIZE, _STATE, _GAMMA, _ALERT = 16, 32, 0, 2, 10
_STATES = ("ok", "no_contact", "learning", "out_of_model", "no_shear", "unzeroed", "stale", "fault", "disconnected")
_ALERTS = ("none", "warn", "slip", "unknown")


def modbus(address, max_age_s, name):
    """A PLC, docs/plc.md: reads its block each cycle; no answer within max_age_s is no margin."""
    host, port = address.rsplit(":", 1)
    block = _FIRST_BLOCK + _BLOCK_SIZE * ("left", "right").index(name)
    whole = 9 + 2 * _BLOCK_SIZE

    def ask(plc):
        plc.sendall(struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, block, _BLOCK_SIZE))
        answer = _received(plc, lambda received: len(received) >= whole)
        registers = struct.unpack(f">{_BLOCK_SIZE}H", answer[9:whole])
        state, alert, gamma = (registers[at] for at in (_STATE, _ALERT, _GAMMA))
        return _STATES[state], _ALERTS[alert] if alert < len(_ALERTS) else "unknown", None if gamma == 0xFFFF else gamma * 1e-4

    return _asked(lambda: socket.create_connection((host, int(port)), timeout=max_age_s), ask)


_CAN_BASE = 0x5A0


def _crc8(data):
    """CRC-8 SAE J1850."""
    crc = 0xFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0x1D if crc & 0x80 else 0)) & 0xFF
    return crc ^ 0xFF


def can(address, _, name):
    """A controller on the bus, docs/can.md: nothing valid for three periods is no margin; an alert that was raised stands."""
    interface, period_s = address.split("/")
    wanted, deadline_s = _CAN_BASE + ("left", "right").index(name), 3 * float(period_s)
    bus = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    bus.bind((interface,))
    bus.settimeout(POLL_S)
    state, alert, gamma, heard, counter = "disconnected", "unknown", None, 0.0, None
    while True:
        try:
            frame_id, length, data = struct.unpack("=IB3x8s", bus.recv(16))
            valid = frame_id == wanted and length == 8 and _crc8(struct.pack("<I", frame_id) + data[:7]) == data[7] and data[6] >> 4 != counter
            if valid:
                state, alert, gamma = _STATES[data[4] & 15], _ALERTS[data[4] >> 4 & 3], int.from_bytes(data[:2], "little")
                gamma = None if gamma == 0xFFFF or state != "ok" else 1e-4 * gamma
                heard, counter = time.monotonic(), data[6] >> 4
        except OSError:  # nothing has come, or the interface is down
            time.sleep(POLL_S)
        if time.monotonic() - heard > deadline_s:
            state, alert, gamma = "disconnected", _without_frames(alert), None
        yield state, alert, gamma


class _Latest:
    """What came last, from another thread."""

    def __init__(self):
        self.lock, self.value = threading.Lock(), None

    def put(self, value):
        with self.lock:
            self.value = value

    def get(self):
        with self.lock:
            return self.value


def _mqtt(address, topics):
    """What the broker sent last under each of `topics`, as JSON; "" for one that it has forgotten. None: no connection."""
    import paho.mqtt.client as paho
    host, port = address.rsplit(":", 1)
    latest, connected = {topic: _Latest() for topic in topics}, _Latest()
    client_of_broker = paho.Client(protocol=paho.MQTTv5)

    def on_connect(*_):
        connected.put(True)
        for topic in topics:
            client_of_broker.subscribe(topic)

    client_of_broker.on_connect = on_connect
    client_of_broker.on_disconnect = lambda *_: connected.put(None)
    client_of_broker.on_message = lambda _, __, message: latest[message.topic].put(json.loads(message.payload or "null"))
    client_of_broker.connect(host, int(port), keepalive=5)
    client_of_broker.loop_start()
    while True:
        yield [latest[topic].get() for topic in topics] if connected.get() else None


def _believed_of(message, status, holds_s):
    """Of docs/mqtt.md: a message counts while status is online, and for `holds_s` from its time on."""
    if not status or status["status"] != "online" or not message:
        return ("disconnected", _without_frames(message["alert"]), None) if message else DISCONNECTED
    if not 0 <= time.time() - 1e-9 * message["time_ns"] <= holds_s:  # of the future: the clocks disagree
        return "stale", _without_frames(message["alert"]), None
    return message["state"], message["alert"], message.get("gamma")


def mqtt_estimates(address, max_age_s, name):
    """A subscriber of estimates, docs/mqtt.md."""
    for both in _mqtt(address, (f"slipd/gripper/{name}/estimate", "slipd/gripper/status")):
        yield _believed_of(both[0], both[1], max_age_s) if both else DISCONNECTED


def mqtt_states(address, _, name):
    """A subscriber of the retained state, docs/mqtt.md."""
    for both in _mqtt(address, (f"slipd/gripper/{name}/state", "slipd/gripper/status")):
        yield _believed_of(both[0], both[1], 1e-3 * both[0]["valid_for_ms"] if both[0] else 0) if both else DISCONNECTED


def ros2(address, max_age_s, name):
    """A node that judges the stamp, and asks for the deadline and the lease of docs/ros2.md."""
    deadline_ms, lease_ms, domain = address.split("/")
    reader = subprocess.Popen([os.path.join(os.environ["SLIPD_BINARY_DIR"], "test-bin", "ros2-cyclone-reader"), domain, name],
                              stdout=subprocess.PIPE, text=True, env={**os.environ, "DEADLINE_MS": deadline_ms, "LEASE_MS": lease_ms})
    latest = _Latest()
    latest.put((0, *DISCONNECTED))

    def read():
        for line in reader.stdout:
            topic, *words = line.split()
            if not topic.endswith("/estimate"):
                continue
            if len(words) == 3:
                latest.put(_of_message(bytes.fromhex(words[2])[4:], name))
            elif words[0] == "missed" or words[1] == "0":  # the deadline has passed, or the writer is not alive
                *_, alert, _ = latest.get()
                latest.put((0, "disconnected", _without_frames(alert), None))

    threading.Thread(target=read, daemon=True).start()
    while reader.poll() is None:
        stamp_s, state, alert, margin = latest.get()
        if state == "ok" and not 0 <= time.time() - stamp_s <= max_age_s:  # of the future: the clocks disagree
            yield "stale", _without_frames(alert), None
        else:
            yield state, alert, margin


def _of_message(data, name):
    """Stamp, state, alert and margin of a slipd_msgs/SlipEstimate in CDR: stamp, frame_id and name are before state and alert, and the margin is
    the second number behind the counters."""
    seconds, nanoseconds = struct.unpack_from("<iI", data)
    at = 8 + 4 + len(name) + 1
    at += -at % 4 + 4 + len(name) + 1
    state, alert = data[at], data[at + 1]
    at += 4
    at += -at % 8 + 3 * 8
    margin, = struct.unpack_from("<d", data, at)
    return seconds + 1e-9 * nanoseconds, _STATES[state], _ALERTS[alert], None if math.isnan(margin) else margin


def page(address, _, name):
    """Somebody who looks at the page of slipd-web, docs/web.md."""
    from page import browser
    chromium = browser()
    chromium.get(address)
    look = """const card = document.querySelector(`.card[data-kind="sensor"][data-name="${arguments[0]}"]`);
              return card ? [card.dataset.state, card.querySelector(".alert").dataset.alert, card.dataset.gamma] : null;"""
    while True:
        shown = chromium.execute_script(look, name)
        if shown:
            yield shown[0], shown[1], float(shown[2]) if shown[2] else None
        else:  # the page has no card yet
            time.sleep(POLL_S)


async def _asynchronous(path, max_age_s, name):
    async with slipd.AsyncClient(path) as connection:
        async for now in connection.estimates(name, max_age_s=max_age_s):
            tell((now.state, now.alert, now.gamma))


def tell(believed):
    state, alert, gamma = believed
    print(json.dumps({"t": time.monotonic(), "state": state, "alert": alert, "gamma": gamma}), flush=True)


DOORS = {"board": board, "client": client, "socket": raw_socket, "modbus": modbus, "can": can, "mqtt-estimates": mqtt_estimates, "mqtt-states": mqtt_states,
         "ros2": ros2, "page": page}
AS_IT_COMES = {"client", "can"}  # these wait for what comes; the others look again after a pause


def main(door, address, max_age_s, name):
    if door == "asyncio":
        asyncio.run(_asynchronous(address, float(max_age_s), name))
        return
    for believed in DOORS[door](address, float(max_age_s), name):
        tell(believed)
        if door not in AS_IT_COMES:
            time.sleep(POLL_S)


if __name__ == "__main__":
    main(*sys.argv[1:])
