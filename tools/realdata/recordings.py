"""Recordings as rows of forces, and through `sliplab replay`."""
import csv
import datetime
import io
import math
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
SCENES = SOURCE / "config/scenes"


@dataclass
class Recording:
    """x, y, z of each taxel in each row, unit of the file (z presses), less the bias; time in s from the first row."""
    times: list
    x: list
    y: list
    z: list

    def normal(self):
        """P of each row."""
        return [sum(row) for row in self.z]

    def shear(self):
        """Q of each row: the size of the resultant."""
        return [math.hypot(sum(xs), sum(ys)) for xs, ys in zip(self.x, self.y)]

    def ratio(self, least_normal):
        """Q/P of each row, 0 where P is below least_normal."""
        return [q / p if p > least_normal else 0.0 for q, p in zip(self.shear(), self.normal())]


def read_csv(file):
    with open(file, newline="") as lines:
        rows = list(csv.reader(lines))
    return rows[0], [[float(value) for value in row] for row in rows[1:] if row]


def read(file, rate_hz, bias=None, taxels=None):
    """A CSV with columns txl1_x …; `bias`: x, y, z of each taxel in turn; `taxels`: the names to take, all if None."""
    names, rows = read_csv(file)
    if taxels is None:
        taxels = [name[:-2] for name in names if name.endswith("_x")]
    column = {name: i for i, name in enumerate(names)}
    bias = bias or [0.0] * (3 * len(taxels))

    def channel(axis):
        places = [(column[f"{taxel}_{'xyz'[axis]}"], bias[3 * k + axis]) for k, taxel in enumerate(taxels)]
        return [[row[at] - off for at, off in places] for row in rows]
    if "time" in column:
        start = rows[0][column["time"]]
        times = [row[column["time"]] - start for row in rows]
    else:
        times = [i / rate_hz for i in range(len(rows))]
    return Recording(times, channel(0), channel(1), channel(2))


def replayed(sliplab, scene, files, sensor=None, more=()):
    """The rows of `sliplab replay`: of one sensor, or of all of the scene, and its grasps, one after another. `scene`: a shipped one, or a file."""
    command = [sliplab, "replay", "--scene", SCENES / scene, "--estimates", "-"]
    for file in files if isinstance(files, list) else [files]:
        command += ["--file", file]
    if sensor:
        command += ["--sensor", sensor]
    command += more
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    return list(csv.DictReader(io.StringIO(done.stdout)))


def today():
    return datetime.date.today().strftime("%-d %B %Y")


def commit():
    """Of this tree; marked where what figures come from was changed since."""
    git = ["git", "-C", str(SOURCE)]
    name = subprocess.run([*git, "describe", "--always"], capture_output=True, text=True, check=True).stdout.strip()
    same = subprocess.run([*git, "diff", "--quiet", "HEAD", "--", "config", "core", "drivers", "tools"], check=False).returncode == 0
    return name if same else f"{name} and changes"


def number(text):
    return float(text) if text else None


def slips(row):
    return row["alert"] == "slip"


def slides(row):
    return row["sliding"] in ("translation", "rotation")
