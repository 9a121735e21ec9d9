"""slipd-mqtt with mosquitto as broker and Eclipse Paho as subscriber: neither has code of slipd. Skips if one is not installed."""
import json, os, shutil, sqlite3, subprocess, sys, unittest

try:
    import paho.mqtt.client as paho
except ImportError:
    paho = None
MOSQUITTO = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin")
if paho is None or MOSQUITTO is None:
    print("skipped: mosquitto or python3-paho-mqtt is not installed: run tools/setup --peers")
    sys.exit(77)

from awaiting import PATIENCE_S, await_true
from ports import await_listening, free_port
from support import Bridge, BridgeTest, Certificates


class Mosquitto:
    def __init__(self, folder, lines=(), listener="", address="127.0.0.1"):
        self.port, self.folder, self.address = free_port(), folder, address
        self.file = os.path.join(folder, f"mosquitto-{self.port}.conf")
        store = os.path.join(folder, f"store-{self.port}")
        os.mkdir(store)
        with open(self.file, "w") as file:
            file.write("\n".join(["persistence true", f"persistence_location {store}/", "autosave_interval 1", "user root", f"listener {self.port} {address}",
                                  listener, *(lines or ["allow_anonymous true"])]) + "\n")
        self.start()

    def start(self):
        with open(os.path.join(self.folder, f"mosquitto-{self.port}.log"), "a") as log:
            self.program = subprocess.Popen([MOSQUITTO, "-c", self.file], stdout=log, stderr=log)
        await_listening(self.port, "mosquitto", self.address)

    def stop(self):
        self.program.terminate()
        self.program.wait(PATIENCE_S)

    def kill(self):
        self.program.kill()
        self.program.wait()


class Subscriber:
    """Paho with a persistent session: every message, and the alerts in the order of their arrival."""

    def __init__(self, port, name="subscriber", set_up=lambda client: None):
        self.messages, self.retained, self.alerts = [], {}, []
        self.ready = False
        self.client = paho.Client(name, clean_session=False)
        self.client.reconnect_delay_set(1, 1)
        self.client.on_connect = lambda client, *_: client.subscribe("slipd/#", 1)
        self.client.on_subscribe = lambda *_: setattr(self, "ready", True)
        self.client.on_message = self._take
        set_up(self.client)
        self.client.connect("127.0.0.1", port, 5)
        self.client.loop_start()
        await_true(lambda: self.ready, "the subscription")

    def _take(self, _client, _data, message):
        payload = json.loads(message.payload) if message.payload else None
        self.messages.append((message.topic, payload))
        self.retained[message.topic] = payload
        if message.topic.endswith("/alert"):
            self.alerts.append(payload)

    def numbers(self):
        return [alert["number"] for alert in self.alerts]

    def close(self):
        self.client.disconnect()
        self.client.loop_stop()


class PeerTest(BridgeTest):
    """A stand-in for slipd with two sensors, mosquitto and Paho."""

    def setUp(self):
        super().setUp()
        self.slipd = self.fake_slipd()

    def broker(self, *arguments, **named):
        broker = Mosquitto(self.folder, *arguments, **named)
        self.addCleanup(broker.kill)
        return broker

    def bridge(self, *brokers, **more):
        return self.bridge_of(self.slipd, brokers, **more)

    def subscriber(self, *arguments, **named):
        subscriber = Subscriber(*arguments, **named)
        self.addCleanup(subscriber.close)
        return subscriber


class Peer(PeerTest):
    def test_birth_states_estimates_and_the_end(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        bridge = self.bridge(broker)
        born = await_true(lambda: (reader.retained.get("slipd/gripper/status") or {}).get("slipd") and reader.retained["slipd/gripper/status"],
                          "the birth; " + bridge.log())
        self.assertEqual(born["status"], "online")
        self.assertEqual([sensor["name"] for sensor in born["sensors"]], ["left", "right"])
        self.slipd.estimate("left", gamma=0.62)
        got = await_true(lambda: reader.retained.get("slipd/gripper/left/estimate"), "the estimate")
        self.assertEqual((got["gamma"], got["state"]), (0.62, "ok"))
        self.slipd.send("state", self.slipd.message("left", state="learning", gamma=None))
        await_true(lambda: (reader.retained.get("slipd/gripper/left/state") or {}).get("state") == "learning", "the state")
        late = self.subscriber(broker.port, "late")
        await_true(lambda: (late.retained.get("slipd/gripper/left/state") or {}).get("state") == "learning", "the retained state")
        self.assertNotIn("slipd/gripper/left/estimate", late.retained)
        self.assertEqual(bridge.stop(), 0)
        ended = await_true(lambda: reader.retained["slipd/gripper/status"]["status"] == "offline" and reader.retained["slipd/gripper/status"], "the end")
        self.assertIsNotNone(ended["time_ns"])
        # Which came before the end of the connection.
        self.assertEqual([reader.retained[f"slipd/gripper/{sensor}/state"]["state"] for sensor in ("left", "right")], ["disconnected"] * 2)

    def test_an_estimate_that_is_old_has_no_margin(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        self.bridge(broker)
        self.slipd.estimate("left", age_ms=5000.0)
        got = await_true(lambda: reader.retained.get("slipd/gripper/left/estimate"), "the estimate")
        self.assertEqual((got["gamma"], got["gamma_low"], got["state"]), (None, None, "stale"))

    def test_a_killed_bridge_leaves_its_last_will(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        bridge = self.bridge(broker)
        await_true(lambda: (reader.retained.get("slipd/gripper/status") or {}).get("status") == "online", "the birth")
        bridge.kill()
        gone = await_true(lambda: reader.retained["slipd/gripper/status"]["status"] == "offline" and reader.retained["slipd/gripper/status"], "the will")
        self.assertIsNone(gone["time_ns"])

    def test_slipd_that_goes_makes_every_state_disconnected(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        self.bridge(broker)
        self.slipd.estimate("left")
        await_true(lambda: reader.retained.get("slipd/gripper/left/state"), "the state")
        self.slipd.close()
        for sensor in "left", "right":
            await_true(lambda: (reader.retained.get(f"slipd/gripper/{sensor}/state") or {}).get("state") == "disconnected", "the loss")
        self.assertIsNone(await_true(lambda: reader.retained["slipd/gripper/status"], "status")["slipd"])

    # The broker dies three times and the bridge once while alerts come: each arrives, in order, and duplicates are recognisable.
    def test_alerts_survive_broker_and_bridge(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        bridge = self.bridge(broker)
        raised = 0
        for turn in range(4):
            for _ in range(50):
                self.slipd.alert("left" if raised % 2 else "right")
                raised += 1
            await_true(lambda: max(reader.numbers(), default=0) >= raised - 25, "half of them; " + bridge.log())
            if turn == 3:
                break
            broker.stop()
            for _ in range(100):
                self.slipd.alert("left")
                raised += 1
            if turn == 1:
                bridge.kill()  # what was in slipd's socket is lost with it: count from what is on disk
                raised = self.on_disk(bridge)
                bridge.start()
                await_true(self.slipd.subscribers, "the subscription at slipd")
                for sensor in "left", "right":  # whichever was lost, this is a change
                    self.slipd.alert(sensor, "none")
                    raised += 1
            broker.start()
        await_true(lambda: len(set(reader.numbers())) >= raised, f"{raised} alerts, got {len(set(reader.numbers()))}; " + bridge.log())
        first_seen = list(dict.fromkeys(reader.numbers()))
        self.assertEqual(first_seen, list(range(1, len(first_seen) + 1)))
        self.assertEqual(len({alert["series"] for alert in reader.alerts}), 1)
        self.assertEqual({alert["dropped"] for alert in reader.alerts}, {0})

    # The broker is killed and stays away while many alerts come, as in minutes without it: none is lost, and order is kept.
    def test_many_alerts_while_the_broker_is_away(self):
        broker = self.broker(["allow_anonymous true", "autosave_on_changes true", "max_queued_messages 0"])
        reader = self.subscriber(broker.port)
        bridge = self.bridge(broker)
        raised = 0
        for turn in range(3):
            for _ in range(20):
                self.slipd.alert("left")
                raised += 1
            # What a broker has acknowledged and not delivered yet is its own to lose.
            await_true(lambda: len(reader.numbers()) and max(reader.numbers()) == raised, "the alerts; " + bridge.log())
            if turn == 2:
                break
            broker.kill()
            for _ in range(700):
                self.slipd.alert("right" if raised % 2 else "left")
                raised += 1
                # As many as the socket between them holds.
                if raised % 50 == 0:
                    await_true(lambda: self.on_disk(bridge) == raised, "the alerts on disk; " + bridge.log())
            await_true(lambda: self.on_disk(bridge) == raised, "the alerts on disk; " + bridge.log())
            broker.start()
            await_true(lambda: max(reader.numbers()) == raised, "the alerts; " + bridge.log())
        self.assertEqual(list(dict.fromkeys(reader.numbers())), list(range(1, raised + 1)))
        self.assertEqual({alert["dropped"] for alert in reader.alerts}, {0})

    def on_disk(self, bridge):
        database = sqlite3.connect(bridge.settings.replace(".json", ".db"))
        try:
            return (database.execute("SELECT seq FROM sqlite_sequence").fetchone() or (0,))[0]
        finally:
            database.close()

    def test_a_full_store_drops_the_oldest_and_says_so(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        bridge = self.bridge(broker, store={"max_alerts": 10})
        await_true(lambda: "accepted" in bridge.log(), "the connection")
        broker.stop()
        await_true(lambda: "lost" in bridge.log() or "refused" in bridge.log(), "the loss")
        for _ in range(25):
            self.slipd.alert("left")
        await_true(lambda: self.on_disk(bridge) == 25, "25 alerts")
        broker.start()
        await_true(lambda: len(set(reader.numbers())) == 10, f"10 alerts, got {reader.numbers()}; " + bridge.log())
        self.assertEqual(sorted(set(reader.numbers())), list(range(16, 26)))
        self.assertEqual(reader.alerts[-1]["dropped"], 15)

    def test_the_next_broker_takes_over(self):
        one, other = self.broker(), self.broker()
        reader = self.subscriber(other.port)
        bridge = self.bridge(one, other)
        await_true(lambda: "accepted" in bridge.log(), "the first broker")
        one.kill()
        self.slipd.alert("left")
        await_true(lambda: reader.numbers(), "the alert at the other; " + bridge.log())

    def test_tls_and_a_password(self):
        authority = Certificates(self.folder, "ca")
        certificate, key = authority.issue("IP:127.0.0.1")
        path = lambda name: os.path.join(self.folder, name)
        subprocess.run([shutil.which("mosquitto_passwd", path="/usr/bin:/usr/sbin"), "-b", "-c", path("users"), "gripper", "secret"], check=True)
        for name, text in ("password", "secret\n"), ("wrong", "guess\n"):
            with open(path(name), "w") as file:
                file.write(text)
        broker = self.broker([f"password_file {path('users')}", "allow_anonymous false"],
                             listener=f"cafile {authority.ca_file}\ncertfile {certificate}\nkeyfile {key}")
        def secure(client):
            client.tls_set(authority.ca_file)
            client.username_pw_set("gripper", "secret")
        reader = self.subscriber(broker.port, set_up=secure)
        settings = {"host": "127.0.0.1", "port": broker.port, "user": "gripper", "password_file": path("password"), "tls": {"ca_file": authority.ca_file}}
        self.bridge(settings, host="right")
        self.slipd.alert("left")
        await_true(reader.numbers, "the alert over TLS")
        refused = Bridge(self.folder, self.slipd.path, [settings | {"password_file": path("wrong")}], host="wrong")
        self.addCleanup(refused.kill)
        await_true(lambda: "not authorised" in refused.log().lower() or "refused" in refused.log().lower(), "the refusal; " + refused.log())
        stranger = Bridge(self.folder, self.slipd.path, [settings | {"tls": {}}], host="stranger")
        self.addCleanup(stranger.kill)
        await_true(lambda: "<4>127.0.0.1" in stranger.log(), "the refused certificate; " + stranger.log())
        self.assertIn("certificate verify failed", stranger.log())
        self.assertNotIn("accepted", stranger.log())


if __name__ == "__main__":
    unittest.main(warnings="ignore")
