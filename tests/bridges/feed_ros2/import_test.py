"""slipctl import: MCAP files that @mcap/core has written become recordings, which the driver replay plays to the margin of the contact.

Needs npm (tools/setup --peers); the messages are made by @foxglove/rosmsg2-serialization from the .msg texts below."""
import json, os, struct, subprocess, sys, tempfile, unittest

import slipd
from awaiting import PATIENCE_S, await_true
from python_test import Daemon

sys.path.insert(0, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "tests", "clients"))
from push_test import HELD, NOTHING, PITCH_M, RATE_HZ, SIDE, contact  # contacts of Cattaneo and Mindlin, in Pa

BUILD, SOURCE, NPM = (os.environ[f"SLIPD_{name}"] for name in ("BINARY_DIR", "SOURCE_DIR", "PEERS_NPM"))
BEGIN_NS, PERIOD_NS = 1_700_000_000_000_000_000, 10_000_000
LINE = "=" * 80 + "\n"
HEADER = (f"{LINE}MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
          f"{LINE}MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n")
TYPES = {
    "array": ("std_msgs/msg/Float32MultiArray",
              f"std_msgs/MultiArrayLayout layout\nfloat32[] data\n{LINE}MSG: std_msgs/MultiArrayLayout\nMultiArrayDimension[] dim\nuint32 data_offset\n"
              f"{LINE}MSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n"),
    "cloud": ("sensor_msgs/msg/PointCloud2",
              "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\n"
              f"uint32 row_step\nuint8[] data\nbool is_dense\n{LINE}MSG: sensor_msgs/PointField\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n{HEADER}"),
    "wrench": ("geometry_msgs/msg/WrenchStamped",
               f"std_msgs/Header header\ngeometry_msgs/Wrench wrench\n{LINE}MSG: geometry_msgs/Wrench\ngeometry_msgs/Vector3 force\n"
               f"geometry_msgs/Vector3 torque\n{LINE}MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n{HEADER}")}
FRAMES = [NOTHING] * 100 + [contact(1, 0.003 * step) for step in range(100)] + [HELD] * 50


def header(time_ns):
    return {"stamp": {"sec": time_ns // 10 ** 9, "nanosec": time_ns % 10 ** 9}, "frame_id": "finger"}


def array(frame, _time_ns):
    return {"layout": {"dim": [], "data_offset": 0}, "data": [value for taxel in frame for value in taxel]}


def cloud(frame, time_ns):
    fields = [{"name": name, "offset": 4 * i, "datatype": 7, "count": 1} for i, name in enumerate("xyz")]
    return {"header": header(time_ns), "height": SIDE, "width": SIDE, "fields": fields, "is_bigendian": False, "point_step": 12,
            "row_step": 12 * SIDE, "data": b"".join(struct.pack("<3f", *taxel) for taxel in frame).hex(), "is_dense": True}


def wrench(force, time_ns):
    return {"header": header(time_ns), "wrench": {"force": dict(zip("xyz", force)), "torque": {"x": 0, "y": 0, "z": 0}}}


class Import(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        if not os.path.isdir(os.path.join(NPM, "node_modules")):
            self.skipTest("the npm packages are not installed: run the test ros2.peers.npm")

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def profile(self, **keys):
        with open(self.path("profile.json"), "w", encoding="utf-8") as file:
            json.dump({"description": "this test", "tested": "synthetic", "source": "this test", "topic": "/taxels", "unit": "Pa", **keys}, file)
        return self.path("profile.json")

    ARRAY = {"type": "std_msgs/Float32MultiArray", "columns": [0, 1, 2], "array": {"row": 3}}

    def record(self, kind, messages, compression="zstd", encoding="cdr"):
        """messages: (time_ns, message or bytes). Another topic stands in the file, too."""
        name, definition = TYPES[kind]
        lines = [{"/taxels": {"name": name, "definition": definition, "encoding": encoding},
                  "/other": {"name": TYPES["wrench"][0], "definition": TYPES["wrench"][1]}}]
        for time_ns, message in messages:
            lines.append({"topic": "/other", "log_ns": str(time_ns), "publish_ns": str(time_ns), "message": wrench((1, 2, 3), time_ns)})
            what = {"bytes": message.hex()} if isinstance(message, bytes) else {"message": message}
            lines.append({"topic": "/taxels", "log_ns": str(time_ns + 1000), "publish_ns": str(time_ns), **what})
        subprocess.run(["node", os.path.join(SOURCE, "tests/bridges/ros2/peers/record.mjs"), self.path("in.mcap"), compression], cwd=NPM,
                       input="\n".join(map(json.dumps, lines)), text=True, check=True, timeout=PATIENCE_S)

    def importing(self, *options, grid=True, profile=None):
        layout = ("--grid", f"{SIDE}x{SIDE}", "--pitch-mm", f"{1e3 * PITCH_M}") if grid else ()
        return subprocess.run([os.path.join(BUILD, "bin", "slipctl"), "import", self.path("in.mcap"), self.path("out.rec"), "--force", "--profile",
                               profile or self.path("profile.json"), *layout, *options], capture_output=True, text=True, timeout=PATIENCE_S, check=False)

    def imported(self, *options, **more):
        done = self.importing(*options, **more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def play(self, layout, condition, **estimator):
        """The first estimate of the recording for which it holds."""
        daemon = Daemon.__new__(Daemon)
        daemon.folder, daemon.socket, daemon.settings = self.folder, self.path("socket"), self.path("slipd.json")
        sensor = {"name": "left", "driver": "replay", "rate_hz": RATE_HZ, "layout": layout, "options": {"file": self.path("out.rec"), "loop": True}}
        with open(daemon.settings, "w", encoding="utf-8") as file:
            json.dump({"socket": {"path": daemon.socket}, "realtime": {"mode": "off"}, **estimator, "sensors": [{**sensor, **({"friction": 0.5} if not estimator else {})}]}, file)
        daemon.start()
        self.addCleanup(daemon.close)
        with slipd.Client(daemon.socket, timeout_s=PATIENCE_S) as client:
            return await_true(lambda: condition(client.gamma("left", max_age_s=PATIENCE_S)), "such an estimate")

    GRID = {"grid": [SIDE, SIDE], "pitch_mm": 1e3 * PITCH_M}
    MOMENTS = {"estimator": {"method": "moments", "tracking": False}}

    def holds(self):
        self.play(self.GRID, lambda each: each.gamma is not None and abs(each.gamma - 0.7) < 0.1, **self.MOMENTS)

    def messages(self, make, frames=FRAMES):
        return [(BEGIN_NS + i * PERIOD_NS, make(frame, BEGIN_NS + i * PERIOD_NS)) for i, frame in enumerate(frames)]

    def test_arrays_of_a_recorder_replay_to_the_margin_of_the_contact(self):
        self.profile(**self.ARRAY)
        self.record("array", self.messages(array))
        self.assertIn(f"{len(FRAMES)} frames\n", self.imported())
        self.holds()

    def test_clouds_do_so_too_and_with_each_compression(self):
        self.profile(type="sensor_msgs/PointCloud2", fields=["x", "y", "z"])
        sizes = set()
        for compression in ("none", "zstd", "unchunked"):
            self.record("cloud", self.messages(cloud), compression)
            self.assertIn(f"{len(FRAMES)} frames\n", self.imported(), compression)
            with open(self.path("out.rec"), "rb") as file:
                sizes.add(file.read())
        self.assertEqual(len(sizes), 1, "the recordings are the same")
        self.holds()

    def test_a_wrench_is_a_recording_of_one_force(self):
        forces = [(0, 0, 0)] * 100 + [(0, 0.02 * min(step, 50), 4) for step in range(150)]
        self.record("wrench", self.messages(wrench, forces))
        self.imported("--topic", "/taxels", "--grid", "1x1", "--pitch-mm", "20", grid=False, profile="wrench")
        self.play({"grid": [1, 1], "pitch_mm": 20}, lambda each: each.gamma is not None and abs(each.gamma - 0.5) < 0.1)

    def test_what_slipctl_exports_it_imports_again(self):
        """LZ4 is what export compresses by."""
        self.profile(**self.ARRAY)
        self.record("array", self.messages(array))
        self.imported()
        exported = self.path("out.mcap")
        subprocess.run([os.path.join(BUILD, "bin", "slipctl"), "export", self.path("out.rec"), "--mcap", exported], check=True, timeout=PATIENCE_S)
        os.replace(exported, self.path("in.mcap"))
        self.imported("--topic", "/slipd/sensor/taxels", profile="cloud-slipd")
        self.holds()

    def test_messages_that_are_no_frame_are_counted_and_left_out(self):
        self.profile(**self.ARRAY)
        messages = self.messages(array, FRAMES[:20])
        nan = array(FRAMES[0], 0)
        nan["data"] = nan["data"][1:]
        broken = [(BEGIN_NS + 1, b""), (BEGIN_NS + 2, b"\0\1\0\0\xff\xff"), (BEGIN_NS + 3, nan), (BEGIN_NS - 5, array(FRAMES[0], 0))]
        self.record("array", messages[:1] + broken + messages[1:])
        done = self.importing()
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("20 frames; left out 3 corrupt, 1 repeated, 0 other", done.stderr)

    def test_a_file_that_was_cut_gives_what_is_whole_and_says_where_it_ends(self):
        self.profile(**self.ARRAY)
        self.record("array", self.messages(array))
        with open(self.path("in.mcap"), "r+b") as file:
            file.truncate(os.path.getsize(self.path("in.mcap")) // 2)
        done = self.importing()
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"byte \d+: the file was cut")
        frames = int(done.stderr.split(" frames")[0].rsplit(" ", 1)[1])
        self.assertTrue(0 < frames < len(FRAMES), frames)

    def test_a_damaged_chunk_is_left_out_and_told(self):
        self.profile(**self.ARRAY)
        self.record("array", self.messages(array), "none")
        with open(self.path("in.mcap"), "r+b") as file:
            file.seek(os.path.getsize(self.path("in.mcap")) // 2)
            byte = file.read(1)
            file.seek(-1, os.SEEK_CUR)
            file.write(bytes([byte[0] ^ 0x55]))
        done = self.importing()
        self.assertEqual(done.returncode, 1)
        self.assertIn("damaged", done.stderr)

    def test_wrong_options_and_files_are_refused_with_what_to_do(self):
        self.profile(**self.ARRAY)
        self.record("array", self.messages(array, FRAMES[:3]))
        for options, remedy in ((("--topic", "/none"), "it has /other (geometry_msgs/msg/WrenchStamped), /taxels"),
                                (("--topic", "/other"), "the profile says std_msgs/msg/Float32MultiArray"),
                                (("--grid", "24"), "COLUMNSxROWS"), (("--taxels-mm", "0,0"), "give the layout")):
            with self.subTest(options):
                done = self.importing(*options) if options[0] != "--grid" else self.importing(*options, grid=False)
                self.assertEqual(done.returncode, 1, done.stderr)
                self.assertIn(remedy, done.stderr)
        self.profile(**{**self.ARRAY, "unit": "counts"})
        self.assertIn("give --scale", self.importing().stderr)
        with open(self.path("in.mcap"), "w", encoding="utf-8") as file:
            file.write("no such file")
        self.profile(**self.ARRAY)
        self.assertIn("is no MCAP file", self.importing().stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
