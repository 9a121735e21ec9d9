"""slipd, the program that pushes frames, the gripper and slipd-grip itself are killed in mid-grasp, and come back: the gripper is never
told to open, no force is above the limit, none falls in the dark, and the journal tells.  killed_test.py [TIMES]"""
import json
import os
import re
import socket
import subprocess
import sys
import threading
import unittest

from awaiting import await_true
from grip_bed import BIN, Programs

SIDE, RATE_HZ = 5, 100
FIRM_N, MOST_N = 12, 15
TIMES = int(sys.argv.pop()) if len(sys.argv) > 1 and sys.argv[-1].isdigit() else 1

# A finger that holds something, as frames of a program: a round contact that is pulled a little.
PUSHER = f"""
import random, sys, time, slipd
random.seed(1)
def frame():
    values = []
    for row in range({SIDE}):
        for column in range({SIDE}):
            r2 = (row - 2) ** 2 + (column - 2) ** 2
            p = max(0.0, 1 - r2 / 6) ** 0.5 * 0.4
            values += [random.gauss(0, 0.001), -0.1 * p + random.gauss(0, 0.001), p + random.gauss(0, 0.001)]
    return values
sources = [slipd.Source(name, taxels={SIDE * SIDE}, rate_hz={RATE_HZ}, unit="N", zeroed=True, path=sys.argv[1]) for name in ("left", "right")]
while True:
    for source in sources:
        try:
            source.push(frame())
        except (slipd.Disconnected, slipd.SlipdError, TimeoutError):
            pass
    time.sleep(1 / {RATE_HZ})
"""


class Gripper:
    """A gripper that listens on a socket and keeps all that it is told."""

    def __init__(self, path):
        self.path, self.orders, self.alive = path, [], True
        self._start()

    def _start(self):
        if os.path.exists(self.path):
            os.unlink(self.path)
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(self.path)
        self.listener.listen()
        self.peers = []
        threading.Thread(target=self._accept, args=(self.listener,), daemon=True).start()

    def _accept(self, listener):
        while True:
            try:
                peer, _ = listener.accept()
            except OSError:
                return
            self.peers.append(peer)
            threading.Thread(target=self._serve, args=(peer,), daemon=True).start()

    def _serve(self, peer):
        try:
            with peer, peer.makefile("rw") as lines:
                for line in lines:
                    self.orders.append(json.loads(line))
                    lines.write("{}\n")
                    lines.flush()
        except OSError:
            pass

    def kill(self):
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        os.unlink(self.path)
        for peer in self.peers:
            try:
                peer.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def restart(self):
        self._start()


class Bed(Programs):
    def __init__(self):
        sensor = {"driver": "push", "rate_hz": RATE_HZ, "layout": {"grid": [SIDE, SIDE], "pitch_mm": 2},
                  "skin": {"radius_mm": 20}, "options": {"unit": "N", "zeroed": True}}
        grip = {"fingers": ["left", "right"], "grasp": "gripper", "max_age_ms": 100, "firm_by": "firm_n",
                "force": {"firm_n": FIRM_N, "most_n": MOST_N, "close_n": 2}}
        super().__init__({"sensors": [{"name": "left", **sensor}, {"name": "right", **sensor}],
                          "grasps": [{"name": "gripper", "sensors": ["left", "right"]}]}, grip)
        self.commands["pusher"] = [sys.executable, "-c", PUSHER, self.at("slipd.sock")]
        self.gripper = Gripper(self.at("gripper.sock"))
        # It grips in the dark, and the frames come then: slipd would else tell of their slip first, now and then.
        for name in ("slipd", "grip"):
            self.start(name)
        await_true(lambda: self.status() is not None, "slipd-grip")
        self.order("close")
        await_true(lambda: self.status()["state"] == "firm", "a grip")
        self.start("pusher")
        await_true(self.has_frames, "frames")

    def has_frames(self):
        return (self.status() or {}).get("slipd") in ("ok", "learning", "out_of_model")

    def close(self):
        self.gripper.kill()
        super().close()


class Killed(unittest.TestCase):
    def setUp(self):
        self.bed = Bed()
        self.addCleanup(self.bed.close)

    def awaits_firm(self, slipd_says):
        def is_firm():
            now = self.bed.status()
            return now and now["slipd"] in slipd_says and now["force_n"] >= FIRM_N
        await_true(is_firm, f"a firm grip while slipd is {slipd_says}")

    def awaits_frames(self):
        await_true(self.bed.has_frames, "frames")

    def judge(self):
        orders = self.bed.gripper.orders
        self.assertFalse([one for one in orders if one["order"] == "open"])
        self.assertLessEqual(max(one.get("force_n", 0) for one in orders), MOST_N)

    def test_slipd(self):
        for _ in range(TIMES):
            self.bed.kill("slipd")
            self.awaits_firm({"disconnected", "stale"})
            self.bed.start("slipd")
            self.awaits_frames()
        self.judge()
        self.assertIn("margin unknown", self.bed.journal())

    def test_sensor(self):
        for _ in range(TIMES):
            self.bed.kill("pusher")
            self.awaits_firm({"stale", "fault"})
            self.bed.start("pusher")
            self.awaits_frames()
        self.judge()
        self.assertIn("margin unknown", self.bed.journal())

    def test_gripper(self):
        for _ in range(TIMES):
            self.bed.gripper.kill()
            await_true(lambda: (self.bed.status() or {}).get("state") == "cut off", "slipd-grip to see it")
            heard = len(self.bed.gripper.orders)
            self.bed.gripper.restart()
            await_true(lambda: len(self.bed.gripper.orders) > heard, "orders again")
            first = self.bed.gripper.orders[heard]
            self.assertEqual(first["order"], "grip")
            self.assertGreaterEqual(first["force_n"], FIRM_N)
        self.judge()
        self.assertIn("gripper gone", self.bed.journal())

    def test_slipd_grip(self):
        for _ in range(TIMES):
            self.bed.kill("grip")
            heard = len(self.bed.gripper.orders)
            self.bed.start("grip")
            await_true(lambda at=heard: [one for one in self.bed.gripper.orders[at:] if one["order"] == "grip"], "a grip again")
            first = next(one for one in self.bed.gripper.orders[heard:] if one["order"] == "grip")
            self.assertGreaterEqual(first["force_n"], FIRM_N, "what it held before is not known: nothing less is safe")
        self.judge()

    def watched(self):
        """What is written on the last screen of slipctl watch, without spaces."""
        picture = self.bed.at("watch.svg")
        subprocess.run([BIN + "/slipctl", "--socket", self.bed.at("slipd.sock"), "watch", "--seconds", "0.1", "--picture", picture,
                        "--grip", self.bed.at("orders.sock")], check=True, stdout=subprocess.DEVNULL)
        with open(picture, encoding="utf-8") as file:
            return "".join(re.findall(">(.)</text>", file.read()))

    def test_slipctl_watch_shows_what_it_does(self):
        await_true(lambda: os.path.exists(self.bed.at("slipd.sock")), "slipd")
        await_true(lambda: "Nafinger" in self.watched(), "slipd-grip in the last row")
        self.bed.gripper.kill()
        await_true(lambda: (self.bed.status() or {}).get("state") == "cut off", "slipd-grip to see it")
        await_true(lambda: "cutoff" in self.watched(), "that it is cut off in the last row")
        self.bed.gripper.restart()
        self.bed.kill("grip")
        self.assertNotIn("Nafinger", self.watched())

    def test_opens_on_the_order_to(self):
        self.bed.order("open")
        await_true(lambda: self.bed.gripper.orders[-1]["order"] == "open", "the order to open")


if __name__ == "__main__":
    unittest.main(verbosity=2)
