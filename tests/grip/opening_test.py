"""slipd-grip tells slipd that it lets go: a gel that relaxes looks like a slip. The real programs; the gel is a program."""
import sys
import unittest

import slipd
from awaiting import await_true
from grip_bed import Programs

RATE_HZ = 50
RESTING = f"""
import random, sys, time, slipd
random.seed(1)
source = slipd.Source("gel", taxels=63, rate_hz={RATE_HZ}, unit="mm", zeroed=True, path=sys.argv[1])
while True:
    try:
        source.push([[random.gauss(0, 0.0025), random.gauss(0, 0.0025), 0.0] for _ in range(63)])
    except (slipd.Disconnected, slipd.SlipdError, TimeoutError):
        pass
    time.sleep(1 / {RATE_HZ})
"""


class Opening(unittest.TestCase):
    def setUp(self):
        gel = {"name": "gel", "driver": "push", "rate_hz": RATE_HZ, "layout": {"grid": [9, 7], "pitch_mm": 1.8}}
        self.bed = Programs({"sensors": [gel]}, {"fingers": ["gel"], "dry_run": True, "force": {"firm_n": 12, "most_n": 15}})
        self.addCleanup(self.bed.close)
        self.bed.commands["gel"] = [sys.executable, "-c", RESTING, self.bed.at("slipd.sock")]
        self.bed.start("grip")
        await_true(self.bed.status, "slipd-grip")

    def alert(self):
        try:
            with slipd.Client(self.bed.at("slipd.sock")) as client:
                return client.call("gamma")["sensors"][0]["alert"]
        except slipd.Disconnected:
            return None

    def test_is_told_to_slipd_and_so_is_its_end(self):
        self.bed.start("slipd")
        self.bed.start("gel")
        await_true(lambda: self.alert() == "none", "a gel that is watched")
        self.bed.order("open")
        self.assertIn('"gel" is let go', self.bed.journal())
        await_true(lambda: self.alert() == "unknown", "no word about slipping while it is let go")
        self.bed.order("close")
        await_true(lambda: self.alert() == "none", "a gel that is watched again")

    def test_needs_no_slipd(self):
        self.bed.order("open")
        await_true(lambda: self.bed.status()["state"] == "open", "an open gripper")
        self.assertIn("slipd does not hear", self.bed.journal())


if __name__ == "__main__":
    unittest.main(verbosity=2)
