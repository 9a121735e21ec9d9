"""slipd-feed-ros2 between publishers of Fast DDS and the real slipd. The messages' bytes are made here, by the rules of CDR alone."""
import json, math, os, signal, struct, subprocess, sys, tempfile, time, unittest

import slipd
from awaiting import PATIENCE_S, await_true

sys.path.insert(0, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "tests", "clients"))
from push_test import HELD, NOTHING, PITCH_M, RATE_HZ, SIDE, Scene, contact  # contacts of Cattaneo and Mindlin, in Pa

BUILD = os.environ["SLIPD_BINARY_DIR"]
TAXELS = SIDE ** 2
OLD_S = 3600
MARGIN_ERROR = 0.1  # of single frames by `moments`, on taxels a tenth of the radius wide
SMALL = 50  # frames slipd hears of what the test does not want used: so many chances to use one
TOPIC = "/left/taxels"
INT16, FLOAT32, FLOAT64 = 3, 7, 8  # of sensor_msgs/PointField


class Cdr:
    """Bytes of a message: XCDR version 1 (OMG XTypes 1.3, 7.4), little-endian unless it is said."""

    def __init__(self, big=False):
        self.bytes, self.order = bytearray(), ">" if big else "<"

    def put(self, code, *values):
        size = struct.calcsize(code)
        for value in values:
            self.bytes += bytes(-len(self.bytes) % size) + struct.pack(self.order + code, value)
        return self

    def text(self, text):
        self.put("I", len(text) + 1)
        self.bytes += text.encode() + b"\0"
        return self

    def blob(self, data):
        self.put("I", len(data))
        self.bytes += data
        return self

    def header(self, stamp_s, frame_id="finger"):
        return self.put("i", int(stamp_s)).put("I", int(stamp_s % 1 * 1e9)).text(frame_id)

    def message(self):
        return (b"\0\0\0\0" if self.order == ">" else b"\0\1\0\0") + bytes(self.bytes)


def array(frame, dims=(), data_offset=0, big=False, values=None):
    values = [value for taxel in frame for value in taxel] if values is None else values
    cdr = Cdr(big).put("I", len(dims))
    for label, size in dims:
        cdr.text(label).put("I", size, 0)
    cdr.put("I", data_offset, len(values))
    cdr.bytes += struct.pack(f"{cdr.order}{len(values)}f", *values)
    return cdr.message()


def cloud(frame, stamp_s=None, big=False, padding=0, points=None, fields=(("y", 8), ("x", 0), ("extra", 4), ("z", 12)), kind=FLOAT32,
          frame_id="finger", code="f"):
    """Rows of SIDE points, each of x, something else, y and z."""
    order = ">" if big else "<"
    cdr = Cdr(big).header(time.time() if stamp_s is None else stamp_s, frame_id).put("I", SIDE, SIDE, len(fields))
    for name, offset in fields:
        cdr.text(name).put("I", offset).put("B", kind).put("I", 1)
    step = struct.calcsize(f"<4{code}")
    cdr.put("?", big).put("I", step, step * SIDE + padding)
    points = [struct.pack(f"{order}4{code}", x, -1, y, z) for x, y, z in frame] if points is None else points
    rows = [b"".join(points[i:i + SIDE]) + bytes(padding) for i in range(0, TAXELS, SIDE)]
    return cdr.blob(b"".join(rows)).put("?", True).message()


def wrench(force, stamp_s=None, frame_id="wrist"):
    return Cdr().header(time.time() if stamp_s is None else stamp_s, frame_id).put("d", *force, 0.0, 0.0, 0.0).message()


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


class Bed(unittest.TestCase):
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

    def estimate(self):
        return self.client.gamma("left", max_age_s=OLD_S)

    def send_until(self, frame, condition, what):
        """Sends messages of the frame at the sensor's rate until the sensor's estimate is so; returns it."""
        def sent():
            self.publisher.send(self.frame_message(frame))
            time.sleep(1 / RATE_HZ)
            estimate = self.estimate()
            return estimate if condition(estimate) else None
        return await_true(sent, what)

    def hold(self, pull=0.3):
        """The margin of this contact, when slipd says it."""
        self.send_until(NOTHING, lambda each: each.state == "no_contact", "the zero")
        return self.send_until(contact(1, pull), lambda each: each.gamma is not None and abs(each.gamma - (1 - pull)) < MARGIN_ERROR,
                               f"the margin {1 - pull}")

    def never_a_margin(self, messages):
        """None of these messages gives a margin once slipd has heard nothing for a second."""
        await_true(lambda: self.estimate().state == "fault", "a fault")
        for number, message in enumerate(messages):
            self.publisher.send(message)
            time.sleep(1 / RATE_HZ)
            estimate = self.estimate()
            self.assertEqual((estimate.gamma, estimate.state), (None, "fault"), number)


class Arrays(Bed):
    def test_frames_of_arrays_give_the_margin_of_the_contact(self):
        self.start()
        self.hold(0.3)
        self.hold(0.6)
        counts = self.program.end()
        self.assertEqual((counts["corrupt"], counts["repeated"], counts["other"]), (0, 0, 0))


if __name__ == "__main__":
    unittest.main(verbosity=2)
