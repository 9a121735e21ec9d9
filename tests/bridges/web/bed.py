"""slipd and slipd-web on sockets of their own, for tests in Python: no test knows the other's ports or files."""
import base64
import contextlib
import http.client
import json
import os
import re
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
from pathlib import Path

from awaiting import PATIENCE_S, await_true

BUILD = Path(os.environ["SLIPD_BINARY_DIR"])

# A grasp of two fingers: grips, is loaded until it slips, holds, is let go. The object hangs beside the fingers, so it turns.
CYCLE = [
    {"ms": 500, "normal_n": 0, "shear_n": 0, "friction": 0.6}, {"ms": 400, "normal_n": [0, 4]}, {"ms": 200},
    {"ms": 900, "load": [0, 1.05]}, {"ms": 300, "normal_n": [4, 6]}, {"ms": 800, "load": [0.7, 0.4]}, {"ms": 1500},
    {"ms": 900, "load": [0.4, 0.85]}, {"ms": 700, "load": [0.85, 1.06]}, {"ms": 500, "shear_n": [3.6, 0]}, {"ms": 400, "normal_n": [6, 0]},
]


def two_fingers(folder, **more):
    """A configuration of slipd: two simulated fingers of one grasp with torque."""
    sensor = lambda name, seed: {"name": name, "driver": "sim", "rate_hz": 200, "stale_after_ms": 1000, "layout": {"grid": [32, 32], "pitch_mm": 0.45}, "options": {"seed": seed, "lever_mm": 3, "cycle": CYCLE, "noise": 0.01, "noise_kind": "relative"}}
    return {"sensors": [sensor("left", 1), sensor("right", 2)], "grasps": [{"name": "gripper", "sensors": ["left", "right"]}],
            "estimator": {"method": "moments"}, "realtime": {"mode": "off"}, "socket": {"path": f"{folder}/slipd.sock"}, **more}


def trial(name, options=None, **more):
    """A sensor of the driver that misbehaves as its options ask (tests/support/trial_driver). It does not go stale for being slow."""
    return {"name": name, "driver": "trial", "rate_hz": 100, "stale_after_ms": 60000, "layout": {"grid": [20, 20], "pitch_mm": 0.72}, "options": options or {}, **more}


def of_trials(*sensors, **more):
    """A configuration of such sensors, for Bed."""
    return lambda folder: {"sensors": list(sensors), "estimator": {"method": "moments"}, "realtime": {"mode": "off"},
                           "socket": {"path": f"{folder}/slipd.sock"}, **more}


class Program:
    """A program with its output in a file."""

    def __init__(self, log, *command, env=None):
        self.log = Path(log)
        with open(log, "wb") as out:
            self.process = subprocess.Popen([str(each) for each in command], stdout=out, stderr=out, stdin=subprocess.DEVNULL,
                                            env={**os.environ, **(env or {})})

    def said(self):
        return self.log.read_text(errors="replace")

    def signal(self, number):
        self.process.send_signal(number)

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
        return self.process.wait(PATIENCE_S)


class Bed:
    """Both programs, in a folder that is removed at the end."""

    def __init__(self, config=two_fingers, slipd=True, drivers="drivers", environment=None, **settings):
        self.drivers, self.environment = BUILD / drivers, environment
        self.folder = Path(tempfile.mkdtemp(prefix="slipd-web-"))
        (self.folder / "recordings").mkdir()
        self.config = self.folder / "slipd.json"
        self.config.write_text(json.dumps(config(self.folder)))
        self.settings = self.folder / "web.json"
        self.settings.write_text(json.dumps({
            "slipd": {"socket": f"{self.folder}/slipd.sock"}, "listen": {"port": 0}, "recordings": str(self.folder / "recordings"), **settings}))
        self.slipd = self.web = None
        if slipd:
            self.start_slipd()
        self.start_web()

    def start_slipd(self):
        self.slipd = Program(self.folder / "slipd.log", BUILD / "bin/slipd", "--config", self.config, "--driver-dir", self.drivers, env={"STATE_DIRECTORY": str(self.folder)})
        await_true(lambda: self._serves() or self._ended(self.slipd), "slipd's socket")

    def _serves(self):
        with socket.socket(socket.AF_UNIX) as client:
            return client.connect_ex(str(self.folder / "slipd.sock")) == 0

    @staticmethod
    def _ended(program):
        if program.process.poll() is not None:
            raise AssertionError(program.said())
        return False

    def start_web(self):
        self.web = Program(self.folder / "web.log", BUILD / "bin/slipd-web", "--config", self.settings, env=self.environment)
        serves = lambda: re.search(r"serves http://(.*):(\d+)/", self.web.said()) or self._ended(self.web)
        self.port = int(await_true(serves, "slipd-web's port")[2])
        self.url = f"http://127.0.0.1:{self.port}/"

    def get(self, target="/", method="GET", host=None, body=None, **headers):
        """(status, headers, body) of one request. `host`: instead of the right one; headers with _ for -."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_S)
        with contextlib.closing(connection):
            connection.putrequest(method, target, skip_host=True, skip_accept_encoding=True)
            connection.putheader("Host", host if host is not None else f"127.0.0.1:{self.port}")
            for name, value in headers.items():
                connection.putheader(name.replace("_", "-"), value)
            if body is not None:
                connection.putheader("Content-Length", str(len(body)))
            connection.endheaders()
            if body is not None:
                connection.send(body)
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()

    def counts(self):
        return json.loads(self.get("/api/counts")[2])

    def close(self):
        for program in (self.web, self.slipd):
            if program:
                program.stop()
        shutil.rmtree(self.folder)


class WebSocket:
    """The least of a client of WebSockets (RFC 6455): no extension, no check of what slipd-web says."""

    def __init__(self, port, path="/live", headers=()):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        head = [f"GET {path} HTTP/1.1", f"Host: 127.0.0.1:{port}", "Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
                "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode(), *headers]
        self.socket.sendall(("\r\n".join(head) + "\r\n\r\n").encode())
        self.input = b""
        while b"\r\n\r\n" not in self.input:
            more = self.socket.recv(65536)
            if not more:
                break
            self.input += more
        head, _, self.input = self.input.partition(b"\r\n\r\n")
        self.status = int(head.split()[1]) if head else 0

    def _take(self, count):
        while len(self.input) < count:
            more = self.socket.recv(262144)
            if not more:
                raise ConnectionError("closed")
            self.input += more
        out, self.input = self.input[:count], self.input[count:]
        return out

    def next(self):
        """(opcode, content)"""
        first, length = self._take(2)
        if length == 126:
            length = struct.unpack(">H", self._take(2))[0]
        elif length == 127:
            length = struct.unpack(">Q", self._take(8))[0]
        return first & 15, self._take(length)

    def message(self, kind):
        """The next message of a type, or the head of the next picture of a kind; the ones before are answered as the page does."""
        while True:
            opcode, content = self.next()
            if opcode == 8:
                raise ConnectionError(f"closed: {content!r}")
            if opcode == 2:
                message = json.loads(content[4:4 + struct.unpack("<I", content[:4])[0]])
                self.say("drawn")
            elif opcode == 1:
                message = json.loads(content)
                if message["type"] == "live":
                    self.say("ready")
            else:
                continue
            if kind in (message.get("type"), message.get("kind")):
                return message

    def say(self, text, opcode=1, masked=True):
        content = text.encode() if isinstance(text, str) else text
        length = bytes([len(content)]) if len(content) < 126 else struct.pack(">BH", 126, len(content)) if len(content) < 65536 else struct.pack(">BQ", 127, len(content))
        head = bytes([0x80 | opcode, length[0] | (0x80 if masked else 0)]) + length[1:]
        self.socket.sendall(head + (bytes(4) if masked else b"") + content)  # a mask of zeros changes nothing

    def close(self):
        self.socket.close()
