"""The pages of docs/tutorials, and a program's way through docs/first-sensor.md, against the real programs: what a page shows is what is printed.

A page's first jsonc block is the configuration, its python block the program, each text block what the commands or the program before it print
("…": anything). Only paths differ here: sockets, and the simulated device in place of a real one."""
import contextlib, os, pathlib, pty, re, subprocess, sys, tempfile, threading, time, tty, unittest

BUILD, SOURCE = (pathlib.Path(os.environ[name]) for name in ("SLIPD_BINARY_DIR", "SLIPD_SOURCE_DIR"))
sys.path.insert(0, str(SOURCE / "tests/support"))
from awaiting import PATIENCE_S, await_true

PAGES = SOURCE / "docs/tutorials"
PULLS = '{"cycle":[{"ms":1500,"normal_n":0,"shear_n":0,"friction":0.6},{"ms":300,"normal_n":[0,3]},{"ms":1500},{"ms":1200,"load":[0,1.1]},{"ms":800},' \
        '{"ms":300,"load":[1.1,0]},{"ms":300,"normal_n":[3,0]}]}'


def blocks(page, kind):
    return re.findall(rf"```{kind}\n(.*?)```", (PAGES / page).read_text(encoding="utf-8"), re.DOTALL)


def as_pattern(line):
    return r"\s+".join(re.escape(word).replace("…", ".*") for word in line.split())


class Tutorial(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder, self.socket = pathlib.Path(kept.name), f"{kept.name}/socket"
        self.environment = os.environ | {"STATE_DIRECTORY": kept.name, "PYTHONPATH": str(SOURCE / "clients/python"), "PATH": f"{BUILD}/bin:{os.environ['PATH']}"}

    def here(self, text, device=None):
        """A page's text with the paths of this test."""
        text = text.replace("/tmp/slipd-tutorial.sock", self.socket).replace("/tmp/slipd-grip", f"{self.folder}/grip")
        text = text.replace("slipd.Client()", f'slipd.Client("{self.socket}")').replace("/dev/serial/by-id/…", device or "")
        text = text.replace('unit="mm")', f'unit="mm", path="{self.socket}")')
        return re.sub(r"\bslipctl (?!--socket)", f"slipctl --socket {self.socket} ", text)

    def configured(self, page, device=None):
        text = self.here(blocks(page, "jsonc")[0], device)
        if '"socket"' not in text:
            text = text.replace("{", f'{{ "realtime": {{ "mode": "off" }}, "socket": {{ "path": "{self.socket}" }},', 1)
        settings = self.folder / "slipd.json"
        settings.write_text(text, encoding="utf-8")
        return settings

    def starts(self, page, device=None):
        self.runs_slipd(self.configured(page, device))

    def runs_slipd(self, settings):
        daemon = subprocess.Popen([BUILD / "bin/slipd", "--config", settings], env=self.environment, stderr=subprocess.DEVNULL)
        self.addCleanup(daemon.wait, PATIENCE_S)
        self.addCleanup(daemon.terminate)
        await_true(lambda: os.path.exists(self.socket) or daemon.poll() is not None, "slipd's socket")
        self.assertIsNone(daemon.poll(), "slipd ended")

    def prints(self, expected, command, once_it_looks=lambda: None):
        """Awaits each expected line in turn. once_it_looks is called when the program has said something."""
        program = subprocess.Popen(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        ended = threading.Timer(PATIENCE_S, program.kill)
        ended.start()
        lines, seen = [line for line in expected.splitlines() if line.strip()], []
        for said in program.stdout:
            if not seen:
                once_it_looks()
            seen.append(said)
            if lines and re.fullmatch(as_pattern(lines[0]), re.sub("^<[0-7]>", "", said.strip())):  # journald takes the level off
                lines.pop(0)
            if not lines:
                break
        ended.cancel()
        program.kill()
        program.wait()
        program.stdout.close()
        self.assertFalse(lines, f"not printed: {lines}, but: {''.join(seen[-20:])}")

    def lists_the_sensor(self, page):
        expected = blocks(page, "text")[0].splitlines()
        command = ["slipctl", "--socket", self.socket, "sensors"]
        await_true(lambda: subprocess.run(command, env=self.environment, capture_output=True, text=True).stdout.strip().endswith("yes"), "frames")
        self.prints("\n".join(expected), command)

    def runs_the_program(self, page, expected):
        self.prints(expected, [sys.executable, "-u", "-c", self.here(blocks(page, "python")[0])])

    def test_the_simulated_gripper_closes_when_told(self):
        self.starts("simulator.md")
        self.lists_the_sensor("simulator.md")
        self.prints(blocks("simulator.md", "text")[1], [sys.executable, SOURCE / "examples/gripper.py", "left", self.socket, f"{self.folder}/grip"])

    def test_mujoco_holds_an_object(self):
        laboratory = BUILD / "bin/slipd-lab"
        if not laboratory.exists() or subprocess.run([laboratory, "grip", "--help"], capture_output=True).returncode != 0:
            self.skipTest("slipd-lab is built without MuJoCo here")
        command = blocks("simulator.md", "sh")[-1].split()
        self.prints(blocks("simulator.md", "text")[4], [laboratory, *command[1:]])

    def test_a_box_in_mujoco_is_held_by_who_listens_and_falls_from_who_does_not(self):
        example, world = BUILD / "examples/example-mujoco", SOURCE / "examples/mujoco"
        if not example.exists():
            self.skipTest("example-mujoco is built without MuJoCo here")
        settings = self.folder / "slipd.json"
        settings.write_text((world / "slipd.json").read_text(encoding="utf-8").replace("/tmp/slipd-mujoco.sock", self.socket))
        self.runs_slipd(settings)
        self.prints(blocks("simulator.md", "text")[2], [example, world / "gripper.xml", self.socket])
        self.prints(blocks("simulator.md", "text")[3], [example, world / "gripper.xml", "deaf", self.socket])

    def test_a_program_pushes_frames_and_gets_an_alert(self):
        self.starts("program.md")
        self.runs_the_program("program.md", blocks("program.md", "text")[0])

    def test_a_serial_skin_tells_a_slide(self):
        device, script = f"{self.folder}/tty", self.folder / "pulls.json"
        script.write_text(PULLS)
        simulated = subprocess.Popen([BUILD / "test-bin/simulated-device", "anyskin", "--at", f"tty:{device}", "--script", script], stdout=subprocess.DEVNULL)
        self.addCleanup(simulated.wait, PATIENCE_S)
        self.addCleanup(simulated.terminate)
        await_true(lambda: os.path.exists(device), "the simulated skin")
        self.starts("serial-skin.md", device)
        self.lists_the_sensor("serial-skin.md")
        self.runs_the_program("serial-skin.md", blocks("serial-skin.md", "text")[1])

    def test_a_force_cell_that_is_printed_warns(self):
        ours, theirs = pty.openpty()
        tty.setraw(theirs)
        over = threading.Event()

        def print_lines():
            begin = time.monotonic()
            while not over.wait(0.01):
                at = (time.monotonic() - begin) % 6
                press, pull = (0, 0) if at < 1 else (min(3, (at - 1) * 10), max(0, min(1.6, (at - 2) * 0.6)))
                os.write(ours, f"{pull:.3f}, 0.000, {press:.3f}\n".encode())

        printing = threading.Thread(target=print_lines)
        printing.start()
        self.addCleanup(printing.join)
        self.addCleanup(over.set)
        self.starts("force-cell.md", os.ttyname(theirs))
        self.lists_the_sensor("force-cell.md")
        self.runs_the_program("force-cell.md", blocks("force-cell.md", "text")[1])

    @contextlib.contextmanager
    def playing(self, settings):
        """Within it, play() starts slipd-camera with these settings, in the folder of the test; it ends with the block."""
        with contextlib.ExitStack() as ends:
            def play():
                camera = subprocess.Popen([BUILD / "bin/slipd-camera", "--config", settings], cwd=self.folder, env=self.environment, stderr=subprocess.DEVNULL)
                ends.callback(camera.wait, PATIENCE_S)
                ends.callback(camera.terminate)
            yield play

    def test_a_camera_tells_a_slide_and_slipd_grip_holds(self):
        if not (BUILD / "bin/slipd-camera").exists():
            self.skipTest("slipd-camera is not built here")
        subprocess.run([BUILD / "test-bin/gel-video", "grasp.avi"], cwd=self.folder, check=True)
        _, of_a_camera, of_a_video, grip = blocks("camera.md", "jsonc")
        camera, video = self.folder / "camera.json", self.folder / "video.json"
        camera.write_text(of_a_camera, encoding="utf-8")
        video.write_text(of_a_video.replace("{", f'{{ "socket": "{self.socket}",', 1), encoding="utf-8")
        subprocess.run([BUILD / "bin/slipd-camera", "--config", camera, "--check-config"], check=True, capture_output=True)
        _, seen, journal = blocks("camera.md", "text")
        react = self.here(blocks("camera.md", "python")[0])

        self.starts("camera.md")
        with self.playing(video) as play:
            play()
            self.lists_the_sensor("camera.md")
        with self.playing(video) as play:
            self.prints(seen, [sys.executable, "-u", "-c", react], once_it_looks=play)

        orders, settings = f"{self.folder}/orders", self.folder / "grip.json"
        settings.write_text(grip.replace("{", f'{{ "socket": "{self.socket}", "orders": "{orders}",', 1), encoding="utf-8")
        with self.playing(video) as play:
            self.prints(journal, [BUILD / "bin/slipd-grip", "--config", settings], once_it_looks=play)

    def test_the_other_configurations_are_accepted(self):
        checked = subprocess.run([BUILD / "bin/slipd", "--config", self.configured("can-pad.md"), "--check-config"], capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stderr + checked.stdout)
        program = BUILD / "bin/slipd-ros2"
        if program.exists():
            settings = self.folder / "ros2.json"
            settings.write_text(blocks("ros2.md", "jsonc")[0])
            checked = subprocess.run([program, "--config", settings, "--check-config"], capture_output=True, text=True)
            self.assertEqual(checked.returncode, 0, checked.stderr + checked.stdout)

    def test_a_node_of_ros_2_hears_the_margin_and_grips_harder(self):
        """With Fast DDS. rclpy itself is not in Debian: tests/tutorials/ros2 has as much of it as the page's node uses."""
        if not (BUILD / "test-bin/fastdds-reader").exists():
            self.skipTest("Fast DDS is not installed: tools/setup --peers")
        domain, settings = str(1 + os.getpid() % 100), self.folder / "ros2.json"
        settings.write_text(f'{{ "socket": "{self.socket}", "domain": {domain} }}', encoding="utf-8")
        self.starts("simulator.md")
        bridge = subprocess.Popen([BUILD / "bin/slipd-ros2", "--config", settings], env=self.environment, stderr=subprocess.DEVNULL)
        self.addCleanup(bridge.wait, PATIENCE_S)
        self.addCleanup(bridge.terminate)
        self.environment |= {"ROS_DOMAIN_ID": domain, "PYTHONPATH": f"{SOURCE}/tests/tutorials/ros2:{SOURCE}/tests/support"}
        self.runs_the_program("ros2.md", blocks("ros2.md", "text")[0])

    def test_the_first_sensor_of_a_program_is_zeroed_and_alerts(self):
        """docs/first-sensor.md: the configuration and the program of its section on programs, then its commands. The page leaves the SDK's
        `read` to the reader: here it is a pad with an offset, that is gripped once there is a zero, and then pulled."""
        shell, program = blocks("../first-sensor.md", "sh"), blocks("../first-sensor.md", "python")[0]
        told = next(block for block in shell if "tee /etc/slipd/slipd.json" in block)
        settings = self.folder / "slipd.json"
        begun = f'{{ "realtime": {{ "mode": "off" }}, "socket": {{ "path": "{self.socket}" }},'
        settings.write_text(re.search(r"<<'END'\n(.*?)END\n", told, re.DOTALL)[1].replace("{", begun, 1))
        self.runs_slipd(settings)
        trouble = re.search(r"slipctl status +# trouble: (.*)", told)[1].replace("/run/slipd", str(self.folder))
        status = ["slipctl", "--socket", self.socket, "status"]
        await_true(lambda: trouble in subprocess.run(status, env=self.environment, capture_output=True, text=True).stdout, trouble)

        pulls = self.folder / "zeroed"
        read = f"""
import itertools, os, random, time
frames, noise = itertools.count(), random.Random(1)
def read():
    time.sleep(0.01)
    if os.path.exists({str(pulls)!r}): read.loaded = next(frames)
    at = read.loaded % 400  # grips, pulls by more than friction holds and lets go, again and again: a busy machine may miss one
    grip, pull = (min(4.0, 0.1 * at), max(0.0, 0.02 * (at - 100))) if at < 300 else (0.0, 0.0)
    return [[0.3 + pull / 16 + noise.gauss(0, 0.001), noise.gauss(0, 0.001), 0.5 + grip / 16 * (0.8 + 0.4 * (taxel % 4 > 1)) + noise.gauss(0, 0.001)]
            for taxel in range(16)]
read.loaded = 0
"""
        running = subprocess.Popen([sys.executable, "-u", "-c", read + self.here(program).replace('slipd.Source("left",', f'slipd.Source("left", path="{self.socket}",')],
                                   env=self.environment, stdout=subprocess.PIPE, text=True)
        ended = threading.Timer(PATIENCE_S, running.kill)
        ended.start()
        self.addCleanup(running.communicate)
        self.addCleanup(running.kill)
        self.addCleanup(ended.cancel)

        def prints(state):
            for line in running.stdout:
                if line.split()[0] == state:
                    return line
            return self.fail(f"the program did not print {state}")

        self.assertEqual(prints("unzeroed").split()[1], "None")
        rebias = next(line.split("#") for line in "".join(shell).splitlines() if line.startswith("sudo slipctl rebias"))
        command = self.here(rebias[0]).split()[1:]
        self.assertRegex(subprocess.run(command, env=self.environment, capture_output=True, text=True, check=True).stdout,
                         as_pattern(re.sub(r"\d+", "…", rebias[1]).strip()))
        prints("no_contact")
        alerts = subprocess.Popen(["slipctl", "--socket", self.socket, "watch", "left"], env=self.environment, stdout=subprocess.PIPE, text=True)
        self.addCleanup(alerts.communicate)
        self.addCleanup(alerts.kill)
        watched = threading.Timer(PATIENCE_S, alerts.kill)
        watched.start()
        self.addCleanup(watched.cancel)
        self.assertTrue(any("no_contact" in line for line in alerts.stdout), "what it shows before the grip")
        pulls.touch()
        self.assertGreater(float(prints("ok").split()[1]), 0)
        self.assertTrue(any(re.search(r"\b(warn|slip)\b", line) for line in alerts.stdout), "an alert")


if __name__ == "__main__":
    unittest.main()
