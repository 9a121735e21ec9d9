#!/usr/bin/env python3
"""The watchdog of slipd-web: fed while both of its threads run, and not longer."""
import os
import signal
import socket
import tempfile
import unittest
from pathlib import Path

from awaiting import PATIENCE_S, await_true
from bed import Bed
from stopping import StoppedThread

PERIOD_S = 1  # of WATCHDOG_USEC: it is fed at least each 0.75 s
SILENCE_S = 4 * PERIOD_S  # without being fed it is not fed any more


class Watchdog(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.notify.close)
        self.notify.bind(f"{folder.name}/notify")
        self.bed = Bed(slipd=False, environment={"NOTIFY_SOCKET": f"{folder.name}/notify", "WATCHDOG_USEC": str(1_000_000 * PERIOD_S)})
        self.addCleanup(self.bed.close)
        self.fed()

    def fed(self, within_s=PATIENCE_S):
        """Whether it is fed within this time."""
        self.notify.settimeout(within_s)
        try:
            while b"WATCHDOG=1" not in self.notify.recv(4096):
                pass
            return True
        except TimeoutError:
            return False

    def starves(self):
        return not self.fed(SILENCE_S)

    def test_it_is_fed_while_nothing_happens(self):
        for _ in range(3):
            self.assertTrue(self.fed())

    def test_the_thread_that_serves_browsers_must_run(self):
        with StoppedThread(self.bed.web.process.pid, "serve"):
            await_true(self.starves, "the end of feeding")
        self.assertTrue(self.fed())
        self.assertEqual(self.bed.get("/")[0], 200)

    def test_the_thread_that_asks_slipd_must_run(self):
        with StoppedThread(self.bed.web.process.pid, "slipd-web"):
            await_true(self.starves, "the end of feeding")
        self.assertTrue(self.fed())

    def test_it_is_fed_after_the_settings_were_read_again(self):
        self.bed.web.signal(signal.SIGHUP)
        await_true(lambda: "again" in self.bed.web.said(), "the settings")
        for _ in range(3):
            self.assertTrue(self.fed())

    def test_the_unit_asks_for_it(self):
        unit = Path(os.environ["SLIPD_SOURCE_DIR"]) / "bridges/web/slipd-web.service.in"
        self.assertRegex(unit.read_text(), r"(?m)^Type=notify$[^\0]*^WatchdogSec=\d+$")


if __name__ == "__main__":
    unittest.main()
