"""slipd-modbus with the real slipd, and PLCs that have no code of slipd: mbpoll (C, libmodbus) and pymodbus (Python). Skips what is
not installed."""
import csv, json, os, re, shutil, signal, subprocess, sys, tempfile, time, unittest

from awaiting import PATIENCE_S, await_true
from ports import free_port

try:
    from pymodbus.client import ModbusTcpClient
except ImportError:
    ModbusTcpClient = None
MBPOLL = shutil.which("mbpoll")
if ModbusTcpClient is None and MBPOLL is None:
    print("skipped: neither mbpoll nor python3-pymodbus is installed: run tools/setup --peers")
    sys.exit(77)

BUILD, SOURCE = os.environ["SLIPD_BINARY_DIR"], os.environ["SLIPD_SOURCE_DIR"]
with open(os.path.join(SOURCE, "bridges", "modbus", "registers.csv")) as file:
    ADDRESS = {row["name"]: int(row["address"]) for row in csv.DictReader(file)}
BLOCK, SIZE = 16, 32
UNKNOWN = 0xFFFF


class Peer(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.port = free_port()
        socket_path = os.path.join(self.folder, "s.sock")
        finger = {"driver": "sim", "rate_hz": 100, "stale_after_ms": 1000, "layout": {"grid": [8, 8], "pitch_mm": 1.5}, "skin": {"radius_mm": 10}}
        self.slipd_file = self.write("slipd.json", {
            "sensors": [finger | {"name": "left"}, finger | {"name": "right"}], "grasps": [{"name": "gripper", "sensors": ["left", "right"]}],
            "socket": {"path": socket_path}, "estimator": {"method": "moments"}, "realtime": {"mode": "off"}})
        self.slipd = self.start("slipd", self.slipd_file)
        self.start("slipd-modbus", self.write("modbus.json", {"port": self.port, "socket": socket_path, "max_age_ms": 10000,
                                                              "blocks": ["gripper", "left", "absent"]}))

    def write(self, name, settings):
        path = os.path.join(self.folder, name)
        with open(path, "w") as file:
            json.dump(settings, file)
        return path

    def start(self, program, settings):
        started = subprocess.Popen([os.path.join(BUILD, "bin", program), "--config", settings], stderr=subprocess.DEVNULL)
        self.addCleanup(lambda: (started.kill(), started.wait()))
        return started

    @unittest.skipUnless(MBPOLL, "mbpoll is not installed")
    def test_mbpoll(self):
        def poll(first, count):
            ran = subprocess.run([MBPOLL, "-m", "tcp", "-p", str(self.port), "-t", "3", "-0", "-r", str(first), "-c", str(count), "-1", "127.0.0.1"],
                                 capture_output=True, text=True, timeout=PATIENCE_S)
            return {int(at): int(value) & 0xFFFF for at, value in re.findall(r"\[(\d+)\]:\s+(-?\d+)", ran.stdout)}
        left = BLOCK + SIZE
        seen = await_true(lambda: (lambda r: r if r.get(left, 8) not in (6, 8) else None)(poll(0, 96)), "an estimate of left")
        self.assertEqual((seen[0], seen[2], seen[3]), (1, 1, 3))
        self.assertEqual(seen[BLOCK + 2 * SIZE], 8)
        self.assertEqual(seen[left] == 0, seen[left + 2] != UNKNOWN)
        # A slipd that hangs: its last sign of life is too old, and poll answers all the same.
        self.slipd.send_signal(signal.SIGSTOP)
        seen = await_true(lambda: (lambda r: r if r.get(ADDRESS["alive"]) == 2 else None)(poll(0, 96)), "the silence of slipd")
        self.assertEqual((seen[BLOCK], seen[left], seen[left + 2]), (8, 8, UNKNOWN))
        self.assertNotEqual(seen[left + ADDRESS["alert"] - BLOCK], 0)
        self.slipd.send_signal(signal.SIGCONT)
        await_true(lambda: poll(0, 96).get(left, 8) not in (6, 8), "slipd again")

    @unittest.skipUnless(ModbusTcpClient, "python3-pymodbus is not installed")
    def test_pymodbus_and_the_end_of_slipd(self):
        client = ModbusTcpClient("127.0.0.1", port=self.port)
        await_true(client.connect, "slipd-modbus")
        self.addCleanup(client.close)
        def read(first, count):
            return client.read_input_registers(first, count, 1).registers
        await_true(lambda: read(ADDRESS["alive"], 1) == [1], "slipd")
        beat = read(ADDRESS["heartbeat"], 1)
        await_true(lambda: read(ADDRESS["heartbeat"], 1) != beat, "the next heartbeat")
        left = BLOCK + SIZE
        number = lambda: (lambda r: r[0] << 16 | r[1])(read(left + ADDRESS["frame_number"] - BLOCK, 2))
        await_true(lambda: number() < 0x80000000, "frames")
        first = number()
        await_true(lambda: first < number() < 0x80000000, "a later frame")
        # A margin is there in state ok and only there, and a cause with an alert and only then, in one answer.
        alert, cause = (ADDRESS[name] - BLOCK for name in ("alert", "alert_cause"))
        oks, causes = 0, set()
        until = time.monotonic() + PATIENCE_S
        while (oks < 20 or not causes & {1, 2}) and time.monotonic() < until:
            block = read(left, SIZE)
            self.assertEqual(block[0] == 0, block[2] != UNKNOWN, block)
            self.assertIn(block[cause], {0: {0}, UNKNOWN: {UNKNOWN}}.get(block[alert], {1, 2}), block)
            oks += block[0] == 0
            causes.add(block[cause])
        self.assertTrue(causes & {1, 2}, causes)
        self.assertTrue(client.write_register(0, 1, 1).isError())
        self.slipd.kill()
        self.slipd.wait()
        await_true(lambda: read(ADDRESS["alive"], 1) == [2], "the end")
        stopped = read(ADDRESS["heartbeat"], 1)
        block = read(left, SIZE)
        self.assertEqual((block[0], block[2]), (8, UNKNOWN))
        # An alert that was raised stands; that there is none is not known any more.
        self.assertIn(block[alert], (1, 2, UNKNOWN), block)
        self.assertEqual(block[cause] == UNKNOWN, block[alert] == UNKNOWN, block)
        time.sleep(0.3)  # three beats of a slipd that works
        self.assertEqual(read(ADDRESS["heartbeat"], 1), stopped)
        self.start("slipd", self.slipd_file)
        await_true(lambda: read(ADDRESS["alive"], 1) == [1], "slipd again")


if __name__ == "__main__":
    unittest.main(warnings="ignore")
