"""Recordings of two 4 x 4 magnetic fingertips that hold one object; one trial of three has a labelled slip."""
import csv
import json
import re
from dataclasses import dataclass, field

from . import recordings as rec
from . import rivals
from .scores import first_above

SCENE = "uskin-4x4.json"
RATE_HZ = 60
SENSORS = ("sensor1", "sensor2")
LEAST_COUNTS = 1000   # of P
SETTLED_S = 0.5       # the plain detectors need so long for their means
EARLY_S = 0.5         # an alarm so long before the label belongs to it


@dataclass
class Run:
    trial: str
    sensor: str
    label_s: float                                 # None: no slip
    rows: list
    recording: rec.Recording
    values: dict
    leads: dict = field(default_factory=dict)      # detector: label minus alarm, s; None: none
    false: dict = field(default_factory=dict)      # detector: whether it alarms without a label, or too early


def bias_of(sensor):
    text = re.sub(r"^\s*//.*$", "", (rec.SCENES / SCENE).read_text(), flags=re.MULTILINE)
    return next(s for s in json.loads(text)["sensors"] if s["name"] == sensor)["options"]["bias"]


def read_run(sliplab, trial, sensor):
    file = trial / f"xela_{sensor}.csv"
    rows = rec.replayed(sliplab, SCENE, file, sensor)
    with open(trial / "slip_label.csv", newline="") as lines:
        labels = [float(row["slip"]) > 0 for row in csv.DictReader(lines)]
    recording = rec.read(file, RATE_HZ, bias_of(sensor))
    label = float(rows[labels.index(True)]["time_s"]) if any(labels) else None
    values = {name: of(recording, LEAST_COUNTS) for name, of in rivals.RIVALS.items()}
    return Run(trial.name, sensor, label, rows, recording, values)


def limits_of(runs):
    """Of each plain detector and sensor the least threshold that stays silent in the trials without a slip."""
    limits = {}
    for run in runs:
        if run.label_s is not None:
            continue
        for name, values in run.values.items():
            most = max(v for v, t in zip(values, run.recording.times) if t >= SETTLED_S)
            limits[name, run.sensor] = max(limits.get((name, run.sensor), 0.0), most)
    return limits


def measure(sliplab, folder):
    runs = [read_run(sliplab, trial, sensor) for trial in sorted(p for p in folder.iterdir() if p.is_dir()) for sensor in SENSORS]
    limits = limits_of(runs)
    for run in runs:
        alarms = {"slipd": next((float(r["time_s"]) for r in run.rows if rec.slips(r)), None)}
        for name, values in run.values.items():
            alarms[name] = first_above(values, run.recording.times, limits[name, run.sensor], SETTLED_S)
        for name, at in alarms.items():
            early = at is not None and (run.label_s is None or at < run.label_s - EARLY_S)
            run.false[name] = early
            run.leads[name] = None if at is None or early or run.label_s is None else run.label_s - at
        ok = sum(r["state"] == "ok" for r in run.rows)
        cause = next((r["alert_cause"] for r in run.rows if rec.slips(r)), "")
        print(f"uskin {run.trial} {run.sensor}: label {run.label_s}, first slip {alarms['slipd']} {cause}, "
              f"margin in {ok} of {len(run.rows)} rows")
    return runs
