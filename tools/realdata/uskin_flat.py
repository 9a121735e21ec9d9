"""Grasps with two 4 x 4 magnetic fingertips while a camera on the hand sees how the object moves in it."""
import csv
import json
import math
import os
import re
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from . import object_motion
from . import recordings as rec
from .scores import area, roc

SCENE = "uskin-4x4.json"
SENSORS = ("sensor1", "sensor2")
GRASP = "gripper"
ZERO_S = 0.5          # nothing touches the sensors before 1 s
EARLIEST_S = 1.0      # an alarm so long before 1 mm of motion is in time,
LATEST_S = 0.5        # and so long after 2 mm or 10 degrees
BEFORE_S = 0.5        # gamma_low before a slip: its median over this time
SETTLED_S = 0.2       # after lifting, for gamma_low in still holds
LAG_S = 0.07          # the fingertips lag behind the camera


@dataclass
class Grasp:
    name: str
    kind: str                                  # slip, still, creep, flex
    truth: dict                                # columns of truth.csv; times in s, None where there is none
    rows: dict                                 # of each sensor and of the grasp
    seconds: list                              # object_motion.Second

    def part(self, source, begin, end):
        return [r for r in self.rows[source] if begin <= float(r["time_s"]) <= end]

    @property
    def end_s(self):
        return self.truth["drop_s"] or self.truth["end_s"]


@dataclass
class Result:
    grasps: list = field(default_factory=list)
    figures: dict = field(default_factory=dict)

    def of(self, kind):
        return [g for g in self.grasps if g.kind == kind]


def scene_for(truth, folder):
    """The shipped scene with this recording's rate, and its own zero."""
    text = re.sub(r"^\s*//.*$", "", (rec.SCENES / SCENE).read_text(), flags=re.MULTILINE)
    scene = json.loads(text)
    scene.pop("$schema", None)
    for sensor in scene["sensors"]:
        sensor["rate_hz"] = truth["rate_hz"]
        sensor["options"].pop("bias")
        sensor["options"]["zero_from_s"] = ZERO_S
    file = Path(folder) / f"{truth['recording']}.json"
    file.write_text(json.dumps(scene))
    return file


def read_truth(folder):
    def value(name, text):
        if name in ("recording", "half", "class", "notes"):
            return text
        return float(text) if text else None
    with open(folder / "truth.csv", newline="") as lines:
        return [{name: value(name, text) for name, text in row.items()} for row in csv.DictReader(lines)]


def read_grasp(sliplab, folder, truth, scenes):
    of = folder / truth["recording"]
    files = [f"{sensor}={of / f'xela_{sensor}.csv'}" for sensor in SENSORS]
    rows = rec.replayed(sliplab, scene_for(truth, scenes), files)
    by_source = {source: [r for r in rows if r["sensor"] == source] for source in (*SENSORS, GRASP)}
    seconds = object_motion.seconds_of(of / "marker.csv", truth["rate_hz"], truth["lift_s"], truth["drop_s"] or truth["end_s"])
    return Grasp(truth["recording"], truth["class"], truth, by_source, seconds)


def onset(grasp):
    """When alarms are in time, s."""
    truth = grasp.truth
    last = min(t for t in (truth["t2mm_s"], truth["turn10_s"], grasp.end_s) if t is not None)
    return truth["t1mm_s"] - EARLIEST_S, max(last, truth["t1mm_s"]) + LATEST_S


def rises(rows, said):
    times, before = [], False
    for row in rows:
        if said(row) and not before:
            times.append(float(row["time_s"]))
        before = said(row)
    return times


def how_told(grasp, sources, said):
    """in time, late, standing (raised before, and never let go of) or missed; and the delay after 1 mm of motion, s."""
    begin, end = onset(grasp)
    after = sorted(t for source in sources for t in rises(grasp.rows[source], said) if t >= begin)
    if after and after[0] <= end:
        return "in time", after[0] - grasp.truth["t1mm_s"]
    at_begin = [[r for r in grasp.rows[source] if float(r["time_s"]) < begin][-1:] for source in sources]
    if any(rows and said(rows[0]) for rows in at_begin):
        return "standing", None
    if after and after[0] <= grasp.end_s:
        return "late", after[0] - grasp.truth["t1mm_s"]
    return "missed", None


def held(grasp, source):
    return grasp.part(source, grasp.truth["closed_s"], grasp.end_s)


def alarmed(grasp, sources, said):
    return any(said(r) for source in sources for r in grasp.part(source, grasp.truth["contact_s"], grasp.end_s))


def told_figures(result, sources, said):
    slips, still = result.of("slip"), result.of("still")
    told = [how_told(g, sources, said) for g in slips]
    ways = {way: sum(t[0] == way for t in told) for way in ("in time", "late", "standing", "missed")}
    delays = sorted(t[1] for t in told if t[1] is not None)
    rows = [r for g in still for source in sources for r in held(g, source)]
    false = [g for g in still if alarmed(g, sources, said)]
    return {"slips": len(slips), **ways, "delay, median": delays[len(delays) // 2] if delays else math.nan,
            "before 1 mm": sum(d < 0 for d in delays), "still": len(still), "still with alarm": len(false),
            "hold in alarm": sum(map(said, rows)) / len(rows),
            "balanced": (sum(t[0] in ("in time", "late") for t in told) / len(slips) + 1 - len(false) / len(still)) / 2}


def said_in(grasp, second, said):
    rows = grasp.part(GRASP, second.begin_s + LAG_S, second.begin_s + 1 + LAG_S)
    return any(said(r) for r in rows)


def second_figures(result):
    found = {"moving": [], "still": [], "turning": [], "turning called translation": []}
    for grasp in result.grasps:
        if grasp.kind == "flex":
            continue
        for second in grasp.seconds:
            if second.kind in ("moving", "turning"):
                found["moving"].append(said_in(grasp, second, rec.slides))
            if second.kind == "still":
                found["still"].append(said_in(grasp, second, rec.slides))
            if second.kind == "turning":
                found["turning"].append(said_in(grasp, second, lambda r: r["sliding"] == "rotation"))
                found["turning called translation"].append(said_in(grasp, second, lambda r: r["sliding"] == "translation"))
    share = {name: sum(values) / max(1, len(values)) for name, values in found.items()}
    return {"counts": {name: (sum(values), len(values)) for name, values in found.items()},
            "balanced": (share["moving"] + 1 - share["still"]) / 2}


def middle(values):
    values = sorted(values)
    return values[len(values) // 2] if values else None


def lows(rows):
    return [float(r["gamma_low"]) for r in rows if r["gamma_low"]]


def margin_figures(result):
    figures = {}
    for source in (*SENSORS, GRASP):
        rows = [r for g in result.of("still") for r in g.part(source, g.truth["lift_s"], g.end_s)]
        figures[f"{source}: with a margin"] = sum(r["state"] == "ok" for r in rows) / len(rows)
        slips = [middle(lows(g.part(source, max(g.truth["lift_s"], g.truth["t1mm_s"] - BEFORE_S), g.truth["t1mm_s"])))
                 for g in result.of("slip")]
        holds = [middle(lows(g.part(source, g.truth["lift_s"] + SETTLED_S, g.end_s))) for g in result.of("still")]
        slips, holds = [-v for v in slips if v is not None], [-v for v in holds if v is not None]
        figures[f"{source}: gamma_low, AUC"] = area(roc(slips, holds)) if slips and holds else math.nan
        figures[f"{source}: gamma_low before slips, in holds"] = (-(middle(slips) or 0), -(middle(holds) or 0))
    return figures


DETECTORS = {"the grasp's alert": ((GRASP,), rec.slips), "alert, either finger": (SENSORS, rec.slips),
             "by its margin": (SENSORS, lambda r: rec.slips(r) and r["alert_cause"] == "margin"),
             "the grasp's sliding": ((GRASP,), rec.slides), "sliding, either finger": (SENSORS, rec.slides)}


def tell(result):
    for name, figures in result.figures["told"].items():
        print(f"uskin-flat, {name}: " + "; ".join(
            f"{key} {value:.3f}" if isinstance(value, float) else f"{key} {value}" for key, value in figures.items()))
    seconds = result.figures["seconds"]
    print("uskin-flat, seconds: " + ", ".join(f"{name} {a} of {b}" for name, (a, b) in seconds["counts"].items())
          + f"; balanced {seconds['balanced']:.3f}")
    for name, value in result.figures["margin"].items():
        print(f"uskin-flat, {name}: " + (f"{value:.3f}" if isinstance(value, float) else f"{value[0]:.3f}, {value[1]:.3f}"))


def measure(sliplab, folder):
    result = Result()
    with tempfile.TemporaryDirectory() as scenes, ThreadPoolExecutor(os.cpu_count()) as pool:
        result.grasps = list(pool.map(lambda truth: read_grasp(sliplab, folder, truth, scenes), read_truth(folder)))
    result.figures = {"told": {name: told_figures(result, *which) for name, which in DETECTORS.items()},
                      "seconds": second_figures(result), "margin": margin_figures(result)}
    tell(result)
    if os.environ.get("SLIPD_REAL_EACH"):
        for grasp in result.grasps:
            told = [how_told(grasp, *DETECTORS[name])[0] if grasp.kind == "slip" else
                    ("alarm" if alarmed(grasp, *DETECTORS[name]) else "silent") for name in DETECTORS]
            print(f"  {grasp.name} {grasp.kind}: " + "; ".join(f"{name}: {way}" for name, way in zip(DETECTORS, told)))
    return result
