"""What readers that ask for a deadline and for liveliness are told when slipd-ros2 or slipd is killed, stands still or ends, by Fast DDS and by
Cyclone DDS. How long it took is printed and not judged: programs may wait for a processor."""
import math, os, signal, struct, subprocess, threading, time, unittest

from awaiting import PATIENCE_S, await_true
from mcap_test import BUILD, STATE_DISCONNECTED
from network_test import FLOAT, READER, Bed
from stopping import StoppedThread

CYCLONE = os.path.join(BUILD, "test-bin", "ros2-cyclone-reader")
ESTIMATE = "slipd_msgs::msg::dds_::SlipEstimate_"
DEADLINE_MS, LEASE_MS = 200, 400  # docs/ros2.md
LEAVES = ("margin", "estimate", "alert")
# All use the loopback interface: when the computer's addresses change, slipd-ros2 would start its node anew. network_test.py is about networks.
LOOPBACK = ('<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo"/></Interfaces><AllowMulticast>false</AllowMulticast></General>'
            '<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>')
STATE_OK, STATE_STALE = 0, 6
ALERT_NONE, ALERT_UNKNOWN = 0, 3


class Reader:
    """A program that reads topics, and what it has printed: for each topic (time, kind, value). Values of messages are (state, alert, margin)."""

    def __init__(self, name, command):
        self.name, self.told = name, {leaf: [] for leaf in LEAVES}
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "CYCLONEDDS_URI": LOOPBACK, "DEADLINE_MS": str(DEADLINE_MS),
                                                                                               "LEASE_MS": str(LEASE_MS)})
        self.thread = threading.Thread(target=self.read)
        self.thread.start()

    def read(self):
        for line in self.process.stdout:
            topic, *words = line.split()
            leaf = topic.rsplit("/", 1)[1]
            kind, value = ("message", self.decode(leaf, bytes.fromhex(words[2])[4:])) if len(words) == 3 else (words[0], int(words[1]))
            self.told[leaf].append((time.monotonic(), kind, value))

    @staticmethod
    def decode(leaf, data):
        """Of a SlipEstimate: the header (stamp, frame_id) and the name, both texts "left", are before the state."""
        if leaf == "margin":
            return None, None, struct.unpack_from("<f", data)[0]
        return data[29], data[30], struct.unpack_from("<d", data, 64)[0]

    def end(self):
        self.process.kill()
        self.process.wait()
        self.thread.join()
        self.process.stdout.close()

    def first(self, leaf, kind, condition, since):
        """Time of the first such line since then, as a list that is empty as long as there is none."""
        return [at for at, each, value in list(self.told[leaf]) if at >= since and each == kind and condition(value)][:1]


def without_numbers(message):
    """What a reader is told of a slipd that is silent: neither ok, nor that there is no alert, nor a margin."""
    state, alert, margin = message
    return math.isnan(margin) and (state is None or (state in (STATE_STALE, STATE_DISCONNECTED) and alert != ALERT_NONE))


class Promises(Bed):
    def setUp(self):
        super().setUp()
        self.readers = [Reader("Cyclone DDS", [CYCLONE, str(self.domain), "left"])]
        if os.path.exists(READER):
            words = [word for leaf in LEAVES for word in (f"/slipd/left/{leaf}", FLOAT if leaf == "margin" else ESTIMATE)]
            self.readers.append(Reader("Fast DDS", [READER, "loopback", str(self.domain), "0", *words]))
        for reader in self.readers:
            self.addCleanup(reader.end)
        self.await_all("before", 0, *self.ALIVE, *self.OK)

    def start_bridge(self, **settings):
        return super().start_bridge(network={"interfaces": ["lo"]}, **settings)

    ALIVE = tuple((leaf, "alive", lambda value: value == 1) for leaf in LEAVES)
    DEAD = tuple((leaf, "alive", lambda value: value == 0) for leaf in LEAVES)
    MISSED = tuple((leaf, "missed", lambda value: value > 0) for leaf in ("margin", "estimate"))
    OK = (("estimate", "message", lambda value: value[0] == STATE_OK), ("margin", "message", lambda value: not math.isnan(value[2])))
    SILENT = tuple((leaf, "message", without_numbers) for leaf in ("margin", "estimate"))
    DISCONNECTED = (("estimate", "message", lambda value: value[0] == STATE_DISCONNECTED and without_numbers(value)),)

    def await_all(self, what, since, *expected):
        for reader in self.readers:
            for leaf, kind, condition in expected:
                at, = await_true(lambda: reader.first(leaf, kind, condition, since), f"{kind} of {leaf} {what}, by {reader.name}")
                if since:
                    print(f"{what}: {reader.name} was told {kind} of {leaf} after {1e3 * (at - since):.0f} ms")

    def misses_since(self, what, since):
        for reader in self.readers:
            for leaf in ("margin", "estimate"):
                count = sum(kind == "missed" and at >= since for at, kind, _ in list(reader.told[leaf]))
                print(f"{what}: {reader.name} missed {count} deadlines of {leaf} in {time.monotonic() - since:.1f} s")

    def signalled(self, process, number):
        process.send_signal(number)
        return time.monotonic()

    def test_a_bridge_that_is_killed_is_not_alive(self):
        at = self.signalled(self.bridge, signal.SIGKILL)
        self.await_all("slipd-ros2 killed", at, *self.DEAD, *self.MISSED)
        self.end(self.bridge, signal.SIGKILL)
        at = time.monotonic()
        self.bridge = self.start_bridge()
        self.await_all("slipd-ros2 started", at, *self.ALIVE, *self.OK)

    def test_a_bridge_that_stands_still_is_not_alive_until_it_goes_on(self):
        at = self.signalled(self.bridge, signal.SIGSTOP)
        self.addCleanup(self.bridge.send_signal, signal.SIGCONT)
        self.await_all("slipd-ros2 stopped", at, *self.DEAD, *self.MISSED)
        at = self.signalled(self.bridge, signal.SIGCONT)
        self.await_all("slipd-ros2 continued", at, *self.ALIVE, *self.OK)

    def test_a_bridge_that_ends_says_before_that_all_is_disconnected(self):
        at = time.monotonic()
        self.end(self.bridge)
        self.await_all("slipd-ros2 ended", at, *self.DISCONNECTED, *self.DEAD)
        for reader in self.readers:
            last = [value for _, kind, value in reader.told["estimate"] if kind == "message"][-1]
            self.assertTrue(without_numbers(last), last)
            margin = [value for _, kind, value in reader.told["margin"] if kind == "message"][-1]
            self.assertTrue(math.isnan(margin[2]))

    def test_a_slipd_that_stands_still_is_stale_and_its_topics_live(self):
        at = self.signalled(self.slipd, signal.SIGSTOP)
        self.addCleanup(self.slipd.send_signal, signal.SIGCONT)
        self.await_all("slipd stopped", at, *self.SILENT)
        self.await_repeats("slipd stopped", at, without_numbers)
        self.await_all("slipd stopped", at, *self.DISCONNECTED)
        self.misses_since("slipd stopped", at)
        at = self.signalled(self.slipd, signal.SIGCONT)
        self.await_all("slipd continued", at, *self.OK)

    def test_a_slipd_that_is_killed_is_disconnected_and_its_topics_live(self):
        at = self.signalled(self.slipd, signal.SIGKILL)
        self.await_all("slipd killed", at, *self.SILENT, *self.DISCONNECTED)
        self.await_repeats("slipd killed", at, without_numbers)
        self.misses_since("slipd killed", at)
        self.end(self.slipd, signal.SIGKILL)
        at = time.monotonic()
        self.slipd = self.start_slipd()
        self.await_all("slipd started", at, *self.OK)

    def hangs(self, process, thread, what):
        """Readers are told while the thread stands still that all is stale, and that it is not once it goes on."""
        try:
            stopped = StoppedThread(process.pid, thread)
        except PermissionError as why:
            self.skipTest(str(why))
        with stopped:
            at = time.monotonic()
            self.await_all(f"{what} stopped", at, *self.SILENT)
            self.await_repeats(f"{what} stopped", at, without_numbers)
        self.await_all(f"{what} continued", time.monotonic(), *self.OK)

    def test_a_slipd_whose_estimate_thread_hangs_is_stale(self):
        self.hangs(self.slipd, "estimate", "slipd's estimate thread")

    def test_a_bridge_whose_loop_hangs_says_that_all_is_stale(self):
        self.hangs(self.bridge, "slipd-ros2", "slipd-ros2's loop")

    def await_repeats(self, what, since, condition):
        """Messages without numbers go on to come: twenty of them are ten promises."""
        for reader in self.readers:
            for leaf in ("margin", "estimate"):
                await_true(lambda: sum(kind == "message" and at >= since and condition(value) for at, kind, value in list(reader.told[leaf])) > 20,
                           f"twenty messages of {leaf}, {what}, by {reader.name}")


if __name__ == "__main__":
    unittest.main()
