"""CSV files with a row a frame and columns txl1_x, txl1_y, txl1_z, txl2_x …, optionally time in s."""
import csv
import re

import numpy as np

from ..recording import Recording


def read_columns(file):
    with open(file, newline="") as lines:
        names = next(csv.reader(lines))
        return names, np.loadtxt(lines, delimiter=",", ndmin=2)


def grid_mm(spec):
    across, along = spec["grid"]["taxels"]
    pitch = spec["grid"]["pitch_mm"]
    return [[column * pitch, row * pitch] for row in range(along) for column in range(across)]


def taxels_of(names, sensor):
    return sensor.get("taxels") or [name[:-2] for name in names if name.endswith("_x")]


def rate_of(spec, path, values):
    """Rows a second: a number, a cell of a table, or by how often a row is new where the sensor's own rate is known."""
    how = spec["rate_hz"]
    if not isinstance(how, dict):
        return how
    if "file" in how:
        with open(path.parent / how["file"], newline="") as lines:
            return next(float(row[how["column"]]) for row in csv.DictReader(lines) if row[how["key"]] == path.stem)
    new = sum((np.diff(v, axis=0) != 0).any(axis=(1, 2)).sum() for v in values.values()) / len(values)
    rows = len(next(iter(values.values())))
    return how["new_rows_a_second"] * (rows - 1) / new


def block_of(spec, path):
    how = spec.get("block", {})
    if "pattern" in how:
        found = re.search(how["pattern"], path.stem)
        return found.group(1) if found else path.stem
    if "file" in how:
        with open(path / how["file"], newline="") as lines:
            return next(csv.DictReader(lines))[how["column"]]
    return path.stem


def read(path, spec):
    values, about, times = {}, {}, None
    for name, sensor in spec["sensors"].items():
        columns, rows = read_columns(path / sensor["file"] if "file" in sensor else path)
        at = {column: i for i, column in enumerate(columns)}
        taxels = taxels_of(columns, sensor)
        values[name] = rows[:, [at[f"{taxel}_{axis}"] for taxel in taxels for axis in "xyz"]].reshape(len(rows), len(taxels), 3)
        about[name] = {"taxels_mm": sensor.get("taxels_mm") or grid_mm(spec), **{k: sensor[k] for k in ("zero",) if k in sensor}}
        if "time" in at:
            times = rows[:, at["time"]] - rows[0, at["time"]]
    least = min(map(len, values.values()))   # files of one grasp may differ by a row
    values = {name: rows[:least] for name, rows in values.items()}
    rate_hz = rate_of(spec, path, values)
    if times is None:
        times = np.arange(least) / rate_hz
    told = {"sensor": spec["sensor"], "unit": spec["unit"], "channels": spec["channels"], "rate_hz": rate_hz, "sensors": about}
    told.update({key: spec[key] for key in ("zero_from_s", "least_normal") if key in spec})
    return Recording(path.stem, block_of(spec, path), rate_hz, times[:least], values, told)


def recordings(folder, spec):
    for path in sorted(folder.glob(spec["recordings"])):
        yield read(path, spec)
