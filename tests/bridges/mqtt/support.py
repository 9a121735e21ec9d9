"""slipd-mqtt under test: a program on a FakeSlipd."""
import json, os, subprocess

from awaiting import PATIENCE_S

BUILD = os.environ["SLIPD_BINARY_DIR"]


class Bridge:
    """slipd-mqtt with these brokers."""

    def __init__(self, folder, socket, brokers, host="gripper", **more):
        self.log_file = os.path.join(folder, host + ".log")
        self.settings = os.path.join(folder, host + ".json")
        with open(self.settings, "w") as file:
            json.dump({"brokers": brokers, "host": host, "socket": socket, "store": {"file": os.path.join(folder, host + ".db")} | more.pop("store", {})}
                      | more, file)
        self.start()

    def start(self):
        with open(self.log_file, "a") as log:
            self.program = subprocess.Popen([os.path.join(BUILD, "bin", "slipd-mqtt"), "--config", self.settings], stderr=log)

    def log(self):
        with open(self.log_file) as log:
            return log.read()

    def stop(self):
        self.program.terminate()
        return self.program.wait(PATIENCE_S)

    def kill(self):
        self.program.kill()
        self.program.wait()
