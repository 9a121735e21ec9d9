"""consumer.py DOOR ADDRESS MAX_AGE_S NAME: what a program at a door of slipd is told of a sensor, as lines of JSON: `t` (CLOCK_MONOTONIC, s), `state`,
`alert`, `gamma`. Each door is a function that yields what its consumer believes, following the rules of the door's page."""
import asyncio
import json
import socket
import struct
import sys
import time

import slipd

POLL_S = 0.005
DISCONNECTED = ("disconnected", "unknown", None)


def board(path, max_age_s, name):
    """Python, shared memory."""
    with slipd.Board(path) as memory:
        while True:
            now = memory.latest(name, max_age_s)
            yield now.state, now.alert, now.gamma
            time.sleep(POLL_S)


def client(path, max_age_s, name):
    """Python, a subscription."""
    with slipd.Client(path) as connection:
        for now in connection.estimates(name, max_age_s=max_age_s):
            yield now.state, now.alert, now.gamma


def raw_socket(path, max_age_s, name):
    """A program without a library, docs/socket.md: asks, and believes an answer of state ok for as long as it is young."""
    connection, rest, number = None, b"", 0
    while True:
        try:
            if connection is None:
                connection, rest = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM), b""
                connection.settimeout(max_age_s)
                connection.connect(path)
            number += 1
            connection.sendall(json.dumps({"jsonrpc": "2.0", "id": number, "method": "gamma", "params": {"sensor": name}}).encode() + b"\n")
            while b"\n" not in rest:
                received = connection.recv(1 << 16)
                if not received:
                    raise ConnectionError
                rest += received
            line, rest = rest.split(b"\n", 1)
            now = json.loads(line)["result"]["sensors"][0]
            young = now["age_ms"] is not None and now["age_ms"] <= 1e3 * max_age_s
            if young:
                yield now["state"], now["alert"], now["gamma"]
            else:
                yield "stale", "unknown" if now["alert"] == "none" else now["alert"], None
        except OSError:
            if connection is not None:
                connection.close()
            connection = None
            yield DISCONNECTED
        time.sleep(POLL_S)


# By registers.csv: blocks, in the order of these sensors, and what is in one.
_FIRST_BLOCK, _BLOCK_SIZE, _STATE, _GAMMA, _ALERT = 16, 32, 0, 2, 10
_STATES = ("ok", "no_contact", "learning", "out_of_model", "no_shear", "unzeroed", "stale", "fault", "disconnected")
_ALERTS = ("none", "warn", "slip")


def modbus(address, max_age_s, name):
    """A PLC, docs/plc.md: reads its block each cycle; no answer within max_age_s is no margin."""
    host, port = address.rsplit(":", 1)
    block = _FIRST_BLOCK + _BLOCK_SIZE * ("left", "right").index(name)
    plc = None
    while True:
        try:
            if plc is None:
                plc = socket.create_connection((host, int(port)), timeout=max_age_s)
            plc.sendall(struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, block, _BLOCK_SIZE))
            answer = b""
            while len(answer) < 9 + 2 * _BLOCK_SIZE:
                received = plc.recv(256)
                if not received:
                    raise ConnectionError
                answer += received
            registers = struct.unpack(f">{_BLOCK_SIZE}H", answer[9:9 + 2 * _BLOCK_SIZE])
            state, alert, gamma = (registers[at] for at in (_STATE, _ALERT, _GAMMA))
            yield _STATES[state], _ALERTS[alert] if alert < len(_ALERTS) else "unknown", None if gamma == 0xFFFF else gamma * 1e-4
        except OSError:
            if plc is not None:
                plc.close()
            plc = None
            yield DISCONNECTED
        time.sleep(POLL_S)


async def _asynchronous(path, max_age_s, name):
    async with slipd.AsyncClient(path) as connection:
        async for now in connection.estimates(name, max_age_s=max_age_s):
            tell((now.state, now.alert, now.gamma))


def tell(believed):
    state, alert, gamma = believed
    print(json.dumps({"t": time.monotonic(), "state": state, "alert": alert, "gamma": gamma}), flush=True)


DOORS = {"board": board, "client": client, "socket": raw_socket, "modbus": modbus}


def main(door, address, max_age_s, name):
    if door == "asyncio":
        asyncio.run(_asynchronous(address, float(max_age_s), name))
        return
    for believed in DOORS[door](address, float(max_age_s), name):
        tell(believed)


if __name__ == "__main__":
    main(*sys.argv[1:])
