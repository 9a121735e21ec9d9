"""69 sequences of ten raw magnetometers: an object is held, and in some pulled until it slips. No zero, no forces."""
import csv
from dataclasses import dataclass, field

from . import recordings as rec
from . import rivals
from .scores import area, balanced, best_balanced, roc

SCENE = "eflesh.json"
RATE_HZ = 100


@dataclass
class Result:
    labels: list = field(default_factory=list)
    slid: list = field(default_factory=list)         # whether slipd reports translation or rotation
    told: list = field(default_factory=list)         # whether it reports anything but none
    statistics: dict = field(default_factory=dict)   # plain detector: of each sequence

    def curve(self, name):
        values = self.statistics[name]
        return roc([v for v, l in zip(values, self.labels) if l], [v for v, l in zip(values, self.labels) if not l])

    def point(self, found):
        """(false, true) of a verdict."""
        false = [f for f, l in zip(found, self.labels) if not l]
        true = [f for f, l in zip(found, self.labels) if l]
        return sum(false) / len(false), sum(true) / len(true)


# The normal channels have no zero, so that P is what they rose to; P drops relative to the range that it has.
def raw_drop(recording, _):
    normal = recording.normal()
    size = sum(abs(v) for v in recording.z[0])
    means = rivals.moving_mean(normal, rivals.rows_in(recording, rivals.DROP_S))
    return [(mean - p) / size for p, mean in zip(normal, means)]


def raw_vibration(recording, _):
    half, window = rivals.rows_in(recording, rivals.STEADY_S) // 2, rivals.rows_in(recording, rivals.RMS_S)
    squares = [0.0] * len(recording.times)
    for sums in ([sum(row) for row in recording.x], [sum(row) for row in recording.y]):
        for i, (value, mean) in enumerate(zip(sums, rivals.moving_mean(sums, half, half))):
            squares[i] += (value - mean) ** 2
    return [s ** 0.5 for s in rivals.moving_mean(squares, window)]


PLAIN = {"P drops": raw_drop, "vibration": raw_vibration, "moved since the hold": rivals.moved}


def measure(sliplab, folder):
    result = Result()
    with open(folder / "labels.csv", newline="") as lines:
        labels = list(csv.DictReader(lines))
    for row in labels:
        file = folder / f"{row['sequence']}.csv"
        rows = rec.replayed(sliplab, SCENE, file)
        recording = rec.read(file, RATE_HZ)
        result.labels.append(row["slip"] == "1")
        result.slid.append(any(rec.slides(r) for r in rows))
        result.told.append(any(r["sliding"] not in ("", "none") for r in rows))
        for name, of in PLAIN.items():
            result.statistics.setdefault(name, []).append(max(of(recording, 0)))
    print(f"eflesh, {len(labels)} sequences: balanced accuracy of sliding {balanced(result.slid, result.labels):.3f}, "
          f"of anything told {balanced(result.told, result.labels):.3f}")
    for name in PLAIN:
        points = result.curve(name)
        print(f"  {name}: area under the ROC {area(points):.3f}, best balanced accuracy {best_balanced(points):.3f}")
    return result
