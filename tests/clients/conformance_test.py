"""One suite for both clients, libslipd (conformance.c) and the Python module (conformance.py), against the real slipd.

Each scenario runs for each client. The truth is what slipd answers to a plain socket, in one scenario to socat and jq."""
import json, os, shutil, signal, socket, subprocess, sys, tempfile, threading, time, unittest

from python_test import OLD_S, PATIENCE_S, Daemon

BUILD, SOURCE = os.environ["SLIPD_BINARY_DIR"], os.environ["SLIPD_SOURCE_DIR"]
PROGRAMS = {"libslipd": [os.path.join(BUILD, "test-bin", "conformance-c")],
            "python": [sys.executable, os.path.join(SOURCE, "tests", "clients", "conformance.py")]}
STALL_AGE_S = 0.2  # the age limit of a reader that notices a slipd that stands still
GONE_AGE_S = 1  # the heartbeat of a killed slipd may be as old before its memory counts as left
AHEAD = ("unshare", "--time", "--monotonic", "1000")  # runs a program whose CLOCK_MONOTONIC is 1000 s ahead
FOREIGN_CLOCK = shutil.which("unshare") and subprocess.run([*AHEAD, "true"], capture_output=True).returncode == 0
WAYS = (("gamma", "left", OLD_S, PATIENCE_S), ("latest", "left", GONE_AGE_S), ("next",))  # request, shared memory, subscription


class Slipd(Daemon):
    """slipd with two simulated fingers that hold one object, configured as each scenario needs it."""

    def __init__(self, rate_hz=200, running=True):
        self.folder = tempfile.TemporaryDirectory()
        self.socket = os.path.join(self.folder.name, "socket")
        self.settings = os.path.join(self.folder.name, "slipd.json")
        self.rate_hz, self.process = rate_hz, None
        self.configure("left", "right")
        if running:
            self.start()

    def configure(self, *names):
        """For the next start or reload."""
        fingers = [{"name": name, "driver": "sim", "rate_hz": self.rate_hz, "layout": {"grid": [8, 8], "pitch_mm": 1.8}} for name in names]
        with open(self.settings, "w") as file:
            json.dump({"socket": {"path": self.socket}, "realtime": {"mode": "off"}, "estimator": {"method": "moments"}, "sensors": fingers,
                       "grasps": [{"name": "cup", "sensors": list(names)}] if len(names) > 1 else []}, file)

    def reload(self, *names):
        """Returns when the sensors are these."""
        self.configure(*names)
        self.process.send_signal(signal.SIGHUP)
        end = time.monotonic() + PATIENCE_S
        while sorted(self.truth("sensors", lambda each: each["name"])) != sorted(names):
            if time.monotonic() > end:
                raise AssertionError("the reload is not done")

    def ask(self, method, **params):
        """The result, by a plain socket."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as plain:
            plain.connect(self.socket)
            plain.sendall(json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}).encode() + b"\n")
            with plain.makefile() as lines:
                return json.loads(lines.readline())["result"]

    def truth(self, method, of):
        return [of(sensor) for sensor in self.ask(method)["sensors"]]

    def close(self):
        if self.process is not None and self.process.returncode is None:
            self.end()
        self.folder.cleanup()


class Client:
    """A conformance program: commands in, answers out."""

    def __init__(self, which, path):
        self.process = subprocess.Popen([*PROGRAMS[which], path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)

    def do(self, *words):
        self.process.stdin.write(" ".join(map(str, words)) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError(f"the client ended with {self.process.wait(PATIENCE_S)} at {words}")
        answer = json.loads(line)
        # Whatever happens: a margin is of a whole estimate in state ok.
        if answer["gamma"] is not None and (answer["code"], answer["state"]) != ("done", "ok"):
            raise AssertionError(f"a margin that may not be used: {answer}")
        silent = answer["code"] != "done" or answer["state"] in ("stale", "disconnected")
        if words[0] != "subscribe" and silent and answer.get("alert") == "none":
            raise AssertionError(f"nobody watches, and there is no alert: {answer}")
        return answer

    def until(self, condition, *words):
        """Repeats a command; the first answer that meets the condition."""
        end = time.monotonic() + PATIENCE_S
        while True:
            answer = self.do(*words)
            if condition(answer):
                return answer
            if time.monotonic() > end:
                raise AssertionError(f"{words}: the last answer was {answer}")

    def close(self):
        self.process.stdin.close()
        self.process.wait(PATIENCE_S)
        self.process.stdout.close()


def has_margin(answer):
    return answer["gamma"] is not None


def is_gone(answer):
    return answer["state"] == "disconnected"


class Scenarios:
    which = ""

    def slipd(self, **options):
        daemon = Slipd(**options)
        self.addCleanup(daemon.close)
        return daemon

    def client(self, daemon, which=None):
        client = Client(which or self.which, daemon.socket)
        self.addCleanup(client.close)
        return client

    def subscribed(self, daemon, name="left", max_age_s=OLD_S):
        client = self.client(daemon)
        self.assertEqual(client.do("subscribe", name, max_age_s)["code"], "done")
        return client

    def test_before_slipd_is_up_there_is_no_margin_and_then_there_is(self):
        daemon = self.slipd(running=False)
        client = self.client(daemon)
        for command in (("subscribe", "left", OLD_S), ("gamma", "left", OLD_S, PATIENCE_S), ("grasp", "cup", OLD_S, PATIENCE_S),
                        ("latest", "left", OLD_S)):
            self.assertEqual(client.do(*command)["code"], "disconnected", command)
        daemon.start()
        client.until(lambda answer: answer["code"] == "done", "subscribe", "left", OLD_S)
        for way in WAYS:
            client.until(has_margin, *way)

    def test_a_killed_slipd_is_told_each_way_and_its_successor_used(self):
        daemon = self.slipd()
        client = self.subscribed(daemon)
        for way in WAYS:
            client.until(has_margin, *way)
        daemon.end(signal.SIGKILL)
        for way in WAYS:
            client.until(is_gone, *way)
            for _ in range(3):
                self.assertFalse(has_margin(client.do(*way)), way)
        daemon.start()
        for way in WAYS:
            self.assertTrue(client.until(has_margin, *way)["simulated"])

    def test_an_orderly_restart_is_the_same(self):
        daemon = self.slipd()
        client = self.subscribed(daemon)
        client.until(has_margin, "next")
        client.until(has_margin, "latest", "left", OLD_S)
        daemon.end()
        for way in WAYS:
            client.until(is_gone, *way)
        daemon.start()
        for way in WAYS:
            client.until(has_margin, *way)

    def test_after_a_reload_all_ways_go_on_with_the_new_sensors(self):
        daemon = self.slipd()
        client = self.subscribed(daemon)
        for way in WAYS:
            client.until(has_margin, *way)
        self.assertEqual(client.do("latest", "third", OLD_S)["code"], "refused")
        daemon.reload("left", "right", "third")
        client.until(has_margin, "latest", "third", OLD_S)
        client.until(has_margin, "gamma", "third", OLD_S, PATIENCE_S)
        for way in WAYS:
            client.until(has_margin, *way)

    def test_a_sensor_that_a_reload_takes_away_has_no_margin_ever_after(self):
        daemon = self.slipd()
        client = self.client(daemon)
        self.assertEqual(client.do("subscribe", "right", STALL_AGE_S)["code"], "done")
        client.until(has_margin, "latest", "right", OLD_S)
        client.until(lambda answer: answer["code"] == "done", "next")
        daemon.reload("left")
        client.until(lambda answer: answer["code"] == "refused", "gamma", "right", OLD_S, PATIENCE_S)
        client.until(lambda answer: answer["code"] == "refused", "latest", "right", OLD_S)
        client.until(lambda answer: answer["code"] == "timeout", "next")  # those that were under way have come
        for command in (("gamma", "right", OLD_S, PATIENCE_S), ("latest", "right", OLD_S), ("next",)):
            for _ in range(5):
                answer = client.do(*command)
                self.assertFalse(has_margin(answer))
                self.assertIn(answer["code"], ("refused", "timeout"))
        client.until(has_margin, "latest", "left", OLD_S)
        self.assertEqual(client.do("grasp", "plate", OLD_S, PATIENCE_S)["code"], "refused")

    def test_while_slipd_stands_still_the_age_limit_takes_the_margin_away(self):
        daemon = self.slipd()
        client = self.subscribed(daemon, max_age_s=STALL_AGE_S)
        ways = (("latest", "left", STALL_AGE_S), ("next",), ("gamma", "left", STALL_AGE_S, STALL_AGE_S))
        client.until(has_margin, "latest", "left", OLD_S)
        daemon.stand_still()
        for way in ways:
            client.until(lambda answer: answer["state"] in ("stale", "disconnected"), *way)
            for _ in range(5):
                self.assertFalse(has_margin(client.do(*way)), way)
        self.assertEqual(client.do("gamma", "left", OLD_S, STALL_AGE_S)["code"], "timeout")
        daemon.process.send_signal(signal.SIGCONT)
        # The answers to the requests that were given up are not taken for this one's.
        self.assertEqual(client.until(has_margin, "gamma", "right", OLD_S, PATIENCE_S)["name"], "right")
        client.until(has_margin, "latest", "left", OLD_S)
        client.until(lambda answer: answer["code"] == "done", "next")

    @unittest.skipUnless(FOREIGN_CLOCK, "time namespaces are not permitted here")
    def test_the_memory_of_a_slipd_whose_clock_is_ahead_has_no_margin(self):
        daemon = self.slipd(running=False)
        daemon.start(*AHEAD)
        client = self.client(daemon)
        # Ages on the socket are of slipd's own clock.
        client.until(has_margin, "gamma", "left", OLD_S, PATIENCE_S)
        for _ in range(100):
            answer = client.do("latest", "left", OLD_S)
            self.assertEqual((answer["code"], answer["state"], answer["gamma"]), ("disconnected", "disconnected", None))
        # One with this clock is read again.
        daemon.end()
        daemon.start()
        client.until(has_margin, "latest", "left", OLD_S)

    def test_an_estimate_that_is_too_old_has_no_margin(self):
        daemon = self.slipd()
        client = self.client(daemon)
        client.until(has_margin, "latest", "left", OLD_S)
        for age_s in (0, -1, 1e-9, "nan"):
            for way in (("latest", "left", age_s), ("gamma", "left", age_s, PATIENCE_S), ("grasp", "cup", age_s, PATIENCE_S)):
                answer = client.do(*way)
                self.assertEqual((answer["code"], answer["state"], answer["gamma"], answer["gamma_low"]), ("done", "stale", None, None), way)

    def test_what_a_slow_reader_loses_is_told_to_the_last_one(self):
        daemon = self.slipd(rate_hz=1000)
        client = self.subscribed(daemon)
        first = client.until(lambda answer: answer["code"] == "done", "next")
        end = time.monotonic() + PATIENCE_S
        while daemon.ask("status")["outputs"]["socket"]["dropped"] < 100:  # the socket and slipd's queue are full
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)
        got, dropped = 0, 0
        while dropped == 0 or got < 500:
            last = client.do("next")
            self.assertEqual(last["code"], "done")
            self.assertLess(time.monotonic(), end, "slipd has dropped estimates, and the client does not say so")
            got, dropped = got + 1, dropped + last["dropped"]
        absent = daemon.truth("status", lambda sensor: sensor["skipped"] + sensor["lost"])[0]
        gone_by = last["seq"] - first["seq"]
        self.assertLessEqual(got + dropped, gone_by)
        self.assertGreaterEqual(got + dropped, gone_by - absent, "each frame has come, was dropped, was not estimated or is the device's loss")

    def test_two_readers_of_the_two_clients_see_the_same(self):
        daemon = self.slipd(rate_hz=50)
        readers = [self.client(daemon, which) for which in PROGRAMS]
        seen = [{}, {}]
        end = time.monotonic() + PATIENCE_S
        while len(common := seen[0].keys() & seen[1].keys()) < 20:
            self.assertLess(time.monotonic(), end)
            for values, reader in zip(seen, readers):
                answer = reader.do("latest", "left", OLD_S)
                if answer["code"] == "done" and answer["seq"] > 0:
                    values[answer["seq"]] = {key: answer[key] for key in ("state", "alert", "alert_cause", "gamma", "gamma_low", "normal_n", "shear_n")}
        for seq in common:
            self.assertEqual(seen[0][seq], seen[1][seq], seq)

    def test_a_reader_that_is_killed_does_not_disturb_the_other(self):
        daemon = self.slipd()
        for _ in range(5):
            other, reader = self.subscribed(daemon), self.client(daemon)
            reader.until(has_margin, "latest", "left", OLD_S)
            other.until(has_margin, "latest", "left", OLD_S)
            other.process.kill()
            other.process.wait(PATIENCE_S)
            seen = reader.do("latest", "left", OLD_S)["seq"]
            reader.until(lambda answer: answer["seq"] > seen, "latest", "left", OLD_S)

    @unittest.skipUnless(shutil.which("socat") and shutil.which("jq"), "socat or jq is not installed: run tools/setup")
    def test_memory_and_socket_say_what_socat_and_jq_say(self):
        daemon = self.slipd(rate_hz=50)
        client = self.client(daemon)
        request = json.dumps({"jsonrpc": "2.0", "id": 1, "method": "subscribe", "params": {"sensors": ["left"]}})
        pick = 'select(.method == "estimate") | .params | {seq, state, alert, alert_cause, gamma, gamma_low, normal_n, shear_n, simulated}'
        pipeline = subprocess.Popen(f"socat - UNIX-CONNECT:{daemon.socket} | jq -c --unbuffered '{pick}'", shell=True, text=True,
                                    stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        pipeline.stdin.write(request + "\n")
        pipeline.stdin.flush()
        truth = {}

        def listen():
            for line in pipeline.stdout:
                estimate = json.loads(line)
                truth[estimate["seq"]] = estimate

        listener = threading.Thread(target=listen)
        listener.start()
        seen = {"latest": {}, "gamma": {}}
        end = time.monotonic() + PATIENCE_S

        def compared(verb):
            return [seq for seq in seen[verb].keys() & truth.copy().keys() if truth[seq]["gamma"] is not None]

        while min(len(compared(verb)) for verb in seen) < 10:
            self.assertLess(time.monotonic(), end)
            for way in (("latest", "left", OLD_S), ("gamma", "left", OLD_S, PATIENCE_S)):
                answer = client.do(*way)
                if answer["code"] == "done":
                    seen[way[0]][answer["seq"]] = answer
        pipeline.stdin.close()
        daemon.end()
        listener.join()
        pipeline.stdout.close()
        pipeline.wait(PATIENCE_S)
        for verb, answers in seen.items():
            for seq in answers.keys() & truth.keys():
                self.assertEqual({key: answers[seq][key] for key in truth[seq]}, truth[seq], verb)


class Libslipd(Scenarios, unittest.TestCase):
    which = "libslipd"


class Module(Scenarios, unittest.TestCase):
    which = "python"


if __name__ == "__main__":
    unittest.main()
