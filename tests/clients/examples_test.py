"""The programs in examples/, each in a loop with a simulated gripper that overshoots and relaxes.

The one on CAN needs the bus that SLIPD_TEST_CAN names, vcan0 unless it is set; tests/vm/guest/can_gripper.sh runs it where there is one."""
import json, os, signal, socket, subprocess, sys, tempfile, threading, time, unittest

from python_test import PATIENCE_S, Daemon

sys.path.insert(0, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "tests", "support"))
from awaiting import await_true

BUILD, SOURCE = os.environ["SLIPD_BINARY_DIR"], os.environ["SLIPD_SOURCE_DIR"]
BUS = os.environ.get("SLIPD_TEST_CAN", "vcan0")
CAN_PERIOD_MS = 50  # one that slipd can keep on an emulated processor
PROGRAMS = {"c": [os.path.join(BUILD, "examples", "example-gripper-c")],
            "cpp": [os.path.join(BUILD, "examples", "example-gripper-cpp")],
            "python": [sys.executable, os.path.join(SOURCE, "examples", "gripper.py")]}


class Pulled(Daemon):
    """slipd with one finger of pillars whose object is pulled at until it slides, unless it is gripped harder than firmly."""

    def __init__(self, rate_hz=200, **more):
        self.folder = tempfile.TemporaryDirectory()
        self.socket = os.path.join(self.folder.name, "socket")
        self.settings = os.path.join(self.folder.name, "slipd.json")
        self.skin = os.path.join(self.folder.name, "skin")
        cycle = [{"ms": 300, "normal_n": 0, "shear_n": 0, "friction": 0.6}, {"ms": 90, "normal_n": [0, 2]}, {"ms": 600},
                 {"ms": 3000, "shear_n": [0, 4]}, {"ms": 600000}]
        finger = {"name": "left", "driver": "sim", "rate_hz": rate_hz, "layout": {"grid": [3, 3], "pitch_mm": 7},
                  "skin": {"radius_mm": "flat", "modulus_mpa": 1, "poisson": 0.49},
                  "options": {"preset": "pillars", "noise": 0, "cycle": cycle, "grip_input": self.skin}}
        scene = {"normal_n": [0.5, 10], "friction": [0.3, 1], "flat_share": 0.5, "radius_mm": [10, 50], "modulus_mpa": [1, 200000]}
        with open(self.settings, "w") as file:
            json.dump({"socket": {"path": self.socket}, "realtime": {"mode": "off"}, "sensors": [finger], "objects": [scene], **more}, file)
        self.start()


class Gripper:
    """Fingers that follow the set-point that they receive, at most 0.05 N in 5 ms, and press on the simulated skin."""

    STEP_N, TICK_S = 0.05, 0.005

    def __init__(self, daemon):
        self.path, self.skin = os.path.join(daemon.folder.name, "grip"), daemon.skin
        self.set_point, self.force_n, self.over = 0.0, 0.0, False
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(self.path)
        self.socket.settimeout(self.TICK_S)
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        due = time.monotonic()
        while not self.over:
            try:
                self.set_point = float(self.socket.recv(64))
            except TimeoutError:
                pass
            if time.monotonic() < due:
                continue
            due = time.monotonic() + self.TICK_S
            self.force_n += max(-self.STEP_N, min(self.STEP_N, self.set_point - self.force_n))
            try:
                self.socket.sendto(f"{self.force_n:.3f}".encode(), self.skin)
            except OSError:
                pass  # slipd is away

    def close(self):
        self.over = True
        self.thread.join()
        self.socket.close()


class Example:
    """A running example, and the lines that it has printed."""

    def __init__(self, command):
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.lines, self.more = [], threading.Condition()
        self.reader = threading.Thread(target=self.read)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            with self.more:
                self.lines.append(line)
                self.more.notify()

    def await_line(self, condition, begin=0):
        """The first line from `begin` on of which (state, alert, force) meet the condition; its number."""
        def found():
            for number in range(begin, len(self.lines)):
                words = self.lines[number].split()
                if condition(words[0], words[1], float(words[5])):
                    return number + 1
            return 0

        with self.more:
            if not self.more.wait_for(found, PATIENCE_S):
                raise AssertionError("it did not come: " + "".join(self.lines[-5:]))
            return found() - 1

    def close(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(PATIENCE_S)
        self.reader.join()
        self.process.stdout.close()


class Examples(unittest.TestCase):
    def each(self, language):
        daemon = Pulled()
        self.addCleanup(daemon.close)
        gripper = Gripper(daemon)
        self.addCleanup(gripper.close)
        self.holds(daemon, gripper, [*PROGRAMS[language], "left", daemon.socket, gripper.path])

    def holds(self, daemon, gripper, command, gone_state="disconnected"):
        """What each loop must do with an object that is pulled at, and with a slipd that is killed and comes back."""
        example = Example(command)
        self.addCleanup(example.close)
        # It is pulled at: it grips harder than firmly.
        pulled = example.await_line(lambda state, alert, force: alert in ("warn", "slip") and force > 6)
        await_true(lambda: gripper.force_n > 6, "the gripper to obey")
        # Without slipd it holds firmly.
        daemon.end(signal.SIGKILL)
        gone = example.await_line(lambda state, alert, force: state in ("disconnected", "stale") and force >= 6, pulled)
        self.assertIn("margin nan", example.lines[gone])
        example.await_line(lambda state, alert, force: state == gone_state, pulled)
        # It goes on with the next one, and does not let go.
        daemon.start()
        back = example.await_line(lambda state, alert, force: state not in ("disconnected", "stale"), gone)
        self.assertGreaterEqual(float(example.lines[back].split()[5]), 6)
        for line in example.lines:
            state, alert, force = line.split()[0], line.split()[1], float(line.split()[5])
            self.assertTrue(state == "ok" or "margin nan" in line, line)
            self.assertTrue(force >= 6 or state == "ok" and alert != "unknown", line)
            self.assertFalse(alert == "none" and state in ("stale", "disconnected"), line)

    @unittest.skipUnless(os.path.exists(f"/sys/class/net/{BUS}"),
                         f"there is no {BUS}: modprobe vcan; ip link add {BUS} type vcan; ip link set {BUS} up")
    def test_c_on_can(self):
        daemon = Pulled(rate_hz=50, can={"interface": BUS, "allow_simulated": True, "period_ms": CAN_PERIOD_MS})
        self.addCleanup(daemon.close)
        gripper = Gripper(daemon)
        self.addCleanup(gripper.close)
        self.holds(daemon, gripper, [os.path.join(BUILD, "examples", "example-gripper-can"), BUS, "5A0", "0", str(CAN_PERIOD_MS),
                                     gripper.path], gone_state="stale")

    def test_c_on_shared_memory(self):
        self.each("c")

    def test_cpp_on_the_socket(self):
        self.each("cpp")

    def test_python_on_the_socket(self):
        self.each("python")


if __name__ == "__main__":
    unittest.main()
