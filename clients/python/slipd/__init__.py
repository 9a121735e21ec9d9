"""Client of slipd, the daemon that says how close the object in a robotic gripper is to slipping.

    import slipd

    with slipd.Client() as client:
        for estimate in client.estimates("left", max_age_s=0.05):
            if estimate.gamma is None:
                stop(estimate.state)  # says why there is no margin
            elif estimate.gamma < 0.3:
                grip_harder(estimate.grip_increase_n)

    with slipd.Board() as board:  # shared memory: no request, no waiting
        board.attach()
        estimate = board.latest("left", max_age_s=0.02)

    for frame in slipd.open("grasp.rec"):
        print(frame.time_s, sum(frame.normal_pa))

    with slipd.Source("left", taxels=16, rate_hz=100, unit="N") as source:  # frames of a sensor of one's own
        source.push(sensor.read())

A margin is a number in state "ok" only, and only while it is younger than the age that the caller allows. When slipd stops, an
iterator yields estimates of state "disconnected", connects again by itself, and goes on. Estimates may be kept: an old one says so.

AsyncClient has the same for asyncio. A client belongs to one thread. This file needs the standard library only, may be copied, and
uses numpy for taxels if numpy is installed.
"""
from __future__ import annotations

import argparse
import array
import asyncio
import json
import mmap
import os
import select
import socket
import struct
import sys
import time
from collections.abc import AsyncIterator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from io import open as io_open
from typing import Any, BinaryIO

try:
    import numpy
except ImportError:
    numpy = None  # type: ignore[assignment]
try:
    import xxhash
except ImportError:
    xxhash = None  # type: ignore[assignment]

SOCKET = "/run/slipd/slipd.sock"
_RETRY_FIRST_S, _RETRY_LAST_S = 0.05, 2.0  # pauses between attempts to connect
_READ_BYTES = 1 << 16
_HOLD, _HOLD_MOST_S = 0.25, 0.02  # how long what an estimate says when it is handed out stands at least: share of max_age_s, at most
_INFINITE = float("inf")
_STATES = ("ok", "no_contact", "learning", "out_of_model", "no_shear", "unzeroed", "stale", "fault")  # by their numbers
_ALERTS = ("none", "warn", "slip", "unknown")


class SlipdError(Exception):
    """slipd refused a request; the text says what to do. `code`: of docs/socket.md."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class Disconnected(ConnectionError):
    """slipd does not run, or the socket may not be used; the text says which."""


@dataclass(frozen=True)
class Estimate:
    """An estimate of one sensor or of one grasp. None: unknown.

    It is judged when it is handed out and at each access after. Once it is older than max_age_s, all that nobody must act on any
    more goes together: gamma, gamma_low, sigma, the advice, sliding and their like in `values` are None, state is "stale", an alert
    that was "none" is "unknown", a raised one stands. Thus an estimate may be kept, and what is kept never says "ok" for a slipd
    that is dead.

    What it says when it is handed out stands for a quarter of max_age_s, but no more than 20 ms, so that a decision that reads several fields, as
    `if estimate.gamma is None: … elif estimate.gamma < 0.3: grip(estimate.grip_increase_n)`, reads one judgement, also where the
    estimate is about to be too old. A program that stands still for longer amid its decision finds None where a number was: an
    error, rather than an act on an old margin. `kept.now()` hands out again what was kept.
    """

    name: str  # of the sensor or grasp
    max_age_s: float  # older ones have state "stale"
    at_state: str  # the state when it was sent: "ok", "no_contact", "learning", "out_of_model", …, "disconnected"
    at_alert: str = "unknown"  # the alert when it was sent; of "stale" and "disconnected" the last one that came
    at_alert_cause: str | None = None
    sent: Mapping[str, Any] = field(repr=False, default_factory=dict)  # all that slipd sent, however old: not to act on
    sent_age_s: float = field(repr=False, default=_INFINITE)  # age of its frame when it was sent, s; infinite: of no frame
    taken_ns: int = field(repr=False, default_factory=time.monotonic_ns)  # when it was read; CLOCK_MONOTONIC
    time_ns: int | None = None  # of its frame; CLOCK_REALTIME
    seq: int | None = None  # of its frame; the device counts
    friction: float | None = None  # coefficient
    friction_sigma: float | None = None
    normal_n: float | None = None  # normal force, N
    shear_n: float | None = None  # tangential force, N
    torque_nmm: float | None = None  # about the contact's normal, N mm
    simulated: bool = False
    dropped: int = 0  # estimates lost just before this one because they were read too slowly
    event: str = "estimate"  # "estimate", "alert", "state"; of subscriptions
    held_until_s: float = field(init=False, repr=False)  # what it said when it was handed out stands until then, time.monotonic()

    def __post_init__(self) -> None:
        hold_s = min(_HOLD * self.max_age_s, _HOLD_MOST_S) if self._is_young() else -_INFINITE
        object.__setattr__(self, "held_until_s", time.monotonic() + hold_s)

    def _is_young(self) -> bool:
        age_s = self.age_s
        return age_s <= self.max_age_s and age_s < _INFINITE

    def _holds(self) -> bool:
        return time.monotonic() <= self.held_until_s or self._is_young()

    def now(self) -> Estimate:
        """The same, handed out now."""
        return replace(self)

    @property
    def age_s(self) -> float:
        """Age of its frame now, s. Two clocks count: one may be set, the other does not see what waited in the socket."""
        since_read = self.sent_age_s + 1e-9 * (time.monotonic_ns() - self.taken_ns)
        return since_read if self.time_ns is None else max(since_read, 1e-9 * (time.time_ns() - self.time_ns))

    @property
    def state(self) -> str:
        """The state now: at_state, or "stale" once it is too old. "fault" and "disconnected" stay."""
        return self.at_state if self.at_state in ("fault", "disconnected") or self._holds() else "stale"

    @property
    def gamma(self) -> float | None:
        """The safety margin, 0 (slips) … 1 (no tangential load), in state "ok"; else None."""
        return self._unless_old("gamma") if self.at_state == "ok" else None

    @property
    def gamma_low(self) -> float | None:
        """A margin that holds with 95 % confidence, also while friction is learnt; None if too old."""
        return self._unless_old("gamma_low")

    @property
    def sigma(self) -> float | None:
        """Standard deviation of the margin; None if too old."""
        return self._unless_old("sigma")

    @property
    def grip_increase_n(self) -> float | None:
        """Normal force to add for the configured target margin, N; None if too old."""
        return self._unless_old("grip_increase_n")

    @property
    def time_to_slip_ms(self) -> float | None:
        """Time until the object slips as the margin falls now, ms; None if it does not fall, or too old."""
        return self._unless_old("time_to_slip_ms")

    @property
    def sliding(self) -> str | None:
        """Whether the object slides: "none", "disturbed", "translation", "rotation"; None if nothing shows it, or too old."""
        return self._unless_old("sliding")

    @property
    def alert(self) -> str:
        """"none" (slipd watches and there is none), "warn", "slip", "unknown". A raised one stands, however old."""
        return self.at_alert if self.at_alert != "none" or self._holds() else "unknown"

    @property
    def alert_cause(self) -> str | None:
        """Of a raised alert: "margin" or "sliding"."""
        return self.at_alert_cause if self.at_alert in ("warn", "slip") else None

    @property
    def health(self) -> str:
        """"good", or what speaks against the frame; "unknown": no frame was checked, it is too old, or it is of a grasp."""
        return self._unless_old("health") or "unknown"

    @property
    def values(self) -> Mapping[str, Any]:
        """All that slipd sent; of what is too old only what may still be used. Empty if slipd sent nothing."""
        if not self.sent or self._holds():
            return self.sent
        return {**self.sent, **{key: None for key in _NOT_WHEN_OLD if key in self.sent}, "state": self.state, "alert": self.alert,
                "health": "unknown"}

    def _unless_old(self, key: str) -> Any:
        return self.sent.get(key) if self._holds() else None


_TAKEN = ("time_ns", "seq", "friction", "friction_sigma", "normal_n", "shear_n", "torque_nmm", "simulated", "dropped")
_NOT_WHEN_OLD = ("gamma", "gamma_low", "sigma", "class", "grip_increase_n", "grip_increase_sigma_n", "time_to_slip_ms", "sliding",
                 "sliding_for_ms", "a_over_r", "first", "first_gamma")


def _estimate(values: Mapping[str, Any], max_age_s: float, event: str = "estimate", taken_ns: int | None = None) -> Estimate:
    age_ms, alert = values.get("age_ms"), values.get("alert") or "unknown"
    return Estimate(
        name=values.get("sensor") or values.get("grasp") or "", max_age_s=max_age_s, at_state=values.get("state") or "fault",
        # An alert that this module does not have is of a newer slipd: none is missed.
        at_alert=alert if alert in _ALERTS else "slip", at_alert_cause=values.get("alert_cause"), event=event, sent=values,
        taken_ns=time.monotonic_ns() if taken_ns is None else taken_ns,
        # Without an age it is of no frame; one of the future is of another clock, and nobody knows how old it is.
        sent_age_s=_INFINITE if age_ms is None or age_ms < 0 else age_ms * 1e-3,
        **{key: values[key] for key in _TAKEN if key in values})


def _without(name: str, state: str, max_age_s: float, alert: tuple[str, str | None] = ("unknown", None)) -> Estimate:
    """That there is no estimate. `alert`: the last one that came, and its cause."""
    level, cause = alert
    return Estimate(name=name, max_age_s=max_age_s, at_state=state, at_alert=level, at_alert_cause=cause)


class _Lines:
    """Requests and answers as lines, without a socket."""

    def __init__(self) -> None:
        self.last_id = 0
        self.rest = b""
        self.answers: dict[int, Any] = {}
        self.notifications: list[tuple[str, Mapping[str, Any], int]] = []  # the last: when it was read, CLOCK_MONOTONIC

    def request(self, method: str, params: Mapping[str, Any]) -> tuple[int, bytes]:
        self.last_id += 1
        message = {"jsonrpc": "2.0", "id": self.last_id, "method": method, "params": params}
        return self.last_id, json.dumps(message).encode() + b"\n"

    def take(self, received: bytes) -> None:
        *lines, self.rest = (self.rest + received).split(b"\n")
        for line in lines:
            message = json.loads(line)
            if "method" in message:
                self.notifications.append((message["method"], message["params"], time.monotonic_ns()))
            elif message.get("id") is None:  # slipd says why it closes the connection
                raise Disconnected(message["error"]["message"])
            else:
                self.answers[message["id"]] = message

    def result(self, number: int) -> Any:
        answer = self.answers.pop(number)
        if "error" in answer:
            raise SlipdError(answer["error"]["code"], answer["error"]["message"])
        return answer["result"]


def _why(path: str, error: OSError) -> Disconnected:
    if isinstance(error, Disconnected):
        return error
    if isinstance(error, PermissionError):
        return Disconnected(f"{path}: not permitted: become a member of the group slipd, and log in again")
    if isinstance(error, (FileNotFoundError, ConnectionRefusedError)):
        return Disconnected(f"{path}: slipd does not run here: start it, or give the path of its socket")
    if isinstance(error, BlockingIOError):
        return Disconnected(f"{path}: slipd accepts no connections: it hangs, or starts")
    if isinstance(error, (BrokenPipeError, ConnectionResetError)):
        return Disconnected(f"{path}: slipd has closed the connection: it was stopped or restarted")
    return Disconnected(f"{path}: {error.strerror or error}")


def _grasp(reply: Mapping[str, Any], name: str, max_age_s: float) -> Estimate:
    """A grasp is as old as the oldest of its fingers."""
    ages = {sensor["sensor"]: sensor["age_ms"] for sensor in reply["sensors"]}
    for grasp in reply["grasps"]:
        if grasp["grasp"] == name:
            fingers = [ages.get(sensor) for sensor in grasp["sensors"]]
            known = None not in fingers and min(fingers) >= 0
            return _estimate({**grasp, "age_ms": max(fingers) if known else None}, max_age_s)
    raise SlipdError(-32001, f"there is no grasp {name!r}; there are: " + ", ".join(g["grasp"] for g in reply["grasps"]))


class _Watch:
    """What a subscriber has to be told besides what arrives: sensors that are silent, and a slipd that has gone."""

    def __init__(self, max_age_s: float, events: Sequence[str]) -> None:
        self.max_age_s, self.events = max_age_s, events
        self.due: dict[str, float] | None = None  # of each name: when it is silent; None: nothing was ever subscribed
        self.alerts: dict[str, tuple[str, str | None]] = {}  # the last ones that came
        self.pause_s = _RETRY_FIRST_S

    def begin(self, names: Sequence[str]) -> None:
        """A subscription is made."""
        self.due, self.pause_s = dict.fromkeys(names, self._next_due()), _RETRY_FIRST_S

    def _next_due(self) -> float:
        # Whoever wants changes only is not told of silence.
        return time.monotonic() + self.max_age_s if "estimate" in self.events else _INFINITE

    def must_ask(self) -> bool:
        """Whether what there is has to be asked for: of one who is told of changes only, a change may have been before."""
        return "estimate" not in self.events

    def found(self, reply: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any], int]]:
        """What there is, from the answer to `gamma`."""
        assert self.due is not None
        return [(self.events[0], each, time.monotonic_ns()) for each in reply["sensors"] if each["sensor"] in self.due]

    def fresh(self, event: str, values: Mapping[str, Any], taken_ns: int) -> Estimate:
        estimate = _estimate(values, self.max_age_s, event, taken_ns)
        assert self.due is not None
        self.due[estimate.name] = self._next_due()
        self.alerts[estimate.name] = estimate.at_alert, estimate.at_alert_cause
        return estimate

    def wait_s(self) -> float:
        assert self.due is not None
        return max(0.0, min(1.0, min(self.due.values(), default=_INFINITE) - time.monotonic()))

    def silent(self) -> list[Estimate]:
        now = time.monotonic()
        assert self.due is not None
        late = [name for name, due in self.due.items() if due <= now]
        for name in late:
            self.due[name] = now + self.max_age_s
        return [self._without(name, "stale") for name in late]

    def lost(self) -> list[Estimate]:
        return [self._without(name, "disconnected") for name in self.due or ()]

    def _without(self, name: str, state: str) -> Estimate:
        return _without(name, state, self.max_age_s, self.alerts.get(name, ("unknown", None)))

    def next_pause(self) -> float:
        pause, self.pause_s = self.pause_s, min(2 * self.pause_s, _RETRY_LAST_S)
        return pause


def _await_readable(descriptor: Any, until: float) -> None:
    if not select.select([descriptor], [], [], max(0.0, until - time.monotonic()))[0]:
        raise TimeoutError("slipd sends nothing any more")


def _take_with_descriptors(connection: socket.socket, lines: _Lines) -> list[int]:
    """Takes what has arrived, and returns the descriptors that came along."""
    received, descriptors, _, _ = socket.recv_fds(connection, _READ_BYTES, 4)
    if not received:
        raise Disconnected("slipd has closed the connection")
    lines.take(received)
    return descriptors


def _subscription(names: Sequence[str], max_rate_hz: float | None, events: Sequence[str]) -> dict[str, Any]:
    params: dict[str, Any] = {"events": list(events)}
    if names:
        params["sensors"] = list(names)
    if max_rate_hz is not None:
        params["max_rate_hz"] = max_rate_hz
    return params


class Client:
    """A connection to slipd. It is made at the first request and again after it was lost.

    Requests raise SlipdError if slipd refuses them, Disconnected if there is no slipd, TimeoutError after timeout_s.
    """

    def __init__(self, path: str = SOCKET, timeout_s: float = 5.0) -> None:
        self.path, self.timeout_s = path, timeout_s
        self._socket: socket.socket | None = None
        self._lines = _Lines()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection; a later request makes a new one."""
        if self._socket is not None:
            self._socket.close()
        self._socket, self._lines = None, _Lines()

    def _connected(self) -> socket.socket:
        if self._socket is None:
            made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                made.settimeout(self.timeout_s)
                made.connect(self.path)
            except OSError as error:
                made.close()
                raise _why(self.path, error) from error
            self._socket = made
        return self._socket

    def _read(self, timeout_s: float) -> bool:
        """Takes what has arrived; False after timeout_s without anything. It never connects: what was subscribed would be gone."""
        assert self._socket is not None
        if not select.select([self._socket], [], [], max(0.0, timeout_s))[0]:
            return False
        received = self._socket.recv(_READ_BYTES)
        if not received:
            raise Disconnected(f"{self.path}: slipd has closed the connection")
        self._lines.take(received)
        return True

    def call(self, method: str, params: Mapping[str, Any] | None = None, *, timeout_s: float | None = None) -> Any:
        """The result of any method of docs/socket.md."""
        deadline = time.monotonic() + (self.timeout_s if timeout_s is None else timeout_s)
        try:
            number = self._send(method, params or {})
            while number not in self._lines.answers:
                if not self._read(deadline - time.monotonic()):
                    raise TimeoutError(f"no answer to {method}")
        except OSError as error:
            self.close()  # a late answer must not be taken for another one's
            if isinstance(error, TimeoutError):
                raise
            raise _why(self.path, error) from error
        return self._lines.result(number)

    def _send(self, method: str, params: Mapping[str, Any]) -> int:
        """Sends a request, on a new connection if slipd has left the one that there is; the request's number."""
        if self._socket is not None and select.select([self._socket], [], [], 0)[0]:
            try:
                self._read(0)
            except OSError:
                self.close()
        connection = self._connected()
        number, line = self._lines.request(method, params)
        connection.sendall(line)
        return number

    def gamma(self, sensor: str, max_age_s: float) -> Estimate:
        """The latest estimate of a sensor."""
        return _estimate(self.call("gamma", {"sensor": sensor})["sensors"][0], max_age_s)

    def grasp(self, name: str, max_age_s: float) -> Estimate:
        """The latest estimate of a grasp of several sensors."""
        return _grasp(self.call("gamma"), name, max_age_s)

    def sensors(self) -> list[dict[str, Any]]:
        """What sensors there are, and how they are."""
        return self.call("sensors")["sensors"]

    def status(self) -> dict[str, Any]:
        """Counts, rates, latencies, outputs, clients."""
        return self.call("status")

    def frame(self, sensor: str) -> dict[str, Any]:
        """The newest frame: normal_pa, shear_x_pa, shear_y_pa, and the taxels' places x_mm, y_mm; one value a taxel. state and age_ms say what
        it is worth: the last frame of a sensor that has ended stays there."""
        return {key: _taxels(value) if isinstance(value, list) else value
                for key, value in self.call("frame", {"sensor": sensor}).items()}

    def record(self, sensor: str, seconds: float, path: str | os.PathLike[str]) -> dict[str, Any]:
        """Records frames into a new file and returns when it is complete: `recording`, `sensor`, `frames`, `missed`, `bytes`,
        `seconds`. Raises SlipdError if slipd refuses, or ended the recording early; the file has what came until then."""
        until = time.monotonic() + seconds + self.timeout_s
        with io_open(path, "xb") as file, Client(self.path, self.timeout_s) as own:
            try:
                return own._record(sensor, seconds, file, until)
            except OSError as error:
                raise error if isinstance(error, TimeoutError) else _why(self.path, error) from error
            finally:
                if file.tell() == 0:
                    os.unlink(path)

    def _record(self, sensor: str, seconds: float, file: BinaryIO, until: float) -> dict[str, Any]:
        number, descriptors = self._send("record", {"sensor": sensor, "seconds": seconds}), []
        assert self._socket is not None
        try:
            while number not in self._lines.answers:
                _await_readable(self._socket, until)
                descriptors += _take_with_descriptors(self._socket, self._lines)
            self._lines.result(number)
            if not descriptors:
                raise Disconnected(f"{self.path}: slipd passed no recording")
            while True:
                _await_readable(descriptors[0], until)
                frames = os.read(descriptors[0], _READ_BYTES)
                if not frames:
                    break
                file.write(frames)
        finally:
            for descriptor in descriptors:
                os.close(descriptor)
        while True:
            for event, result, _ in self._lines.notifications:
                if event == "recorded":
                    if result.get("trouble"):
                        raise SlipdError(-32003, result["trouble"])
                    return dict(result)
            self._lines.notifications.clear()
            if not self._read(until - time.monotonic()):
                raise TimeoutError("slipd does not say that the recording is complete")

    def estimates(self, *sensors: str, max_age_s: float, max_rate_hz: float | None = None,
                  events: Sequence[str] = ("estimate",)) -> Iterator[Estimate]:
        """Estimates as they come, of all sensors unless some are named, without end. Among them, of each sensor: one of state
        "stale" whenever it was silent for max_age_s, which is to be longer than the estimates' period; one of state
        "disconnected" when slipd is gone, and at each vain attempt to reach it. Without the event "estimate", one who is told of
        changes only is told what there is at the beginning and after each loss, of a slipd that is gone, and of no silence.

        Raises SlipdError if there is no such sensor, and Disconnected if slipd cannot be reached at first."""
        watch = _Watch(max_age_s, events)
        with Client(self.path, self.timeout_s) as own:
            while True:
                try:
                    if own._socket is None:
                        names = sensors or [sensor["name"] for sensor in own.sensors()]
                        own.call("subscribe", _subscription(sensors, max_rate_hz, events))
                        watch.begin(names)
                        if watch.must_ask():
                            own._lines.notifications += watch.found(own.call("gamma"))
                    if not own._lines.notifications and not own._read(watch.wait_s()):
                        yield from watch.silent()
                    arrived, own._lines.notifications = own._lines.notifications, []
                    for each in arrived:
                        yield watch.fresh(*each)
                except OSError as error:
                    own.close()
                    if watch.due is None:
                        raise _why(self.path, error) from error
                    yield from watch.lost()
                    time.sleep(watch.next_pause())


# Of a record in shared memory, docs/clients.md: where the numbers begin, the keys of the numbers with their factors to the units of
# the socket, and the names of the small numbers behind them.
_RECORD = struct.Struct("<QqqQ20d8BI")
_NUMBERS = (("gamma", 1), ("sigma", 1), ("gamma_low", 1), ("friction", 1), ("friction_sigma", 1), ("normal_n", 1), ("shear_n", 1),
            ("torque_nmm", 1e3), ("torque_sigma_nmm", 1e3), ("center_x_mm", 1e3), ("center_y_mm", 1e3), ("radius_mm", 1e3),
            ("a_over_r", 1), ("time_to_slip_ms", 1e3), ("grip_increase_n", 1), ("grip_increase_sigma_n", 1), ("sliding_for_ms", 1e3),
            ("first_gamma", 1), ("truth_gamma", 1), ("truth_friction", 1))
_HEALTHS = ("good", "not_finite", "full_scale", "spike", "uniform", "wrong_scale", "saturated", "repeated", "frozen", "dead_normal",
            "dead_shear_x", "dead_shear_y", "dead_row", "time", "jump", "unexplained", "noisy")
_UNKNOWN = 255  # of health and of sliding
_CAUSES = (None, "margin", "sliding")
_METHODS = ("none", "svd-knn", "registered", "moments", "fit", "friction", "closing", "block-fit", "displacement")
_SLIDINGS = ("none", "disturbed", "translation", "rotation")
_HEADER = struct.Struct("<8s6IQqI")
_HEARTBEAT = 64  # where it is
_LOOK_S = 0.001  # how often attach() looks whether slipd has written its first records
_BOARD_VERSION, _BEATS_MISSED = 1, 10  # a heartbeat older than so many of its periods is that of a slipd that has stopped


def _named(names: Sequence[Any], number: int, other: Any) -> Any:
    return names[number] if number < len(names) else other


class _Attaching:
    """A request for slipd's shared memory that is under way. Nothing here waits."""

    def __init__(self, path: str) -> None:
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._lines, self._descriptors = _Lines(), list[int]()
        self._memory: mmap.mmap | None = None
        try:
            self.socket.setblocking(False)
            self.socket.connect(path)
            self._number, line = self._lines.request("attach", {"wait": []})
            self.socket.send(line)
        except OSError:
            self.close()
            raise

    def close(self) -> None:
        """Lets go of what was not taken."""
        self._close_descriptors()
        if self._memory is not None:
            self._memory.close()
        self.socket.close()

    def _close_descriptors(self) -> None:
        while self._descriptors:
            os.close(self._descriptors.pop())

    def memory(self) -> mmap.mmap | None:
        """The memory, the caller's from now on; None: slipd has not yet answered, or not yet written into it."""
        try:
            self._descriptors += _take_with_descriptors(self.socket, self._lines)
        except BlockingIOError:
            pass
        if self._number in self._lines.answers:
            self._lines.result(self._number)
            if not self._descriptors:
                raise Disconnected("slipd passed no memory")
            self._memory = mmap.mmap(self._descriptors[0], 0, mmap.MAP_SHARED, mmap.PROT_READ)
            self._close_descriptors()
            magic, version = struct.unpack_from("<8sI", self._memory)
            if magic != b"slipdbrd" or version != _BOARD_VERSION:
                raise Disconnected("the board of this slipd is of another version: upgrade slipd and python3-slipd together")
        if self._memory is None or struct.unpack_from("<q", self._memory, _HEARTBEAT)[0] == 0:
            return None
        memory, self._memory = self._memory, None
        return memory


class Board:
    """The latest estimates in slipd's shared memory: reading one takes some microseconds, and slipd nothing.

    It is attached at the first use, and again after slipd was restarted or reloaded, or hung; until it is, estimates have the state
    "disconnected". Only attach() waits. To wait for the next estimate, use Client.estimates(). A board belongs to one thread.
    """

    def __init__(self, path: str = SOCKET, timeout_s: float = 5.0) -> None:
        """`timeout_s`: how long attach() waits."""
        self.path, self.timeout_s = path, timeout_s
        self._socket: socket.socket | None = None  # slipd lets go of the memory when it closes
        self._memory: mmap.mmap | None = None
        self._slots: dict[str, int] = {}
        self._attaching: _Attaching | None = None
        self._next_attempt, self._pause_s, self._period_ns = 0.0, _RETRY_FIRST_S, 0

    def __enter__(self) -> Board:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection and the mapping; a later use makes new ones."""
        self._give_up()
        if self._memory is not None:
            self._memory.close()
        if self._socket is not None:
            self._socket.close()
        self._memory, self._socket, self._slots = None, None, {}

    def attach(self) -> None:
        """Maps the memory anew, and waits for it. latest() does so, too, by and by and without waiting. Raises Disconnected if
        there is no slipd, SlipdError if it refuses, TimeoutError."""
        self.close()
        until = time.monotonic() + self.timeout_s
        try:
            while not self._attach_on():
                if time.monotonic() > until:
                    raise TimeoutError(f"{self.path}: slipd does not answer")
                if self._attaching is not None:
                    select.select([self._attaching.socket], [], [], _LOOK_S)
        except OSError as error:
            self._give_up()
            if isinstance(error, TimeoutError):
                raise
            raise _why(self.path, error) from error
        except SlipdError:
            self._give_up()
            raise

    def _attach_on(self) -> bool:
        """The next step of attaching, which never waits: connecting to a slipd that hangs would, and so would its answer. What is
        mapped stays until there is another. True: it is attached."""
        if self._attaching is None:
            self._attaching = _Attaching(self.path)
        memory = self._attaching.memory()
        if memory is None:
            return False
        made, self._attaching = self._attaching.socket, None
        self.close()
        self._memory, self._socket = memory, made
        _, _, header, slot_bytes, _, sensors, grasps, _, self._period_ns, _ = _HEADER.unpack_from(memory)
        for slot in reversed(range(sensors + grasps)):  # a sensor's name comes before a grasp's
            at = header + slot * slot_bytes
            self._slots[memory[at:at + 64].rstrip(b"\0").decode()] = at
        return True

    def _give_up(self) -> None:
        if self._attaching is not None:
            self._attaching.close()
            self._attaching = None

    def _word(self, form: str, at: int) -> int:
        assert self._memory is not None
        return struct.unpack_from(form, self._memory, at)[0]

    @property
    def generation(self) -> int:
        """A number of the memory that is mapped: another one after each start and reload of slipd. 0: none is mapped."""
        return 0 if self._memory is None else self._word("<Q", 32)

    @property
    def alive(self) -> bool:
        """Whether slipd writes the memory that is mapped."""
        return self._heartbeat_age_s <= 1e-9 * _BEATS_MISSED * self._period_ns

    @property
    def _heartbeat_age_s(self) -> float:
        """Infinite if no memory is mapped, or slipd has closed it; or of the future, which is of another clock, as in a time
        namespace, and says nothing of now."""
        if self._memory is None or self._word("<I", 72) != 0:
            return _INFINITE
        beat_ns = self._word("<q", _HEARTBEAT)
        age_ns = time.monotonic_ns() - beat_ns  # the clock after the heartbeat
        return _INFINITE if age_ns < 0 else 1e-9 * age_ns

    def _usable(self, max_age_s: float) -> bool:
        """Whether memory is mapped whose heartbeat is no older than the caller allows estimates to be, as in libslipd."""
        return self.alive or self._heartbeat_age_s <= max_age_s

    def _usable_or_attached(self, max_age_s: float) -> bool:
        if self._usable(max_age_s):
            self._give_up()  # slipd hung, and goes on
            self._pause_s = _RETRY_FIRST_S
            return True
        if self._attaching is None:
            if time.monotonic() < self._next_attempt:
                return False
            self._next_attempt, self._pause_s = time.monotonic() + self._pause_s, min(2 * self._pause_s, _RETRY_LAST_S)
        try:
            return self._attach_on() and self._usable(max_age_s)
        except (OSError, SlipdError):
            self._give_up()
            return False

    def latest(self, name: str, max_age_s: float) -> Estimate:
        """The latest estimate of a sensor or grasp. It never waits, whatever slipd does: while there is no memory of a slipd that
        runs, it is "disconnected", with the last alert if one was raised. Raises SlipdError if slipd has none of this name."""
        if not self._usable_or_attached(max_age_s):
            return self._disconnected(name, max_age_s)
        if name not in self._slots:
            raise SlipdError(-32001, f"there is no sensor or grasp {name!r}; there are: " + ", ".join(sorted(self._slots)))
        return _estimate(self._values(name), max_age_s)

    def _disconnected(self, name: str, max_age_s: float) -> Estimate:
        if name not in self._slots:
            return _without(name, "disconnected", max_age_s)
        last = self._values(name)
        return _without(name, "disconnected", max_age_s, (last["alert"], last["alert_cause"]))

    def _record(self, slot: int) -> tuple[Any, ...]:
        """A whole record: slipd writes into two copies in turn, each with a version that is odd meanwhile."""
        assert self._memory is not None
        while True:
            current = self._word("<I", slot + 640)
            copy = slot + 128 + 256 * (current & 1)
            before = self._word("<Q", copy)
            content = self._memory[copy + 8:copy + 8 + _RECORD.size]
            if before % 2 == 0 and before == self._word("<Q", copy) and current == self._word("<I", slot + 640):
                return _RECORD.unpack(content)

    def _values(self, name: str) -> dict[str, Any]:
        """The record with the keys of the socket."""
        record = self._record(self._slots[name])
        seq, time_ns, published_ns, _ = record[:4]
        state, alert, cause, method, health, sliding, simulated, _, _ = record[24:]
        values: dict[str, Any] = {key: None if value != value else value * factor
                                  for (key, factor), value in zip(_NUMBERS, record[4:24])}
        # The clock after the record. That of a recording may be ahead, so its age counts from the estimate at the latest; an estimate
        # of the future is of another clock, and its age is negative.
        age_ns = time.monotonic_ns() - min(time_ns, published_ns)
        values.update(sensor=name, seq=seq, state=_named(_STATES, state, "fault"), alert=_named(_ALERTS, alert, "slip"),
                      alert_cause=_named(_CAUSES, cause, None), method=_named(_METHODS, method, "none"),
                      health="unknown" if health == _UNKNOWN else _named(_HEALTHS, health, "unexplained"),
                      sliding=_named(_SLIDINGS, sliding, None), simulated=bool(simulated),
                      time_ns=time.time_ns() - age_ns if time_ns else None, age_ms=age_ns * 1e-6 if time_ns else None)
        return values


class AsyncClient:
    """Client for asyncio: `async with slipd.AsyncClient() as client: async for estimate in client.estimates(…)`. One task at a time
    may wait for a client's answer; an iterator has a connection of its own."""

    def __init__(self, path: str = SOCKET, timeout_s: float = 5.0) -> None:
        self.path, self.timeout_s = path, timeout_s
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None
        self._lines = _Lines()

    async def __aenter__(self) -> AsyncClient:
        return self

    async def __aexit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection; a later request makes a new one."""
        if self._streams is not None:
            self._streams[1].close()
        self._streams, self._lines = None, _Lines()

    async def _connected(self) -> asyncio.StreamWriter:
        if self._streams is not None and (self._streams[0].at_eof() or self._streams[0].exception()):  # slipd has left
            self.close()
        if self._streams is None:
            try:
                self._streams = await asyncio.wait_for(asyncio.open_unix_connection(self.path), self.timeout_s)
            except asyncio.TimeoutError:
                raise TimeoutError(f"{self.path}: slipd accepts no connections") from None
        return self._streams[1]

    async def _read(self, timeout_s: float) -> bool:
        """As Client._read."""
        assert self._streams is not None
        try:
            received = await asyncio.wait_for(self._streams[0].read(_READ_BYTES), timeout_s)
        except asyncio.TimeoutError:
            return False
        if not received:
            raise Disconnected(f"{self.path}: slipd has closed the connection")
        self._lines.take(received)
        return True

    async def call(self, method: str, params: Mapping[str, Any] | None = None) -> Any:
        """As Client.call."""
        deadline = time.monotonic() + self.timeout_s
        try:
            writer = await self._connected()
            number, line = self._lines.request(method, params or {})
            writer.write(line)
            await writer.drain()
            while number not in self._lines.answers:
                if not await self._read(max(0.0, deadline - time.monotonic())):
                    raise TimeoutError(f"no answer to {method}")
        except OSError as error:
            self.close()
            if isinstance(error, TimeoutError):
                raise
            raise _why(self.path, error) from error
        return self._lines.result(number)

    async def gamma(self, sensor: str, max_age_s: float) -> Estimate:
        """As Client.gamma."""
        return _estimate((await self.call("gamma", {"sensor": sensor}))["sensors"][0], max_age_s)

    async def grasp(self, name: str, max_age_s: float) -> Estimate:
        """As Client.grasp."""
        return _grasp(await self.call("gamma"), name, max_age_s)

    async def estimates(self, *sensors: str, max_age_s: float, max_rate_hz: float | None = None,
                        events: Sequence[str] = ("estimate",)) -> AsyncIterator[Estimate]:
        """As Client.estimates."""
        watch = _Watch(max_age_s, events)
        async with AsyncClient(self.path, self.timeout_s) as own:
            while True:
                try:
                    if own._streams is None:
                        names = sensors or [sensor["name"] for sensor in (await own.call("sensors"))["sensors"]]
                        await own.call("subscribe", _subscription(sensors, max_rate_hz, events))
                        watch.begin(names)
                        if watch.must_ask():
                            own._lines.notifications += watch.found(await own.call("gamma"))
                    if not own._lines.notifications and not await own._read(watch.wait_s()):
                        for estimate in watch.silent():
                            yield estimate
                    arrived, own._lines.notifications = own._lines.notifications, []
                    for each in arrived:
                        yield watch.fresh(*each)
                except OSError as error:
                    own.close()
                    if watch.due is None:
                        raise _why(self.path, error) from error
                    for estimate in watch.lost():
                        yield estimate
                    await asyncio.sleep(watch.next_pause())


# Frames to the driver push: docs/push.md states every byte.

_HELLO = struct.Struct("<8sHBBIdB7x")  # magic, version, axes, unit, taxels, rate_hz, zero
_FRAME_HEAD = struct.Struct("<HHIQq")  # version, flags, size, sequence, time_ns
_RING_HEAD = struct.Struct("<8sHHIQ")  # of the shared memory: magic, version, 0, slots, bytes from slot to slot
_RING_HEAD_BYTES, _RING_SLOT_HEAD_BYTES, _RING_TAKEN, _IN_RING = 128, 64, 64, 2
_ANSWER = struct.Struct("<I")  # then a text
_UNITS = {None: 0, "Pa": 1, "N": 2, "counts": 3, "uT": 4, "mm": 5}
_ZEROS = {None: 0, False: 1, True: 2}
_PUSH_VERSION, _LONGEST_ANSWER = 1, 4096


def _float32(values: Any) -> bytes | memoryview:
    """Numbers as float32, little-endian: of a buffer, or of a list, nested or not."""
    try:
        view = memoryview(values)
    except TypeError:
        view = None
    if view is not None and view.c_contiguous and (view.format in ("B", "b", "c", "<f") or (view.format == "f" and sys.byteorder == "little")):
        return view.cast("B")
    if numpy is not None:
        return memoryview(numpy.ascontiguousarray(values, dtype="<f4")).cast("B")
    if view is not None:
        values = view.tolist()
    numbers = array.array("f", _flat(values))
    if sys.byteorder == "big":
        numbers.byteswap()
    return numbers.tobytes()


def _flat(values: Any) -> Iterator[float]:
    for value in values:
        if isinstance(value, (int, float)):
            yield value
        else:
            yield from _flat(value)


class _FrameRing:
    """The values of large frames, in memory that slipd shares with this program: docs/push.md. The notice that follows by the socket
    makes them visible to slipd: the kernel's lock of the socket's queue orders them before it."""

    def __init__(self, memory: mmap.mmap, slots: int, slot_bytes: int) -> None:
        self._bytes = memoryview(memory)
        self._words = self._bytes.cast("Q")  # an item is read and written as one word
        self._slots, self._slot_bytes, self._put = slots, slot_bytes, 0

    @classmethod
    def of(cls, file: int, values_bytes: int) -> _FrameRing | None:
        """None if it is not what this module knows: then frames go by the socket."""
        try:
            memory = mmap.mmap(file, 0)
        except (OSError, ValueError):
            return None
        finally:
            os.close(file)
        if sys.byteorder != "little" or len(memory) < _RING_HEAD_BYTES:
            return None
        magic, version, _, slots, slot_bytes = _RING_HEAD.unpack_from(memory)
        known = magic == b"slipring" and version == _PUSH_VERSION and slots > 0 and slot_bytes % 8 == 0
        if not known or slot_bytes < _RING_SLOT_HEAD_BYTES + values_bytes or len(memory) != _RING_HEAD_BYTES + slots * slot_bytes:
            return None
        return cls(memory, slots, slot_bytes)

    def put(self, values: bytes | memoryview) -> int:
        """The frame's number in the ring; 0: slipd still reads what is there."""
        number = self._put + 1
        if number > self._words[_RING_TAKEN // 8] + self._slots:
            return 0
        at = _RING_HEAD_BYTES + number % self._slots * self._slot_bytes
        self._words[at // 8] = 0
        begin = at + _RING_SLOT_HEAD_BYTES
        self._bytes[begin:begin + len(values)] = values
        self._words[at // 8] = self._put = number
        return number


class Source:
    """Frames of a sensor from this program, for a sensor whose driver in slipd's configuration is "push".

        with slipd.Source("left", taxels=16, rate_hz=100, unit="N") as source:
            source.push(frame)

    `sensor`: its name, or the path of its socket. `taxels`: as many as its layout has. `axes`: values of each taxel, 3 (x, y and z, z
    positive when pressed) or 1 (z). `rate_hz`: frames a second. `unit`: "Pa", "N" (force of each taxel), "counts", "uT" or "mm". `zeroed`:
    whether frames read 0 without load; False: slipd measures what they read. What is left out is as configured; what contradicts the
    configuration raises SlipdError, whose text says how, with `code` 1. `code` 2: another program sends this sensor's frames; 3: one
    took over, because this one was silent. `path`: slipd's socket. A source belongs to one thread.

    slipd gone, or restarted: push raises Disconnected, and the next push connects again.
    """

    def __init__(self, sensor: str, *, taxels: int, axes: int = 3, rate_hz: float = 0.0, unit: str | None = None,
                 zeroed: bool | None = None, path: str = SOCKET, timeout_s: float = 5.0) -> None:
        if unit not in _UNITS:
            raise ValueError(f"the unit {unit!r} is none that slipd knows: Pa, N, counts, uT or mm")
        if axes not in (1, 3):
            raise ValueError(f"{axes} values a taxel: 3 (x, y, z) or 1 (z) are possible")
        self.path = sensor if "/" in sensor else os.path.join(os.path.dirname(path), "push", sensor)
        self.timeout_s = timeout_s
        self._hello = _HELLO.pack(b"slippush", _PUSH_VERSION, axes, _UNITS[unit], taxels, rate_hz, _ZEROS[zeroed])
        self._values_bytes = 4 * taxels * axes
        self._sequence = 0  # of the last frame
        self._socket: socket.socket | None = None
        self._ring: _FrameRing | None = None

    def __enter__(self) -> Source:
        self.connect()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection; a later push makes a new one."""
        if self._socket is not None:
            self._socket.close()
        self._socket = self._ring = None

    def connect(self) -> None:
        """Connects, unless it is connected. Raises SlipdError, Disconnected or TimeoutError."""
        if self._socket is not None:
            return
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.settimeout(self.timeout_s)
        # A frame may be longer than what a socket holds by default.
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, max(2 * self._values_bytes, 1 << 17))
        try:
            self._socket.connect(self.path)
            try:
                self._socket.sendall(self._hello)
            except BrokenPipeError:
                pass  # the answer says why
            code, text = self._answer(accepts_ring=True)
        except OSError as error:
            self.close()
            raise self._why(error) from error
        if code != 0:
            self.close()
            raise SlipdError(code, text)

    def push(self, frame: Any, *, time_ns: int | None = None, sequence: int | None = None, bad: bool = False) -> None:
        """Sends a frame: taxels x axes numbers, those of one taxel side by side, in the order of the layout. An array of numpy, or any
        other buffer of float32; bytes are taken as float32, little-endian; or a list, nested or not.

        `time_ns`: of the sample, time.monotonic_ns(); by default now. `sequence`: the device's own count, which must rise; slipd counts
        what it skips as lost. By default each frame is the next. `bad`: the device says that it is no sample; slipd counts it.
        Waits at most timeout_s while slipd does not read. Raises ValueError for a frame of another size, before anything is sent.
        """
        values = _float32(frame)
        if len(values) != self._values_bytes:
            raise ValueError(f"the frame has {len(values) // 4} values; expected {self._values_bytes // 4}, taxels x axes")
        number = self._sequence + 1 if sequence is None else sequence
        sampled_ns = time.monotonic_ns() if time_ns is None else time_ns
        self.connect()
        assert self._socket is not None
        flags, rest = 1 if bad else 0, values
        if self._ring is not None and (in_ring := self._ring.put(values)):
            flags, rest = flags | _IN_RING, struct.pack("<Q", in_ring)
        head = _FRAME_HEAD.pack(_PUSH_VERSION, flags, _FRAME_HEAD.size + len(rest), number, sampled_ns)
        try:
            self._socket.sendmsg((head, rest))
        except (BrokenPipeError, ConnectionResetError) as error:
            raise self._lost(error) from error
        except OSError as error:
            self.close()
            raise self._why(error) from error
        self._sequence = number

    def _answer(self, accepts_ring: bool = False) -> tuple[int, str]:
        assert self._socket is not None
        room = socket.CMSG_SPACE(struct.calcsize("i")) if accepts_ring else 0
        try:
            message, passed, *_ = self._socket.recvmsg(_LONGEST_ANSWER, room)
        except ConnectionResetError:  # of a hello that came after the refusal, which is still there
            message, passed, *_ = self._socket.recvmsg(_LONGEST_ANSWER, room)
        for level, kind, content in passed:
            if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS):
                self._ring = _FrameRing.of(struct.unpack("i", content)[0], self._values_bytes)
        if len(message) < _ANSWER.size:
            raise ConnectionResetError
        return _ANSWER.unpack_from(message)[0], message[_ANSWER.size:].decode(errors="replace")

    def _lost(self, error: OSError) -> SlipdError | OSError:
        """Why slipd has ended the connection: what it has said, or that it has gone."""
        try:
            code, text = self._answer()
            lost: SlipdError | OSError = SlipdError(code, text)
        except OSError:
            lost = self._why(error)
        self.close()
        return lost

    def _why(self, error: OSError) -> OSError:
        if isinstance(error, TimeoutError):
            return TimeoutError(f"{self.path}: slipd does not read: it hangs, or the frames come faster than rate_hz")
        if isinstance(error, FileNotFoundError):
            return Disconnected(f"{self.path}: slipd does not run here, or its configuration has no sensor with driver push there")
        return _why(self.path, error)


# Recordings: a CBOR sequence (RFC 8742); core/recording/recording.hpp describes it.

_BLOCK = bytes.fromhex("A865626C6F636B1B")  # what each block begins with
_FLOATS = 85  # RFC 8746: little-endian float32


class RecordingError(ValueError):
    """The file is no recording; the text says where it is none."""


class _Cut(Exception):
    """An item ends after the last byte."""


def _item(data: bytes, at: int) -> tuple[Any, int]:
    """The CBOR item (RFC 8949) at a place, and the place behind it."""
    if at >= len(data):
        raise _Cut
    kind, short = data[at] >> 5, data[at] & 31
    at += 1
    argument = short
    if 24 <= short <= 27:
        width = 1 << (short - 24)
        if at + width > len(data):
            raise _Cut
        argument, at = int.from_bytes(data[at:at + width], "big"), at + width
    elif short > 27:
        raise RecordingError(f"byte {at - 1}: lengths must be given")
    if kind == 0:
        return argument, at
    if kind == 1:
        return -1 - argument, at
    if kind in (2, 3):
        if at + argument > len(data):
            raise _Cut
        content = data[at:at + argument]
        return content if kind == 2 else content.decode(), at + argument
    if kind == 4:
        values = []
        for _ in range(argument):
            value, at = _item(data, at)
            values.append(value)
        return values, at
    if kind == 5:
        entries = {}
        for _ in range(argument):
            key, at = _item(data, at)
            entries[key], at = _item(data, at)
        return entries, at
    if kind == 6:
        value, at = _item(data, at)
        return _floats(value) if argument == _FLOATS else value, at
    if short == 26:
        return struct.unpack(">f", data[at - 4:at])[0], at
    if short == 27:
        return struct.unpack(">d", data[at - 8:at])[0], at
    return {20: False, 21: True}.get(short), at


def _floats(content: bytes) -> Sequence[float]:
    if numpy is not None:
        return numpy.frombuffer(content, dtype="<f4")
    values = array.array("f", content)
    if sys.byteorder == "big":
        values.byteswap()
    return values


def _taxels(values: Sequence[float]) -> Sequence[float]:
    return array.array("f", values) if numpy is None else numpy.array(values, dtype="<f4")


@dataclass(frozen=True)
class Frame:
    """One frame of a recording. Taxels are float32, one value each: arrays of numpy, else array.array."""

    seq: int
    time_ns: int  # CLOCK_MONOTONIC
    time_s: float  # since the recording began
    device_time_ns: int | None
    normal_pa: Sequence[float]
    shear_x_pa: Sequence[float]
    shear_y_pa: Sequence[float]
    truth_gamma: float | None  # of simulated sensors
    truth_friction: float | None
    estimate: Mapping[str, Any] | None  # of the flight recorder: state, alert, gamma, sigma, friction, normal_n, shear_n


class Recording:
    """A recording of one sensor. Iterating gives its frames; blocks that are damaged are left out and counted in `damaged`.

    Blocks are checked by their checksum if the module xxhash is installed (`checked`), else by their form only.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        with io_open(path, "rb") as file:
            self._data = file.read()
        try:
            head, self._begin = _item(self._data, 0)
        except (_Cut, RecordingError, UnicodeDecodeError):
            head = None
        if not isinstance(head, dict) or head.get("format") != "slipd-recording":
            raise RecordingError(f"{os.fspath(path)} is no recording of slipd")
        if head["version"] not in (1, 2):
            raise RecordingError(f"{os.fspath(path)} is of version {head['version']}; a newer slipd reads it")
        self._blocks = head["version"] == 2
        self.checked = self._blocks and xxhash is not None
        self.damaged = 0  # blocks, of the last time that all frames were read
        about = _item(head["body"], 0)[0] if self._blocks else head
        self.sensor: str = about["sensor"]
        self.sensor_class: str = about["class"]  # "array3", "wrench", "normal", "displacement"
        self.layout: Mapping[str, Any] = about["layout"]  # {"grid": [columns, rows], "pitch_m"}, {"x_m", "y_m"} or {"side_m"}
        self.rate_hz: float = about["rate_hz"]  # 0: unknown
        self.simulated: bool = about["simulated"]
        self.start_realtime_ns: int = about["start_realtime_ns"]
        self.start_monotonic_ns: int = about["start_monotonic_ns"]
        self.description: str = about["description"]
        self.zeroed: bool = about.get("zeroed", True)

    def __iter__(self) -> Iterator[Frame]:
        if not self._blocks:
            yield from self._frames(self._data, self._begin)
            return
        self.damaged = 0
        at, number = self._data.find(_BLOCK, self._begin), 0
        while at >= 0:
            end = self._end_of_block(at)
            if end is None:
                at = self._data.find(_BLOCK, at + 1)
                continue
            block = _item(self._data, at)[0]
            self.damaged += block["block"] - number
            number = block["block"] + 1
            yield from self._frames(block["body"], 0)
            at = self._data.find(_BLOCK, end)

    def _end_of_block(self, at: int) -> int | None:
        """The place behind the block at a place; None if it is damaged or cut."""
        try:
            block, end = _item(self._data, at)
            known = block.keys() >= {"block", "body", "xxh3"}
        except (_Cut, RecordingError, UnicodeDecodeError, TypeError, AttributeError):
            return None
        if not known:
            return None
        sealed = self._data[at:end - len(b"\x64xxh3") - 9]  # all before the checksum's entry
        return end if xxhash is None or xxhash.xxh3_64_intdigest(sealed) == block["xxh3"] else None

    def _frames(self, data: bytes, at: int) -> Iterator[Frame]:
        while at < len(data):
            try:
                values, at = _item(data, at)
            except _Cut:  # the recording was cut here
                return
            estimate = values.get("estimate")
            if estimate is not None:
                # Numbers that this module does not have are of a newer slipd: no margin, and no alert that is missed.
                estimate = {**estimate, "state": _named(_STATES, estimate["state"], "fault"),
                            "alert": _named(_ALERTS, estimate["alert"], "slip")}
            yield Frame(time_s=1e-9 * (values["time_ns"] - self.start_monotonic_ns), estimate=estimate,
                        **{key: values[key] for key in ("seq", "time_ns", "device_time_ns", "normal_pa", "shear_x_pa", "shear_y_pa",
                                                        "truth_gamma", "truth_friction")})


def open(path: str | os.PathLike[str]) -> Recording:  # noqa: A001: slipd.open() is what people look for
    """A recording, read whole. Raises OSError, or RecordingError if it is none."""
    return Recording(path)


def main(arguments: Sequence[str] | None = None) -> int:
    """python3 -m slipd [--socket PATH] [SENSOR …]: a line for each sensor, ten times a second, until it is interrupted."""
    parser = argparse.ArgumentParser(prog="python3 -m slipd", description="Prints the safety margin of slipd's sensors as it changes.")
    parser.add_argument("--socket", default=SOCKET)
    parser.add_argument("sensors", nargs="*", metavar="SENSOR")
    options = parser.parse_args(arguments)
    try:
        with Client(options.socket) as client:
            for estimate in client.estimates(*options.sensors, max_age_s=0.5, max_rate_hz=10):
                gamma = "     " if estimate.gamma is None else f"{estimate.gamma:5.3f}"
                bar = "#" * round(40 * (estimate.gamma or 0))
                print(f"{estimate.name:12.12} {gamma} |{bar:40}| {estimate.state:12} {estimate.alert}", flush=True)
    except (SlipdError, OSError) as error:
        print(f"slipd: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
