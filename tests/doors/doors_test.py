"""doors_test.py [--peers | --can INTERFACE]: no consumer of slipd goes on believing in a margin, or in "no alert", once something between it and the object has died. How long each
took is printed, and judged by docs/doors.md only: a loaded machine is late. --peers: the doors that need programs of others;
--can: the bus, and shared memory and socket, also while the clock is set: in a guest; else those that need nothing more."""
import sys
import tempfile
import unittest

from doors import CAN_DOORS, PEERLESS_DOORS, PEERS_DOORS, available, failures_possible, in_a_network_of_its_own, run

CAN = sys.argv[2] if sys.argv[1:2] == ["--can"] else None
NETWORKED = CAN is not None or in_a_network_of_its_own()
DOORS = available(PEERS_DOORS if "--peers" in sys.argv else PEERLESS_DOORS)
if CAN:
    DOORS = CAN_DOORS + [door for door in DOORS if not door.networked]


class Doors(unittest.TestCase):
    def test_no_consumer_goes_on_believing(self):
        for failure in failures_possible(NETWORKED, clock=CAN is not None):
            if not any(door.concerned_by(failure) for door in DOORS):
                continue
            with self.subTest(failure=failure.name), tempfile.TemporaryDirectory(prefix="slipd-doors-") as folder:
                cells = run(failure, DOORS, folder, CAN)
                self.assertGreater(len(cells), 1)
                for cell in cells:
                    print(f"{failure.name:26} {cell.door:24} {cell.sensor:6} {1e3 * cell.late_s:5.0f} ms  {cell.then['state']}, "
                          f"alert {cell.then['alert']}", flush=True)
                    self.assertNotEqual(cell.then["alert"], "none")
                    self.assertIn(cell.then["alert"], ("unknown",) if cell.sensor == "left" else ("slip", "unknown"))


if __name__ == "__main__":
    if not DOORS:
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
