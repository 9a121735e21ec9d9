"""slipd-mqtt under test: a program on a FakeSlipd."""
import json, os, subprocess, tempfile, threading, unittest

from awaiting import PATIENCE_S, await_true
from fake_slipd import FakeSlipd, Server

BUILD = os.environ["SLIPD_BINARY_DIR"]


class Certificates:
    """An authority in `folder`, and certificates that it issues; paths of PEM files."""

    def __init__(self, folder, name):
        self.folder, self.name, self.ca_file = folder, name, os.path.join(folder, name + ".crt")
        self._openssl("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", name + ".key", "-out", name + ".crt", "-days", "2", "-subj", "/CN=" + name)

    def issue(self, names):
        """(certificate, key) of a server with these names, such as "IP:127.0.0.1"."""
        server = f"{self.name}-{names.replace(':', '-')}"
        path = os.path.join(self.folder, server)
        self._openssl("req", "-newkey", "rsa:2048", "-nodes", "-keyout", server + ".key", "-out", server + ".csr", "-subj", "/CN=broker")
        with open(path + ".names", "w") as file:
            file.write(f"subjectAltName={names}\n")
        self._openssl("x509", "-req", "-in", server + ".csr", "-CA", self.name + ".crt", "-CAkey", self.name + ".key", "-CAcreateserial",
                      "-out", server + ".crt", "-days", "2", "-extfile", server + ".names")
        return path + ".crt", path + ".key"

    def _openssl(self, *arguments):
        subprocess.run(["openssl", *arguments], check=True, capture_output=True, cwd=self.folder)


class Bridge:
    """slipd-mqtt with these brokers. `within`: a command that runs it. `restarts`: it is started anew after a failure, as by its service."""

    def __init__(self, folder, socket, brokers, host="gripper", within=(), restarts=False, **more):
        self.within = within
        self.ends = not restarts
        self.log_file = os.path.join(folder, host + ".log")
        self.settings = os.path.join(folder, host + ".json")
        with open(self.settings, "w") as file:
            json.dump({"brokers": brokers, "host": host, "socket": socket, "store": {"file": os.path.join(folder, host + ".db")} | more.pop("store", {})}
                      | more, file)
        self.start()

    def start(self):
        with open(self.log_file, "a") as log:
            self.program = subprocess.Popen([*self.within, os.path.join(BUILD, "bin", "slipd-mqtt"), "--config", self.settings], stderr=log)
        threading.Thread(target=self._watch, args=(self.program,), daemon=True).start()

    def _watch(self, program):
        if program.wait() != 0 and not self.ends:
            self.start()

    def log(self):
        with open(self.log_file) as log:
            return log.read()

    def stop(self):
        self.program.terminate()
        return self.program.wait(PATIENCE_S)

    def kill(self):
        self.ends = True
        self.program.kill()
        self.program.wait()


class BridgeTest(unittest.TestCase):
    """Tests with a folder of their own and stand-ins for slipd, which all end with the test."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.server = Server()
        self.addCleanup(self.server.close)

    def fake_slipd(self, name="s", sensors=("left", "right"), grasps=()):
        return FakeSlipd(os.path.join(self.folder, name + ".sock"), list(sensors), self.server, grasps)

    def bridge_of(self, slipd, brokers, **more):
        """slipd-mqtt, once it has subscribed. Brokers: settings, or what has a `port`."""
        bridge = Bridge(self.folder, slipd.path, [b if isinstance(b, dict) else {"host": "127.0.0.1", "port": b.port, "keepalive_s": 5} for b in brokers],
                        **more)
        self.addCleanup(bridge.kill)
        await_true(slipd.subscribers, "the subscription at slipd")
        return bridge
