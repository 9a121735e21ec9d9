"""slipctl fleet with mosquitto as broker: what it shows of grippers that come, alert, go and come back. And grasps on MQTT."""
import json, os, queue, socket, subprocess, threading, time, unittest

from awaiting import PATIENCE_S, await_true
from peer_test import Mosquitto, Subscriber
from ports import free_port
from support import BUILD, BridgeTest, Certificates

SLIPCTL = os.path.join(BUILD, "bin", "slipctl")


class FleetLines:
    """`slipctl --json fleet`: its lines as they come, and the last one of each gripper."""

    def __init__(self, port):
        self.program = subprocess.Popen([SLIPCTL, "--json", "fleet", "--broker", f"127.0.0.1:{port}"], stdout=subprocess.PIPE, text=True)
        self.lines, self.last, self.brokers = [], {}, []
        self.thread = threading.Thread(target=self._read)
        self.thread.start()

    def _read(self):
        for text in self.program.stdout:
            line = json.loads(text)
            self.lines.append(line)
            if "broker" in line:
                self.brokers.append(line)
            else:
                self.last[line["gripper"]] = line

    def await_line(self, gripper, condition, what):
        def fits():
            line = self.last.get(gripper)
            return line if line and condition(line) else None
        try:
            return await_true(fits, what)
        except AssertionError as error:
            raise AssertionError(f"{error}; the last line: {self.last.get(gripper)}") from None

    def close(self):
        self.program.terminate()
        self.program.wait(PATIENCE_S)
        self.thread.join()
        self.program.stdout.close()


class WithGrippers(BridgeTest):
    def setUp(self):
        super().setUp()
        self.broker = Mosquitto(self.folder)
        self.addCleanup(self.broker.kill)

    def gripper(self, host, grasps=(), **more):
        slipd = self.fake_slipd(host, grasps=grasps)
        return slipd, self.bridge_of(slipd, [self.broker], host=host, summary_s=1, **more)

    def lines(self):
        lines = FleetLines(self.broker.port)
        self.addCleanup(lines.close)
        return lines

    def show(self, *arguments):
        return subprocess.run([SLIPCTL, "fleet", "--broker", f"127.0.0.1:{self.broker.port}", *arguments], capture_output=True, text=True,
                              timeout=PATIENCE_S, check=False)


class Playing:
    """Estimates of both sensors until the block ends, so that summaries have margins."""

    def __init__(self, slipd, **gamma):
        self.slipd, self.gamma, self.ends = slipd, gamma, threading.Event()
        self.thread = threading.Thread(target=self._play)

    def __enter__(self):
        self.thread.start()
        return self

    def _play(self):
        while not self.ends.wait(0.1):
            for sensor, gamma in self.gamma.items():
                self.slipd.estimate(sensor, gamma=gamma)

    def __exit__(self, *_):
        self.ends.set()
        self.thread.join()


class Fleet(WithGrippers):
    def test_a_gripper_comes_alerts_goes_and_comes_back(self):
        slipd, bridge = self.gripper("g1")
        lines = self.lines()
        with Playing(slipd, left=0.62, right=0.31):
            line = lines.await_line("g1", lambda line: line["gamma"] is not None, "the margin")
            self.assertEqual((line["status"], line["state"], line["gamma"], line["gamma_of"]), ("online", "ok", 0.31, "right"))
            self.assertEqual((line["version"], line["alerts_last_hour"], line["simulated"]), ("0.1.0", 0, True))
            for sensor in "left", "right", "left":
                slipd.alert(sensor, "warn")
            line = lines.await_line("g1", lambda line: line["alerts_last_hour"] == 3, "three alerts")
            self.assertEqual(line["alert"], "warn")
            slipd.send("state", slipd.message("left", state="fault", gamma=None))
            line = lines.await_line("g1", lambda line: line["state"] == "fault", "the fault")
            self.assertEqual((line["state_of"], line["gamma"]), ("left", None))
        killed = time.time_ns()
        bridge.kill()
        line = lines.await_line("g1", lambda line: line["status"] == "offline", "the last will")
        self.assertLess(line["offline_since_ns"], killed)
        self.assertGreater(line["offline_since_ns"], killed - 60e9)
        self.assertEqual((line["gamma"], line["alert"], line["alerts_last_hour"], line["version"]), (None, "warn", None, "0.1.0"))
        bridge.start()
        line = lines.await_line("g1", lambda line: line["alerts_last_hour"] is not None, "the gripper again")
        self.assertEqual((line["status"], line["alerts_last_hour"]), ("online", 3))  # counted before it was killed

    # A second one that starts later shows the same: all is in retained topics.
    def test_whoever_starts_later_shows_the_same(self):
        slipd, _ = self.gripper("g1")
        other, gone = self.gripper("g2")
        first = self.lines()
        slipd.alert("left")
        first.await_line("g1", lambda line: line["alerts_last_hour"] == 1, "the alert")
        gone.stop()
        first.await_line("g2", lambda line: line["status"] == "offline", "the end")
        self.assertEqual([line["connected"] for line in first.brokers], [True])
        shown = self.show("--once", "--json")
        self.assertEqual(shown.returncode, 0, shown.stderr)
        once = {line["gripper"]: line for line in map(json.loads, shown.stdout.splitlines())}
        self.assertEqual(set(once), {"g1", "g2"})
        self.assertEqual((once["g1"]["status"], once["g1"]["alerts_last_hour"], once["g1"]["alert"]), ("online", 1, "slip"))
        self.assertEqual(once["g2"]["offline_since_ns"], first.last["g2"]["offline_since_ns"])
        table = self.show("--once")
        self.assertEqual(table.returncode, 0, table.stderr)
        heading, *rows = table.stdout.splitlines()
        self.assertEqual([row.split()[:2] for row in rows], [["g1", rows[0].split()[1]], ["g2", "offline"]])
        self.assertIn("offline since", heading)

    def test_slipd_away_and_a_gripper_that_is_removed(self):
        slipd, bridge = self.gripper("g1")
        lines = self.lines()
        with Playing(slipd, left=0.6, right=0.6):
            lines.await_line("g1", lambda line: line["gamma"] == 0.6, "the margin")
        slipd.close()
        line = lines.await_line("g1", lambda line: line["state"] == "disconnected", "the loss")
        self.assertEqual((line["status"], line["gamma"]), ("online", None))
        bridge.kill()
        writer = Subscriber(self.broker.port, "operator")
        self.addCleanup(writer.close)
        lines.await_line("g1", lambda line: line["status"] == "offline", "the last will")
        for topic in "status", "summary", "seen":
            writer.client.publish(f"slipd/g1/{topic}", b"", 1, True)
        lines.await_line("g1", lambda line: line["status"] == "removed", "the removal")

    def test_the_broker_goes_and_comes_back(self):
        slipd, _ = self.gripper("g1")
        lines = self.lines()
        with Playing(slipd, left=0.6, right=0.6):
            lines.await_line("g1", lambda line: line["gamma"] == 0.6, "the margin")
            self.broker.kill()
            await_true(lambda: lines.brokers[-1]["connected"] is False, "the loss")
            seen = len(lines.lines)
            self.broker.start()
            await_true(lambda: lines.brokers[-1]["connected"] is True, "the broker")
            await_true(lambda: any(line.get("gamma") == 0.6 for line in lines.lines[seen:]), "the margin again")

    def test_lines_of_text_where_there_is_no_terminal(self):
        slipd, _ = self.gripper("g1")
        program = subprocess.Popen([SLIPCTL, "fleet", "--broker", f"127.0.0.1:{self.broker.port}"], stdout=subprocess.PIPE, text=True)
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.wait)
        self.addCleanup(program.terminate)
        lines = queue.Queue()
        threading.Thread(target=lambda: [lines.put(line) for line in program.stdout], daemon=True).start()
        with Playing(slipd, left=0.62, right=0.7):
            while "margin 0.62 (left)" not in (line := lines.get(timeout=PATIENCE_S)):
                pass
        self.assertTrue(line.startswith("g1  ok  "), line)
        self.assertIn("simulated", line)

    def test_errors(self):
        port = free_port()
        nobody = subprocess.run([SLIPCTL, "fleet", "--once", "--broker", f"127.0.0.1:{port}"], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual((nobody.returncode, nobody.stdout), (1, ""))
        self.assertIn("refused", nobody.stderr)
        for arguments, what in ((["--broker", "h:port"], "port"), (["--broker", "h:70000"], "port"), (["--prefix", "#"], "topic_prefix"),
                                (["--broker", "192.0.2.1", "--user", "u", "--password-file", "/p"], "in the clear"),
                                (["--cert-file", "/c"], "key_file"), (["--password-file", "/p"], "needs user")):
            ran = subprocess.run([SLIPCTL, "fleet", "--once", *arguments], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
            self.assertEqual(ran.returncode, 2, ran)
            self.assertIn(what, ran.stderr)
        empty = self.show("--once", "--json")
        self.assertEqual((empty.returncode, empty.stdout), (0, ""))

    def test_a_user_and_a_password(self):
        path = lambda name: os.path.join(self.folder, name)
        subprocess.run(["mosquitto_passwd", "-b", "-c", path("users"), "operator", "secret"], check=True, capture_output=True)
        for name, text in ("password", "secret\n"), ("wrong", "guess\n"):
            with open(path(name), "w") as file:
                file.write(text)
        self.broker.kill()
        self.broker = Mosquitto(self.folder, [f"password_file {path('users')}", "allow_anonymous false"])
        self.addCleanup(self.broker.kill)
        right = self.show("--once", "--user", "operator", "--password-file", path("password"))
        self.assertEqual(right.returncode, 0, right.stderr)
        for arguments in [], ["--user", "operator", "--password-file", path("wrong")]:
            refused = self.show("--once", *arguments)
            self.assertEqual(refused.returncode, 1)
            self.assertIn("not authorised", refused.stderr.lower())


class Tls(BridgeTest):
    """A broker that takes TLS and a password only."""

    def setUp(self):
        super().setUp()
        self.path = lambda name: os.path.join(self.folder, name)
        subprocess.run(["mosquitto_passwd", "-b", "-c", self.path("users"), "operator", "secret"], check=True, capture_output=True)
        with open(self.path("password"), "w") as file:
            file.write("secret\n")
        self.authority = Certificates(self.folder, "ca")
        certificate, key = self.authority.issue("IP:127.0.0.1")
        self.broker = Mosquitto(self.folder, [f"password_file {self.path('users')}", "allow_anonymous false"], listener=f"certfile {certificate}\nkeyfile {key}")
        self.addCleanup(self.broker.kill)

    def show(self, *arguments, host="127.0.0.1", port=None):
        return subprocess.run([SLIPCTL, "fleet", "--once", "--json", "--user", "operator", "--password-file", self.path("password"),
                               "--broker", f"{host}:{port or self.broker.port}", *arguments],
                              capture_output=True, text=True, timeout=PATIENCE_S, check=False)

    def seen_by_broker(self):
        with open(self.path(f"mosquitto-{self.broker.port}.log")) as log:
            return log.read()

    def test_a_broker_whose_certificate_is_good(self):
        settings = {"host": "127.0.0.1", "port": self.broker.port, "user": "operator", "password_file": self.path("password"),
                    "tls": {"ca_file": self.authority.ca_file}}
        self.bridge_of(self.fake_slipd("g1"), [settings], host="g1")
        def table():
            ran = self.show("--ca-file", self.authority.ca_file)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            return ran.stdout and json.loads(ran.stdout)
        line = await_true(table, "the gripper")
        self.assertEqual((line["gripper"], line["status"]), ("g1", "online"))
        self.assertIn("u'operator'", self.seen_by_broker())

    def test_a_certificate_of_another_authority_or_host_is_refused_before_the_password_is_sent(self):
        other = Certificates(self.folder, "other")
        for arguments, host, why in ((["--tls"], "127.0.0.1", "TLS: certificate verify failed; the certificate of the broker must be"),
                                     (["--ca-file", other.ca_file], "127.0.0.1", "TLS: certificate verify failed; the certificate of the broker must be"),
                                     (["--ca-file", self.authority.ca_file], "localhost", "TLS: host name verification failed"),
                                     ([], "127.0.0.1", "lost")):
            with self.subTest(arguments=arguments, host=host):
                refused = self.show(*arguments, host=host)
                self.assertEqual((refused.returncode, refused.stdout), (1, ""))
                self.assertIn(why, refused.stderr)
        self.assertNotIn("operator", self.seen_by_broker())

    def test_without_tls_no_password_leaves_this_computer(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(("192.0.2.1", 9))  # sends nothing
            except OSError:
                self.skipTest("this computer has no network")
            address = probe.getsockname()[0]
        with socket.create_server((address, 0)) as listener:
            listener.setblocking(False)
            refused = self.show(host=address, port=listener.getsockname()[1])
            self.assertEqual((refused.returncode, refused.stdout), (2, ""))
            self.assertIn("in the clear", refused.stderr)
            with self.assertRaises(BlockingIOError):
                listener.accept()


class Grasps(WithGrippers):
    def test_states_estimates_and_alerts_of_a_grasp(self):
        slipd, _ = self.gripper("g1", grasps=["cup"])
        reader = Subscriber(self.broker.port)
        self.addCleanup(reader.close)
        at = lambda kind: reader.retained.get(f"slipd/g1/cup/{kind}") or {}
        with Playing(slipd, left=0.6, right=0.6):
            await_true(lambda: at("estimate").get("gamma") == 0.5, "the estimate")
            self.assertEqual(at("estimate")["sensors"], ["left", "right"])
            await_true(lambda: at("state").get("state") == "ok", "the state")
            slipd.grasps["cup"] = {"alert": "warn", "alert_cause": "margin", "gamma": 0.2}
            await_true(lambda: reader.alerts, "the alert")
            slipd.grasps["cup"] = {"alert": "slip", "alert_cause": "sliding", "state": "out_of_model", "gamma": None}
            await_true(lambda: len(reader.alerts) == 2, "the next alert")
            slipd.grasps["cup"] = {}
            await_true(lambda: len(reader.alerts) == 3, "its end")
            summary = lambda: reader.retained.get("slipd/g1/summary") or {"alerts_last_hour": None, "grasps": []}
            await_true(lambda: summary()["alerts_last_hour"] == 2, "the count")
            await_true(lambda: [line["gamma_min"] for line in summary()["grasps"]] == [0.5], "the least margin")
        self.assertEqual([(a["number"], a["grasp"], a["alert"], a["alert_cause"], a["gamma"]) for a in reader.alerts],
                         [(1, "cup", "warn", "margin", 0.2), (2, "cup", "slip", "sliding", None), (3, "cup", "none", None, 0.5)])
        slipd.close()
        await_true(lambda: at("state").get("state") == "disconnected", "the loss")

    # The grasp is as old as the sensor that is silent.
    def test_a_grasp_of_old_frames_has_no_margin(self):
        slipd, _ = self.gripper("g1", grasps=["cup"])
        reader = Subscriber(self.broker.port)
        self.addCleanup(reader.close)
        before = slipd.message
        slipd.message = lambda sensor, **members: before(sensor, **({"age_ms": 5000.0} if sensor == "left" else {}) | members)
        slipd.estimate("right")
        got = await_true(lambda: reader.retained.get("slipd/g1/cup/estimate"), "the estimate")
        self.assertEqual((got["state"], got["gamma"], got["gamma_low"], got["first"]), ("stale", None, None, None))


if __name__ == "__main__":
    unittest.main(warnings="ignore")
