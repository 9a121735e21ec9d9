"""What can die between an object and a consumer of slipd, and the bed in which it does: slipd with a finger that holds (`left`, no alert) and one
whose object is about to slip (`right`, alert slip), the bridges, and a stop of any of them."""
import json
import os
import signal
import subprocess
import time
from pathlib import Path

from awaiting import await_true
from stopping import StoppedThread

BUILD = Path(os.environ["SLIPD_BINARY_DIR"])
# By how much all is slower than elsewhere: a guest's processor is emulated.
SLOWER = float(os.environ.get("SLIPD_DOORS_SLOWER", "1"))
RATE_HZ = 100 / SLOWER
MAX_AGE_S = 0.1 * SLOWER
STALE_AFTER_MS = 1e3 * MAX_AGE_S
CAN_PERIOD_S = 0.02 * SLOWER
SENSORS = {"left": 0.7, "right": 0.05}  # margins


class Bed:
    """slipd and its bridges in `folder`. `misbehaves`: what the sensors do once they are told to."""

    def __init__(self, folder, misbehaves="steady", can=None):
        self.folder, self.log = Path(folder), open(Path(folder) / "log", "wb")
        self.socket = str(self.folder / "slipd.sock")
        self.programs, self.bridges, self.can, self.stopped = [], [], can, None
        sensor = {"driver": "trial", "rate_hz": RATE_HZ, "stale_after_ms": STALE_AFTER_MS, "layout": {"grid": [16, 16], "pitch_mm": 0.9}}
        options = {"simulated": can is None, "behaviour": misbehaves, "well_until": str(self.folder / "ill")}
        self.write("slipd.json", {
            "sensors": [{"name": name, "options": {**options, "gamma": gamma}, **sensor} for name, gamma in SENSORS.items()],
            "estimator": {"method": "moments"}, "realtime": {"mode": "off"}, "socket": {"path": self.socket},
            **({"can": {"interface": can, "period_ms": 1e3 * CAN_PERIOD_S}} if can else {})})
        self.slipd = self.start("slipd", "--driver-dir", str(BUILD / "test-drivers"))
        await_true(lambda: Path(self.socket).exists() or self.slipd.poll() is not None, "slipd's socket")

    def write(self, name, settings):
        (self.folder / name).write_text(json.dumps(settings))
        return self.folder / name

    def start(self, program, *more, settings=None):
        """A program of the build tree, with `settings` written to its file first."""
        file = self.write(f"{program}.json", settings) if settings else self.folder / f"{program}.json"
        started = subprocess.Popen([BUILD / "bin" / program, "--config", file, *more], stdout=self.log, stderr=self.log, stdin=subprocess.DEVNULL,
                                   env={**os.environ, "STATE_DIRECTORY": str(self.folder)})
        self.programs.append(started)
        return started

    def bridge(self, program, settings):
        self.bridges.append(self.start(program, settings=settings))
        return self.bridges[-1]

    def said(self):
        return (self.folder / "log").read_text(errors="replace")

    def misbehave(self):
        (self.folder / "ill").touch()

    def end(self):
        if self.stopped:
            self.stopped.end()
        for program in self.programs:
            program.send_signal(signal.SIGCONT)
            program.kill()
            program.wait()
        self.log.close()


def _stop_estimate_thread(bed):
    bed.stopped = StoppedThread(bed.slipd.pid, "estimate")


def _signal_bridges(number):
    def send(bed):
        for bridge in bed.bridges:
            bridge.send_signal(number)
    return send


def _cut_network(bed):
    subprocess.run(["ip", "link", "set", bed.can or "lo", "down"], check=True)


def mend_network(bed):
    subprocess.run(["ip", "link", "set", bed.can or "lo", "up"], check=True)


def _set_clock_and_stop(hours):
    """Whoever takes the age from the time of day only is wrong by an hour, and slipd says nothing more."""
    def break_it(bed):
        bed.slipd.send_signal(signal.SIGSTOP)
        time.clock_settime(time.CLOCK_REALTIME, time.time() + 3600 * hours)
    return break_it


class Failure:
    """`break_it(bed)` returns once it has happened. `misbehaves`: of the sensors, see Bed. `reaches`: which doors it concerns: "all", "bridges" or
    "network"."""

    def __init__(self, name, break_it, reaches="all", misbehaves="steady"):
        self.name, self.break_it, self.reaches, self.misbehaves = name, break_it, reaches, misbehaves


FAILURES = [
    Failure("slipd killed", lambda bed: bed.slipd.send_signal(signal.SIGKILL)),
    Failure("slipd stopped (SIGSTOP)", lambda bed: bed.slipd.send_signal(signal.SIGSTOP)),
    Failure("estimate thread hung", _stop_estimate_thread),
    Failure("sensor silent", Bed.misbehave, misbehaves="silent"),
    Failure("sensor unplugged", Bed.misbehave, misbehaves="vanish"),
    Failure("bridge killed", _signal_bridges(signal.SIGKILL), reaches="bridges"),
    Failure("bridge stopped (SIGSTOP)", _signal_bridges(signal.SIGSTOP), reaches="bridges"),
    Failure("network cut", _cut_network, reaches="network"),
]
# Only where nobody else has this clock.
CLOCK_FAILURES = [
    Failure("clock set back, slipd stopped", _set_clock_and_stop(-1)),
    Failure("clock set ahead, slipd stopped", _set_clock_and_stop(1)),
]
