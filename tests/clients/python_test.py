"""clients/python/slipd against the real slipd."""
import asyncio, contextlib, io, itertools, json, os, re, signal, subprocess, sys, tempfile, threading, time, unittest

import slipd

PROGRAM = os.path.join(os.environ["SLIPD_BINARY_DIR"], "bin", "slipd")
PATIENCE_S = 300  # for what hangs: far longer than anything takes on a machine that does much else
OLD_S = 3600  # no estimate of these tests is as old


class Daemon:
    """slipd with two simulated fingers that hold one object."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.socket = os.path.join(self.folder.name, "socket")
        self.settings = os.path.join(self.folder.name, "slipd.json")
        finger = {"driver": "sim", "rate_hz": 200, "layout": {"grid": [16, 16], "pitch_mm": 0.9}}
        with open(self.settings, "w") as file:
            json.dump({"socket": {"path": self.socket}, "realtime": {"mode": "off"}, "estimator": {"method": "moments"},
                       "sensors": [{"name": "left", **finger}, {"name": "right", **finger}],
                       "grasps": [{"name": "cup", "sensors": ["left", "right"]}]}, file)
        self.start()

    def start(self, *through):
        """`through`: a program with its arguments that becomes slipd."""
        self.process = subprocess.Popen([*through, PROGRAM, "--config", self.settings], stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            if "serves" in line:
                break
        else:
            raise RuntimeError("slipd did not start")
        self.drain = threading.Thread(target=self.process.stderr.read)  # so that it never waits for its log to be read
        self.drain.start()

    def stand_still(self):
        """Returns once all its threads do: on a busy machine they go on until the one that takes the signal is run."""
        self.process.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, self.process.pid, os.WSTOPPED)

    def end(self, how=signal.SIGTERM):
        self.process.send_signal(signal.SIGCONT)
        self.process.send_signal(how)
        self.process.wait(PATIENCE_S)
        self.drain.join()
        self.process.stderr.close()

    def close(self):
        if self.process.returncode is None:
            self.end()
        self.folder.cleanup()


def first(estimates, condition):
    """The first estimate that meets the condition."""
    end = time.monotonic() + PATIENCE_S
    for estimate in estimates:
        if condition(estimate):
            return estimate
        if time.monotonic() > end:
            raise AssertionError(f"it did not come; the last one was {estimate}")


class WithSlipd(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon()
        self.addCleanup(self.daemon.close)
        self.client = slipd.Client(self.daemon.socket, timeout_s=PATIENCE_S)
        self.addCleanup(self.client.close)

    def estimates(self, *sensors, max_age_s=OLD_S, **options):
        iterator = self.client.estimates(*sensors, max_age_s=max_age_s, **options)
        self.addCleanup(iterator.close)
        return iterator

    def test_a_margin_comes_with_its_state_and_age(self):
        estimate = first(self.estimates("left"), lambda each: each.state == "ok")
        self.assertTrue(0 <= estimate.gamma <= 1)
        self.assertTrue(0 <= estimate.age_s < OLD_S)
        self.assertGreater(estimate.normal_n, 0)
        self.assertTrue(estimate.simulated)

    def test_without_a_contact_there_is_no_margin(self):
        estimate = first(self.estimates("left"), lambda each: each.state == "no_contact")
        self.assertIsNone(estimate.gamma)

    def test_a_margin_is_gone_once_it_is_older_than_allowed(self):
        estimate = first(self.estimates("left", max_age_s=1), lambda each: each.state == "ok")
        end = time.monotonic() + PATIENCE_S
        while estimate.state == "ok" and time.monotonic() < end:
            time.sleep(0.01)
        self.assertEqual((estimate.state, estimate.gamma, estimate.gamma_low), ("stale", None, None))

    def test_an_estimate_of_no_frame_has_no_margin_whatever_age_is_allowed(self):
        self.assertIsNone(slipd._estimate({"sensor": "left", "state": "ok", "gamma": 0.9, "age_ms": None}, OLD_S).gamma)

    def test_all_that_slipd_sends_of_an_estimate_is_kept(self):
        first(self.estimates("left"), lambda each: each.seq is not None)
        estimate = self.client.gamma("left", OLD_S)
        self.assertEqual(estimate.values["sensor"], estimate.name)
        known = set(slipd._TAKEN) | {"sensor", "state", "gamma", "gamma_low", "alert", "health", "age_ms"}
        self.assertEqual(known - set(estimate.values), {"dropped"}, "every key that is read exists on the socket")

    def board(self):
        board = slipd.Board(self.daemon.socket, timeout_s=PATIENCE_S)
        self.addCleanup(board.close)
        return board

    def looked(self, board, name, condition, max_age_s=OLD_S):
        return first((board.latest(name, max_age_s) for _ in itertools.count()), condition)

    def test_shared_memory_has_what_the_socket_has(self):
        board = self.board()
        self.looked(board, "left", lambda each: each.state == "ok")
        end = time.monotonic() + PATIENCE_S
        while True:
            shared, sent = board.latest("left", OLD_S), self.client.gamma("left", OLD_S)
            if shared.seq == sent.seq:
                break
            self.assertLess(time.monotonic(), end)
        self.assertEqual((shared.state, shared.alert, shared.health, shared.simulated), (sent.state, sent.alert, sent.health, True))
        for key, factor in slipd._NUMBERS:
            if key in sent.values and sent.values[key] is not None:
                self.assertAlmostEqual(shared.values[key], sent.values[key], msg=key)
        self.assertEqual(shared.values["method"], sent.values["method"])
        self.assertEqual(self.looked(board, "cup", lambda each: each.seq is not None).name, "cup")
        with self.assertRaisesRegex(slipd.SlipdError, "left, right"):
            board.latest("middle", OLD_S)

    def test_a_margin_of_shared_memory_is_gone_once_it_is_older_than_allowed(self):
        board = self.board()
        self.looked(board, "left", lambda each: each.state == "ok")
        for none in (0, -1, float("nan")):
            old = board.latest("left", none)
            self.assertEqual((old.state, old.gamma, old.gamma_low), ("stale", None, None), none)

    def test_shared_memory_tells_of_a_stopped_a_killed_and_a_reloaded_slipd_and_goes_on(self):
        board = self.board()
        self.looked(board, "left", lambda each: each.state == "ok")
        self.daemon.stand_still()
        board.timeout_s = 0.1
        self.assertIsNone(self.looked(board, "left", lambda each: each.state == "disconnected", 0.05).gamma)
        board.timeout_s = PATIENCE_S
        self.daemon.process.send_signal(signal.SIGCONT)
        self.looked(board, "left", lambda each: each.state == "ok")
        before = board.generation
        self.daemon.process.send_signal(signal.SIGHUP)
        self.looked(board, "left", lambda each: board.generation != before and each.state == "ok")
        self.daemon.end(signal.SIGKILL)
        self.looked(board, "left", lambda each: each.state == "disconnected", 1)
        self.daemon.start()
        self.looked(board, "left", lambda each: each.state == "ok")

    def test_a_grasp_is_as_old_as_its_oldest_finger(self):
        for name in ("left", "right"):
            first(self.estimates(name), lambda each: each.seq is not None)
        grasp = self.client.grasp("cup", OLD_S)
        self.assertEqual((grasp.name, grasp.at_state in slipd._STATES), ("cup", True))
        fingers = [{"sensor": "left", "age_ms": 3}, {"sensor": "right", "age_ms": 7}]
        cup = {"grasp": "cup", "sensors": ["left", "right"], "state": "ok", "gamma": 0.5}
        self.assertEqual(slipd._grasp({"sensors": fingers, "grasps": [cup]}, "cup", OLD_S).sent_age_s, 0.007)
        fingers[0]["age_ms"] = None
        self.assertIsNone(slipd._grasp({"sensors": fingers, "grasps": [cup]}, "cup", OLD_S).gamma)

    def test_a_stopped_slipd_is_stale_and_then_goes_on(self):
        estimates = self.estimates("left", max_age_s=0.2)
        first(estimates, lambda each: each.state != "stale")
        self.daemon.stand_still()
        self.assertIsNone(first(estimates, lambda each: each.state == "stale" and each.seq is None).gamma)
        self.daemon.process.send_signal(signal.SIGCONT)
        first(estimates, lambda each: each.seq is not None)

    def test_a_killed_slipd_is_disconnected_and_connected_again_when_it_is_back(self):
        estimates = self.estimates()
        first(estimates, lambda each: each.seq is not None)
        self.daemon.end(signal.SIGKILL)
        gone = [first(estimates, lambda each: each.state == "disconnected") for _ in range(2)]
        self.assertEqual({each.name for each in gone}, {"left", "right"})
        self.assertEqual([each.gamma for each in gone], [None, None])
        self.daemon.start()
        first(estimates, lambda each: each.name == "right" and each.seq is not None)

    def test_requests_go_on_after_a_restart(self):
        before = self.client.status()["pid"]
        self.daemon.end()
        with self.assertRaisesRegex(slipd.Disconnected, "does not run here"):
            self.client.status()
        self.daemon.start()
        self.assertNotEqual(self.client.status()["pid"], before)

    def test_a_reload_ends_no_iterator(self):
        estimates = self.estimates("left")
        seen = first(estimates, lambda each: each.seq is not None)
        self.daemon.process.send_signal(signal.SIGHUP)
        first(estimates, lambda each: each.time_ns is not None and each.time_ns > seen.time_ns)

    def test_losses_of_a_slow_reader_are_counted(self):
        estimates = self.estimates()
        next(estimates)
        received = lambda: sum(each["received"] for each in self.client.status()["sensors"])
        begin, enough = received(), 3000  # more than the socket's buffers hold
        while received() < begin + enough:
            time.sleep(0.05)
        self.assertGreater(first(estimates, lambda each: each.dropped > 0).dropped, 0)

    def test_unknown_names_are_refused_with_those_that_exist(self):
        for refused in (lambda: self.client.gamma("middle", OLD_S), lambda: next(self.estimates("middle")),
                        lambda: self.client.grasp("plate", OLD_S)):
            with self.assertRaises(slipd.SlipdError) as error:
                refused()
            self.assertEqual(error.exception.code, -32001)

    def test_a_frame_has_a_value_for_each_taxel(self):
        first(self.estimates("left"), lambda each: each.seq is not None)
        frame = self.client.frame("left")
        self.assertEqual({len(frame[key]) for key in ("normal_pa", "shear_x_pa", "shear_y_pa", "x_mm", "y_mm")}, {256})

    def test_asyncio_has_the_same(self):
        async def watch():
            async with slipd.AsyncClient(self.daemon.socket, timeout_s=PATIENCE_S) as client:
                self.assertEqual((await client.gamma("left", OLD_S)).name, "left")
                self.assertEqual((await client.grasp("cup", OLD_S)).name, "cup")
                states = set()
                async for estimate in client.estimates("left", max_age_s=OLD_S):
                    states.add(estimate.state)
                    if "ok" in states and estimate.state == "ok":
                        self.daemon.end(signal.SIGKILL)
                    if "disconnected" in states:
                        return states

        self.assertLessEqual({"ok", "disconnected"}, asyncio.run(asyncio.wait_for(watch(), PATIENCE_S)))

    def test_a_recording_is_read_back_as_it_was_written(self):
        path = os.path.join(self.daemon.folder.name, "left.rec")
        answer = self.client.record("left", 0.5, path)
        recording = slipd.open(path)
        frames = list(recording)
        self.assertEqual((len(frames), recording.damaged), (answer["frames"], 0))
        self.assertEqual((recording.sensor, recording.sensor_class, recording.layout["grid"]), ("left", "array3", [16, 16]))
        self.assertTrue(all(a.seq < b.seq and a.time_ns < b.time_ns for a, b in itertools.pairwise(frames)))
        self.assertEqual({len(frame.shear_y_pa) for frame in frames}, {256})

    def test_a_damaged_block_is_left_out_and_counted(self):
        path = os.path.join(self.daemon.folder.name, "left.rec")
        self.client.record("left", 1, path)
        whole = {frame.seq for frame in slipd.open(path)}
        with open(path, "r+b") as file:
            blocks = [at for at in range(os.path.getsize(path)) if file.seek(at) == at and file.read(8) == slipd._BLOCK]
            self.assertGreater(len(blocks), 2)
            file.seek(blocks[1])
            file.write(b"x")
        recording = slipd.open(path)
        rest = {frame.seq for frame in recording}
        self.assertTrue(rest and rest < whole)
        self.assertEqual(recording.damaged, 1)
        os.truncate(path, blocks[2] + 100)
        self.assertLess({frame.seq for frame in slipd.open(path)}, rest)

    def test_the_examples_of_the_page_are_programs(self):
        with open(os.path.join(os.environ["SLIPD_SOURCE_DIR"], "docs", "clients.md"), encoding="utf-8") as page:
            examples = re.findall(r"```python\n(.*?)```", page.read(), re.DOTALL)
        self.assertEqual(len(examples), 3)
        for example in examples:
            here = re.sub(r"(Client|Board)\(\)", rf"\1({self.daemon.socket!r})", example)
            with subprocess.Popen([sys.executable, "-u", "-c", here], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
                lines = list(itertools.islice(program.stdout, 2))
                program.kill()
                self.assertEqual(len(lines), 2, program.stderr.read())

    def test_the_command_prints_a_line_for_each_sensor(self):
        printed = io.StringIO()
        waiting = slipd.Client.estimates

        def some(*args, **options):
            return itertools.islice(waiting(*args, **options), 8)

        slipd.Client.estimates, restore = some, waiting
        with contextlib.redirect_stdout(printed):
            self.assertEqual(slipd.main(["--socket", self.daemon.socket]), 0)
        slipd.Client.estimates = restore
        self.assertEqual({line.split()[0] for line in printed.getvalue().splitlines()}, {"left", "right"})


class WithoutSlipd(unittest.TestCase):
    def test_it_says_what_to_do(self):
        for attempt in (lambda client: client.status(), lambda client: next(client.estimates(max_age_s=1))):
            with self.assertRaisesRegex(slipd.Disconnected, "start it, or give the path"):
                attempt(slipd.Client("/nonexistent/slipd.sock"))

    def test_what_is_no_recording_is_refused(self):
        for content in (b"", b"text", bytes.fromhex("a0"), b"\xbf", b"\xa1\x66format\x61x"):
            with tempfile.NamedTemporaryFile() as file:
                file.write(content)
                file.flush()
                with self.assertRaisesRegex(slipd.RecordingError, "no recording"):
                    slipd.open(file.name)


if __name__ == "__main__":
    unittest.main()
