"""Detectors on the recordings of a set."""
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from .detector import decide, frames_of, labels_of, run_program
from .figures import figures
from .measures import judge

FOLDS = 6


@dataclass
class Result:
    """Of one set and detector."""
    spec: dict
    detector: str
    recordings: list
    decided: list          # the Decisions of each recording
    counted: list          # the Counts of each
    figures: dict


def models_of(detector, recordings, frames, folder):
    """For each block a model that was trained on recordings of other blocks only; of many blocks, some share a model that saw none of them."""
    blocks, models = sorted({r.block for r in recordings}), {}
    for fold in range(min(FOLDS, len(blocks)) if detector.train else 0):
        left_out = blocks[fold::FOLDS]
        lessons, model = Path(folder) / f"lessons{fold}", Path(folder) / f"model{fold}"
        lessons.mkdir()
        for i, (recording, lines) in enumerate(zip(recordings, frames)):
            if recording.block not in left_out and (recording.truth.slips or recording.truth.quiet):
                (lessons / f"{i}.frames").write_bytes(lines)
                (lessons / f"{i}.labels").write_text(labels_of(recording))
        run_program([*detector.train, lessons, model], b"")
        models.update(dict.fromkeys(left_out, model))
    return models


def run_detector(spec, detector, recordings, frames, jobs):
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(jobs) as pool:
        models = models_of(detector, recordings, frames, folder)
        decided = list(pool.map(lambda r, lines: decide(detector, r, lines, models.get(r.block)), recordings, frames))
    counted = judge(recordings, decided)
    return Result(spec, detector.name, recordings, decided, counted, figures(counted))


def run_set(spec, detectors, recordings, jobs):
    """The Result of each detector; of two blocks none is trained."""
    frames = [frames_of(r) for r in recordings]
    blocks = {r.block for r in recordings}
    return [run_detector(spec, d, recordings, frames, jobs) for d in detectors if not d.train or len(blocks) > 2]
