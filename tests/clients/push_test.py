"""Frames from programs: the driver push of the real slipd, and both clients, the Python module and libslipd (by ctypes).

The pushed frames are contacts of Cattaneo and Mindlin, whose margin is known."""
import array, ctypes, json, math, os, random, signal, struct, subprocess, sys, tempfile, time, unittest

import slipd
from python_test import OLD_S, PATIENCE_S, Daemon

sys.path.insert(0, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "tests", "support"))
from awaiting import await_true

BUILD = os.environ["SLIPD_BINARY_DIR"]
SIDE, PITCH_M = 24, 0.25e-3
RATE_HZ = 100
FRICTION, RADIUS_M, PEAK_PA = 0.5, 2.5e-3, 30e3
MARGIN_ERROR = 0.1  # of single frames by `moments`, on taxels a tenth of the radius wide
FEWEST_MARGINS = 40  # of 150 frames with a load: fewer, and slipd was not watching


def contact(press, pull):
    """A frame of SIDE x SIDE taxels, [x, y, z] each, in Pa. `pull`: of the largest tangential force; the margin is 1 - pull."""
    a = RADIUS_M * press ** (1 / 3)
    c = a * (1 - pull) ** (1 / 3)
    hertz = lambda r, radius, peak: peak * math.sqrt(1 - (r / radius) ** 2) if r < radius else 0.0
    frame = []
    for row in range(SIDE):
        for column in range(SIDE):
            r = math.hypot(column - (SIDE - 1) / 2, row - (SIDE - 1) / 2) * PITCH_M
            normal = hertz(r, a, PEAK_PA * press ** (1 / 3))
            stuck = hertz(r, c, PEAK_PA * press ** (1 / 3)) * c / a if c > 0 else 0.0
            frame.append([FRICTION * (normal - stuck), 0.0, normal])
    return frame


NOTHING = [[0.0, 0.0, 0.0]] * SIDE ** 2
HELD = contact(1, 0.3)


SKIN = {"layout": {"grid": [SIDE, SIDE], "pitch_mm": 1e3 * PITCH_M}}
# Five magnetometers, as config/scenes/eflesh.json has them.
FIELD = {"layout": {"taxels": [[0, 0], [-6, 0], [6, 0], [0, -6], [0, 6]]}, "skin": {"radius_mm": "flat", "modulus_mpa": 0.5, "poisson": 0.45}}


class Scene(Daemon):
    """slipd with one sensor whose frames come from programs, that calls no frame old: other programs may run, too."""

    def __init__(self, skin=SKIN, **options):
        self.folder = tempfile.TemporaryDirectory()
        self.socket = os.path.join(self.folder.name, "socket")
        self.settings = os.path.join(self.folder.name, "slipd.json")
        finger = {"name": "left", "driver": "push", "rate_hz": RATE_HZ, **skin,
                  "options": {"max_age_ms": 10000, **options}}
        with open(self.settings, "w") as file:
            json.dump({"socket": {"path": self.socket}, "realtime": {"mode": "off"}, "estimator": {"method": "moments", "tracking": False},
                       "sensors": [finger]}, file)
        self.start()


class CFrames(ctypes.Structure):
    _fields_ = [("taxels", ctypes.c_uint32), ("axes", ctypes.c_int32), ("unit", ctypes.c_int32), ("zero", ctypes.c_int32),
                ("rate_hz", ctypes.c_double)]


class CSource:
    """libslipd's source with the interface of the Python one."""

    UNITS, ZEROS = {None: 0, "Pa": 1, "N": 2, "counts": 3, "uT": 4}, {None: 0, False: 1, True: 2}
    TIMEOUT, DISCONNECTED, REFUSED = 1, -1, -2

    def __init__(self, sensor, *, taxels, axes=3, rate_hz=0.0, unit=None, zeroed=None, path, timeout_s=PATIENCE_S):
        self.library = ctypes.CDLL(os.path.join(BUILD, "lib", "libslipd.so.0"))
        self.library.slipd_source_error.restype = ctypes.c_char_p
        self.source, self.timeout_s = ctypes.c_void_p(), ctypes.c_double(timeout_s)
        frames = CFrames(taxels, axes, self.UNITS[unit], self.ZEROS[zeroed], rate_hz)
        code = self.library.slipd_source_open(ctypes.byref(self.source), sensor.encode(), path.encode(), ctypes.byref(frames))
        assert code == 0, code

    def __enter__(self):
        self.connect()
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.library.slipd_source_close(self.source)
        self.source = ctypes.c_void_p()

    def connect(self):
        self.check(self.library.slipd_source_connect(self.source, self.timeout_s))

    def push(self, frame, *, time_ns=0, sequence=0):
        values = array.array("f", [value for taxel in frame for value in taxel])
        address, _ = values.buffer_info()
        self.check(self.library.slipd_push(self.source, ctypes.c_void_p(address), ctypes.c_int64(time_ns), ctypes.c_uint64(sequence),
                                           self.timeout_s))

    def check(self, code):
        text = self.library.slipd_source_error(self.source).decode()
        if code == self.REFUSED:
            raise slipd.SlipdError(code, text)
        if code == self.DISCONNECTED:
            raise slipd.Disconnected(text)
        if code != 0:
            raise TimeoutError(text)


# A program that pushes contacts until it is ended, and says when slipd has taken it.
WRITER = """
import sys, time
sys.path.insert(0, sys.argv[2])
import push_test, slipd
with slipd.Source("left", taxels=push_test.SIDE ** 2, unit="Pa", zeroed=True, path=sys.argv[1], timeout_s=push_test.PATIENCE_S) as source:
    print("accepted", flush=True)
    while True:
        source.push(push_test.HELD)
        time.sleep(1 / push_test.RATE_HZ)
"""


class Writer:
    """That program."""

    def __init__(self, daemon):
        self.process = subprocess.Popen([sys.executable, "-c", WRITER, daemon.socket, os.path.dirname(os.path.abspath(__file__))],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.process.stdout.readline() == "accepted\n", self.process.stderr.read()

    def end(self, how=signal.SIGKILL):
        """What it said of its error."""
        self.process.send_signal(how)
        _, errors = self.process.communicate(timeout=PATIENCE_S)
        return errors


class Scenarios:
    """Of each client; `make` makes its source."""

    skin = SKIN

    def setUp(self):
        self.daemon = Scene(self.skin)
        self.addCleanup(self.daemon.close)
        self.client = slipd.Client(self.daemon.socket, timeout_s=PATIENCE_S)
        self.addCleanup(self.client.close)
        self.await_socket()

    def await_socket(self):
        await_true(lambda: os.path.exists(os.path.join(self.daemon.folder.name, "push", "left")), "the sensor's socket")

    def source(self, **more):
        """Of frames in Pa that read 0 without load."""
        return self.make("left", path=self.daemon.socket, timeout_s=PATIENCE_S,
                         **{"taxels": SIDE ** 2, "rate_hz": RATE_HZ, "unit": "Pa", "zeroed": True, **more})

    def sensor(self):
        return self.client.call("status")["sensors"][0]

    def await_sensor(self, condition, what):
        return await_true(lambda: condition(self.sensor()), what)

    def push_until(self, source, frame, condition, what):
        """Pushes the frame, or what a function returns, at the sensor's rate until the sensor's status is so."""
        def pushed():
            source.push(frame() if callable(frame) else frame)
            time.sleep(1 / RATE_HZ)
            return condition(self.sensor())
        return await_true(pushed, what)

    def refusal(self, **hello):
        with self.assertRaises(slipd.SlipdError) as refused:
            self.source(**hello).connect()
        return str(refused.exception)

    def states(self):
        """The states as they change; the first is that of now."""
        return (estimate.state for estimate in self.client.estimates("left", max_age_s=OLD_S, events=("state",)))


    def ends_in_fault(self, states):
        """A program that the machine held up for a moment was stale before, and went on."""
        seen = [next(states)]
        while seen[-1] != "fault":
            seen.append(next(states))
        self.assertEqual(seen[-2:], ["stale", "fault"], seen)


class MarginScenarios(Scenarios):
    def test_pushed_frames_give_margins_that_are_those_of_the_contact(self):
        pulls, frames, truth = [0.006 * i for i in range(150)], 20 + 30, {}
        with self.source() as source:
            estimates = self.client.estimates("left", max_age_s=OLD_S)
            next(estimates)  # the subscription is made
            for sequence in range(1, frames + len(pulls) + 1):
                pull = pulls[sequence - frames - 1] if sequence > frames else 0.0
                press = min(1.0, max(0.0, (sequence - 20) / 30))
                truth[sequence] = 1 - pull
                source.push(contact(press, pull) if press > 0 else NOTHING, sequence=sequence)
                time.sleep(1 / RATE_HZ)
            last = sequence
            found = {}
            for estimate in estimates:
                if estimate.gamma is not None:
                    found[estimate.seq] = estimate.gamma
                if estimate.seq == last:
                    break
        sensor = self.sensor()
        self.assertEqual((sensor["received"], sensor["corrupt"], sensor["lost"]), (last, 0, 0), sensor)
        self.assertEqual(sensor["estimated"] + sensor["skipped"], last)
        self.assertGreaterEqual(len(found), FEWEST_MARGINS)
        for sequence, gamma in found.items():
            self.assertAlmostEqual(gamma, truth[sequence], delta=MARGIN_ERROR, msg=f"frame {sequence}")

    def test_a_killed_program_is_stale_then_fault_and_the_next_is_served_at_once(self):
        writer = Writer(self.daemon)
        self.addCleanup(writer.end)
        states = self.states()
        while next(states) != "ok":
            pass
        writer.end(signal.SIGKILL)
        self.ends_in_fault(states)
        self.assertIn("no program is connected", self.sensor()["trouble"])
        writer = Writer(self.daemon)
        while (state := next(states)) != "ok":
            self.assertEqual(state, "stale", "the sensor is there again, and its first frame is on its way")
        writer.end(signal.SIGKILL)
        received = self.sensor()["received"]
        with self.source() as source:  # without waiting for anything
            source.push(HELD)
        self.await_sensor(lambda sensor: sensor["received"] > received, "the next program's frame")

    def test_a_program_that_hangs_is_stale_then_fault_and_loses_its_place_to_the_next_and_is_told(self):
        writer = Writer(self.daemon)
        self.addCleanup(writer.process.kill)
        states = self.states()
        while next(states) != "ok":
            pass
        writer.process.send_signal(signal.SIGSTOP)
        self.ends_in_fault(states)
        with self.source() as source:
            self.push_until(source, HELD, lambda sensor: sensor["state"] == "ok", "a margin of the next program")
            self.assertIn("another one sends the frames now", writer.end(signal.SIGCONT))

    def test_a_second_program_is_refused_and_told_who_is_the_first(self):
        writer = Writer(self.daemon)
        self.addCleanup(writer.end)
        self.assertIn(f"another program (process {writer.process.pid})", self.refusal())

    def test_frames_after_a_pause_that_come_at_once_are_all_taken(self):
        with self.source() as source:
            source.push(NOTHING)
            self.await_sensor(lambda sensor: sensor["state"] == "stale", "the pause")
            received = self.sensor()["received"]
            begun_ns = time.monotonic_ns()
            for i in range(30):  # of samples a millisecond apart
                source.push(NOTHING, time_ns=begun_ns - (30 - i) * 1_000_000)
            self.await_sensor(lambda sensor: sensor["received"] == received + 30, "the burst")
            self.assertEqual(self.sensor()["corrupt"], 0)

    def test_a_value_that_is_no_number_is_counted_and_never_a_margin(self):
        odd = [*HELD[:-1], [math.nan, 0.0, 0.0]]
        with self.source() as source:
            self.push_until(source, odd, lambda sensor: sensor["corrupt"] >= 20, "frames that are counted")
            sensor = self.sensor()
            self.assertEqual(sensor["received"], 0)
            self.assertIn(sensor["state"], ("stale", "fault"))
            self.push_until(source, odd, lambda sensor: "values that are not finite" in (sensor["trouble"] or ""), "the reason")

    def test_what_contradicts_the_configuration_is_refused_and_named(self):
        self.assertIn("9 taxels, the layout in the configuration has 576", self.refusal(taxels=9))
        self.assertIn("neither the program nor options.unit", self.refusal(unit=None))
        self.assertIn("1000 frames a second, rate_hz in the configuration is 100", self.refusal(rate_hz=1000))

    def test_a_program_goes_on_after_slipd_was_restarted(self):
        source = self.source()
        source.push(NOTHING)
        self.await_sensor(lambda sensor: sensor["received"] == 1, "the first frame")
        self.daemon.end(signal.SIGKILL)
        with self.assertRaises(slipd.Disconnected):
            source.push(NOTHING)
        with self.assertRaises(slipd.Disconnected):
            source.push(NOTHING)
        self.daemon.start()

        def pushed():
            try:
                source.push(NOTHING)
                return True
            except slipd.Disconnected:
                return False
        await_true(pushed, "a slipd that takes frames")
        self.await_sensor(lambda sensor: sensor["received"] >= 1, "a frame")
        source.close()

    def test_a_reload_ends_the_connection_and_the_next_push_makes_a_new_one(self):
        with self.source() as source:
            source.push(NOTHING)
            self.daemon.process.send_signal(signal.SIGHUP)

            def lost():
                try:
                    source.push(NOTHING)
                except slipd.Disconnected:
                    return True
                time.sleep(1 / RATE_HZ)
                return False
            await_true(lost, "the end of the connection")

            def served():
                try:
                    source.push(NOTHING)
                except slipd.Disconnected:
                    return False
                return self.sensor()["received"] > 0
            await_true(served, "a frame of the new connection")


class SlidingScenarios(Scenarios):
    """Microtesla of an unknown scale."""

    skin = FIELD

    def test_a_field_gives_sliding_and_never_a_margin_whatever_zero_is_asked_for(self):
        states, noise = set(), random.Random(1)

        def field():
            return [[100.0 + i + noise.gauss(0, 0.5), noise.gauss(-50, 0.5), 30.0 * i + noise.gauss(0, 0.5)] for i in range(5)]

        def watched(sensor):
            states.add(sensor["state"])
            return sensor["sliding"] == "none" and sensor["received"] > 50
        with self.source(unit="uT", taxels=5) as source:
            self.push_until(source, field, watched, "a word about sliding")
            with self.assertRaisesRegex(slipd.SlipdError, "unknown scale"):
                self.client.call("rebias", {"sensor": "left", "force": True})
            self.push_until(source, field, lambda sensor: watched(sensor) and sensor["received"] > 300, "more frames than a zero takes")
        self.assertIn("unzeroed", states)
        self.assertLessEqual(states, {"unzeroed", "stale", "fault", "learning"})


class Gel(Scenarios, unittest.TestCase):
    make = slipd.Source
    skin = {"layout": {"grid": [9, 7], "pitch_mm": 1.8}}

    def pressed(self, by_mm):
        """A function that gives frames of a gel that something presses outwards; with a dot's noise."""
        def frame():
            values = []
            for row in range(7):
                for column in range(9):
                    x, y = 1.8 * (column - 4), 1.8 * (row - 3)
                    each = by_mm / 2 * math.exp(-(x * x + y * y) / 8)
                    values.append([each * x + self.noise.gauss(0, 0.0025), each * y + self.noise.gauss(0, 0.0025), 0.0])
            return values
        return frame

    def hold(self, source):
        self.push_until(source, self.pressed(0), lambda sensor: sensor["received"] > 40, "a gel at rest")
        held = self.sensor()["received"] + 40
        self.push_until(source, self.pressed(0.4), lambda sensor: sensor.get("contact") and sensor["received"] > held, "a gel that holds something")

    def alerts_while_it_relaxes(self, source):
        let_go, alerts = self.sensor()["received"] + 60, set()

        def seen(sensor):
            alerts.add(sensor["alert"])
            return sensor["received"] > let_go
        self.push_until(source, self.pressed(0), seen, "a gel that relaxes")
        return alerts

    def setUp(self):
        super().setUp()
        self.noise = random.Random(1)

    def sensor(self):
        return {**super().sensor(), **self.client.call("gamma")["sensors"][0]}

    def test_that_relaxes_is_a_slip_unless_the_robot_says_that_it_lets_go_and_then_only_for_a_while(self):
        with self.source(unit="mm", taxels=63, zeroed=True) as source:
            self.hold(source)
            self.assertEqual(self.client.call("releasing", {"seconds": 60}), {"sensors": ["left"], "seconds": 60})
            self.assertNotIn("slip", self.alerts_while_it_relaxes(source))
            self.assertEqual((self.sensor()["alert"], self.sensor()["sliding"]), ("unknown", None))

            self.client.call("releasing", {"sensor": "left", "seconds": 0})

            def slips():  # where the machine holds the program up, its pictures have no past to be compared with
                self.hold(source)
                return "slip" in self.alerts_while_it_relaxes(source)
            await_true(slips, "a slip that is told")

    def test_silence_has_an_end_and_is_for_gels(self):
        for seconds in (-1, 61, "2", None):
            with self.assertRaisesRegex(slipd.SlipdError, "0 to 60"):
                self.client.call("releasing", {"seconds": seconds})
        with self.assertRaisesRegex(slipd.SlipdError, "no sensor here sees displacements"):
            self.client.call("releasing", {"seconds": 1})
        with self.source(unit="mm", taxels=63, zeroed=True) as source:
            self.hold(source)
            self.client.call("releasing", {"seconds": 0.2})
            self.push_until(source, self.pressed(0.4), lambda sensor: sensor["alert"] == "unknown", "silence")
            self.push_until(source, self.pressed(0.4), lambda sensor: sensor["alert"] == "none", "its end")


class LargeScenarios:
    """Frames whose values go through shared memory."""

    SIDE = 48

    def setUp(self):
        self.daemon = Scene({"layout": {"grid": [self.SIDE, self.SIDE], "pitch_mm": 0.25}})
        self.addCleanup(self.daemon.close)
        await_true(lambda: os.path.exists(os.path.join(self.daemon.folder.name, "push", "left")), "the sensor's socket")
        self.client = slipd.Client(self.daemon.socket)
        self.addCleanup(self.client.close)

    def sensor(self):
        return self.client.call("status")["sensors"][0]

    def shares(self, process):
        with open(f"/proc/{process}/maps") as maps:
            return any("memfd:slipd-push" in line for line in maps)

    def test_large_frames_come_whole_through_shared_memory_and_none_is_lost(self):
        with self.make("left", taxels=self.SIDE ** 2, rate_hz=RATE_HZ, unit="Pa", zeroed=True, path=self.daemon.socket) as source:
            for number in range(1, 31):
                values = [[float(number), float(i), float(i % 100)] for i in range(self.SIDE ** 2)]
                source.push(values)
                await_true(lambda: self.sensor()["received"] == number, "the frame")
                frame = self.client.call("frame", {"sensor": "left"})
                self.assertEqual([list(taxel) for taxel in zip(frame["shear_x_pa"], frame["shear_y_pa"], frame["normal_pa"])], values, number)
            self.assertTrue(self.shares(os.getpid()) and self.shares(self.daemon.process.pid), "shared memory")
        sensor = self.sensor()
        self.assertEqual((sensor["corrupt"], sensor["lost"]), (0, 0))

    def test_more_frames_at_once_than_there_are_slots_all_come(self):
        with self.make("left", taxels=self.SIDE ** 2, rate_hz=RATE_HZ, unit="Pa", zeroed=True, path=self.daemon.socket) as source:
            self.daemon.stand_still()
            try:
                for number in range(1, 7):
                    source.push([[0.0, 0.0, float(number)]] * self.SIDE ** 2)
            finally:
                self.daemon.process.send_signal(signal.SIGCONT)
            await_true(lambda: self.sensor()["received"] == 6, "all frames")
            self.assertEqual((self.sensor()["corrupt"], self.sensor()["lost"]), (0, 0))


class PythonLarge(LargeScenarios, unittest.TestCase):
    make = slipd.Source


class CLarge(LargeScenarios, unittest.TestCase):
    make = CSource


class PythonMargins(MarginScenarios, unittest.TestCase):
    make = slipd.Source

    def frame(self, source, values):
        """What slipd got of it, as x, y and z of each taxel in turn."""
        received = self.sensor()["received"]
        source.push(values)
        self.await_sensor(lambda sensor: sensor["received"] > received, "the frame")
        frame = self.client.call("frame", {"sensor": "left"})
        return [value for taxel in zip(frame["shear_x_pa"], frame["shear_y_pa"], frame["normal_pa"]) for value in taxel]

    def test_a_frame_may_be_a_list_nested_or_not_a_buffer_bytes_or_an_array_of_numpy(self):
        flat = [float(i % 100) for i in range(3 * SIDE ** 2)]
        nested = [flat[3 * i:3 * i + 3] for i in range(SIDE ** 2)]
        grid = [nested[SIDE * row:SIDE * (row + 1)] for row in range(SIDE)]
        forms = [flat, tuple(flat), nested, grid, array.array("f", flat), array.array("d", flat), struct.pack(f"<{len(flat)}f", *flat),
                 [int(value) for value in flat]]
        if slipd.numpy is not None:
            made = slipd.numpy.array(nested)
            forms += [made, made.astype("f4"), made.astype(">f4"), made.astype(int), made.reshape(SIDE, SIDE, 3), slipd.numpy.asfortranarray(made)]
        with self.source() as source:
            for form in forms:
                self.assertEqual(self.frame(source, form), flat, type(form))

    def test_the_module_needs_no_numpy(self):
        numpy, slipd.numpy = slipd.numpy, None
        try:
            self.test_a_frame_may_be_a_list_nested_or_not_a_buffer_bytes_or_an_array_of_numpy()
        finally:
            slipd.numpy = numpy

    def test_a_frame_of_another_size_is_an_error_before_anything_is_sent(self):
        with self.source() as source:
            with self.assertRaisesRegex(ValueError, "has 3 values; expected 1728"):
                source.push([1, 2, 3])
            source.push(NOTHING)
            self.await_sensor(lambda sensor: sensor["received"] == 1 and sensor["corrupt"] == 0, "the frame")

    def test_a_unit_of_which_slipd_has_no_idea_is_an_error(self):
        with self.assertRaisesRegex(ValueError, "Pa, N, counts, uT or mm"):
            self.source(unit="inch")

    def test_torn_and_foreign_messages_are_counted_and_the_program_may_go_on(self):
        with self.source() as source:
            source.push(NOTHING)
            for message in (b"x", b"slippush", bytes(24), bytes(100000)):
                source._socket.send(message)
            source.push(NOTHING)
            self.await_sensor(lambda sensor: sensor["received"] == 2 and sensor["corrupt"] == 4, "the counts")

    def test_without_slipd_the_error_says_what_to_do(self):
        with self.assertRaisesRegex(slipd.Disconnected, "does not run here, or its configuration has no sensor"):
            slipd.Source("right", taxels=1, path=self.daemon.socket).connect()


class CMargins(MarginScenarios, unittest.TestCase):
    make = CSource


class PythonSliding(SlidingScenarios, unittest.TestCase):
    make = slipd.Source


class CSliding(SlidingScenarios, unittest.TestCase):
    make = CSource


class Example(unittest.TestCase):
    def test_the_program_of_the_first_sensors_page_sees_its_sensor_zeroed_by_itself(self):
        daemon = Scene({"layout": {"grid": [4, 4], "pitch_mm": 4}})
        self.addCleanup(daemon.close)
        await_true(lambda: os.path.exists(os.path.join(daemon.folder.name, "push", "left")), "the sensor's socket")
        program = subprocess.Popen([sys.executable, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "examples", "push.py"), "left", daemon.socket],
                                   stdout=subprocess.PIPE, text=True)
        self.addCleanup(program.communicate)
        self.addCleanup(program.kill)
        for line in program.stdout:
            if line.startswith("no_contact None"):
                break
        else:
            self.fail("the program ended")


class Socket(unittest.TestCase):
    def test_a_program_that_may_not_send_is_told_to_join_the_group(self):
        if os.geteuid() != 0:
            self.skipTest("takes root, to be another user")
        daemon = Scene(mode="0600")
        self.addCleanup(daemon.close)
        os.chmod(daemon.folder.name, 0o755)
        await_true(lambda: os.path.exists(os.path.join(daemon.folder.name, "push", "left")), "the sensor's socket")
        program = ("import os, sys, slipd; os.setuid(65534)\n"
                   f"try: slipd.Source('left', taxels={SIDE ** 2}, unit='Pa', path=sys.argv[1]).connect()\n"
                   "except slipd.Disconnected as error: print(error)")
        told = subprocess.run([sys.executable, "-c", program, daemon.socket], capture_output=True, text=True)
        self.assertIn("become a member of the group", told.stdout, told.stderr)


if __name__ == "__main__":
    unittest.main()
