"""slipd-mqtt behind a network that is cut: a network namespace and a pair of interfaces, one of which goes down. Skips if none can be made."""
import os, subprocess, threading, unittest

from awaiting import await_true
from peer_test import PeerTest
from support import Bridge

HERE, THERE = "198.51.100.1", "198.51.100.2"  # for documentation: nobody's


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=False)


class Cut(PeerTest):
    def setUp(self):
        super().setUp()
        self.link, self.space = f"slipd{os.getpid() % 100000}", f"slipd-mqtt-{os.getpid()}"
        if run("ip", "netns", "add", self.space).returncode != 0:
            self.skipTest("no network namespace can be made: root can, with ip of iproute2")
        self.addCleanup(run, "ip", "netns", "del", self.space)
        for line in (f"link add {self.link} type veth peer name eth0 netns {self.space}", f"addr add {HERE}/30 dev {self.link}", f"link set {self.link} up",
                     f"-n {self.space} addr add {THERE}/30 dev eth0", f"-n {self.space} link set eth0 up", f"-n {self.space} link set lo up"):
            self.assertEqual(run("ip", *line.split()).returncode, 0, line)
        self.addCleanup(run, "ip", "link", "del", self.link)

    def bridge_there(self, broker):
        """slipd-mqtt in the namespace, whose keepalive would notice the cut much later."""
        inside = f"nsenter --net=/run/netns/{self.space}".split()
        bridge = Bridge(self.folder, self.slipd.path, [{"host": HERE, "port": broker.port, "keepalive_s": 600}], within=inside)
        self.addCleanup(bridge.kill)
        await_true(lambda: "accepted" in bridge.log(), "the connection; " + bridge.log())
        return bridge

    def test_no_estimate_of_before_the_loss_arrives_after_a_cut(self):
        broker = self.broker(address="0.0.0.0")
        reader = self.subscriber(broker.port)  # by loopback
        bridge = self.bridge_there(broker)
        ends = threading.Event()
        def play():
            while not ends.wait(0.02):
                self.slipd.estimate("left")
        player = threading.Thread(target=play)
        self.addCleanup(player.join)
        self.addCleanup(ends.set)
        player.start()
        estimates = lambda: [payload for topic, payload in list(reader.messages) if topic.endswith("/estimate")]
        await_true(lambda: len(estimates()) > 10, "estimates")
        self.assertEqual(run("ip", "link", "set", self.link, "down").returncode, 0)
        cut_at = self.slipd.sequence
        await_true(lambda: "timed out" in bridge.log(), "that slipd-mqtt notices the cut; " + bridge.log())
        lost_at, seen = self.slipd.sequence, len(estimates())
        self.assertGreater(lost_at, cut_at)
        # By then the kernel has thrown away what waited for the address of the other side, too.
        await_true(lambda: bridge.log().count("<4>") > 1, "that slipd-mqtt cannot connect; " + bridge.log())
        self.assertEqual(run("ip", "link", "set", self.link, "up").returncode, 0)
        await_true(lambda: len(estimates()) > seen + 10, "estimates again; " + bridge.log())
        self.assertGreaterEqual(min(estimate["seq"] for estimate in estimates()[seen:]), lost_at)


if __name__ == "__main__":
    unittest.main(warnings="ignore")
