"""The doors of slipd, and what a consumer at each of them believes while something dies: a matrix of doors and failures.

Each consumer is a program that follows the rules of its door's page and prints what it believes (consumer.py, consumer.c). Of a cell counts the last
moment at which it believed in a margin or in "no alert", from the failure on. All runs in a network of its own, whose interface is taken down as
the network's cut."""
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

from awaiting import PATIENCE_S, await_true
from failures import BUILD, CAN_PERIOD_S, CLOCK_FAILURES, FAILURES, MAX_AGE_S, SENSORS, SLOWER, Bed, mend_network
from ports import await_listening, free_port

HERE = Path(__file__).parent
GOES_ON_S = 0.5 * SLOWER  # how long a consumer is listened to after a failure at least; in the second half of that it must not believe


class Consumer:
    """A program at a door, for one sensor; its lines as they come."""

    def __init__(self, command, log):
        self.said, self.lock = [], threading.Lock()
        self.process = subprocess.Popen([str(each) for each in command], stdout=subprocess.PIPE, stderr=log, text=True,
                                        start_new_session=True)  # with the programs that it starts
        self.reader = threading.Thread(target=self._read)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            now = json.loads(line)
            with self.lock:
                self.said.append(now)

    def all(self):
        with self.lock:
            return list(self.said)

    def end(self):
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self.reader.join()
        self.process.stdout.close()


class Door:
    """`command(bed, sensor)`: the consumer's. `serve(bed)`: starts what stands between slipd and the consumer; returns after it serves. `needs()`: which
    programs of others are not installed, or None; without it the door needs none."""

    def __init__(self, name, command, serve=None, networked=False, needs=None):
        self.name, self.command, self.serve, self.networked, self.needs = name, command, serve, networked, needs

    def concerned_by(self, failure):
        return failure.reaches == "all" or (self.serve and failure.reaches == "bridges") or (self.networked and failure.reaches == "network")


def _python(door, address=lambda bed: bed.socket):
    return lambda bed, sensor: [sys.executable, HERE / "consumer.py", door, address(bed), MAX_AGE_S, sensor]


def _libslipd(door):
    return lambda bed, sensor: [BUILD / "test-bin" / "door-consumer", door, bed.socket, MAX_AGE_S, sensor]


def _serve_modbus(bed):
    bed.modbus_port = free_port()
    bed.bridge("slipd-modbus", {"port": bed.modbus_port, "socket": bed.socket, "max_age_ms": 1e3 * MAX_AGE_S, "blocks": list(SENSORS)})


def _serve_mqtt(bed):
    bed.mqtt_port = free_port()
    (bed.folder / "mosquitto.conf").write_text(f"listener {bed.mqtt_port} 127.0.0.1\nallow_anonymous true\n")
    bed.programs.append(subprocess.Popen(["mosquitto", "-c", bed.folder / "mosquitto.conf"], stdout=bed.log, stderr=bed.log))
    await_listening(bed.mqtt_port, "mosquitto")
    bed.bridge("slipd-mqtt", {"brokers": [{"host": "127.0.0.1", "port": bed.mqtt_port, "keepalive_s": 5}], "host": "gripper", "socket": bed.socket,
                              "store": {"file": str(bed.folder / "alerts.db")}, "rate_hz": 50, "max_age_ms": 1e3 * MAX_AGE_S, "summary_s": 1})


ROS_DEADLINE_MS, ROS_LEASE_MS = 200, 400  # docs/ros2.md


def _serve_ros2(bed):
    bed.domain = 1 + os.getpid() % 100
    bed.bridge("slipd-ros2", {"socket": bed.socket, "domain": bed.domain, "max_age_ms": 1e3 * MAX_AGE_S})


def _serve_page(bed):
    bed.bridge("slipd-web", {"slipd": {"socket": bed.socket, "max_age_ms": 1e3 * MAX_AGE_S}, "listen": {"port": 0}, "recordings": str(bed.folder)})
    bed.page = await_true(lambda: re.search(r"http://[0-9.:]+/", bed.said()), "the page's address").group(0) + "#/live"


def _missing_for_mqtt():
    return None if shutil.which("mosquitto") and importlib.util.find_spec("paho") else "mosquitto and python3-paho-mqtt"


def _missing_for_ros2():
    return None if (BUILD / "test-bin" / "ros2-cyclone-reader").exists() else "Cyclone DDS"


def _missing_for_page():
    return None if shutil.which("chromium") and shutil.which("chromedriver") and importlib.util.find_spec("selenium") else "chromium and python3-selenium"


DOORS = [
    Door("shared memory, C", _libslipd("memory")),
    Door("shared memory, Python", _python("board")),
    Door("socket, no library", _python("socket")),
    Door("socket, C", _libslipd("subscription")),
    Door("socket, Python", _python("client")),
    Door("socket, asyncio", _python("asyncio")),
    Door("Modbus", _python("modbus", lambda bed: f"127.0.0.1:{bed.modbus_port}"), _serve_modbus, networked=True),
    Door("MQTT, estimates", _python("mqtt-estimates", lambda bed: f"127.0.0.1:{bed.mqtt_port}"), _serve_mqtt, networked=True, needs=_missing_for_mqtt),
    Door("MQTT, retained states", _python("mqtt-states", lambda bed: f"127.0.0.1:{bed.mqtt_port}"), _serve_mqtt, networked=True, needs=_missing_for_mqtt),
    Door("ROS 2", _python("ros2", lambda bed: f"{ROS_DEADLINE_MS}/{ROS_LEASE_MS}/{bed.domain}"), _serve_ros2, networked=True, needs=_missing_for_ros2),
    Door("page", _python("page", lambda bed: bed.page), _serve_page, needs=_missing_for_page),
]


PEERLESS_DOORS = [door for door in DOORS if not door.needs]
PEERS_DOORS = [door for door in DOORS if door.needs]


CAN_DOORS = [Door("CAN", _python("can", lambda bed: f"{bed.can}/{CAN_PERIOD_S}"), networked=True)]


def available(doors):
    for door in doors:
        if door.needs and door.needs():
            print(f"doors: left out: {door.name}: {door.needs()} is not installed (tools/setup --peers)", file=sys.stderr)
    return [door for door in doors if not (door.needs and door.needs())]


def believes_ok(now):
    return now["state"] == "ok" or now["gamma"] is not None


def believes_no_alert(now):
    return now["alert"] == "none"


class Cell:
    """What one consumer believed after a failure. `late_s`: how long it went on believing in a margin, or in no alert; `then`: its last word."""

    def __init__(self, door, sensor, after, broken_at):
        self.door, self.sensor, self.after = door, sensor, after
        wrong = [now["t"] for now in after if believes_ok(now) or believes_no_alert(now)]
        self.late_s = max(0.0, max(wrong, default=broken_at) - broken_at)
        self.then = after[-1]


def run(failure, doors, folder, can=None):
    """The cells of a failure, of all doors that it concerns, each for both sensors. Raises AssertionError if one goes on believing."""
    doors = [door for door in doors if door.concerned_by(failure)]
    bed, consumers = Bed(folder, failure.misbehaves, can), {}
    try:
        for serve in dict.fromkeys(door.serve for door in doors if door.serve):  # doors may share a bridge
            serve(bed)
        for door in doors:
            for sensor in SENSORS:
                consumers[door.name, sensor] = Consumer(door.command(bed, sensor), bed.log)
        for (door, sensor), consumer in consumers.items():
            alert = "slip" if sensor == "right" else "none"
            _await(lambda c=consumer, a=alert: any(believes_ok(now) and now["alert"] == a for now in c.all()[-5:]),
                   lambda c=consumer, what=f"{failure.name}: no margin of {sensor} comes at {door}": f"{what}: {c.all()[-1:]} {bed.said()[-2000:]}")
        failure.break_it(bed)
        broken_at = time.monotonic()
        cells = [_settled(failure, door, sensor, consumer, broken_at) for (door, sensor), consumer in consumers.items()]
        return cells
    finally:
        if failure.reaches == "network":
            mend_network(bed)
        for consumer in consumers.values():
            consumer.end()
        bed.end()


def _await(condition, explain):
    """`explain()`: what went wrong, when it has."""
    try:
        await_true(condition, "", PATIENCE_S)
    except AssertionError:
        raise AssertionError(explain()) from None


def _settled(failure, door, sensor, consumer, broken_at):
    """The cell, once the consumer has said for a while nothing that it cannot know."""
    def after():
        return [now for now in consumer.all() if now["t"] >= broken_at]

    def settled():
        said = after()
        return (len(said) >= 2 and said[-1]["t"] - broken_at > GOES_ON_S and
                not any(believes_ok(now) or believes_no_alert(now) for now in said if now["t"] > said[-1]["t"] - GOES_ON_S / 2))
    _await(settled, lambda: f"{failure.name}: {sensor} at {door} goes on believing: {consumer.all()[-3:]}")
    return Cell(door, sensor, after(), broken_at)


def in_a_network_of_its_own():
    """Starts this program again there, where `lo` can be taken down. False: that is not permitted here."""
    if os.environ.get("SLIPD_DOORS_NETWORK"):
        subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
        return True
    command = ["unshare", "-n"] if os.geteuid() == 0 else ["unshare", "-Urn"]
    if subprocess.run([*command, "true"], stderr=subprocess.DEVNULL).returncode != 0:
        return False
    os.execvpe("unshare", [*command, sys.executable, *sys.argv], {**os.environ, "SLIPD_DOORS_NETWORK": "1"})


def failures_possible(networked, clock=False):
    """`networked`: the network is its own, or the CAN bus; `clock`: the machine's clock may be set."""
    return [failure for failure in FAILURES + (CLOCK_FAILURES if clock else []) if networked or failure.reaches != "network"]
