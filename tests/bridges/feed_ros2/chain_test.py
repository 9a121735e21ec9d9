"""slipd-feed-ros2 reads what slipd-ros2 publishes: the taxels of one slipd are a sensor of another, with the same margin."""
import json, os, subprocess, sys, unittest

import slipd
from awaiting import PATIENCE_S, await_true

sys.path.insert(0, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "tests", "clients"))
from push_test import NOTHING, RATE_HZ, SIDE, Scene, contact  # contacts of Cattaneo and Mindlin, in Pa

BUILD = os.environ["SLIPD_BINARY_DIR"]
OLD_S = 3600
SAME = 0.02  # pressures are the same float32; the zeros that both measure differ by rounding


class Chain(unittest.TestCase):
    def start(self, daemon, program, settings):
        path = os.path.join(daemon.folder.name, program + ".json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"socket": daemon.socket, "domain": 1 + os.getpid() % 100, **settings}, file)
        process = subprocess.Popen([os.path.join(BUILD, "bin", program), "--config", path], stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)

    def scene(self):
        daemon = Scene()
        self.addCleanup(daemon.close)
        client = slipd.Client(daemon.socket, timeout_s=PATIENCE_S)
        self.addCleanup(client.close)
        await_true(lambda: os.path.exists(os.path.join(daemon.folder.name, "push", "left")), "the sensor's socket")
        return daemon, client

    def test_taxels_of_one_slipd_have_the_same_margin_in_another(self):
        (near, near_client), (far, far_client) = self.scene(), self.scene()
        self.start(near, "slipd-ros2", {"topics": {"taxels": {"rate_hz": RATE_HZ}}})
        self.start(far, "slipd-feed-ros2", {"feeds": [{"sensor": "left", "profile": "cloud-slipd", "topic": "/slipd/left/taxels", "taxels": SIDE ** 2}]})
        with slipd.Source("left", taxels=SIDE ** 2, unit="Pa", path=near.socket, timeout_s=PATIENCE_S) as source:
            def pushed(frame, condition):
                source.push(frame)
                near_now, far_now = near_client.gamma("left", max_age_s=OLD_S), far_client.gamma("left", max_age_s=OLD_S)
                return condition(near_now, far_now) and (near_now, far_now)
            await_true(lambda: pushed(NOTHING, lambda one, other: one.state == other.state == "no_contact"), "both zeros")
            for pull in (0.3, 0.6):
                await_true(lambda pull=pull: pushed(contact(1, pull), lambda one, other: None not in (one.gamma, other.gamma)
                                                    and abs(one.gamma - (1 - pull)) < 0.1 and abs(one.gamma - other.gamma) < SAME), f"the margin {1 - pull} in both")


if __name__ == "__main__":
    unittest.main(verbosity=2)
