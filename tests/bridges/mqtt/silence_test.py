"""What a broker keeps, and what it says, when slipd goes, hangs or falls silent, and when slipd-mqtt does: never ok or no alert of what is dead."""
import json, signal, threading, unittest

import paho.mqtt.client as paho

from awaiting import PATIENCE_S, await_true
from fleet_test import Playing
from peer_test import PeerTest


class Silence(PeerTest):
    def state(self, reader, sensor="left"):
        got = reader.retained.get(f"slipd/gripper/{sensor}/state") or {}
        return got.get("state"), got.get("alert")

    def await_state(self, reader, state, alert, sensor="left"):
        await_true(lambda: self.state(reader, sensor) == (state, alert), f"{sensor} {state} {alert}")

    def kept(self, broker):
        """The retained messages of `broker`, by topic."""
        found, complete = {}, threading.Event()

        def take(_client, _data, message):
            if message.topic == "complete":
                complete.set()
            elif message.retain:
                found[message.topic] = json.loads(message.payload)

        client = paho.Client("late")
        client.on_connect = lambda *_: client.subscribe([("slipd/#", 1), ("complete", 1)])
        client.on_subscribe = lambda *_: client.publish("complete", b"", 1)  # comes behind what is retained
        client.on_message = take
        client.connect("127.0.0.1", broker.port)
        client.loop_start()
        self.assertTrue(complete.wait(PATIENCE_S), "the broker did not answer")
        client.disconnect()
        client.loop_stop()
        return found

    def await_expiry(self, broker):
        def expired():
            kept = self.kept(broker)
            return not any(topic.endswith(("/state", "/summary")) or message.get("status") == "online" for topic, message in kept.items()) and kept
        kept = await_true(expired, "the expiry of what a slipd-mqtt that has gone said")
        self.assertIn("slipd/gripper/seen", kept)

    def test_an_alert_stands_while_slipd_is_away_and_that_there_is_none_is_unknown(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        self.bridge(broker)
        self.slipd.estimate("left")
        self.slipd.alert("left", "slip")
        self.slipd.estimate("right")
        self.await_state(reader, "ok", "slip")
        self.await_state(reader, "ok", "none", "right")
        self.slipd.close()
        self.await_state(reader, "disconnected", "slip")
        self.await_state(reader, "disconnected", "unknown", "right")
        # A slipd that has started anew does not know the alert. It stands until frames show its end, which is recorded.
        again = self.fake_slipd()
        await_true(again.subscribers, "the subscription at the next slipd")
        again.send("state", again.message("left", state="stale", gamma=None, alert="unknown", time_ns=None, age_ms=None))
        self.await_state(reader, "stale", "slip")
        again.estimate("left")
        self.await_state(reader, "ok", "none")
        await_true(lambda: len(reader.alerts) == 2, "the end of the alert")
        self.assertEqual([alert["alert"] for alert in reader.alerts], ["slip", "none"])

    def test_only_alerts_that_were_raised_or_ended_are_recorded(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        self.bridge(broker)
        for level in "unknown", "none", "unknown", "none", "warn", "unknown", "none", "unknown", "slip":
            self.slipd.alert("left", level)
        await_true(lambda: len(reader.alerts) == 3, "three alerts")
        self.assertEqual([(alert["number"], alert["alert"]) for alert in reader.alerts], [(1, "warn"), (2, "none"), (3, "slip")])

    # As after a restart of slipd, or where slipd-mqtt read too slowly.
    def test_an_alert_whose_event_was_lost_is_recorded_by_the_next_estimate(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        self.bridge(broker)
        for level in "none", "warn", "warn", "slip", "none":
            self.slipd.estimate("left", alert=level)
        await_true(lambda: len(reader.alerts) == 3, "three alerts")
        self.assertEqual([(alert["number"], alert["alert"]) for alert in reader.alerts], [(1, "warn"), (2, "slip"), (3, "none")])

    # slipd sends the estimate of a frame first, then the event of its alert, then that of its state.
    def test_an_alert_that_several_events_tell_of_is_recorded_once(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        self.bridge(broker)
        for level in "slip", "none":
            for event in "estimate", "alert", "state":
                self.slipd.send(event, self.slipd.message("left", alert=level))
        await_true(lambda: "none" in [alert["alert"] for alert in reader.alerts], "the end of the alert")
        self.assertEqual([(alert["number"], alert["alert"]) for alert in reader.alerts], [(1, "slip"), (2, "none")])

    def test_an_alert_that_stands_is_recorded_once_and_its_end_also_over_a_restart_of_the_bridge(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        bridge = self.bridge(broker)
        self.slipd.alert("left", "slip")
        await_true(lambda: reader.alerts, "the alert")
        self.assertEqual(bridge.stop(), 0)
        await_true(lambda: not self.slipd.subscribers(), "the end of the subscription")
        bridge.start()
        await_true(self.slipd.subscribers, "the subscription at slipd")
        self.slipd.estimate("left")  # it still slips
        self.slipd.estimate("right", alert="warn")  # which began meanwhile
        self.slipd.alert("left", "none")
        await_true(lambda: len(reader.alerts) >= 3, "the end of the alert")
        self.assertEqual([(alert["sensor"], alert["alert"]) for alert in reader.alerts], [("left", "slip"), ("right", "warn"), ("left", "none")])

    def test_a_sensor_that_falls_silent_is_stale(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        self.bridge(broker, max_age_ms=300)
        self.slipd.alert("left", "warn")
        self.slipd.estimate("left")
        self.slipd.estimate("right")
        self.await_state(reader, "stale", "warn")
        self.await_state(reader, "stale", "unknown", "right")
        for topic, payload in reader.messages:
            if topic.endswith("/right/state") and payload["state"] == "stale":
                self.assertEqual((payload["health"], payload["sliding"]), ("unknown", None))
        with Playing(self.slipd, right=0.6):
            self.await_state(reader, "ok", "none", "right")

    # Neither are the states of before sent by then, nor is the wait for an answer the end of the program.
    def test_a_slipd_that_hangs_makes_every_state_stale_and_then_disconnected(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        self.bridge(broker)
        for sensor in "left", "right":
            self.slipd.estimate(sensor)
            await_true(lambda: any(topic.endswith(f"/{sensor}/state") and payload["state"] == "ok" for topic, payload in reader.messages), "the state")
        self.server.close()  # it answers nothing any more
        self.addCleanup(setattr, self.server, "close", lambda: None)
        for sensor in "left", "right":
            self.await_state(reader, "disconnected", "unknown", sensor)
            said = [payload["state"] for topic, payload in reader.messages if topic.endswith(f"/{sensor}/state")]
            self.assertLess(said.index("stale"), said.index("disconnected"))

    def test_a_state_that_holds_is_said_anew(self):
        broker = self.broker()
        reader = self.subscriber(broker.port)
        self.bridge(broker, summary_s=1)
        with Playing(self.slipd, left=0.6):
            for topic in "left/state", "status", "summary", "seen":
                await_true(lambda: sum(got == "slipd/gripper/" + topic for got, _ in reader.messages) > 4, topic + " anew")
        states = [payload for topic, payload in reader.messages if topic.endswith("left/state") and payload["state"] == "ok"]
        self.assertGreater(states[-1]["time_ns"], states[0]["time_ns"])
        self.assertEqual({payload["valid_for_ms"] for payload in states}, {2000})

    def test_nothing_that_a_broker_keeps_outlives_a_bridge_that_hangs(self):
        broker = self.broker()
        bridge = self.bridge(broker, summary_s=1)
        with Playing(self.slipd, left=0.6):
            await_true(lambda: (self.kept(broker).get("slipd/gripper/left/state") or {}).get("state") == "ok", "the state")
            bridge.program.send_signal(signal.SIGSTOP)
            self.await_expiry(broker)

    # A broker that restarts publishes no last will of before.
    def test_nothing_that_a_broker_keeps_on_disk_outlives_a_bridge_that_died_while_it_was_away(self):
        broker = self.broker()
        bridge = self.bridge(broker, summary_s=1)
        with Playing(self.slipd, left=0.6):
            await_true(lambda: (self.kept(broker).get("slipd/gripper/left/state") or {}).get("state") == "ok", "the state")
            broker.stop()  # which saves
            bridge.kill()
            broker.start()
            self.await_expiry(broker)


if __name__ == "__main__":
    unittest.main(warnings="ignore")
