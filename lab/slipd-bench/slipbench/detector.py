"""A detector: a program that reads frames on standard input and writes decisions on standard output (docs/slipd-bench.md)."""
import json
import os
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .recording import within
from .sets import WrongUse

DETECTORS = Path(__file__).resolve().parents[1] / "detectors"
ENVIRONMENT = os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}   # detectors already run side by side
NICE = ["nice", "-n", "10"]
SAME_S = 1e-6       # times are the same to this: programs print them with nine digits


@dataclass
class Detector:
    name: str
    command: list
    train: list | None = None      # command that trains it: gets a folder, and the file for its model

    @staticmethod
    def of(command):
        return Detector(command, shlex.split(command))


@dataclass
class Decisions:
    """Of each row of the recording the newest decision: NaN or False before the first."""
    alarm: np.ndarray | None       # None: the detector decides nothing, and only gives scores
    score: np.ndarray              # NaN: not answered
    gamma: np.ndarray
    low: np.ndarray                # a safe end of gamma
    turns: np.ndarray              # 1: the alarm is of a rotation, 0: of a translation
    answered: np.ndarray


def shipped(tools):
    """The detectors of this folder. tools: what {words} of their commands stand for."""
    found = {}
    for file in sorted(DETECTORS.glob("*.json")):
        for entry in json.loads(file.read_text()):
            def filled(command):
                return [word.format(here=DETECTORS, python=sys.executable, **tools) for word in command]
            found[entry["name"]] = Detector(entry["name"], filled(entry["command"]), filled(entry["train"]) if "train" in entry else None)
    return found


def frames_of(recording):
    """The lines that a detector reads."""
    lines = [json.dumps(recording.about)]
    values = {name: rows.tolist() for name, rows in recording.values.items()}
    for i, t in enumerate(recording.times.tolist()):
        lines.append(json.dumps({"t": t, **{name: rows[i] for name, rows in values.items()}}))
    return ("\n".join(lines) + "\n").encode()


def labels_of(recording):
    """For training: of each frame, 1 while it slips, 0 in a quiet hold, null where neither is known."""
    slips = within(recording.times, [(s.begin_s if s.onset_s is None else s.onset_s, s.end_s) for s in recording.truth.slips])
    quiet = within(recording.times, recording.truth.quiet)
    return json.dumps([1 if s else 0 if q else None for s, q in zip(slips.tolist(), quiet.tolist())])


def run_program(command, given):
    try:
        done = subprocess.run([*NICE, *map(str, command)], input=given, capture_output=True, check=False, env=ENVIRONMENT)
    except FileNotFoundError:
        raise WrongUse(f"{command[0]}: no such program") from None
    if done.returncode:
        raise WrongUse(f"{shlex.join(map(str, command))} ended with {done.returncode}: {done.stderr.decode(errors='replace').strip()[-2000:]}")
    return done.stdout.decode()


def parsed(line, number, command):
    try:
        found = json.loads(line)
        return float(found["t"]), found
    except (ValueError, KeyError, TypeError):
        raise WrongUse(f"{shlex.join(map(str, command))}: line {number} of its output is no decision: {line[:100]!r}; expected a JSON object with "
                       '"t" in s, and "slip" (true, false), "score" or "gamma"') from None


def decide(detector, recording, frames, model=None):
    command = [*detector.command, *([model] if model else [])]
    decided = [parsed(line, i + 1, command) for i, line in enumerate(run_program(command, frames).splitlines()) if line.strip()]
    return held_on(decided, recording.times)


def held_on(decided, times):
    """Decisions at their times, each held until the next."""
    said = np.array([t for t, _ in decided])
    if (np.diff(said) < 0).any():
        raise WrongUse("decisions are not in order of time")
    newest = np.searchsorted(said, times + SAME_S, side="right") - 1

    def column(key, kind=float):
        values = np.array([kind(np.nan if d.get(key) is None else d[key]) for _, d in decided] + [np.nan])
        return values[newest]     # -1: the NaN at the end
    slip, score = column("slip"), column("score")
    decides = any("slip" in d for _, d in decided)
    answered = ~np.isnan(slip) if decides else ~np.isnan(score)
    return Decisions(slip == 1 if decides else None, np.where(np.isnan(score), slip, score) if decides else score,
                     column("gamma"), column("gamma_low"), column("kind", lambda kind: np.nan if kind != kind else float(kind == "rotation")), answered)
