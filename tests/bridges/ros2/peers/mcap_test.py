"""MCAP files of slipctl and of slipd-ros2, read by @mcap/core and decoded by @foxglove/rosmsg2-serialization from the .msg texts in them."""
import bisect, json, math, os, signal, struct, subprocess, tempfile, unittest

import slipd
from awaiting import PATIENCE_S, await_true

BUILD, SOURCE, NPM = os.environ["SLIPD_BINARY_DIR"], os.environ["SLIPD_SOURCE_DIR"], os.environ["SLIPD_PEERS_NPM"]
DAEMON = os.environ.get("SLIPD_PROGRAM", os.path.join(BUILD, "bin", "slipd"))
BRIDGE = os.path.join(BUILD, "bin", "slipd-ros2")
FLOAT32_ROUNDING = 1e-6  # a number below 2 as a float32
STATE_DISCONNECTED, ALERT_NONE = 8, 0
SAMPLES_APART_NS = 1_000_000  # less than a period of 200 Hz


def messages(file):
    """The head line, and the messages of each topic in order: (time, message)."""
    ran = subprocess.run(["node", os.path.join(SOURCE, "tests", "bridges", "ros2", "peers", "messages.mjs"), file], cwd=NPM,
                         capture_output=True, text=True, check=False)
    if ran.returncode != 0:
        raise AssertionError(ran.stderr)
    head, *lines = map(json.loads, ran.stdout.splitlines())
    topics = {topic: [] for topic in head["topics"]}
    for line in lines:
        topics[line["topic"]].append((int(line["time"]), line["message"]))
    return head, topics


def number(value):
    return float(value)  # "NaN" is a text in JSON


class Programs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.socket = self.path("socket")
        finger = {"driver": "sim", "rate_hz": 200, "layout": {"grid": [4, 4], "pitch_mm": 3}}
        self.write("slipd.json", {"socket": {"path": self.socket}, "realtime": {"mode": "off"}, "recorder": {"seconds": 2},
                                  "sensors": [{"name": "left", **finger}, {"name": "right", **finger}],
                                  "grasps": [{"name": "cup", "sensors": ["left", "right"]}]})
        self.slipd = self.start_slipd()

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, settings):
        with open(self.path(name), "w", encoding="utf-8") as file:
            json.dump(settings, file)

    def start(self, *command):
        process = subprocess.Popen(command, stderr=subprocess.DEVNULL, env={**os.environ, "STATE_DIRECTORY": self.folder})
        self.addCleanup(self.end, process)
        return process

    def start_slipd(self):
        process = self.start(DAEMON, "--config", self.path("slipd.json"))
        await_true(lambda: os.path.exists(self.socket), "slipd's socket")
        return process

    def end(self, process, how=signal.SIGTERM):
        if process.poll() is None:
            process.send_signal(how)
            self.assertEqual(process.wait(PATIENCE_S), -how if how == signal.SIGKILL else 0)

    def estimate(self, condition):
        with slipd.Client(self.socket, timeout_s=PATIENCE_S) as client:
            for estimate in client.estimates("left", max_age_s=3600):
                if condition(estimate):
                    return estimate


class Export(Programs):
    def test_each_sample_of_a_recording_is_in_the_file(self):
        self.estimate(lambda one: one.at_state == "ok" and one.seq > 300)
        made = subprocess.run([os.path.join(BUILD, "bin", "slipctl"), "--socket", self.socket, "flight", "left"], check=True,
                              capture_output=True, text=True).stdout
        recording = next(os.path.join(at, name) for at, _, names in os.walk(self.folder) for name in names if name in made)
        frames = list(slipd.open(recording))
        subprocess.run([os.path.join(BUILD, "bin", "slipctl"), "export", recording, "--mcap", self.path("out.mcap")], check=True)
        head, topics = messages(self.path("out.mcap"))
        self.assertEqual(head["profile"], "ros2")
        self.assertEqual(head["topics"]["/slipd/left/wrench"], "geometry_msgs/msg/WrenchStamped")
        self.assertEqual(int(head["messages"]), sum(map(len, topics.values())))
        estimated = [frame for frame in frames if frame.estimate is not None]  # the others were skipped
        for leaf, of in (("wrench", frames), ("taxels", frames), ("margin", estimated), ("estimate", estimated)):
            self.assertEqual(len(topics[f"/slipd/left/{leaf}"]), len(of), leaf)
        for frame, (_, cloud) in zip(frames, topics["/slipd/left/taxels"]):
            self.compare_taxels(frame, cloud)
        for frame, (_, margin), (_, estimate) in zip(estimated, topics["/slipd/left/margin"], topics["/slipd/left/estimate"]):
            self.compare_estimate(frame, margin, estimate)
        self.assertGreater(sum(frame.estimate["state"] == "ok" for frame in estimated), 100, "margins were compared")

    def compare_taxels(self, frame, cloud):
        values = struct.unpack(f"<{6 * len(frame.normal_pa)}f", bytes.fromhex(cloud["data"]))
        self.assertEqual(list(values[3::6]), list(frame.normal_pa))
        self.assertEqual(list(values[4::6]), list(frame.shear_x_pa))
        self.assertEqual(list(values[5::6]), list(frame.shear_y_pa))

    def compare_estimate(self, frame, margin, estimate):
        self.assertEqual(int(estimate["seq"]), frame.seq)
        self.assertEqual(state_name(estimate["state"]), frame.estimate["state"])
        known = frame.estimate["gamma"] if frame.estimate["state"] == "ok" else None
        if known is None:
            self.assertTrue(math.isnan(number(margin["data"])) and math.isnan(number(estimate["margin"])))
        else:
            self.assertEqual(estimate["margin"], known)
            self.assertAlmostEqual(margin["data"], known, delta=FLOAT32_ROUNDING)


class Live(Programs):
    def start_bridge(self):
        self.write("ros2.json", {"socket": self.socket, "domain": 1 + os.getpid() % 100, "topics": {"taxels": {"rate_hz": 20}}})
        return self.start(BRIDGE, "--config", self.path("ros2.json"), "--record", self.path("live.mcap"))

    def test_what_is_published_is_what_slipd_says_and_no_margin_outlives_slipd(self):
        bridge = self.start_bridge()
        self.estimate(lambda one: one.at_state == "ok" and one.seq > 400)
        await_true(lambda: os.path.exists(self.path("live.mcap")), "the recording")
        with slipd.Client(self.socket, timeout_s=PATIENCE_S) as client:
            truth = {}
            for one in client.estimates("left", max_age_s=3600):
                truth[one.seq] = one
                if len(truth) > 400:
                    break
        self.end(self.slipd, signal.SIGKILL)
        self.end(bridge)
        head, topics = messages(self.path("live.mcap"))
        for subject in ("left", "right", "cup"):
            for leaf in ("wrench", "margin", "margin_low", "estimate"):
                self.assertGreater(len(topics[f"/slipd/{subject}/{leaf}"]), 100, f"{subject} {leaf}")
        self.assertGreater(len(topics["/slipd/left/taxels"]), 10)
        self.assertGreater(len(topics["/diagnostics"]), 1)
        compared = self.compare(topics["/slipd/left/estimate"], truth)
        self.assertGreater(compared, 300)
        self.compare_stamps(topics)
        for subject in ("left", "cup"):
            last = topics[f"/slipd/{subject}/estimate"][-1][1]
            self.assertEqual(last["state"], STATE_DISCONNECTED)
            self.assertNotEqual(last["alert"], ALERT_NONE)
            self.assertNotEqual(topics[f"/slipd/{subject}/alert"][-1][1]["alert"], ALERT_NONE)
            self.assertTrue(math.isnan(number(last["margin"])))
            self.assertTrue(math.isnan(number(topics[f"/slipd/{subject}/margin"][-1][1]["data"])))
            self.assertTrue(math.isnan(number(topics[f"/slipd/{subject}/wrench"][-1][1]["wrench"]["force"]["z"])))

    def compare_stamps(self, topics):
        """Messages of one sample have one stamp, whichever topic they are on."""
        def stamps(leaf):
            return {1_000_000_000 * int(message["header"]["stamp"]["sec"]) + int(message["header"]["stamp"]["nanosec"])
                    for _, message in topics[f"/slipd/left/{leaf}"]}
        samples = sorted(stamps("estimate"))
        self.assertEqual(stamps("wrench"), set(samples))
        self.assertLessEqual(stamps("alert"), set(samples))
        same = 0
        for stamp in stamps("taxels"):
            at = bisect.bisect(samples, stamp - SAMPLES_APART_NS)
            if at < len(samples) and samples[at] < stamp + SAMPLES_APART_NS:  # not of a frame that was skipped
                same += 1
                self.assertEqual(samples[at], stamp)
        self.assertGreater(same, 5)

    def compare(self, published, truth):
        compared = 0
        for _, message in published:
            one = truth.get(int(message["seq"]))
            if one is None or state_name(message["state"]) != one.at_state:  # too old by then
                continue
            compared += 1
            margin = number(message["margin"])
            self.assertEqual(math.isnan(margin), one.sent["gamma"] is None)
            if one.sent["gamma"] is not None:
                self.assertEqual(margin, one.sent["gamma"])
            if one.shear_n is not None and "shear_x_n" in one.values:
                self.assertEqual(message["shear_force_x"], one.values["shear_x_n"])
        return compared


def state_name(state):
    return ("ok", "no_contact", "learning", "out_of_model", "no_shear", "unzeroed", "stale", "fault", "disconnected")[state]


if __name__ == "__main__":
    unittest.main()
