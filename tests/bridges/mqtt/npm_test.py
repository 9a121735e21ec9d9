"""Alerts at MQTT.js and at NATS's own client for Node.js, over brokers that are killed: every one, and none of a number that was not given."""
import json, os, subprocess, threading, unittest

from awaiting import PATIENCE_S, await_true
from nats_servers import PROGRAM as NATS, make_messages_stream, start_servers
from peer_test import Mosquitto
from support import BridgeTest

NPM, HERE = os.environ["SLIPD_PEERS_NPM"], os.path.dirname(os.path.realpath(__file__))


class Client:
    """alerts.mjs: the alerts in the order of their arrival."""

    def __init__(self, *arguments):
        self.program = subprocess.Popen(["node", os.path.join(HERE, "alerts.mjs"), *map(str, arguments)], cwd=NPM, stdout=subprocess.PIPE, text=True)
        self.alerts, self.ready = [], threading.Event()
        self.thread = threading.Thread(target=self._read)
        self.thread.start()

    def _read(self):
        for line in self.program.stdout:
            if line == "ready\n":
                self.ready.set()
            else:
                self.alerts.append(json.loads(line))

    def numbers(self):
        """Of the alerts, each once, in the order of their first arrival."""
        return list(dict.fromkeys(alert["number"] for alert in self.alerts))

    def close(self):
        self.program.kill()
        self.program.wait()
        self.thread.join()
        self.program.stdout.close()


class Npm(BridgeTest):
    def setUp(self):
        super().setUp()
        self.slipd = self.fake_slipd()

    def client(self, *arguments):
        client = Client(*arguments)
        self.addCleanup(client.close)
        self.assertTrue(client.ready.wait(PATIENCE_S), "alerts.mjs did not subscribe")
        return client

    def bridge(self, broker):
        return self.bridge_of(self.slipd, [broker])

    def kill_and_start(self, broker, clients, bridge, loses=False):
        """Alerts before, during and after two outages of the broker, of which every client gets all, in order. `loses`: what the broker has
        acknowledged it may lose until it has delivered it."""
        raised = 0
        for _ in range(3):
            for _ in range(40):
                self.slipd.alert("left" if raised % 2 else "right")
                raised += 1
            wanted = raised if loses else 1
            await_true(lambda: all(len(client.numbers()) >= wanted for client in clients), f"{wanted} alerts; {bridge.log()}")
            if raised < 160:
                broker.kill()
                for _ in range(40):
                    self.slipd.alert("left")
                    raised += 1
                broker.start()
        for client in clients:
            await_true(lambda: len(client.numbers()) >= raised, f"{raised} alerts; {bridge.log()}")
            self.assertEqual(client.numbers(), list(range(1, raised + 1)))
            self.assertEqual({alert["dropped"] for alert in client.alerts}, {0})

    def test_mqtt_js_at_mosquitto(self):
        broker = Mosquitto(self.folder, ["allow_anonymous true", "autosave_on_changes true", "max_queued_messages 0"])
        self.addCleanup(broker.kill)
        self.kill_and_start(broker, [self.client("mqtt", broker.port)], self.bridge(broker), loses=True)

    @unittest.skipIf(NATS is None, "nats-server is not installed: run tools/setup --peers")
    def test_mqtt_js_and_nats_js_at_nats(self):
        [broker] = start_servers(self.folder, 1)
        self.addCleanup(broker.kill)
        make_messages_stream([broker])
        clients = [self.client("mqtt", broker.port), self.client("nats", broker.client)]
        self.kill_and_start(broker, clients, self.bridge(broker))


if __name__ == "__main__":
    unittest.main(warnings="ignore")
