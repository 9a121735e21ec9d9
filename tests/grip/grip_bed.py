"""The real programs around slipd-grip, their settings in a folder of their own and all that they say in one journal."""
import json
import os
import subprocess
import tempfile

BIN = os.path.join(os.environ["SLIPD_BINARY_DIR"], "bin")
DRIVERS = os.path.join(os.environ["SLIPD_BINARY_DIR"], "drivers")


class Programs:
    def __init__(self, slipd, grip):
        """Settings of slipd and of slipd-grip, without the paths of sockets. The gripper listens on gripper.sock, if there is one."""
        self.folder = tempfile.TemporaryDirectory(prefix="slipd-grip-")
        self._write("slipd.json", {**slipd, "realtime": {"mode": "off", "lock_memory": False}, "socket": {"path": self.at("slipd.sock")}})
        self._write("grip.json", {**grip, "socket": self.at("slipd.sock"), "orders": self.at("orders.sock"),
                                  "gripper": {"type": "line", "socket": self.at("gripper.sock")}})
        self.log = open(self.at("log"), "a+", encoding="utf-8")
        self.commands = {"slipd": [BIN + "/slipd", "--config", self.at("slipd.json"), "--driver-dir", DRIVERS],
                         "grip": [BIN + "/slipd-grip", "--config", self.at("grip.json")]}
        self.programs = {}

    def at(self, name):
        return os.path.join(self.folder.name, name)

    def _write(self, name, what):
        with open(self.at(name), "w", encoding="utf-8") as file:
            json.dump(what, file)

    def start(self, name):
        self.programs[name] = subprocess.Popen(self.commands[name], stderr=self.log, stdout=subprocess.DEVNULL)

    def kill(self, name):
        self.programs[name].kill()
        self.programs[name].wait()

    def order(self, word):
        ran = subprocess.run([BIN + "/slipd-grip", word, "--orders", self.at("orders.sock")], capture_output=True, text=True, check=False)
        return json.loads(ran.stdout) if ran.returncode == 0 else None

    def status(self):
        return self.order("status") or None

    def journal(self):
        with open(self.at("log"), encoding="utf-8") as file:
            return file.read()

    def close(self):
        for program in self.programs.values():
            program.kill()
            program.wait()
        self.log.close()
        self.folder.cleanup()
