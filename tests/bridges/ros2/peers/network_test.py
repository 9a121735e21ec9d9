"""slipd-ros2 among others: readers with each network that ROS 2 gives a node, what ros_discovery_info says, a reader that stalls, restarts
in any order, a reload, every estimate at 1 kHz, and packets that Wireshark dissects."""
import json, os, re, signal, struct, subprocess, unittest

from awaiting import PATIENCE_S, await_true
from mcap_test import BRIDGE, BUILD, SOURCE, Programs

READER = os.path.join(BUILD, "test-bin", "fastdds-reader")
WATCHER = os.path.join(BUILD, "test-bin", "ros2-watcher")
FLOAT, INFO = "std_msgs::msg::dds_::Float32_", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_"
GID_BYTES, HUMBLE_GID_BYTES = 16, 24
# Megabytes that slipd-ros2 may grow by while a reader stalls: its writers keep ten messages of some hundred bytes.
GROWTH_MB = 8


def lines_of(out):
    return [line.split(" ") for line in out.splitlines()]


class Bed(Programs):
    def setUp(self):
        super().setUp()
        self.domain = 1 + os.getpid() % 100
        self.bridge = self.start_bridge()

    # What the bridge and its readers are run by: a command and its arguments before theirs.
    within = ()

    def start_bridge(self, **settings):
        self.write("ros2.json", {"socket": self.socket, "domain": self.domain, **settings})
        return self.start(*self.within, BRIDGE, "--config", self.path("ros2.json"))

    def read(self, network, messages, *topics):
        """Lines of the Fast DDS reader: topic, user data, GUID of the writer, bytes."""
        if not os.path.exists(READER):
            self.skipTest("Fast DDS is not installed: run tools/setup --peers")
        return lines_of(subprocess.run([*self.within, READER, network, str(self.domain), str(messages), *topics], stdout=subprocess.PIPE, text=True,
                                       timeout=PATIENCE_S, check=True).stdout)

    def watch(self, seconds, *leaves, participants=0):
        """What the watcher counted; it brings so many more participants into the domain."""
        return json.loads(subprocess.run([WATCHER, self.socket, "left", str(self.domain), str(seconds), "100", *leaves],
                                         stdout=subprocess.PIPE, timeout=PATIENCE_S, check=True,
                                         env={**os.environ, "PARTICIPANTS": str(participants)}).stdout)


class Network(Bed):
    def test_nodes_of_this_computer_read_it_with_each_network_that_ros_2_gives_them(self):
        for network in ("default", "localhost", "loopback"):
            with self.subTest(network):
                self.assertGreaterEqual(len(self.read(network, 3, "/slipd/left/margin", FLOAT)), 3)

    def test_it_is_read_in_a_domain_of_fifty_participants(self):
        counted = self.watch(2, "margin", "wrench", participants=50)
        self.assertEqual([counted[leaf]["lost"] for leaf in ("margin", "wrench")], [0, 0])
        self.assertGreater(counted["margin"]["samples"], 10)

    def test_a_node_of_cyclone_reads_it_with_its_default_network(self):
        os.environ["CYCLONEDDS_URI"] = ""
        self.addCleanup(os.environ.pop, "CYCLONEDDS_URI")
        self.assertGreater(self.watch(1, "margin")["margin"]["samples"], 10)

    def test_its_sockets_receive_from_this_computer_only(self):
        def receiving():
            out = subprocess.run(["ss", "-Huanp"], stdout=subprocess.PIPE, text=True, check=True).stdout
            own = [line.split()[3] for line in out.splitlines() if f"pid={self.bridge.pid}," in line]
            return [address for address in own if address.startswith(("0.0.0.0", "*", "["))]
        for address in await_true(receiving, "the sockets of slipd-ros2"):
            self.assertIn("%lo:", address)


class Addresses(Bed):
    """On a network of its own, which has loopback only at first."""

    def setUp(self):
        name = f"slipd-ros2-{os.getpid()}"
        if subprocess.run(["ip", "netns", "add", name], capture_output=True, check=False).returncode != 0:
            self.skipTest("no network namespace can be made: root can, with ip of iproute2")
        self.addCleanup(subprocess.run, ["ip", "netns", "del", name], check=True)  # after what runs in it has ended
        self.within = ("nsenter", f"--net=/run/netns/{name}")
        self.ip("link", "set", "lo", "up")
        super().setUp()

    def ip(self, *arguments):
        subprocess.run([*self.within, "ip", *arguments], check=True)

    def test_nodes_that_start_after_the_addresses_have_changed_read_it(self):
        self.assertGreaterEqual(len(self.read("default", 3, "/slipd/left/margin", FLOAT)), 3)
        self.ip("link", "add", "cable", "type", "veth", "peer", "name", "end")
        for interface in ("cable", "end"):
            self.ip("link", "set", interface, "up")
        self.ip("address", "add", "192.168.77.1/24", "dev", "cable")
        # Fast DDS says this address and no other, which Cyclone DDS answers only if it was there at its start.
        self.assertGreaterEqual(len(self.read("default", 3, "/slipd/left/margin", FLOAT)), 3)


class Discovery(Bed):
    def test_ros_discovery_info_names_the_node_and_its_writers(self):
        for distribution, size in (("jazzy", GID_BYTES), ("humble", HUMBLE_GID_BYTES)):
            with self.subTest(distribution):
                self.end(self.bridge, signal.SIGKILL)  # it may not have come so far as to end in order
                self.bridge = self.start_bridge(distribution=distribution, node="finger")
                (_, hash_data, writer, _), *_ = self.read("default", 1, "/slipd/left/margin", FLOAT)
                self.assertEqual(hash_data != "-", distribution == "jazzy", "only Iron and later have hashes")
                infos = [bytes.fromhex(line[3]) for line in self.read("default", 1, "ros_discovery_info", INFO)]
                gid, nodes = self.decode(infos[-1], size)
                self.assertEqual(gid[12:16], bytes.fromhex("000001c1"), "a participant")
                self.assertEqual([(space, name) for space, name, _, _ in nodes], [("/", "finger")])
                self.assertIn(bytes.fromhex(writer), [one[:GID_BYTES] for one in nodes[0][3]])

    @staticmethod
    def decode(data, size):
        """The participant's gid, and of each node namespace, name, gids of readers and of writers. From the .msg texts of rmw_dds_common."""
        at = 4  # encapsulation

        def take(count):
            nonlocal at
            at += count
            return data[at - count:at]

        def number():
            nonlocal at
            at += -(at - 4) % 4
            return struct.unpack("<I", take(4))[0]

        def text():
            return take(number())[:-1].decode()

        def gids():
            return [take(size) for _ in range(number())]

        gid = take(size)
        return gid, [(text(), text(), gids(), gids()) for _ in range(number())]


class Faults(Bed):
    def memory_mb(self):
        with open(f"/proc/{self.bridge.pid}/status", encoding="utf-8") as file:
            return int(re.search(r"VmRSS:\s+(\d+)", file.read())[1]) / 1024

    def test_a_reader_that_stalls_keeps_no_other_from_reading(self):
        if not os.path.exists(READER):
            self.skipTest("Fast DDS is not installed: run tools/setup --peers")
        with open(self.path("stalled"), "w", encoding="utf-8") as out:
            stalled = subprocess.Popen([READER, "default", str(self.domain), "0", "/slipd/left/margin", FLOAT], stdout=out)
        self.addCleanup(stalled.wait)
        self.addCleanup(stalled.kill)
        await_true(lambda: os.path.getsize(self.path("stalled")) > 0, "the first margin")
        self.watch(1, "margin", "wrench")
        before = self.memory_mb()
        stalled.send_signal(signal.SIGSTOP)
        counted = self.watch(5, "margin", "wrench")
        self.assertEqual([counted[leaf]["lost"] for leaf in ("socket", "margin", "wrench")], [0, 0, 0])
        self.assertLess(self.memory_mb(), before + GROWTH_MB)
        size = os.path.getsize(self.path("stalled"))
        stalled.send_signal(signal.SIGCONT)
        await_true(lambda: os.path.getsize(self.path("stalled")) > size, "margins after the stall")

    def test_slipd_and_it_may_be_restarted_in_any_order(self):
        if not os.path.exists(READER):
            self.skipTest("Fast DDS is not installed: run tools/setup --peers")
        with open(self.path("out"), "w", encoding="utf-8") as out:
            reader = subprocess.Popen([READER, "default", str(self.domain), "0", "/slipd/left/estimate",
                                       "slipd_msgs::msg::dds_::SlipEstimate_"], stdout=out)
        self.addCleanup(reader.wait)
        self.addCleanup(reader.kill)
        self.await_state(connected=True)
        for order in (("slipd",), ("bridge",), ("slipd", "bridge"), ("bridge", "slipd")):
            with self.subTest(order):
                for name in order:
                    self.end(getattr(self, name), signal.SIGKILL)
                if order == ("slipd",):
                    self.await_state(connected=False)
                for name in order:
                    setattr(self, name, self.start_slipd() if name == "slipd" else self.start_bridge())
                self.await_state(connected=True)

    def await_state(self, connected):
        """Until a message that came after this call says that slipd is there, or away (state 8)."""
        path, begin = self.path("out"), os.path.getsize(self.path("out"))

        def seen():
            with open(path, encoding="utf-8") as file:
                file.seek(begin)
                states = [self.state(line) for line in file.read().splitlines()[1:-1]]
            return any((state not in (6, 8)) == connected for state in states)

        await_true(seen, "an estimate" if connected else "the loss of slipd")

    @staticmethod
    def state(line):
        """state of a SlipEstimate: after the header (stamp, frame_id) and the name."""
        data = bytes.fromhex(line.split(" ")[3])[4:]
        at = 8
        for _ in range(2):
            at += -at % 4
            at += 4 + struct.unpack_from("<I", data, at)[0]
        return data[at]

    def test_sighup_takes_up_the_settings_and_an_error_in_them_changes_nothing(self):
        self.read("default", 1, "/slipd/left/margin", FLOAT)
        with open(self.path("ros2.json"), "w", encoding="utf-8") as file:
            file.write("{ not settings")
        self.bridge.send_signal(signal.SIGHUP)
        self.read("default", 1, "/slipd/left/margin", FLOAT)
        self.write("ros2.json", {"socket": self.socket, "domain": self.domain, "prefix": "/fingers"})
        self.bridge.send_signal(signal.SIGHUP)
        self.read("default", 1, "/fingers/left/margin", FLOAT)


class Rate(unittest.TestCase):
    def test_a_reliable_reader_loses_nothing_at_1_khz(self):
        ran = subprocess.run([os.path.join(SOURCE, "tools", "ros2"), "10", "--keep", "--check", "--build", BUILD], capture_output=True, text=True,
                             timeout=PATIENCE_S, check=False)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)


class Wireshark(Bed):
    def test_it_dissects_every_packet(self):
        try:
            capture = subprocess.Popen(["tshark", "-q", "-i", "lo", "-f", f"udp portrange {7400 + 250 * self.domain}-{7649 + 250 * self.domain}",
                                        "-w", self.path("capture.pcapng")], stderr=subprocess.PIPE, text=True)
        except FileNotFoundError:
            self.skipTest("tshark is not installed: run tools/setup --peers")
        self.addCleanup(capture.kill)
        for line in capture.stderr:
            if "Capturing on" in line:
                break
        else:
            self.skipTest("tshark may not capture on lo: root may")
        self.read("default", 20, "/slipd/left/margin", FLOAT, "/slipd/left/estimate", "slipd_msgs::msg::dds_::SlipEstimate_",
                  "/slipd/left/taxels", "sensor_msgs::msg::dds_::PointCloud2_")
        capture.send_signal(signal.SIGINT)
        capture.communicate(timeout=PATIENCE_S)
        self.assertGreater(self.packets("rtps"), 60)
        self.assertEqual(self.packets("!rtps"), 0)
        self.assertEqual(self.packets("_ws.malformed || _ws.expert.severity >= 0x600000"), 0)

    def packets(self, condition):
        out = subprocess.run(["tshark", "-r", self.path("capture.pcapng"), "-Y", condition], capture_output=True, text=True, check=True).stdout
        return len(out.splitlines())


if __name__ == "__main__":
    unittest.main()
