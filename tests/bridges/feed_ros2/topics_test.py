"""slipd-feed-ros2 between publishers of Fast DDS and the real slipd. The messages' bytes are made here, by tests/support/cdr.py."""
import json, math, os, signal, struct, subprocess, sys, tempfile, time, unittest

import slipd
from awaiting import PATIENCE_S, await_true
from cdr import CdrWriter
from margins_of_messages import MARGIN_ERROR, OLD_S, MarginsOfMessages

sys.path.insert(0, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "tests", "clients"))
from push_test import HELD, RATE_HZ, SIDE, Scene, contact  # contacts of Cattaneo and Mindlin, in Pa

BUILD = os.environ["SLIPD_BINARY_DIR"]
TAXELS = SIDE ** 2
SMALL = 50  # frames slipd hears of what the test does not want used: so many chances to use one
TOPIC = "/left/taxels"
INT16, FLOAT32, FLOAT64 = 3, 7, 8  # of sensor_msgs/PointField


def array(frame, dims=(), data_offset=0, big=False, values=None):
    values = [value for taxel in frame for value in taxel] if values is None else values
    cdr = CdrWriter(big).put("I", len(dims))
    for label, size in dims:
        cdr.text(label).put("I", size, 0)
    cdr.put("I", data_offset, len(values))
    cdr.bytes += struct.pack(f"{cdr.order}{len(values)}f", *values)
    return cdr.message()


def cloud(frame, stamp_s=None, big=False, padding=0, points=None, fields=(("y", 8), ("x", 0), ("extra", 4), ("z", 12)), kind=FLOAT32,
          frame_id="finger", code="f"):
    """Rows of SIDE points, each of x, something else, y and z."""
    order = ">" if big else "<"
    cdr = CdrWriter(big).header(time.time() if stamp_s is None else stamp_s, frame_id).put("I", SIDE, SIDE, len(fields))
    for name, offset in fields:
        cdr.text(name).put("I", offset).put("B", kind).put("I", 1)
    step = struct.calcsize(f"<4{code}")
    cdr.put("?", big).put("I", step, step * SIDE + padding)
    points = [struct.pack(f"{order}4{code}", x, -1, y, z) for x, y, z in frame] if points is None else points
    rows = [b"".join(points[i:i + SIDE]) + bytes(padding) for i in range(0, TAXELS, SIDE)]
    return cdr.blob(b"".join(rows)).put("?", True).message()


def wrench(force, stamp_s=None, frame_id="wrist"):
    return CdrWriter().header(time.time() if stamp_s is None else stamp_s, frame_id).put("d", *force, 0.0, 0.0, 0.0).message()


class Publisher:
    """A program of Fast DDS; send() puts bytes on the topic."""

    def __init__(self, domain, kind, topic=TOPIC, reliability="reliable"):
        self.process = subprocess.Popen([os.path.join(BUILD, "test-bin", "fastdds-writer"), str(domain), topic, kind, reliability],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def await_subscription(self):
        for line in self.process.stdout:
            if line.startswith("matched ") and int(line.split()[1]) > 0:
                return
        raise AssertionError("the publisher has ended")

    def send(self, message):
        self.process.stdin.write(message.hex() + "\n")
        self.process.stdin.flush()

    def end(self):
        if self.process.returncode is None:
            self.process.stdin.close()
            self.process.wait(PATIENCE_S)
        self.process.stdout.close()

    def kill(self):
        self.process.kill()
        self.process.wait()


class Program:
    """slipd-feed-ros2 with one feed."""

    def __init__(self, daemon, domain, sensor="left", **feed):
        self.settings = os.path.join(daemon.folder.name, "feed-ros2.json")
        self.sensor = sensor
        with open(self.settings, "w", encoding="utf-8") as file:
            json.dump({"socket": daemon.socket, "domain": domain, "feeds": [{"sensor": sensor, **feed}]}, file)
        self.log_file = os.path.join(daemon.folder.name, "feed-ros2.log")
        with open(self.log_file, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen([os.path.join(BUILD, "bin", "slipd-feed-ros2"), "--config", self.settings], stderr=log, stdout=log)

    def log(self):
        with open(self.log_file, encoding="utf-8") as log:
            return log.read()

    def end(self):
        """Its counts, by name."""
        if self.process.returncode is None:
            self.process.terminate()
            assert self.process.wait(PATIENCE_S) == 0, self.log()
        summary = [line for line in self.log().splitlines() if "messages," in line][-1]
        return {name: int(count) for count, name in (each.split(" ", 1) for each in summary.split(f"{self.sensor}: ")[1].split(", "))}


class Bed(MarginsOfMessages, unittest.TestCase):
    KIND = "std_msgs::msg::dds_::Float32MultiArray_"
    PROFILE = {"type": "std_msgs/Float32MultiArray", "columns": [0, 1, 2], "array": {"row": 3}, "unit": "Pa"}
    frame_message = staticmethod(array)

    def setUp(self):
        self.domain = 1 + os.getpid() % 100
        self.daemon = Scene(max_age_ms=100)
        self.addCleanup(self.daemon.close)
        self.client = slipd.Client(self.daemon.socket, timeout_s=PATIENCE_S)
        self.addCleanup(self.client.close)
        await_true(lambda: os.path.exists(os.path.join(self.daemon.folder.name, "push", "left")), "the sensor's socket")

    def profile(self, **more):
        path = os.path.join(self.daemon.folder.name, "profile.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"description": "this test", "tested": "synthetic", "source": "this test", "topic": TOPIC, **self.PROFILE, **more}, file)
        return path

    def feed(self, taxels=TAXELS, profile=None, **settings):
        self.program = Program(self.daemon, self.domain, profile=profile or self.profile(), taxels=taxels, **settings)
        self.addCleanup(self.program.end)

    def publish(self, **options):
        self.publisher = Publisher(self.domain, options.pop("kind", self.KIND), **options)
        self.addCleanup(self.publisher.end)
        return self.publisher

    def start(self, **settings):
        self.feed(**settings)
        self.publish().await_subscription()

    def send(self, message):
        self.publisher.send(message)


class Arrays(Bed):
    def test_frames_of_arrays_give_the_margin_of_the_contact(self):
        self.start()
        self.hold(0.3)
        self.hold(0.6)
        counts = self.program.end()
        self.assertEqual((counts["corrupt"], counts["repeated"], counts["other"]), (0, 0, 0))

    def test_the_profile_says_where_the_numbers_are(self):
        """Axes one after the other, in another order, between other numbers, behind an offset, big-endian."""
        columns, first, behind, offset = [2, 0, 1], [9.0] * 3, [8.0], [7.0] * 2
        self.frame_message = lambda frame: array((), big=True, data_offset=len(offset), values=[
            *offset, *first, *(taxel[axis] for axis in (1, 2, 0) for taxel in frame), *behind])
        self.start(profile=self.profile(columns=columns, array={"row": 3, "order": "axes", "first": len(first), "behind": len(behind)}))
        self.hold()

    def test_dimensions_are_compared_where_a_message_states_them(self):
        self.frame_message = lambda frame: array(frame, dims=(("taxel", TAXELS), ("axis", 3)))
        self.start()
        self.hold()
        self.never_a_margin([array(HELD, dims=(("taxel", TAXELS), ("axis", 2))), array(HELD, dims=(("all", 0),))])
        self.assertEqual(self.program.end()["corrupt"], 2)

    def test_a_best_effort_publisher_is_heard(self):
        self.feed()
        self.publish(reliability="best_effort").await_subscription()
        self.hold()

    def test_broken_messages_are_counted_and_give_no_margin(self):
        self.start()
        self.hold()
        whole = [value for taxel in HELD for value in taxel]
        corrupt = [array((), values=whole[:-1]), array((), values=[*whole, 0.0]), array((), values=[]), array(HELD, data_offset=1),
                   array(HELD, data_offset=2 ** 32 - 1),
                   array((), values=[math.nan, *whole[1:]]), array((), values=[math.inf, *whole[1:]])]
        self.never_a_margin(corrupt)
        self.send_until(HELD, lambda each: each.gamma is not None, "a whole one")
        self.assertEqual(self.program.end()["corrupt"], len(corrupt))

    def test_torn_messages_never_give_a_margin(self):
        self.start()
        self.hold()
        torn = [array(HELD)[:length] for length in (4, 8, 12, 13, 400, len(array(HELD)) - 4)]
        self.never_a_margin(torn)
        self.send_until(HELD, lambda each: each.gamma is not None, "a whole one")
        self.assertEqual(self.program.end()["corrupt"], len(torn))
        self.assertNotIn("deserialization", self.program.log())

    def test_messages_that_waited_are_old(self):
        self.start()
        self.hold()
        self.program.process.send_signal(signal.SIGSTOP)
        await_true(lambda: self.estimate().state == "fault", "a fault")
        for _ in range(SMALL):
            self.publisher.send(array(HELD))
        # Older than any frame may be, as the sender's clock shows.
        until = time.monotonic() + 0.3
        await_true(lambda: time.monotonic() > until, "time")
        corrupt = self.client.call("status")["sensors"][0]["corrupt"]
        self.program.process.send_signal(signal.SIGCONT)
        await_true(lambda: self.client.call("status")["sensors"][0]["corrupt"] > corrupt, "frames that slipd finds old")
        estimate = self.estimate()
        self.assertEqual((estimate.gamma, estimate.state), (None, "fault"))


class Clouds(Bed):
    KIND = "sensor_msgs::msg::dds_::PointCloud2_"
    PROFILE = {"type": "sensor_msgs/PointCloud2", "fields": ["x", "y", "z"], "unit": "Pa"}
    frame_message = staticmethod(cloud)

    def test_frames_of_clouds_give_the_margin_of_the_contact(self):
        self.start()
        self.hold(0.3)
        self.hold(0.6)

    def test_padded_rows_of_big_endian_doubles_give_the_same(self):
        self.frame_message = lambda frame: cloud(frame, big=True, padding=5, kind=FLOAT64, code="d",
                                                 fields=(("y", 16), ("x", 0), ("extra", 8), ("z", 24)))
        self.start()
        self.hold()

    def test_whole_numbers_are_read_as_they_are(self):
        """A field of another type than float."""
        self.frame_message = lambda frame: cloud([[round(value) for value in taxel] for taxel in frame], kind=INT16, code="h",
                                                 fields=(("y", 4), ("x", 0), ("extra", 2), ("z", 6)))
        self.start()
        self.hold()

    def test_broken_clouds_are_counted_and_give_no_margin(self):
        self.start()
        self.hold()
        points = [struct.pack("<4f", x, -1, y, z) for x, y, z in HELD]
        other_fields = (("y", 8), ("x", 0), ("z", 14))  # beyond the point
        corrupt = [cloud(HELD, fields=(("x", 0), ("y", 8))), cloud(HELD, fields=other_fields), cloud(HELD, kind=9), cloud(HELD, kind=0),
                   cloud(HELD, points=points[:-1]), cloud(HELD, points=[struct.pack("<4f", math.nan, 0, 0, 1), *points[1:]]),
                   cloud(HELD, stamp_s=0), cloud(HELD, stamp_s=-5)]
        self.never_a_margin(corrupt)
        self.assertEqual(self.program.end()["corrupt"], len(corrupt))

    def test_a_message_whose_stamp_does_not_rise_is_a_repetition(self):
        self.start()
        self.hold()
        again = cloud(HELD)
        for _ in range(3):
            self.publisher.send(again)
        self.publisher.send(cloud(HELD, stamp_s=time.time() - 1))
        self.send_until(HELD, lambda each: each.gamma is not None, "the next")
        self.assertIn(self.program.end()["repeated"], (1, 2, 3))  # of messages that wait, DDS keeps the newest

    def test_stamps_that_are_old_give_no_margin(self):
        """The publisher's own queue: DDS hands over at once what was measured long ago."""
        self.start()
        self.hold()
        began = time.time()
        self.never_a_margin([cloud(HELD, stamp_s=began + i * 1e-3) for i in range(SMALL)])

    def test_messages_of_another_frame_id_are_of_another_sensor(self):
        self.feed(frame_id="finger")
        self.publish().await_subscription()
        self.hold()
        self.never_a_margin([cloud(HELD, frame_id="thumb") for _ in range(5)])
        self.assertEqual(self.program.end()["other"], 5)


class Publishers(Bed):
    def test_a_publisher_that_was_killed_is_stale_and_the_next_gives_margins_again(self):
        self.start()
        self.hold()
        self.publisher.kill()
        await_true(lambda: self.estimate().state == "fault", "no frames")
        self.assertIsNone(self.estimate().gamma)
        self.publish().await_subscription()
        self.hold(0.5)  # before DDS takes the killed one for dead

    def test_one_that_ends_is_told_and_so_is_the_next(self):
        self.feed()
        await_true(lambda: f"no node publishes {TOPIC}" in self.program.log(), "word of no publisher")
        self.publish().await_subscription()
        self.hold()
        self.publisher.end()
        await_true(lambda: self.program.log().count(f"no node publishes {TOPIC}") == 2, "word of its end")
        self.assertIsNone(self.estimate().gamma)
        self.publish().await_subscription()
        await_true(lambda: "the source is there" in self.program.log().rsplit("no node publishes", 1)[1], "word of the next")
        self.hold()

    def test_a_second_publisher_is_counted_while_the_first_sends(self):
        self.start()
        self.hold()
        first = self.publisher
        self.publish().await_subscription()
        second, self.publisher = self.publisher, first
        self.send_until(HELD, lambda each: each.gamma is not None, "the first, which may have been silent for a second")
        sent = time.monotonic()
        for _ in range(20):
            if time.monotonic() - sent > 0.5:
                self.skipTest("this machine stood still: the first was silent")
            sent = time.monotonic()
            first.send(array(HELD))
            second.send(array(contact(1, 0.9)))
            time.sleep(1 / RATE_HZ)
            gamma = self.estimate().gamma
            self.assertTrue(gamma is None or gamma > 0.5, gamma)
        await_true(lambda: "of a second sender" in self.program.log(), "word of the second")
        self.assertGreater(self.program.end()["of a second sender"], 0)

    def test_another_type_or_reliability_is_told(self):
        self.feed(profile=self.profile(qos={"reliable": True}))
        self.publish(reliability="best_effort")
        await_true(lambda: '"reliable": false' in self.program.log(), "word of the reliability")
        self.publisher.end()
        self.publish(kind="std_msgs::msg::dds_::Float64MultiArray_")
        await_true(lambda: "as std_msgs::msg::dds_::Float64MultiArray_" in self.program.log(), "word of the type")

    def test_it_sleeps_while_nothing_comes(self):
        self.start()
        self.hold()

        def ticks():
            with open(f"/proc/{self.program.process.pid}/stat", encoding="utf-8") as file:
                return sum(map(int, file.read().rpartition(")")[2].split()[11:13]))
        before, began = ticks(), time.monotonic()
        await_true(lambda: time.monotonic() > began + 2, "time")
        self.assertLess((ticks() - before) / os.sysconf("SC_CLK_TCK"), 0.5)


class ForceScene(Scene):
    """slipd with one force, and friction that is given."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.socket = os.path.join(self.folder.name, "socket")
        self.settings = os.path.join(self.folder.name, "slipd.json")
        finger = {"name": "left", "driver": "push", "rate_hz": RATE_HZ, "layout": {"grid": [1, 1], "pitch_mm": 20}, "friction": 0.5}
        with open(self.settings, "w", encoding="utf-8") as file:
            json.dump({"socket": {"path": self.socket}, "realtime": {"mode": "off"}, "sensors": [finger]}, file)
        self.start()


class Force(unittest.TestCase):
    """A force sensor is one taxel; friction is given."""

    def test_a_wrench_gives_the_margin_of_one_force(self):
        domain = 1 + os.getpid() % 100
        daemon = ForceScene()
        self.addCleanup(daemon.close)
        client = slipd.Client(daemon.socket, timeout_s=PATIENCE_S)
        self.addCleanup(client.close)
        await_true(lambda: os.path.exists(os.path.join(daemon.folder.name, "push", "left")), "the sensor's socket")
        program = Program(daemon, domain, profile="wrench", topic="/wrist/wrench", frame_id="wrist")
        self.addCleanup(program.end)
        publisher = Publisher(domain, "geometry_msgs::msg::dds_::WrenchStamped_", topic="/wrist/wrench")
        self.addCleanup(publisher.end)
        publisher.await_subscription()

        def sent(force, condition):
            publisher.send(wrench(force))
            time.sleep(1 / RATE_HZ)
            return condition(client.gamma("left", max_age_s=OLD_S))
        await_true(lambda: sent((0, 0, 0), lambda each: each.state == "no_contact"), "the zero")
        for step in range(50):  # the load rises
            publisher.send(wrench((0, 0.02 * step, 4)))
            time.sleep(1 / RATE_HZ)
        await_true(lambda: sent((0, 1, 4), lambda each: each.gamma is not None and abs(each.gamma - 0.5) < MARGIN_ERROR), "the margin 1 - 1 / (0.5 4)")


class Settings(unittest.TestCase):
    def refusal(self, network=None, **feed):
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump({"feeds": [{"sensor": "left", "profile": "array-xyz", "topic": "/a", "taxels": 4, **feed}], "network": network or {}}, file)
            file.flush()
            checked = subprocess.run([os.path.join(BUILD, "bin", "slipd-feed-ros2"), "--config", file.name, "--check-config"],
                                     capture_output=True, text=True, check=False)
        return checked.returncode, checked.stderr

    def test_right_settings_are_right(self):
        self.assertEqual(self.refusal(), (0, ""))

    def test_wrong_settings_are_refused_with_what_to_do(self):
        for settings, remedy in (({"profile": "clouds"}, "there is no profile"), ({"topic": "a"}, "/NAME"), ({"profile": "wrench"}, "one taxel"),
                                 ({"frame_id": "x"}, "no frame_id"), ({"network": {"multicast": False, "peers": []}}, "no node could be found")):
            with self.subTest(settings):
                code, text = self.refusal(**settings)
                self.assertEqual(code, 2)
                self.assertIn(remedy, text)


del Bed  # has no tests of its own
if __name__ == "__main__":
    unittest.main(verbosity=2)
