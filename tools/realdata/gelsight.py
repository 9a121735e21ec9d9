"""Trials with two gel cameras in a gripper, each labelled as a whole: with a slip or without (folder gelsight, its README.md)."""
import csv
from dataclasses import dataclass
from pathlib import Path

from . import recordings as rec
from .scores import area, roc

SCENE = "gel-dots.json"
GRASP = "gripper"
FINGERS = {"left": "camera_0.avi", "right": "camera_2.avi"}
LONG = 450                      # pictures of a trial of kind A; all others are of kind B
RELEASE_S = {"A": 11.6, "B": 7.8}  # the robot lets go: picture 290 or 195, by the data's README
SLIDES_FROM = 1.0               # GelRelaxationOptions::slides_from


@dataclass
class Trial:
    name: str
    slip: bool
    kind: str
    evidence: dict              # most of the grasp's slide_evidence: as it comes, and with releasing
    slid: dict                  # whether an alert slip was raised

    @property
    def object(self):
        return self.name.split("/")[0]


def grasp_rows(sliplab, folder, releasing_from_s=None):
    files = [f"{finger}={folder / file}" for finger, file in FINGERS.items()]
    more = [] if releasing_from_s is None else ["--releasing-from", str(releasing_from_s)]
    rows = rec.replayed(sliplab, rec.SCENES / SCENE, files, more=more)
    return [row for row in rows if row["sensor"] == GRASP]


def read_trial(sliplab, folder, name, slip):
    plain = grasp_rows(sliplab, folder / name)
    kind = "A" if len(plain) >= LONG else "B"
    muted = grasp_rows(sliplab, folder / name, RELEASE_S[kind])
    evidence = {how: max((rec.number(r["slide_evidence"]) or 0 for r in rows), default=0) for how, rows in (("plain", plain), ("releasing", muted))}
    slid = {how: any(rec.slips(r) for r in rows) for how, rows in (("plain", plain), ("releasing", muted))}
    return Trial(name, slip, kind, evidence, slid)


def auc(trials, how):
    slips = [t.evidence[how] for t in trials if t.slip]
    holds = [t.evidence[how] for t in trials if not t.slip]
    return area(roc(slips, holds)) if slips and holds else None


def balanced(trials, how):
    slips, holds = [t for t in trials if t.slip], [t for t in trials if not t.slip]
    return (sum(t.slid[how] for t in slips) / len(slips) + sum(not t.slid[how] for t in holds) / len(holds)) / 2


def measure(sliplab, folder):
    with open(Path(folder) / "labels.csv", newline="") as lines:
        labels = [(row["trial"], row["slip"] == "1") for row in csv.DictReader(lines)]
    trials = [read_trial(sliplab, Path(folder), name, slip) for name, slip in labels]
    for how in ("plain", "releasing"):
        groups = {"all": trials, "A": [t for t in trials if t.kind == "A"], "B": [t for t in trials if t.kind == "B"]}
        figures = ", ".join(f"{name} {auc(group, how):.2f}" for name, group in groups.items() if auc(group, how) is not None)
        print(f"gelsight, {how}: AUC {figures}; balanced accuracy {balanced(trials, how):.2f}")
    return trials


if __name__ == "__main__":
    import sys
    measure(Path(sys.argv[1]), Path(sys.argv[2]))
