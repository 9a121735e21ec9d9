"""slipd-bench: what its measures say of alarms that are known, and that the detector of docs/slipd-bench.md enters as the page says."""
import csv, json, os, re, subprocess, sys, tempfile, unittest
from pathlib import Path

SOURCE, BUILD = Path(os.environ["SLIPD_SOURCE_DIR"]), Path(os.environ["SLIPD_BINARY_DIR"])
BENCH = SOURCE / "lab/slipd-bench"
sys.path.insert(0, str(BENCH))
import numpy as np  # noqa: E402
from slipbench import figures, measures  # noqa: E402
from slipbench.detector import Decisions  # noqa: E402
from slipbench.recording import Recording, Slip, Truth  # noqa: E402

RATE_HZ, END_S, ONSET_S = 50, 4.0, 2.0
TIMES = np.arange(0, END_S, 1 / RATE_HZ)


def judged(*grasps):
    """Counts of recordings, each of the intervals of its alarms, its truth and its block."""
    recordings, decided = [], []
    for alarmed, truth, block in grasps:
        alarm = np.zeros(len(TIMES), bool)
        for begin, end in alarmed:
            alarm |= (TIMES >= begin) & (TIMES < end)
        recordings.append(Recording("r", block, RATE_HZ, TIMES, {}, {}, truth))
        decided.append(Decisions(alarm, alarm.astype(float), *(np.full(len(TIMES), np.nan) for _ in range(3)), np.ones(len(TIMES), bool)))
    return measures.judge(recordings, decided)


def counted(alarmed, truth):
    return judged((alarmed, truth, "a"))[0]


SLIPS = Truth(slips=[Slip(ONSET_S - 0.5, ONSET_S + 0.5, ONSET_S)])
HOLDS = Truth(quiet=[(0, END_S)], held=[(0, END_S)])


class Measures(unittest.TestCase):
    def test_an_alarm_in_the_window_tells_the_slip_with_its_latency(self):
        counts = counted([(2.2, 3)], SLIPS)
        self.assertEqual((counts.in_time, counts.late, counts.standing), (1, 0, 0))
        self.assertAlmostEqual(counts.latencies[0], 0.2)

    def test_an_alarm_that_stood_before_tells_nothing(self):
        self.assertEqual((counted([(1, 4)], SLIPS).in_time, counted([(1, 4)], SLIPS).standing), (0, 1))

    def test_an_alarm_after_the_window_is_late(self):
        self.assertEqual((counted([(3, 4)], SLIPS).in_time, counted([(3, 4)], SLIPS).late), (0, 1))

    def test_alarms_that_pause_shortly_are_one_false_alarm_and_others_two(self):
        self.assertEqual(counted([(1, 1.2), (1.4, 2)], HOLDS).false, 1)
        self.assertEqual(counted([(1, 1.2), (2.4, 3)], HOLDS).false, 2)

    def test_false_alarms_are_counted_per_hour_of_holding(self):
        found = figures.figures(judged(*(([(1, 1.2)], HOLDS, block) for block in "abcdef")))
        self.assertAlmostEqual(found["false alarms"].value, 3600 / END_S, delta=0.01 * 3600 / END_S)
        self.assertAlmostEqual(found["held in alarm"].value, 0.2 / END_S, delta=1 / RATE_HZ)

    def test_a_perfect_detector_has_area_0_and_a_silent_one_area_1(self):
        perfect = judged(([(2, 3)], SLIPS, "a"), ([], HOLDS, "b"))
        silent = judged(([], SLIPS, "a"), ([], HOLDS, "b"))
        self.assertEqual(figures.figures(perfect)["area"].value, 0)
        self.assertEqual(figures.figures(silent)["area"].value, 1)

    def test_intervals_hold_what_they_are_of_and_are_the_same_in_each_run(self):
        of_blocks = judged(*(([(2, 3)] if block in "abcd" else [], SLIPS, block) for block in "abcdefgh"))
        found = figures.figures(of_blocks)["in time"]
        self.assertEqual(found.value, 0.5)
        self.assertTrue(0 < found.low < 0.5 < found.high < 1)
        self.assertEqual(found, figures.figures(of_blocks)["in time"])


def page_example():
    return re.search(r"^```python\n(.*?)^```", (SOURCE / "docs/slipd-bench.md").read_text(), re.S | re.M)[1]


class Program(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.data = Path(self.folder.name)
        (self.data / "detector.py").write_text(page_example())

    def bench(self, *words):
        return subprocess.run([BENCH / "slipd-bench", *map(str, words)], capture_output=True, text=True, check=False)

    def make_set(self):
        """Two taxels; in half of the recordings the pull passes half of the pressure at the onset, for good."""
        (self.data / "pulls").mkdir()
        for i in range(6):
            rise = np.where(TIMES >= ONSET_S, 1.2, 0.6) if i % 2 else np.full(len(TIMES), 0.6)
            rows = np.c_[TIMES, rise / 2, 0 * TIMES, 0 * TIMES + 1, rise / 2, 0 * TIMES, 0 * TIMES + 1]
            np.savetxt(self.data / f"pulls/of{i}.csv", rows, delimiter=",", comments="", header="time,txl1_x,txl1_y,txl1_z,txl2_x,txl2_y,txl2_z")
            np.savetxt(self.data / f"pulls/of{i}.slip", np.c_[TIMES, rise > 1], delimiter=",", comments="", header="time,slip")
        (self.data / "pulls/labels.txt").write_text("name,slip\n" + "".join(f"of{i},{i % 2}\n" for i in range(6)))
        described = {"title": "pulls", "source": {"url": "-", "licence": "-"}, "sha256": "", "reader": "csv_rows", "recordings": "*.csv", "sensor": "-",
                     "sensors": {"pad": {"taxels_mm": [[0, 0], [1, 0]]}}, "unit": "N", "channels": ["x", "y", "z"], "rate_hz": RATE_HZ,
                     "truth": {"generator": "labels", "file": "labels.txt", "key": "name", "column": "slip", "quiet_s": 1.0}}
        described["sha256"] = self.bench("digest", self.data / "pulls").stdout.strip()
        (self.data / "pulls.json").write_text(json.dumps(described))
        return self.data / "pulls.json"

    def figures_of(self, *words):
        done = self.bench("run", *words, "--data", self.data, "--out", self.data / "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.data / "out/figures.csv", newline="") as lines:
            return {(row["detector"], row["figure"]): float(row["value"]) for row in csv.DictReader(lines)}

    def test_the_detector_of_the_page_enters_a_set_that_somebody_described(self):
        mine = f"{sys.executable} {self.data / 'detector.py'}"
        found = self.figures_of(self.make_set(), "--command", mine)
        self.assertEqual((found[mine, "in time"], found[mine, "false alarms"], found[mine, "answered"]), (1, 0, 1))

    def test_one_that_looks_ahead_is_found_out(self):
        (self.data / "ahead.py").write_text("import json, sys\nlines = list(sys.stdin)\n"
                                            "for line in lines[1:]:\n    print(json.dumps({'t': json.loads(line)['t'], 'score': len(lines)}))\n")
        described = self.make_set()
        self.assertEqual(self.bench("check", described, "--data", self.data, "--command", f"{sys.executable} {self.data / 'detector.py'}").returncode, 0)
        ahead = self.bench("check", described, "--data", self.data, "--command", f"{sys.executable} {self.data / 'ahead.py'}")
        self.assertIn("looks into the future", ahead.stderr)

    def test_other_files_than_those_described_are_refused(self):
        described = self.make_set()
        (self.data / "pulls/of1.csv").write_text("time,txl1_x\n0,0\n")
        self.assertIn("not the files that pulls.json describes", self.bench("run", described, "--data", self.data, "--command", "true").stderr)

    def test_what_is_no_decision_is_named(self):
        self.assertIn("line 1 of its output is no decision", self.bench("run", self.make_set(), "--data", self.data, "--command", "echo slip").stderr)

    def test_slipd_tells_the_slips_of_a_magnetic_skin_as_its_own_tests_say(self):
        (self.data / "eflesh").mkdir()
        for file in (SOURCE / "tests/data/eflesh").glob("*.csv"):
            (self.data / "eflesh" / file.name).symlink_to(file)
        (self.data / "eflesh/labels.csv").write_text("sequence,slip\n" + "".join(f"seq_0{n},{int(n < '50')}\n" for n in ("00", "02", "04", "86", "88", "90")))
        found = self.figures_of("eflesh", "--any-files", "--detector", "slipd", "--build", BUILD)
        self.assertEqual(found["slipd", "in time"], 1)
        self.assertLessEqual(found["slipd", "quiet with alarm"], 1 / 3)


if __name__ == "__main__":
    unittest.main()
