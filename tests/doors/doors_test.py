"""doors_test.py [--peers]: no consumer of slipd goes on believing in a margin, or in "no alert", once something between it and the object has died. How long each
took is printed, and judged by docs/doors.md only: a loaded machine is late. --peers: the doors that need programs of others; else the others."""
import sys
import tempfile
import unittest

from doors import PEERLESS_DOORS, PEERS_DOORS, available, failures_possible, in_a_network_of_its_own, run

NETWORKED = in_a_network_of_its_own()
DOORS = available(PEERS_DOORS if "--peers" in sys.argv else PEERLESS_DOORS)


class Doors(unittest.TestCase):
    def test_no_consumer_goes_on_believing(self):
        for failure in failures_possible(NETWORKED):
            with self.subTest(failure=failure.name), tempfile.TemporaryDirectory(prefix="slipd-doors-") as folder:
                cells = run(failure, DOORS, folder)
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
