"""What the detectors of this folder share: the frames of standard input as arrays, and how decisions are written."""
import json
import sys

import numpy as np


class Frames:
    """Of one recording. zeroed: whether values are less a zero; without one they are less nothing."""

    def __init__(self, lines):
        self.about = json.loads(next(lines))
        rows = [json.loads(line) for line in lines]
        self.times = np.array([row["t"] for row in rows])
        self.values = {name: np.array([row[name] for row in rows]) for name in self.about["sensors"]}
        self.zeroed = "zero_from_s" in self.about or all("zero" in s for s in self.about["sensors"].values())
        for name, sensor in self.about["sensors"].items():
            if "zero" in sensor:
                self.values[name] = self.values[name] - np.reshape(sensor["zero"], self.values[name].shape[1:])
            elif "zero_from_s" in self.about:
                self.values[name] = self.values[name] - self.values[name][self.times < self.about["zero_from_s"]].mean(axis=0)
        self.least_normal = self.about.get("least_normal", 0.0)

    def rows_in(self, seconds):
        return max(1, round(seconds * self.about["rate_hz"]))


def past_mean(values, rows):
    """Of each row and the `rows` before it, as many as there are."""
    sums = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    first = np.maximum(0, np.arange(len(values)) - rows)
    count = np.arange(len(values)) + 1 - first
    return (sums[1:] - sums[first]) / count.reshape(-1, *[1] * (values.ndim - 1))


def write(times, score, slip=None):
    for i, (t, s) in enumerate(zip(times.tolist(), score.tolist())):
        line = {"t": t, "score": None if s != s else s}
        if slip is not None:
            line["slip"] = None if s != s else bool(slip[i])
        sys.stdout.write(json.dumps(line) + "\n")
