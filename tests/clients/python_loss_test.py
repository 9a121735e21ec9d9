"""What users of the Python module are told by a slipd that hangs, dies or comes back, and that nothing waits for it in vain."""
import asyncio, contextlib, itertools, json, os, shutil, signal, socket, subprocess, sys, tempfile, unittest


from python_test import OLD_S, PATIENCE_S, Daemon, first

sys.path.insert(0, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "tests", "support"))
from fake_slipd import FakeSlipd, Server
import slipd

FRESH_S = 1  # the heartbeat of a killed slipd may be as old before its memory counts as left


class Holding(Daemon):
    """slipd with a finger that holds an object: gently pulled at, or so that it slides."""

    def __init__(self, shear_n=0.2):
        self.folder = tempfile.TemporaryDirectory()
        self.socket = os.path.join(self.folder.name, "socket")
        self.settings = os.path.join(self.folder.name, "slipd.json")
        cycle = [{"ms": 100, "normal_n": 0, "shear_n": 0, "friction": 0.5}, {"ms": 50, "normal_n": [0, 2]},
                 {"ms": 300, "shear_n": [0, shear_n]}, {"ms": 600000}]
        finger = {"name": "left", "driver": "sim", "rate_hz": 200, "layout": {"grid": [16, 16], "pitch_mm": 0.9}, "friction": 0.5,
                  "options": {"cycle": cycle, "noise": 0.002}}
        with open(self.settings, "w") as file:
            json.dump({"socket": {"path": self.socket}, "realtime": {"mode": "off"}, "estimator": {"method": "moments"}, "sensors": [finger]}, file)
        self.start()


class Losses(unittest.TestCase):
    def slipd(self, **options):
        daemon = Holding(**options)
        self.addCleanup(daemon.close)
        return daemon

    def board(self, daemon):
        board = slipd.Board(daemon.socket, timeout_s=PATIENCE_S)  # whoever waits for a slipd that hangs waits this long
        self.addCleanup(board.close)
        return board

    def looked(self, board, condition, max_age_s=OLD_S):
        return first((board.latest("left", max_age_s) for _ in itertools.count()), condition)

    @contextlib.contextmanager
    def crowd(self, daemon):
        """Meanwhile as many connections wait as slipd, which is stopped, lets wait."""
        with contextlib.ExitStack() as connections:
            with self.assertRaises(BlockingIOError):
                while True:
                    each = connections.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_STREAM))
                    each.setblocking(False)
                    each.connect(daemon.socket)
            yield

    def test_latest_never_waits_for_a_slipd_that_hangs(self):
        daemon = self.slipd()
        board, fresh = self.board(daemon), self.board(daemon)
        self.looked(board, lambda each: each.state == "ok")
        daemon.stand_still()
        self.looked(board, lambda each: each.state == "disconnected", 0)
        for each in (board, fresh):
            for _ in range(1000):
                self.assertEqual(each.latest("left", 0).state, "disconnected")
        daemon.process.send_signal(signal.SIGCONT)
        for each in (board, fresh):
            self.looked(each, lambda now: now.state == "ok")

    def test_latest_never_waits_for_a_slipd_that_accepts_no_connection(self):
        daemon = self.slipd()
        with slipd.Client(daemon.socket) as client:
            first(client.estimates("left", max_age_s=OLD_S), lambda each: each.state == "ok")
        daemon.stand_still()
        with self.crowd(daemon):
            board = self.board(daemon)
            for _ in range(1000):
                self.assertEqual(board.latest("left", OLD_S).state, "disconnected")
            with self.assertRaisesRegex(slipd.Disconnected, "hangs"):
                board.attach()
        daemon.process.send_signal(signal.SIGCONT)
        self.looked(board, lambda each: each.state == "ok")

    def test_attach_says_that_slipd_does_not_answer(self):
        daemon = self.slipd()
        daemon.stand_still()
        board = self.board(daemon)
        board.timeout_s = 0.05
        with self.assertRaises(TimeoutError):
            board.attach()

    def test_a_slipd_that_goes_on_is_read_again_without_another_connection(self):
        daemon = self.slipd()
        board = self.board(daemon)
        self.looked(board, lambda each: each.state == "ok")
        generation = board.generation
        for _ in range(3):
            daemon.stand_still()
            self.looked(board, lambda each: each.state == "disconnected", 0)
            daemon.process.send_signal(signal.SIGCONT)
            self.looked(board, lambda each: each.state == "ok")
        self.assertEqual(board.generation, generation)

    def test_no_alert_of_a_slipd_that_is_gone_is_unknown_in_shared_memory(self):
        daemon = self.slipd()
        board = self.board(daemon)
        self.looked(board, lambda each: each.state == "ok" and each.alert == "none" and each.health == "good")
        daemon.end(signal.SIGKILL)
        gone = self.looked(board, lambda each: each.state == "disconnected", FRESH_S)
        self.assertEqual((gone.alert, gone.alert_cause, gone.health), ("unknown", None, "unknown"))

    def test_a_slip_stands_in_shared_memory_when_slipd_is_gone(self):
        daemon = self.slipd(shear_n=3)
        board = self.board(daemon)
        slip = self.looked(board, lambda each: each.alert == "slip")
        daemon.end(signal.SIGKILL)
        gone = self.looked(board, lambda each: each.state == "disconnected", FRESH_S)
        self.assertEqual((gone.alert, gone.health), ("slip", "unknown"))
        self.assertIn(gone.alert_cause, ("margin", "sliding"))
        self.assertEqual(board.latest("right", FRESH_S).alert, "unknown", "no sensor of which anything is known")

    def test_a_slip_stands_in_an_iterator_when_slipd_hangs_and_is_killed(self):
        daemon = self.slipd(shear_n=3)
        with slipd.Client(daemon.socket, timeout_s=PATIENCE_S) as client:
            estimates = client.estimates("left", max_age_s=0.2)
            self.addCleanup(estimates.close)
            first(estimates, lambda each: each.alert == "slip")
            daemon.stand_still()
            self.assertEqual(first(estimates, lambda each: each.seq is None and each.state == "stale").alert, "slip")
            daemon.end(signal.SIGKILL)
            self.assertEqual(first(estimates, lambda each: each.state == "disconnected").alert, "slip")

    def busy(self, events):
        """What an asyncio consumer is told who was busy while slipd was killed and started again."""
        daemon = self.slipd()

        async def watch():
            async with slipd.AsyncClient(daemon.socket, timeout_s=PATIENCE_S) as client:
                estimates = client.estimates("left", max_age_s=OLD_S, events=events)
                told = [await estimates.__anext__()]
                daemon.end(signal.SIGKILL)
                daemon.start()
                await client.call("status")  # the loop hears that the first slipd has left
                async for estimate in estimates:
                    told.append(estimate)
                    if told[-2].state == "disconnected" and estimate.seq is not None:
                        await estimates.aclose()
                        return told

        return asyncio.run(asyncio.wait_for(watch(), PATIENCE_S))

    def test_a_consumer_that_was_busy_is_told_of_the_loss_and_then_of_the_next_slipd(self):
        told = self.busy(("estimate",))
        self.assertEqual({each.alert for each in told if each.state == "disconnected"}, {"unknown"})

    def test_a_consumer_of_alerts_alone_is_told_of_the_loss_and_then_what_there_is(self):
        self.assertEqual(self.busy(("alert",))[-1].event, "alert")

    def test_an_iterator_of_alerts_alone_is_told_of_the_loss_and_then_what_there_is(self):
        daemon = self.slipd()
        with slipd.Client(daemon.socket, timeout_s=PATIENCE_S) as client:
            estimates = client.estimates(max_age_s=OLD_S, events=("alert",))
            self.addCleanup(estimates.close)
            next(estimates)
            daemon.end(signal.SIGKILL)
            self.assertEqual(first(estimates, lambda each: each.state == "disconnected").name, "left")
            daemon.start()
            self.assertEqual(first(estimates, lambda each: each.seq is not None).event, "alert")

    def test_a_sensor_that_a_reload_adds_is_lost_with_the_others(self):
        daemon = self.slipd()
        with slipd.Client(daemon.socket, timeout_s=PATIENCE_S) as client:
            estimates = client.estimates(max_age_s=OLD_S)
            self.addCleanup(estimates.close)
            next(estimates)
            with open(daemon.settings) as file:
                settings = json.load(file)
            settings["sensors"].append({**settings["sensors"][0], "name": "right"})
            with open(daemon.settings, "w") as file:
                json.dump(settings, file)
            daemon.process.send_signal(signal.SIGHUP)
            first(estimates, lambda each: each.name == "right")
            daemon.end(signal.SIGKILL)
            first(estimates, lambda each: each.name == "right" and each.state == "disconnected")


class Standing(unittest.TestCase):
    def test_whoever_is_told_of_alerts_alone_is_told_after_a_loss_the_one_that_stands(self):
        server = Server()
        self.addCleanup(server.close)
        with tempfile.TemporaryDirectory() as folder:
            stand_in = FakeSlipd(os.path.join(folder, "socket"), ["left"], server)
            with slipd.Client(stand_in.path, timeout_s=PATIENCE_S) as client:
                estimates = client.estimates(max_age_s=OLD_S, events=("alert",))
                self.addCleanup(estimates.close)
                self.assertEqual(next(estimates).alert, "none", "what there is at the beginning")
                stand_in.alert("left")
                self.assertEqual(next(estimates).alert, "slip")
                stand_in.close()
                lost = next(estimates)
                self.assertEqual((lost.state, lost.alert, lost.alert_cause), ("disconnected", "slip", "margin"))
                stand_in = FakeSlipd(stand_in.path, ["left"], server)  # which watches, and sends no event
                back = first(estimates, lambda each: each.state != "disconnected")
                self.assertEqual((back.event, back.state, back.alert), ("alert", "ok", "none"))
            stand_in.close()


class Copies(unittest.TestCase):
    def test_a_copy_of_the_folder_or_of_the_file_is_a_program_under_any_name(self):
        source = os.path.join(os.environ["SLIPD_SOURCE_DIR"], "clients", "python", "slipd")
        alone = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(source, os.path.join(folder, "gripper_margins"))
            shutil.copy(os.path.join(source, "__init__.py"), os.path.join(folder, "margins.py"))
            for name in ("gripper_margins", "margins"):
                run = subprocess.run([sys.executable, "-m", name, "--socket", os.path.join(folder, "none")], cwd=folder, env=alone,
                                     capture_output=True, text=True, timeout=PATIENCE_S)
                self.assertEqual(run.returncode, 1, run.stderr)
                self.assertRegex(run.stderr, "slipd: .*start it, or give the path")


if __name__ == "__main__":
    unittest.main()
