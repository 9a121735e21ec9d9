"""slipd-grip-ros2 between the lines of slipd-grip and a gripper's action on Fast DDS. The messages' bytes are read and made here and in
tests/support/cdr.py, by the rules of CDR alone."""
import json
import os
import queue
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import unittest

from awaiting import PATIENCE_S, await_true
from cdr import CdrReader, CdrWriter
from grip_bed import Programs

BUILD = os.environ["SLIPD_BINARY_DIR"]
ACTION = "/gripper_controller/gripper_cmd"
EXECUTING, ABORTED = 2, 6
HEADER = b"\0\1\0\0"


def aligned(body, size):
    return body + bytes(-len(body) % size)


def read_joints(cdr):
    """Names, positions and efforts of a sensor_msgs/JointState."""
    cdr.number("i"), cdr.number("I"), cdr.text()
    names = [cdr.text() for _ in range(cdr.number("I"))]
    position, velocity, effort = ([cdr.number("d") for _ in range(cdr.number("I"))] for _ in range(3))
    assert velocity == [] and cdr.at <= len(cdr.body)
    return names, position, effort


def joints(names, position, effort):
    cdr = CdrWriter().header(0, "").put("I", len(names))
    for name in names:
        cdr.text(name)
    for numbers in (position, [], effort):
        cdr.put("I", len(numbers)).put("d", *numbers)
    return bytes(cdr.bytes)


class Gripper:
    """A server of the action. It lists each goal as `state`, or none where that is None."""

    def __init__(self, domain, kind="GripperCommand", counted=False, state=EXECUTING):
        self.kind, self.counted, self.state = kind, counted, state
        self.goals, self.clients, self.listed = queue.Queue(), [], []
        self.process = subprocess.Popen([os.path.join(BUILD, "test-bin", "fastdds-gripper"), str(domain), ACTION, kind],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout.readline() == "ready\n"
        self.reader = threading.Thread(target=self._serve, daemon=True)
        self.reader.start()

    def _serve(self):
        for line in self.process.stdout:
            body = bytes.fromhex(line.split()[1])[4:]
            if self.counted:
                self.clients.append(struct.unpack_from("<Qq", body))
                body = body[16:]
            goal = body[:16]
            if self.kind == "GripperCommand":
                self.goals.put(struct.unpack_from("<dd", body, 16))
            else:
                names, position, effort = read_joints(CdrReader(body, 16))
                self.goals.put((*position, *effort, *names))
            if self.state is not None:
                self.list(goal, self.state)

    def list(self, goal, state):
        self.listed.append((goal, state))
        body = struct.pack("<I", len(self.listed))
        for one, how in self.listed:
            body = aligned(body, 4) + one + struct.pack("<iIB", 0, 0, how)
        self._send("status", body)

    def feedback(self, position, effort, names=("other", "finger")):
        if self.kind == "GripperCommand":
            self._send("feedback", bytes(16) + struct.pack("<dd??", position, effort, False, False))
        else:
            self._send("feedback", bytes(16) + joints(names, (9.0, position), (9.0, effort)))

    def _send(self, topic, body):
        self.process.stdin.write(f"{topic} {(HEADER + body).hex()}\n")
        self.process.stdin.flush()

    def goal(self):
        return self.goals.get(timeout=PATIENCE_S)

    def close(self):
        if self.process.returncode is None:
            self.process.stdin.close()
            self.process.wait(PATIENCE_S)
        self.reader.join(PATIENCE_S)
        self.process.stdout.close()


class Bed(unittest.TestCase):
    SETTINGS = {"action": ACTION, "open": 0.085, "closed": 0.0, "stroke_mm": 85, "effort_per_n": 2, "open_effort": 30}

    def setUp(self):
        self.domain = 1 + os.getpid() % 100
        self.folder = tempfile.TemporaryDirectory(prefix="slipd-grip-ros2-")
        self.addCleanup(self.folder.cleanup)
        self.socket_path = os.path.join(self.folder.name, "gripper.sock")
        self.log_path = os.path.join(self.folder.name, "log")

    def program(self, **settings):
        path = os.path.join(self.folder.name, "grip-ros2.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump({**self.SETTINGS, "socket": self.socket_path, "domain": self.domain, **settings}, file)
        with open(self.log_path, "w", encoding="utf-8") as log:
            process = subprocess.Popen([os.path.join(BUILD, "bin", "slipd-grip-ros2"), "--config", path], stderr=log)
        self.addCleanup(lambda: (process.kill(), process.wait()))
        await_true(lambda: os.path.exists(self.socket_path), "its socket")
        return process

    def gripper(self, **how):
        gripper = Gripper(self.domain, **how)
        self.addCleanup(gripper.close)
        return gripper

    def connect(self):
        line = socket.socket(socket.AF_UNIX)
        line.settimeout(PATIENCE_S)
        line.connect(self.socket_path)
        self.addCleanup(line.close)
        lines = line.makefile("rw", encoding="utf-8")
        self.addCleanup(lines.close)
        return lines

    def say(self, lines, order):
        lines.write((order if isinstance(order, str) else json.dumps(order)) + "\n")
        lines.flush()
        return json.loads(lines.readline())

    def grip(self, lines, force_n):
        for _ in range(2):  # an order counts when it stays
            self.say(lines, {"order": "grip", "force_n": force_n})

    def await_server(self, lines):
        await_true(lambda: "fault" not in self.say(lines, {"order": "stay"}), "the action's server")

    def log(self):
        with open(self.log_path, encoding="utf-8") as log:
            return log.read()


class Orders(Bed):
    def test_become_goals_and_feedback_becomes_width_and_force(self):
        self.program()
        gripper, lines = self.gripper(), self.connect()
        self.await_server(lines)
        for sequence in (1, 2):
            self.assertEqual(self.say(lines, {"order": "grip", "force_n": 3.5, "sequence": sequence, "speed_mm_s": 50}), {})
        self.assertEqual(gripper.goal(), (0.0, 7.0))
        self.assertEqual(self.say(lines, {"order": "open"}), {})
        self.assertEqual(gripper.goal(), (0.085, 30.0))

        def answer():
            gripper.feedback(0.034, 6.5)
            return self.say(lines, {"order": "open"})
        await_true(lambda: answer() == {"width_mm": 34.0, "force_n": 3.25}, "what the fingers do")

    def test_that_stay_the_same_are_sent_once(self):
        self.program(goals_per_s=100)
        gripper, lines = self.gripper(), self.connect()
        self.await_server(lines)
        for _ in range(500):
            self.say(lines, {"order": "grip", "force_n": 3})
        self.say(lines, {"order": "open"})
        self.assertEqual([gripper.goal(), gripper.goal()], [(0.0, 6.0), (0.085, 30.0)])

    def test_follow_a_force_that_rises(self):
        self.program(goals_per_s=100)
        gripper, lines = self.gripper(), self.connect()
        self.await_server(lines)
        last = None
        for step in range(1, 21):
            def risen():
                self.say(lines, {"order": "grip", "force_n": step})
                return not gripper.goals.empty()
            await_true(risen, f"a goal for {step} N")
            last = gripper.goal()
        self.assertEqual(last, (0.0, 40.0))

    def test_go_to_a_gripper_of_named_joints(self):
        self.program(type="ParallelGripperCommand", joint="finger")
        gripper, lines = self.gripper(kind="ParallelGripperCommand"), self.connect()
        self.await_server(lines)
        self.grip(lines, 3.5)
        self.assertEqual(gripper.goal(), (0.0, 7.0, "finger"))

        def answer():
            gripper.feedback(0.017, 4)
            return self.say(lines, {"order": "grip", "force_n": 3.5})
        await_true(lambda: answer() == {"width_mm": 17.0, "force_n": 2.0}, "where the named joint is")

    def test_have_the_header_of_cyclonedds_where_it_is_asked_for(self):
        for kind, more in (("GripperCommand", {}), ("ParallelGripperCommand", {"joint": "finger"})):
            with self.subTest(kind=kind):
                program = self.program(middleware="cyclonedds", type=kind, **more)
                gripper, lines = self.gripper(kind=kind, counted=True), self.connect()
                self.await_server(lines)
                self.grip(lines, 1)
                self.say(lines, {"order": "open"})
                self.assertEqual([gripper.goal()[:2], gripper.goal()[:2]], [(0.0, 2.0), (0.085, 30.0)])
                (first, one), (second, two) = gripper.clients
                self.assertEqual((first == second, one, two), (True, 1, 2))
                program.terminate()
                self.assertEqual(program.wait(PATIENCE_S), 0)
                gripper.close()

    def test_that_are_none_are_answered_as_such(self):
        self.program()
        gripper, lines = self.gripper(), self.connect()
        self.await_server(lines)
        for line in ("{}", "open", '{"order":"grip"}', '{"order":"grip","force_n":-1}'):
            self.assertIn("no order", self.say(lines, line)["fault"])
        self.say(lines, {"order": "open"})
        self.assertEqual(gripper.goal(), (0.085, 30.0), "and moved nothing")


class AGripper(Bed):
    def test_that_is_not_there_counts_as_gone_until_it_is(self):
        self.program()
        lines = self.connect()
        fault = self.say(lines, {"order": "grip", "force_n": 1})["fault"]
        self.assertIn(f"no node serves the action {ACTION} of type control_msgs/action/GripperCommand", fault)
        gripper = self.gripper()
        self.await_server(lines)
        self.grip(lines, 1)
        self.assertEqual(gripper.goal(), (0.0, 2.0))

    def test_that_goes_counts_as_gone_and_gets_its_goal_when_it_is_back(self):
        self.program()
        lines, first = self.connect(), self.gripper()
        self.await_server(lines)
        self.grip(lines, 1)
        first.goal()
        first.close()
        await_true(lambda: "no node serves" in self.say(lines, {"order": "grip", "force_n": 1}).get("fault", ""), "word of it")
        second = self.gripper()
        await_true(lambda: self.say(lines, {"order": "grip", "force_n": 1}) == {} and not second.goals.empty(), "the gripper and its goal")
        self.assertEqual(second.goal(), (0.0, 2.0))

    def test_of_another_type_is_none(self):
        self.program()
        self.gripper(kind="ParallelGripperCommand")
        other, lines = self.gripper(), self.connect()
        self.await_server(lines)  # the right one is found, so the wrong one has been, too
        other.close()
        await_true(lambda: "no node serves" in self.say(lines, {"order": "stay"}).get("fault", ""), "word of it")

    def test_that_takes_no_goals_counts_as_gone(self):
        self.program(accept_ms=50)
        gripper, lines = self.gripper(state=None), self.connect()
        self.await_server(lines)
        await_true(lambda: "takes no goals" in self.say(lines, {"order": "grip", "force_n": 1}).get("fault", ""), "word of it")
        gripper.state = EXECUTING
        # slipd-grip orders the same all the time while the gripper counts as gone.
        await_true(lambda: self.say(lines, {"order": "grip", "force_n": 1}) == {}, "that it takes one that is sent again")
        await_true(lambda: self.say(lines, {"order": "grip", "force_n": 2}) == {}, "that it takes the next")

    def test_that_stalls_on_the_object_holds_it(self):
        self.program()
        gripper, lines = self.gripper(state=ABORTED), self.connect()
        self.await_server(lines)
        await_true(lambda: self.say(lines, {"order": "grip", "force_n": 1}) == {} and "gave its goal up" in self.log(), "the journal")

    def test_obeys_one_program_at_a_time(self):
        self.program()
        lines = self.connect()
        self.say(lines, {"order": "stay"})
        other = self.connect()
        self.assertIn("another program commands this gripper", json.loads(other.readline())["fault"])
        self.assertEqual(other.readline(), "")

    def test_keeps_its_goal_when_the_program_ends(self):
        program = self.program()
        gripper, lines = self.gripper(), self.connect()
        self.await_server(lines)
        self.grip(lines, 1)
        gripper.goal()
        program.send_signal(signal.SIGTERM)
        self.assertEqual(program.wait(PATIENCE_S), 0)
        self.assertTrue(gripper.goals.empty())


class SlipdGrip(Bed):
    def test_moves_the_gripper_through_it(self):
        left = {"name": "left", "driver": "push", "rate_hz": 100, "layout": {"grid": [4, 4], "pitch_mm": 4}}
        bed = Programs({"sensors": [left]}, {"fingers": ["left"], "force": {"close_n": 2, "firm_n": 12, "most_n": 15}})
        self.addCleanup(bed.close)
        self.socket_path = bed.at("gripper.sock")
        gripper = self.gripper()
        self.program()
        bed.start("grip")
        await_true(lambda: (bed.status() or {}).get("gripper") == "answers", "slipd-grip and its gripper")
        bed.order("close")
        self.assertEqual(gripper.goal(), (0.0, 24.0), "firm, as slipd is not there")
        bed.order("open")
        self.assertEqual(gripper.goal(), (0.085, 30.0))
        gripper.close()
        await_true(lambda: "no node serves the action" in bed.status()["gripper"], "slipd-grip hears that it has gone")


class Settings(Bed):
    def test_that_cannot_work_are_refused_with_their_places(self):
        path = os.path.join(self.folder.name, "grip-ros2.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"type": "ParallelGripperCommand", "open": 1, "closed": 1}, file)
        ran = subprocess.run([os.path.join(BUILD, "bin", "slipd-grip-ros2"), "--config", path, "--check-config"], capture_output=True, text=True,
                             check=False)
        self.assertEqual(ran.returncode, 2)
        for part in ("/type", 'needs "joint"', "/open", "the gripper never moves"):
            self.assertIn(part, ran.stdout + ran.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
