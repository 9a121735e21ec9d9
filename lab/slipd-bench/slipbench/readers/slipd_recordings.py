"""Recordings of slipd, one sensor each, with the true margin that simulated sensors have. Forces in newtons."""
import sys
from pathlib import Path

import numpy as np

from ..recording import Recording, Truth

sys.path.insert(0, str(Path(__file__).resolve().parents[4] / "clients/python"))
import slipd  # noqa: E402


def read(path, spec):
    recorded = slipd.open(path)
    frames = list(recorded)
    side_m = recorded.layout["pitch_m"]
    columns, rows = recorded.layout["grid"]
    values = np.array([np.stack([f.shear_x_pa, f.shear_y_pa, f.normal_pa], axis=1) for f in frames], float) * side_m ** 2
    places = [[1000 * side_m * column, 1000 * side_m * row] for row in range(rows) for column in range(columns)]
    sensor = next(iter(spec["sensors"]))
    about = {"sensor": spec["sensor"], "unit": spec["unit"], "channels": spec["channels"], "rate_hz": recorded.rate_hz,
             "sensors": {sensor: {"taxels_mm": places, "zero": [0] * values[0].size}}, "least_normal": spec["least_normal"]}
    times = np.array([f.time_s for f in frames]) - frames[0].time_s
    gamma = np.array([np.nan if f.truth_gamma is None else f.truth_gamma for f in frames])
    return Recording(path.stem, path.stem, recorded.rate_hz, times, {sensor: values}, about, Truth(gamma=gamma))


def recordings(folder, spec):
    for path in sorted(folder.glob(spec["recordings"])):
        yield read(path, spec)
